// SPDX-License-Identifier: Apache-2.0
// `scrim make ax file=IN.vdb code=CODE -o OUT.vdb`: saves the grids of a file after an expression in OpenVDB AX.
#pragma once

#include "console.h"

#include <string>
#include <utility>
#include <vector>

namespace scrim::cli {

/// `parameters`: file, code or ax_file, resample; all others are external variables of the expression. Throws Error.
void makeAx(const std::vector<std::pair<std::string, std::string>>& parameters, const std::string& output, bool verbose,
            Console& console);

}  // namespace scrim::cli
