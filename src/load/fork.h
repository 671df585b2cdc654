// SPDX-License-Identifier: Apache-2.0
// Copies of this process. Only a program without active threads may make them, so the library cannot.
#pragma once

#include <scrim/base/child_process.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>
#include <thread>

#include <unistd.h>

namespace scrim::load {

#ifdef __SANITIZE_ADDRESS__
/// Waits until the other threads sleep, for a second at most. OpenVDB brings log4cplus along, which starts some that
/// have nothing to do later. A copy made while one of them allocates would wait for ever for the sanitizer's allocator;
/// that of glibc takes care of it.
inline bool letThreadsSleep() {
    const auto sleeps = [](const std::filesystem::path& thread) {
        std::string text;
        std::getline(std::ifstream(thread / "stat"), text);
        const std::size_t name = text.rfind(')');
        return name == text.npos || text.compare(name, 3, ") S") == 0;
    };
    for (int tries = 0, quiet = 0; tries < 1000 && quiet < 3; ++tries) {
        bool all = true;
        for (const auto& thread : std::filesystem::directory_iterator("/proc/self/task"))
            all = all && (thread.path().filename() == std::to_string(::getpid()) || sleeps(thread.path()));
        quiet = all ? quiet + 1 : 0;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
}
#else
inline bool letThreadsSleep() {
    return true;
}
#endif

/// Makes a copy of this process that runs `task` and exits with the status that it returns; nothing is cleaned up
/// there. It is killed with the returned object. Throws std::system_error where no process can be made.
template <typename Task>
ChildProcess forked(const Task& task) {
    [[maybe_unused]] static const bool asleep = letThreadsSleep();
    const pid_t child = ::fork();
    if (child < 0) throw std::system_error(errno, std::generic_category());
    if (child == 0) ::_exit(task());
    return ChildProcess(child, SIGKILL);
}

}  // namespace scrim::load
