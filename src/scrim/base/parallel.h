// SPDX-License-Identifier: Apache-2.0
// Parallel loops. This header hides oneTBB from the library, in which only parallel.cpp runs loops by it: so the one
// place where order could become random is easy to check. Tasks are independent, and no result depends on which
// thread runs which task. Beyond the library, the module for AX runs a loop over leaves by oneTBB
// (src/modules/ax_together.cpp).
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>
#include <numeric>
#include <vector>

namespace scrim {

/// Calls `task(i)` once for every i in [0, count), in any order and on any thread. A task should take at least some
/// microseconds; it runs with denormal floats flushed to zero. The first exception thrown by a task is rethrown after
/// the others have stopped. May be called from within a task: its thread then runs no other task of the outer loop
/// before the inner loop has ended, so that a task may keep memory of its thread (thread_local) meanwhile.
void parallelFor(std::size_t count, const std::function<void(std::size_t)>& task);

inline constexpr std::size_t kParallelChunk = 2048;  ///< of parallelChunks

/// Calls `task(begin, end)` for consecutive parts of [0, count), as parallelFor does.
template <class Task>
void parallelChunks(std::size_t count, const Task& task) {
    parallelFor((count + kParallelChunk - 1) / kParallelChunk,
                [&](std::size_t i) { task(i * kParallelChunk, std::min(count, (i + 1) * kParallelChunk)); });
}

/// The sum of term(i) for every i in [0, count). Threads do not change how it is rounded.
template <class Term>
double parallelSum(std::size_t count, const Term& term) {
    std::vector<double> sums((count + kParallelChunk - 1) / kParallelChunk);
    parallelChunks(count, [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t i = begin; i < end; ++i) sum += term(i);
        sums[begin / kParallelChunk] = sum;
    });
    return std::accumulate(sums.begin(), sums.end(), 0.0);
}

/// The number of threads that `parallelFor` may use at this point.
int threadCount();

/// Limits the number of threads for the code that runs in it, and for nothing else in the process.
/// `threads` 0 means as many as the caller has; there are never more than the machine has.
class TaskArena {
  public:
    explicit TaskArena(int threads);
    ~TaskArena();
    TaskArena(const TaskArena&) = delete;
    TaskArena& operator=(const TaskArena&) = delete;

    /// Runs `task` on the calling thread and rethrows its exceptions.
    void run(const std::function<void()>& task);

  private:
    struct Arena;
    std::unique_ptr<Arena> m_arena;  // null: the caller's own arena
};

}  // namespace scrim
