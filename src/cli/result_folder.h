// SPDX-License-Identifier: Apache-2.0
// The folder of a study's results.
#pragma once

#include "file_claims.h"

#include <initializer_list>
#include <string>

namespace scrim::cli {

/// It is made once before hours of work rely on it, and removed until there are results, so that nothing is left of a
/// study that ends early, however it ends.
class ResultFolder {
  public:
    /// Throws Error(output) where there can be no such folder.
    explicit ResultFolder(std::string path);

    /// Claims the files of these names in the folder, and removes what a killed study left there. Before it is made.
    static void claim(const std::string& path, std::initializer_list<const char*> names, FileClaims& claims);

    const std::string& path() const { return m_path; }
    /// Writes a file completely or not at all. Throws Error(output).
    void write(const std::string& name, const std::string& text) const;

  private:
    bool make() const;

    std::string m_path;
};

}  // namespace scrim::cli
