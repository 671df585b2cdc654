// SPDX-License-Identifier: Apache-2.0
// Moves a scene's camera once around its target.
#pragma once

#include <scrim/scene/scene_reader.h>

#include <string>
#include <vector>

namespace scrim {

/// Overrides that make the camera circle its target (or the centre of its orbit) once in frames 1 to `frames`, in equal
/// steps, about its `up`. It starts at its place at frame 1 of the scene and, seen from above, goes to the right.
/// Throws Error(input) where the camera has neither an orbit nor a position and a target.
std::vector<std::string> turntableOverrides(const SceneText& text, const std::vector<std::string>& overrides,
                                            int frames);

}  // namespace scrim
