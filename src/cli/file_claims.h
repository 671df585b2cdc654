// SPDX-License-Identifier: Apache-2.0
// Keeps track of the files that a command reads and writes. No file may be both read and written, nor written twice,
// whatever names it goes by; this is checked before any work starts.
#pragma once

#include <scrim/base/file_identity.h>

#include <map>
#include <set>
#include <string>

namespace scrim::cli {

class FileClaims {
  public:
    /// Declares that a file is read. `role`: "the volume 'plume'", "the scene". All calls must come before those of
    /// `writes`.
    void reads(const std::string& path, const std::string& role);

    /// Declares that a file is written. `role`: "--stats". Throws Error(usage) where the file is read. Returns the role
    /// in which the file is already claimed for writing, or "" where the claim is new.
    std::string writes(const std::string& path, const std::string& role);

    /// As `writes`, but throws Error(usage) also where the file is already claimed for writing.
    void writesAlone(const std::string& path, const std::string& role);

    /// The existing folders that files are written into.
    std::set<std::string> folders() const;

  private:
    std::map<FileIdentity, std::string> m_read, m_written;
    std::set<std::string> m_folders;
};

}  // namespace scrim::cli
