// SPDX-License-Identifier: Apache-2.0
// Copies of this process. Only a program without active threads may make them, so the library cannot.
#pragma once

#include <scrim/base/child_process.h>

#include <cerrno>
#include <csignal>
#include <system_error>

#include <unistd.h>

namespace scrim::load {

/// Waits until all other threads of this process sleep, for about a second at most. One that starts or ends may hold a
/// lock, which a copy made at that moment would find locked for ever; a pool that has nothing to do holds none.
void waitForThreadsToSleep();

/// Waits until a copy may be made. Without sanitizers it returns at once. With them its first call waits as above.
void waitForQuietThreads();
/// Its next call waits again.
void threadsHaveStarted();

/// Makes a copy of this process that runs `task` and exits with the status that it returns; nothing is cleaned up
/// there. It is killed with the returned object. Throws std::system_error where no process can be made.
template <typename Task>
ChildProcess forked(const Task& task) {
    waitForQuietThreads();
    const pid_t child = ::fork();
    if (child < 0) throw std::system_error(errno, std::generic_category());
    if (child == 0) ::_exit(task());
    return ChildProcess(child, SIGKILL);
}

}  // namespace scrim::load
