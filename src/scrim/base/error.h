// SPDX-License-Identifier: Apache-2.0
// The library's only exception type. A message says where the error is, what was found, what was expected and which
// choices there are; the kind lets a program choose an exit status without reading the text.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace scrim {

enum class ErrorKind {
    render,       ///< something inside of a render went wrong
    usage,        ///< the caller asked for something that does not exist or is inconsistent
    input,        ///< a file, scene or asset is missing or bad
    output,       ///< a result could not be written
    memory,       ///< the memory limit does not suffice
    interrupted,  ///< the caller asked to stop
    accuracy,     ///< there is a result, but it is less accurate than requested
};

class Error : public std::runtime_error {
  public:
    Error(ErrorKind kind, const std::string& message) : std::runtime_error(message), m_kind(kind) {}
    ErrorKind kind() const noexcept { return m_kind; }

  private:
    ErrorKind m_kind;
};

/// `message` shortened to at most `limit` bytes. Texts that libraries make from damaged files can
/// be huge and contain unprintable bytes, which become '?'.
std::string shortened(std::string_view message, std::size_t limit = 300);

/// "3 bytes", "12.5 MB", in units of 1024.
std::string bytesText(std::size_t bytes);

/// "'a', 'b' or 'c'": a list of choices for a message; "none" if it is empty.
std::string choices(const std::vector<std::string>& names);

}  // namespace scrim
