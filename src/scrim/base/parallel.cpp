// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/parallel.h>

#include <scrim/base/loop_recorder.h>

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <time.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <ostream>
#include <thread>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace scrim {
namespace {

// While an object lives, denormal floats count as 0 on its thread. Light in deep shadow consists of
// them, and a processor takes a hundred times as long for each.
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

// What a LoopRecorder has begun.
struct Recording {
    std::ostream& to;
    int threads;
    std::thread::id thread = std::this_thread::get_id();
    double since = processorSeconds();  // when the last part ended

    static double processorSeconds() {
        timespec time{};
        ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
        return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
    }
    void end(char kind) {
        const double now = processorSeconds();
        to << kind << ' ' << static_cast<std::int64_t>(1e9 * (now - since)) << '\n';
        since = processorSeconds();
    }
    void loop(std::size_t count, const std::function<void(std::size_t)>& task) {
        end('S');
        to << "L " << count << '\n';
        for (std::size_t i = 0; i < count; ++i) {
            task(i);
            end('T');
        }
    }
};

std::optional<Recording> recording;

bool isRecorded() {
    return recording && recording->thread == std::this_thread::get_id();
}

void runTasks(std::size_t count, const std::function<void(std::size_t)>& task) {
    if (count == 1) {
        const FlushDenormals flush;
        return task(0);
    }
    // A thread that waits for this loop within a task of another must not begin one more task of
    // that: memory that belongs to the thread would then belong to two tasks at once.
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

}  // namespace

void parallelFor(std::size_t count, const std::function<void(std::size_t)>& task) {
    if (isRecorded()) {
        const FlushDenormals flush;
        return recording->loop(count, task);
    }
    runTasks(count, task);
}

int threadCount() {
    return isRecorded() ? recording->threads : tbb::this_task_arena::max_concurrency();
}

LoopRecorder::LoopRecorder(std::ostream& to, int threads) {
    recording.emplace(to, threads);
}

LoopRecorder::~LoopRecorder() {
    recording->end('S');
    recording.reset();
}

struct TaskArena::Arena {
    explicit Arena(int threads) : arena(threads) {}
    tbb::task_arena arena;
};

TaskArena::TaskArena(int threads) {
    if (isRecorded()) return;
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
