// SPDX-License-Identifier: Apache-2.0
// What the program says of a rendered frame: the line at its end, the details below it, and --stats.
#pragma once

#include <scrim/shot/shot_frame.h>

#include <string>
#include <vector>

namespace scrim::cli {

/// "frame 1: plume.exr 512x512, 0.21 s (load 0.05, render 0.12, write 0.04)".
std::string summaryLine(const ShotReport& report);
/// The stages and the work, several lines without the last newline.
std::string detailLines(const ShotReport& report);

/// All frames, as an array.
std::string reportsAsJson(const std::vector<ShotReport>& reports);

}  // namespace scrim::cli
