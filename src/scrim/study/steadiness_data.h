// SPDX-License-Identifier: Apache-2.0
// The steadiness of a shot as data: a table for spreadsheets, and everything for programs.
#pragma once

#include <scrim/study/shot_steadiness.h>

#include <string>

namespace scrim {

/// A table with one line for each layer and each frame but the first and the last: second
/// differences of the frames and of the converged ones, the excess, and the error, relative to the
/// layer's mean. The line of a layer without a frame is that of all frames.
std::string steadinessAsCsv(const ShotSteadinessResult& result);

/// All of the result. `scene`: the name of the scene.
std::string steadinessAsJson(const ShotSteadinessResult& result, const std::string& scene);

}  // namespace scrim
