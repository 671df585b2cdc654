// SPDX-License-Identifier: Apache-2.0
// A camera that goes once around what a scene's camera looks at.
#pragma once

#include <scrim/scene/scene_reader.h>

#include <string>
#include <vector>

namespace scrim {

/// Overrides by which, in frames 1 to `frames`, the camera that the scene has at frame 1 goes around its target, or the
/// middle of its orbit, in equal steps on a true circle, about its `up`. Seen from above it goes to the right. In frame
/// 1 it is where it is in the scene. Throws Error(input) where the camera has neither an orbit nor a position and a
/// target.
std::vector<std::string> turntableOverrides(const SceneText& text, const std::vector<std::string>& overrides,
                                            int frames);

}  // namespace scrim
