// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/loop_recorder.h>
#include <scrim/base/parallel.h>

#include <tbb/global_control.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <limits>
#include <mutex>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace scrim::test {
namespace {

TEST(ParallelFor, CallsEveryIndexOnce) {
    for (const std::size_t count : {0u, 1u, 2u, 7u, 1000u}) {
        std::vector<std::atomic<int>> calls(count);
        parallelFor(count, [&](std::size_t i) { ++calls.at(i); });
        EXPECT_TRUE(std::all_of(calls.begin(), calls.end(), [](const auto& c) { return c == 1; })) << count;
    }
}

TEST(ParallelFor, MayBeNested) {
    std::atomic<int> calls{0};
    parallelFor(5, [&](std::size_t) { parallelFor(7, [&](std::size_t) { ++calls; }); });
    EXPECT_EQ(calls, 35);
}

// Waits for the end of an inner loop are what a scheduler likes to fill with other tasks of the outer one.
TEST(ParallelFor, ATaskThatWaitsForALoopOfItsOwnKeepsItsThreadsMemory) {
    const tbb::global_control many(tbb::global_control::max_allowed_parallelism, 8);  // on however few processors
    static thread_local int tasksOfThisThread = 0;
    std::atomic<int> most{0};
    TaskArena(8).run([&] {
        parallelFor(400, [&](std::size_t) {
            const int now = ++tasksOfThisThread;
            for (int seen = most; now > seen && !most.compare_exchange_weak(seen, now);) {
            }
            parallelFor(8, [](std::size_t i) { std::this_thread::sleep_for(std::chrono::microseconds(20 * i)); });
            --tasksOfThisThread;
        });
    });
    EXPECT_EQ(most, 1);
}

TEST(ParallelFor, RethrowsWhatATaskThrows) {
    for (const std::size_t count : {1u, 2u, 500u}) {
        std::string text;
        try {
            parallelFor(count, [&](std::size_t i) {
                if (i == count / 2) throw std::runtime_error("task failed");
            });
        } catch (const std::runtime_error& error) {
            text = error.what();
        }
        EXPECT_EQ(text, "task failed") << count;
    }
}

TEST(ParallelFor, WorksOnAfterAnException) {
    EXPECT_THROW(parallelFor(100, [](std::size_t) { throw std::logic_error("x"); }), std::logic_error);
    std::atomic<int> calls{0};
    parallelFor(100, [&](std::size_t) { ++calls; });
    EXPECT_EQ(calls, 100);
}

#if defined(__SSE__)

// Half of the smallest normal float, computed where the compiler cannot see it.
float halfOfTheSmallest() {
    volatile float smallest = std::numeric_limits<float>::min();
    volatile float half = 0.5f;
    return smallest * half;
}

TEST(Denormals, AreFlushedInsideTasksAndNotOutside) {
    for (const std::size_t count : {1u, 64u}) {
        const unsigned before = _mm_getcsr();
        ASSERT_GT(halfOfTheSmallest(), 0) << "this thread flushes denormals anyway";
        std::atomic<int> flushed{0};
        parallelFor(count, [&](std::size_t) { flushed += halfOfTheSmallest() == 0 ? 1 : 0; });
        EXPECT_EQ(flushed, static_cast<int>(count));
        // Flags that arithmetic itself sets (the low six bits) may differ.
        EXPECT_EQ(_mm_getcsr() & ~0x3fu, before & ~0x3fu);
        EXPECT_GT(halfOfTheSmallest(), 0);
    }
}

TEST(Denormals, CountAgainAfterAnException) {
    for (const std::size_t count : {1u, 64u}) {
        EXPECT_THROW(parallelFor(count, [](std::size_t) { throw std::runtime_error("x"); }), std::runtime_error);
        EXPECT_GT(halfOfTheSmallest(), 0) << count;
    }
}

// Workers belong to the program, too: what they compute outside of our loops must not change.
TEST(Denormals, CountInOtherLoopsOfTheSameThread) {
    parallelFor(64, [](std::size_t) {});
    float outside = 0;
    std::thread([&] { outside = halfOfTheSmallest(); }).join();
    EXPECT_GT(outside, 0);
}

#endif

// The threads that take part in a loop.
std::set<std::thread::id> threadsOfALoop() {
    std::mutex mutex;
    std::set<std::thread::id> threads;
    parallelFor(200, [&](std::size_t) {
        const std::lock_guard lock(mutex);
        threads.insert(std::this_thread::get_id());
    });
    return threads;
}

TEST(TaskArena, HoldsForWhatRunsInItAlone) {
    const int before = threadCount();
    EXPECT_GE(before, 1);
    TaskArena(1).run([] {
        EXPECT_EQ(threadCount(), 1);
        EXPECT_EQ(threadsOfALoop().size(), 1u);
    });
    EXPECT_EQ(threadCount(), before);
    // Others are not held back meanwhile.
    TaskArena(1).run([&] { std::thread([&] { EXPECT_EQ(threadCount(), before); }).join(); });
}

// Lines of a LoopRecorder without their times.
std::string recorded(const std::function<void()>& work, int threads = 8) {
    std::ostringstream all;
    {
        const LoopRecorder recorder(all, threads);
        work();
    }
    std::istringstream lines(all.str());
    std::string out, kind, number;
    while (lines >> kind >> number) out += kind == "L" ? "L" + number : kind;
    return out;
}

TEST(LoopRecorder, WritesLoopsTheirTasksAndWhatIsBetween) {
    EXPECT_EQ(recorded([] {}), "S");
    EXPECT_EQ(recorded([] { parallelFor(3, [](std::size_t) {}); }), "SL3TTTS");
    EXPECT_EQ(recorded([] { parallelFor(1, [](std::size_t) { parallelFor(2, [](std::size_t) {}); }); }), "SL1SL2TTTS");
}

TEST(LoopRecorder, RunsOnOneThreadAsIfThereWereMore) {
    int threads = 0;
    std::set<std::thread::id> used;
    std::vector<std::size_t> order;
    recorded(
        [&] {
            TaskArena(2).run([&] {
                threads = threadCount();
                parallelFor(4, [&](std::size_t i) {
                    order.push_back(i);
                    used.insert(std::this_thread::get_id());
                });
            });
        },
        64);
    EXPECT_EQ(threads, 64);
    EXPECT_EQ(order, (std::vector<std::size_t>{0, 1, 2, 3}));
    EXPECT_EQ(used, std::set{std::this_thread::get_id()});
}

TEST(LoopRecorder, LeavesOtherThreadsAlone) {
    std::size_t done = 0;
    EXPECT_EQ(recorded([&] { std::thread([&] { parallelFor(1, [&](std::size_t) { ++done; }); }).join(); }), "S");
    EXPECT_EQ(done, 1u);
}

// Times are those of the processor, so that waiting counts for nothing.
TEST(LoopRecorder, MeasuresWorkButNotWaiting) {
    std::ostringstream all;
    {
        const LoopRecorder recorder(all, 2);
        parallelFor(1, [](std::size_t) { std::this_thread::sleep_for(std::chrono::milliseconds(50)); });
    }
    std::istringstream lines(all.str());
    std::string kind;
    double inTasks = 0;
    for (double nanoseconds = 0; lines >> kind >> nanoseconds;) inTasks += kind == "T" ? nanoseconds : 0;
    EXPECT_GT(inTasks, 0);
    EXPECT_LT(inTasks, 2e7);
}

TEST(TaskArena, OfZeroIsTheCallers) {
    const tbb::global_control many(tbb::global_control::max_allowed_parallelism, 8);  // on however few processors
    TaskArena(3).run([] { TaskArena(0).run([] { EXPECT_EQ(threadCount(), 3); }); });
}

TEST(TaskArena, OnesWithinAnotherHaveThreadsOfTheirOwn) {
    const tbb::global_control many(tbb::global_control::max_allowed_parallelism, 8);
    TaskArena(1).run([] {
        TaskArena(7).run([] { EXPECT_EQ(threadCount(), 7); });
        EXPECT_EQ(threadCount(), 1);
    });
}

TEST(TaskArena, HasNoMoreThreadsThanTheMachine) {
    TaskArena(4000).run([] { EXPECT_LE(threadCount(), static_cast<int>(std::thread::hardware_concurrency())); });
}

TEST(TaskArena, RunsOnTheCallersThreadAndRethrows) {
    const std::thread::id caller = std::this_thread::get_id();
    for (const int threads : {0, 1, 5}) {
        TaskArena(threads).run([&] { EXPECT_EQ(std::this_thread::get_id(), caller); });
        EXPECT_THROW(TaskArena(threads).run([] { throw std::runtime_error("x"); }), std::runtime_error);
    }
}

}  // namespace
}  // namespace scrim::test
