// SPDX-License-Identifier: Apache-2.0
// A file that somebody else named, opened for reading. It may be anything.
#pragma once

#include <scrim/base/descriptor.h>

#include <cstdint>
#include <string>

namespace scrim {

/// A regular file that is open for reading, or the reason why it is not.
class OpenFile {
  public:
    /// Throws an Error of another kind than `input` where the file is not to blame: memory, too many open files.
    explicit OpenFile(const std::string& path);
    int fd() const { return m_file.fd(); }
    std::uint64_t size() const { return m_size; }  ///< bytes
    /// "": the file is open.
    const std::string& problem() const { return m_problem; }

  private:
    Descriptor m_file;
    std::uint64_t m_size = 0;
    std::string m_problem;
};

/// All bytes of a file, or of a pipe or device, whose name the user gave. Throws Error(input)
/// "`path`: cannot be read: Is a directory"; of another kind where the file is not to blame.
std::string bytesOf(const std::string& path);

}  // namespace scrim
