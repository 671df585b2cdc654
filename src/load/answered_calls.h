// SPDX-License-Identifier: Apache-2.0
// Behind the filter (confine.h) a process opens nothing. Libraries that open a file by its name are told of files that
// are open already, one or two, and that there is no other.
#pragma once

#include <span>
#include <string>

namespace scrim::load {

class AnsweredCalls {
  public:
    /// From now on in this process: calls that the filter traps are answered as if `path` were the file that is open as
    /// `file`, and nothing else were there. What is opened shares its place in the file with `file`, and begins at 0.
    static void install(const std::string& path, int file);
    /// And as if `name`, open as `beside`, were in the same folder.
    static void add(const std::string& name, int file);

    /// The first name in that folder that was asked for and not there; "" where none was.
    static std::string lacked();

    /// System calls that ask about files by name, beside those that open them.
    static std::span<const long> ofNames();
};

}  // namespace scrim::load
