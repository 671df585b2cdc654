// SPDX-License-Identifier: Apache-2.0
// The program's text about a rendered frame: the line at its end, and the details below it.
#pragma once

#include <scrim/shot/shot_frame.h>

#include <string>

namespace scrim::cli {

/// "frame 1: plume.exr 512x512, 0.21 s (load 0.05, render 0.12, write 0.04)".
std::string summaryLine(const ShotReport& report);
/// The stages and the work: several lines without the last newline.
std::string detailLines(const ShotReport& report);

}  // namespace scrim::cli
