// SPDX-License-Identifier: Apache-2.0
// Takes away from this process everything that reading a file does not need. Parsers of untrusted bytes run confined,
// so that a file that takes over the parser controls a process that can compute and nothing else.
#pragma once

#include <cstddef>

namespace scrim::load {

struct Limits {
    /// Bytes of address space beyond what the process has now; also the limit on what it sends.
    std::size_t memory = 0;
    std::size_t seconds = 0;  ///< seconds of processor time
};

/// True if `confine` installs the system call filter. False under sanitizers, which open files of their own.
bool hasFilter();

enum class Rights {
    reading,  ///< files whose descriptors are open
    threads,  ///< as `reading`; also threads
    names,    ///< also files that libraries ask for by name, as AnsweredCalls answers them (answered_calls.h); threads
    /// As `reading`; also threads, and memory that holds code until forbidCode() is called. Opening a file to read it
    /// fails.
    compiling,
};

/// Confines this process permanently: no core dumps, no capabilities of root and no new privileges, limits of memory
/// and time, and only system calls that compute or read and write open descriptors. Any other call (to open a file,
/// make a socket, start a thread or a program) ends the process by SIGSYS. With all rights but Rights::reading, threads
/// may be started; with Rights::names, harmless queries fail instead. Returns 0, or the errno of what failed:
/// ENOMEM where there is not enough memory to build the filter, anything else where the system refuses.
int confine(const Limits& limits, Rights rights = Rights::reading);

/// After confine() with Rights::compiling: from now on no memory can be made to hold code. What holds code already can
/// still be run. Returns 0 or the errno.
int forbidCode();

}  // namespace scrim::load
