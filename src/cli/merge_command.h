// SPDX-License-Identifier: Apache-2.0
// `scrim merge`: joins crops of a picture, or reports which pictures are incomplete.
#pragma once

#include <string>
#include <vector>

namespace scrim::cli {

struct MergeOptions {
    std::vector<std::string> tiles;
    std::string output;
    std::string compression;  ///< "": the tiles' compression
    bool check = false;
    bool quiet = false;
};

/// Throws Error.
void mergeCommand(const MergeOptions& options);

}  // namespace scrim::cli
