// SPDX-License-Identifier: Apache-2.0
// Work on data nobody can trust, done by a child process: where a library crashes, hangs or eats all memory, the child
// does, and the caller gets a reason instead. A process that was made for that work alone does it itself.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace mesh {

struct ApartLimits {
    std::uint64_t moreMemory = 0;  ///< bytes of address space beyond those in use
    unsigned seconds = 60;         ///< of processor time
};

/// The text `work` returns, computed in this process, within the limits: out of memory is thrown as runApart does, or
/// as std::bad_alloc where this process has less than the limits allow; out of time ends the process by SIGXCPU.
std::string runAlone(const std::function<std::string()>& work, const ApartLimits& limits);

/// The text `work` returns, computed in a child process. What `work` throws is thrown here with its text; a child that
/// dies otherwise is a std::runtime_error that says how. `goOn` is asked several times a second; false ends the child
/// and gives an empty text.
std::string runApart(const std::function<std::string()>& work, const ApartLimits& limits,
                     const std::function<bool()>& goOn);

}  // namespace mesh
