// SPDX-License-Identifier: Apache-2.0
// The files that a shot reads, for whoever writes others beside them. Nothing of them is read here.
#pragma once

#include <scrim/scene/scene_files.h>
#include <scrim/shot/shot.h>

#include <vector>

namespace scrim {

/// For `frames`, and of sequences all files that there are; the shot's own among them. Throws Error(input) where the
/// scene is wrong at one of the frames.
std::vector<SceneFile> filesReadBy(const Shot& shot, const std::vector<int>& frames);

}  // namespace scrim
