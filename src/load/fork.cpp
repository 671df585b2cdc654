// SPDX-License-Identifier: Apache-2.0
#include "fork.h"
#include "sanitized.h"

#ifdef SCRIM_SANITIZED

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

namespace scrim::load {
namespace {

bool sleeps(const std::filesystem::path& thread) {
    std::string text;
    std::getline(std::ifstream(thread / "stat"), text);
    const std::size_t name = text.rfind(')');
    return name == text.npos || text.compare(name, 3, ") S") == 0;
}

bool othersSleep() {
    for (const auto& thread : std::filesystem::directory_iterator("/proc/self/task"))
        if (thread.path().filename() != std::to_string(::getpid()) && !sleeps(thread.path())) return false;
    return true;
}

bool& areQuiet() {
    static bool quiet = false;
    return quiet;
}

}  // namespace

// OpenVDB brings log4cplus along, which starts threads that have nothing to do later. A copy made while one of them
// allocates would wait for ever for the sanitizer's allocator; that of glibc takes care of it.
void waitForQuietThreads() {
    bool& quiet = areQuiet();
    constexpr int kMostTries = 1000, kInARow = 3;
    for (int tries = 0, row = 0; !quiet && tries < kMostTries && row < kInARow; ++tries) {
        row = othersSleep() ? row + 1 : 0;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    quiet = true;
}

void threadsHaveStarted() {
    areQuiet() = false;
}

}  // namespace scrim::load

#else

namespace scrim::load {

void waitForQuietThreads() {}
void threadsHaveStarted() {}

}  // namespace scrim::load

#endif
