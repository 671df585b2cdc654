// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/parallel.h>

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <numeric>
#include <utility>
#include <vector>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace scrim {
namespace {

// While an object lives, denormal floats count as 0 on its thread. Light in deep shadow consists of them, and a
// processor takes a hundred times as long for each.
class FlushDenormals {
  public:
#if defined(__SSE__)
    FlushDenormals() : m_before(_mm_getcsr()) {
        _mm_setcsr(m_before | kFlushToZero | kDenormalsAreZero);
    }
    ~FlushDenormals() {
        _mm_setcsr(m_before);
    }

  private:
    static constexpr unsigned kFlushToZero = 0x8000, kDenormalsAreZero = 0x0040;
    unsigned m_before;
#endif
};

std::function<void(std::size_t, double, double, double)> loopSink;

/// True on a thread that runs a task of a watched loop.
thread_local bool inWatchedTask = false;

void runTasks(std::size_t count, const std::function<void(std::size_t)>& task) {
    if (count == 1) {
        const FlushDenormals flush;
        return task(0);
    }
    // A thread that waits for this loop within a task of another must not begin one more task of that: memory that
    // belongs to the thread would then belong to two tasks at once.
    tbb::this_task_arena::isolate([&] {
        tbb::parallel_for(
            tbb::blocked_range<std::size_t>(0, count, 1),
            [&](const tbb::blocked_range<std::size_t>& range) {
                const FlushDenormals flush;
                for (std::size_t i = range.begin(); i != range.end(); ++i) task(i);
            },
            tbb::simple_partitioner());
    });
}

// Marks the thread while it runs a task.
class InWatchedTask {
  public:
    InWatchedTask() : m_before(std::exchange(inWatchedTask, true)) {}
    ~InWatchedTask() { inWatchedTask = m_before; }
    InWatchedTask(const InWatchedTask&) = delete;
    InWatchedTask& operator=(const InWatchedTask&) = delete;

  private:
    bool m_before;
};

// Loops inside of the tasks are not reported separately.
void runWatched(std::size_t count, const std::function<void(std::size_t)>& task) {
    using Clock = std::chrono::steady_clock;
    const auto since = [](Clock::time_point begin) {
        return std::chrono::duration<double>(Clock::now() - begin).count();
    };
    std::vector<double> seconds(count);
    const auto begin = Clock::now();
    runTasks(count, [&](std::size_t i) {
        const InWatchedTask mark;
        const auto taskBegin = Clock::now();
        task(i);
        seconds[i] = since(taskBegin);
    });
    const double wall = since(begin);
    if (count > 0)
        loopSink(count, wall, std::accumulate(seconds.begin(), seconds.end(), 0.0),
                 *std::max_element(seconds.begin(), seconds.end()));
}

}  // namespace

void parallelFor(std::size_t count, const std::function<void(std::size_t)>& task) {
    if (loopSink && !inWatchedTask) return runWatched(count, task);
    runTasks(count, task);
}

void watchLoops(std::function<void(std::size_t, double, double, double)> sink) {
    loopSink = std::move(sink);
}

int threadCount() {
    return tbb::this_task_arena::max_concurrency();
}

struct TaskArena::Arena {
    explicit Arena(int threads) : arena(threads) {}
    tbb::task_arena arena;
};

TaskArena::TaskArena(int threads) {
    // Asking for more threads than there are would only make oneTBB print a warning.
    const auto most = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    threads = std::min(threads, static_cast<int>(most));
    if (threads > 0 && threads != threadCount()) m_arena = std::make_unique<Arena>(threads);
}

TaskArena::~TaskArena() = default;

void TaskArena::run(const std::function<void()>& task) {
    if (m_arena)
        m_arena->arena.execute(task);
    else
        task();
}

}  // namespace scrim
