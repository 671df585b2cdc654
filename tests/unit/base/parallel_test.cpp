// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/parallel.h>

#include <tbb/global_control.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <limits>
#include <mutex>
#include <set>
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

TEST(Parallel, TellsABenchmarkOfEachLoopAndItsTasks) {
    std::vector<std::size_t> loops;
    double work = 0, longest = 0;
    watchLoops([&](std::size_t tasks, double, double inTasks, double inLongest) {
        loops.push_back(tasks);
        work += inTasks;
        longest += inLongest;
    });
    const auto wait = [](std::size_t i) { std::this_thread::sleep_for(std::chrono::milliseconds(i == 2 ? 20 : 2)); };
    parallelFor(3, wait);
    parallelFor(1, [](std::size_t) {});
    watchLoops({});
    parallelFor(5, [](std::size_t) {});
    EXPECT_EQ(loops, (std::vector<std::size_t>{3, 1}));
    EXPECT_GE(longest, 0.02);
    EXPECT_GE(work, longest + 0.004);
}

TEST(Parallel, TellsABenchmarkOfOuterLoopsThatRunSideBySide) {
    const tbb::global_control many(tbb::global_control::max_allowed_parallelism, 8);
    std::mutex mutex;
    std::multiset<std::size_t> loops;
    watchLoops([&](std::size_t tasks, double, double, double) {
        const std::lock_guard lock(mutex);
        loops.insert(tasks);
    });
    std::multiset<std::size_t> expected;
    std::vector<std::thread> hosts;
    for (std::size_t host = 0; host < 4; ++host) {
        for (int round = 0; round < 50; ++round) expected.insert(10 + host);
        hosts.emplace_back([host] {
            for (int round = 0; round < 50; ++round)
                parallelFor(10 + host, [](std::size_t) { parallelFor(3, [](std::size_t) {}); });
        });
    }
    for (std::thread& host : hosts) host.join();
    watchLoops({});
    EXPECT_EQ(loops, expected);
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
