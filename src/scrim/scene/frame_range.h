// SPDX-License-Identifier: Apache-2.0
// Frame ranges as a command line gives them: "1-48x2,60".
#pragma once

#include <string>
#include <vector>

namespace scrim {

/// The frames of `text` in the order given, each once. `text` is a comma-separated list of numbers and of ranges
/// "first-last" or "first-lastxstep". Frames may be negative: "-5--1". Throws Error(usage) for anything else, for ':'
/// (farm managers disagree on its meaning), and for more than a million frames.
std::vector<int> parseFrameRange(const std::string& text);

}  // namespace scrim
