// SPDX-License-Identifier: Apache-2.0
// The shadows that volumes throw onto solids which catch them. Rays are marched from the solids to the lights: a point
// on a solid lies where no sheet needs to be, and there is but one for each pixel's ray.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/engine/model/frame.h>
#include <scrim/engine/model/sub_lights.h>
#include <scrim/scene/view_scene.h>

#include <cstdint>

namespace scrim {

/// Fills the layers `shadow` of `frame`: for each light that throws shadows (an extended one as its sub-lights), of
/// red, green and blue, which part of it reaches the first solid that a pixel sees, through all volumes; the mean over
/// its rays. 1 where it sees none that catches shadows. Solids throw no shadows here: whoever draws them does that.
/// Returns how many rays were marched. `checkpoint` is called now and then.
std::uint64_t catchShadows(const ViewScene& scene, const SubLights& subLights, Frame& frame,
                           const Checkpoint& checkpoint);

}  // namespace scrim
