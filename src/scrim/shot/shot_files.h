// SPDX-License-Identifier: Apache-2.0
// The files that a shot reads, for code that writes other files beside them. None of them is read here.
#pragma once

#include <scrim/scene/scene_files.h>
#include <scrim/shot/shot.h>

#include <vector>

namespace scrim {

/// The files of `frames`, all existing files of sequences, and the shot's own file. Throws
/// Error(input) where the scene is wrong at one of the frames.
std::vector<SceneFile> filesReadBy(const Shot& shot, const std::vector<int>& frames);

}  // namespace scrim
