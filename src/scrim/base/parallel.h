// SPDX-License-Identifier: Apache-2.0
// Parallel loops. Behind this header stands oneTBB; nothing else in Scrim includes it, so that the one place
// where order could become random is easy to watch: tasks are independent, and no result depends on which
// thread runs which.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace scrim {

/// Calls `task(i)` once for every i in [0, count), in any order and on any thread. A task should be worth at least some
/// microseconds, and runs with denormal floats flushed to zero. The first exception a task throws is rethrown after the
/// others have stopped.
void parallelFor(std::size_t count, const std::function<void(std::size_t)>& task);

/// For benchmarks: from now on `sink` hears of every loop as it ends: how many tasks it had, and the seconds that it,
/// all its tasks together and the longest of them took. An empty one ends that. Not to be called while loops run.
void watchLoops(std::function<void(std::size_t tasks, double wall, double work, double longest)> sink);

/// Number of threads `parallelFor` may use where it is called now.
int threadCount();

/// So many threads (0: as many as the caller has; at most those that the machine has) for what runs in it, and for
/// nothing else in the process.
class TaskArena {
  public:
    explicit TaskArena(int threads);
    ~TaskArena();
    TaskArena(const TaskArena&) = delete;
    TaskArena& operator=(const TaskArena&) = delete;

    /// Runs `task` on the calling thread, and rethrows what it throws.
    void run(const std::function<void()>& task);

  private:
    struct Arena;
    std::unique_ptr<Arena> m_arena;  // null: the caller's own
};

}  // namespace scrim
