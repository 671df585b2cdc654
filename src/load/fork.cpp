// SPDX-License-Identifier: Apache-2.0
#include "fork.h"
#include "sanitized.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

namespace scrim::load {
namespace {

/// True also for a thread that is no longer there.
bool sleeps(const std::filesystem::path& thread) {
    std::string text;
    std::getline(std::ifstream(thread / "stat"), text);
    const std::size_t name = text.rfind(')');
    return name == text.npos || text.compare(name, 3, ") S") == 0;
}

bool othersSleep() {
    std::error_code error;
    for (std::filesystem::directory_iterator thread("/proc/self/task", error), end; !error && thread != end;
         thread.increment(error))
        if (thread->path().filename() != std::to_string(::getpid()) && !sleeps(thread->path())) return false;
    return !error;
}

}  // namespace

void waitForThreadsToSleep() {
    constexpr int kMostTries = 1000, kInARow = 3;
    for (int tries = 0, row = 0; tries < kMostTries && row < kInARow; ++tries) {
        row = othersSleep() ? row + 1 : 0;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
}

#ifdef SCRIM_SANITIZED

namespace {

bool& areQuiet() {
    static bool quiet = false;
    return quiet;
}

}  // namespace

// OpenVDB brings log4cplus along, which starts threads that have nothing to do later. A copy made while one of them
// allocates would wait for ever for the sanitizer's allocator; that of glibc takes care of it.
void waitForQuietThreads() {
    if (!std::exchange(areQuiet(), true)) waitForThreadsToSleep();
}

void threadsHaveStarted() {
    areQuiet() = false;
}

#else

void waitForQuietThreads() {}
void threadsHaveStarted() {}

#endif

}  // namespace scrim::load
