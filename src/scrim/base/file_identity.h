// SPDX-License-Identifier: Apache-2.0
// Identifies the file that a path means, independently of spelling, hard links and symbolic links.
#pragma once

#include <compare>
#include <cstdint>
#include <string>

namespace scrim {

/// Equal for paths that mean the same file, whether it exists or not.
struct FileIdentity {
    std::uint64_t device = 0, node = 0;  ///< of the file, or of the nearest existing folder above it
    std::string rest;                    ///< the path from that folder to the file; "": the file exists

    auto operator<=>(const FileIdentity&) const = default;
};

FileIdentity identityOf(const std::string& path);

/// The path of the file that would be written at `path`: where symbolic links lead, whether there
/// is a file or not. Links that lead in a circle stay.
std::string linkTarget(const std::string& path);

}  // namespace scrim
