// SPDX-License-Identifier: Apache-2.0
// Parallel loops. Behind this header stands oneTBB; nothing else in Scrim includes it, so that the one place
// where order could become random is easy to watch: tasks are independent, and no result depends on which
// thread runs which.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace scrim {

/// Calls `task(i)` once for every i in [0, count), in any order and on any thread. A task should be worth at
/// least some microseconds, and runs with denormal floats flushed to zero. The first exception a task throws is rethrown after the others have stopped.
void parallelFor(std::size_t count, const std::function<void(std::size_t)>& task);

/// Number of threads `parallelFor` may use now.
int threadCount();

/// Limits `parallelFor` to `threads` threads while it lives (0: all of the machine's).
class ThreadLimit {
  public:
    explicit ThreadLimit(int threads);
    ~ThreadLimit();
    ThreadLimit(const ThreadLimit&) = delete;
    ThreadLimit& operator=(const ThreadLimit&) = delete;

  private:
    struct Control;
    std::unique_ptr<Control> m_control;
};

}  // namespace scrim
