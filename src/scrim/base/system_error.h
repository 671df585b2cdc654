// SPDX-License-Identifier: Apache-2.0
// What the system says of a call that failed, as an Error: a limit that was set to the process (ulimit) is not the
// fault of the file that it was met with.
#pragma once

#include <scrim/base/error.h>

#include <chrono>
#include <cstddef>
#include <string>

namespace scrim {

/// Of an error number: `memory` for want of it, `render` for want of descriptors, else `otherwise`.
ErrorKind kindOfSystemError(int errorNumber, ErrorKind otherwise);

/// In a catch block: throws what was caught. What there was no memory for (std::bad_alloc, a size that no container can
/// have, no further thread) is an Error(memory), any other std::system_error one as kindOfSystemError says.
[[noreturn]] void throwAsError();

/// Runs `task`; what it throws is thrown as throwAsError does.
template <typename Task>
auto withErrors(const Task& task) {
    try {
        return task();
    } catch (...) {
        throwAsError();
    }
}

/// "No space left on device"; of limits also how they are raised.
std::string systemErrorText(int errorNumber);

/// Whether files of this process may not grow beyond some size (ulimit -f).
bool limitsFileSizes();

/// Whether a child that took so much processor time was ended by the limit of this process (ulimit -t).
bool limitsTime(std::chrono::microseconds used);

/// Whether the memory of this process may not grow to `bytes` (ulimit -v, ulimit -d).
bool limitsMemory(std::size_t bytes);

/// `fd`, or else a copy of it that is none of stdin, stdout and stderr, where it took the place of one that is closed:
/// children would get another one there. Closed on exec. Negative where there is none left; `fd` is closed then.
int aboveStandardStreams(int fd) noexcept;

/// For programs, before anything else: opens what is closed of stdin, stdout and stderr, so that no file can take their
/// places. Writing to a stdout that was closed still fails.
void openStandardStreams() noexcept;

}  // namespace scrim
