// SPDX-License-Identifier: Apache-2.0
// Turns errors of system calls into Errors. A limit on the process (ulimit) is not the fault of the
// file at which it was reached.
#pragma once

#include <scrim/base/error.h>

#include <chrono>
#include <cstddef>
#include <string>

namespace scrim {

/// The kind of a system error: `memory` for lack of memory, `render` for lack of descriptors, else `otherwise`.
ErrorKind kindOfSystemError(int errorNumber, ErrorKind otherwise);

/// For use in a catch block: rethrows the current exception as an Error. Lack of memory
/// (std::bad_alloc, an impossible container size, no further thread) becomes Error(memory); any
/// other std::system_error gets the kind that kindOfSystemError returns.
[[noreturn]] void throwAsError();

/// Runs `task`; its exceptions are rethrown as throwAsError does.
template <typename Task>
auto withErrors(const Task& task) {
    try {
        return task();
    } catch (...) {
        throwAsError();
    }
}

/// "No space left on device"; for limits, the text also says how to raise them.
std::string systemErrorText(int errorNumber);

/// True if files of this process may not grow beyond some size (ulimit -f).
bool limitsFileSizes();

/// True if a child that used so much processor time was ended by a limit of this process (ulimit -t).
bool limitsTime(std::chrono::microseconds used);

/// True if the memory of this process may not grow to `bytes` (ulimit -v, ulimit -d).
bool limitsMemory(std::size_t bytes);

/// Returns `fd`, or a copy of it if it has the number of stdin, stdout or stderr (because that was
/// closed), since children would get another file at that number. The copy is closed on exec.
/// Returns a negative number where no descriptor is left; `fd` is closed then.
int aboveStandardStreams(int fd) noexcept;

/// For programs, before anything else: opens those of stdin, stdout and stderr that are closed, so
/// that no other file can take their numbers. Writing to a stdout that was closed still fails.
void openStandardStreams() noexcept;

}  // namespace scrim
