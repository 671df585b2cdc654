// SPDX-License-Identifier: Apache-2.0
// `scrim info`: describes .vdb files and scans.
#pragma once

#include <string>
#include <vector>

namespace scrim::cli {

struct InfoOptions {
    std::vector<std::string> files;
    std::vector<int> frames;  ///< frames of sequences; empty: all existing ones
    bool json = false;
    std::string ax;  ///< an expression that changes the grids first; "": none
    bool verbose = false;
};

/// Prints the contents of each file, and for a sequence ("smoke.####.vdb") those of all its files together; as JSON, an
/// object, or an array of objects for several files. Throws Error.
void infoCommand(const InfoOptions& options);

}  // namespace scrim::cli
