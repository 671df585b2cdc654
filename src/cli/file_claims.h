// SPDX-License-Identifier: Apache-2.0
// Which files a command reads and which it writes. No file may be both, and none be written twice, whatever names it
// goes by; that is seen before anything is done.
#pragma once

#include <scrim/base/file_identity.h>

#include <map>
#include <set>
#include <string>

namespace scrim::cli {

class FileClaims {
  public:
    /// `role`: "the volume 'plume'", "the scene". All that is read comes before what is written.
    void reads(const std::string& path, const std::string& role);

    /// `role`: "--stats". Throws Error(usage) where the file is read. Returns the role in which it is written already;
    /// "": it is not, so that whoever asked has it now.
    std::string writes(const std::string& path, const std::string& role);

    /// As `writes`. Throws Error(usage) also where the file is written already.
    void writesAlone(const std::string& path, const std::string& role);

    /// Those that files are written into, as far as they are there.
    std::set<std::string> folders() const;

  private:
    std::map<FileIdentity, std::string> m_read, m_written;
    std::set<std::string> m_folders;
};

}  // namespace scrim::cli
