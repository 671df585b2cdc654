// SPDX-License-Identifier: Apache-2.0
// `scrim info`: what .vdb files hold.
#pragma once

#include <string>
#include <vector>

namespace scrim::cli {

struct InfoOptions {
    std::vector<std::string> files;
    bool json = false;
    bool verbose = false;
};

/// Prints what each file holds; as JSON an object, or an array of them for several files. Throws Error.
void infoCommand(const InfoOptions& options);

}  // namespace scrim::cli
