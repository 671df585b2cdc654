// SPDX-License-Identifier: Apache-2.0
// Frame ranges as a command line gives them: "1-48x2,60".
#pragma once

#include <string>
#include <vector>

namespace scrim {

/// The frames of `text` in its order, each once: numbers and ranges "first-last" or "first-lastxstep",
/// separated by commas. Frames may be negative: "-5--1". Throws Error(usage) on anything else, on ':' (farm
/// managers disagree on its meaning), and on more than a million frames.
std::vector<int> parseFrameRange(const std::string& text);

}  // namespace scrim
