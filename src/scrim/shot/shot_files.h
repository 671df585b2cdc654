// SPDX-License-Identifier: Apache-2.0
// The files that a shot reads, for whoever writes others beside them. Nothing of them is read here.
#pragma once

#include <scrim/scene/scene_files.h>
#include <scrim/shot/shot.h>

#include <vector>

namespace scrim {

/// For a frame, the shot's own among them. Throws Error(input) where the scene is wrong at that frame.
std::vector<SceneFile> filesReadBy(const Shot& shot, int frame);

}  // namespace scrim
