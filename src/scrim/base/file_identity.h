// SPDX-License-Identifier: Apache-2.0
// Which file a path means, whatever names it goes by: other spellings, links of both kinds.
#pragma once

#include <compare>
#include <cstdint>
#include <string>

namespace scrim {

/// Equal for paths that mean the same file, there or still to be made.
struct FileIdentity {
    std::uint64_t device = 0, node = 0;  ///< of the file, or of the nearest folder above it that there is
    std::string rest;                    ///< the way from that folder to the file; "": the file is there

    auto operator<=>(const FileIdentity&) const = default;
};

FileIdentity identityOf(const std::string& path);

}  // namespace scrim
