// SPDX-License-Identifier: Apache-2.0
// `scrim make`: runs a volume source and saves its grids.
#pragma once

#include <string>
#include <vector>

namespace scrim::cli {

struct MakeOptions {
    std::string source;
    std::vector<std::string> parameters;  ///< "key=value"
    std::string output;
    int threads = 0;
    bool list = false;        ///< prints all sources instead
    bool helpSource = false;  ///< prints the source's parameters instead
    bool verbose = false, quiet = false;
};

/// Throws Error.
void makeCommand(const MakeOptions& options);

}  // namespace scrim::cli
