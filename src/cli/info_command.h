// SPDX-License-Identifier: Apache-2.0
// `scrim info`: what .vdb files and scans hold.
#pragma once

#include <string>
#include <vector>

namespace scrim::cli {

struct InfoOptions {
    std::vector<std::string> files;
    std::vector<int> frames;  ///< of sequences; empty: all there are
    bool json = false;
    bool verbose = false;
};

/// Prints what each file holds, of a sequence ("smoke.####.vdb") what all its files hold together; as JSON an object,
/// or an array of them for several files. Throws Error.
void infoCommand(const InfoOptions& options);

}  // namespace scrim::cli
