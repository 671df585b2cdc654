// SPDX-License-Identifier: Apache-2.0
// Takes from this process all that reading a file does not need. What parses untrusted bytes runs behind this, so that
// a file that takes over the parser gets a process that can compute, and nothing else.
#pragma once

#include <cstddef>

namespace scrim::load {

struct Limits {
    std::size_t memory = 0;   ///< bytes of address space beyond what the process has now, and of what it hands over
    std::size_t seconds = 0;  ///< of computing
};

/// Whether `confine` installs the system call filter. Not under sanitizers, which open files of their own.
bool hasFilter();

enum class Files {
    descriptors,  ///< those that are open
    answered,     ///< and what libraries ask by name, as AnsweredCalls answers it (answered_calls.h)
};

/// For good: no dump of a crash, no rights of root, no new ones, limits of memory and time, and from then
/// on only system calls that compute, and read and write descriptors that are open. Any other ends the process by
/// SIGSYS: to open a file, make a socket, start a thread or a program. Where files are answered, threads may be started
/// (some libraries need them to decode), and harmless questions fail instead. False where the system refuses.
bool confine(const Limits& limits, Files files = Files::descriptors);

}  // namespace scrim::load
