// SPDX-License-Identifier: Apache-2.0
// The one exception type of the library. A message says where, what was found, what was expected and the
// choices there are; the kind lets a program pick an exit status without reading text.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace scrim {

enum class ErrorKind {
    render,       ///< something inside a render went wrong
    usage,        ///< the caller asked for something that does not exist or does not fit together
    input,        ///< a file, scene or asset is missing or bad
    output,       ///< a result could not be written
    memory,       ///< the memory limit does not suffice
    interrupted,  ///< the caller asked to stop
    accuracy,     ///< the result is there, but not as accurate as was asked for
};

class Error : public std::runtime_error {
  public:
    Error(ErrorKind kind, const std::string& message) : std::runtime_error(message), m_kind(kind) {}
    ErrorKind kind() const noexcept { return m_kind; }

  private:
    ErrorKind m_kind;
};

/// `message` shortened to at most `limit` bytes: texts made by libraries from damaged files can be huge and
/// hold unprintable bytes (those become '?').
std::string shortened(std::string_view message, std::size_t limit = 300);

/// "3 bytes", "12.5 MB", in units of 1024.
std::string bytesText(std::size_t bytes);

/// "'a', 'b' or 'c'": choices for a message. "none" where there are none.
std::string choices(const std::vector<std::string>& names);

}  // namespace scrim
