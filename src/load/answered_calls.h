// SPDX-License-Identifier: Apache-2.0
// Behind the filter (confine.h) a process opens no files. Libraries that open a file by name get one or two files that
// are already open, and are told that no other file exists.
#pragma once

#include <span>
#include <string>

namespace scrim::load {

class AnsweredCalls {
  public:
    /// From now on, calls in this process that the filter traps are answered as if `path` were the file that is open as
    /// `file`, and no other file existed. Opened descriptors share their position with `file`, and start at 0.
    static void install(const std::string& path, int file);
    /// Adds a second file to that folder: `name`, which is open as `file`.
    static void add(const std::string& name, int file);

    /// The first name in that folder that was asked for and does not exist; "" where there was none.
    static std::string lacked();

    /// The system calls that ask about files by name, beside those that open them.
    static std::span<const long> ofNames();
};

}  // namespace scrim::load
