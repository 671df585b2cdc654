// SPDX-License-Identifier: Apache-2.0
// The shadows that volumes cast onto solids which catch them. Rays are marched from the solids to the lights, because
// the points on solids need not lie in any sheet, and there is only one for each pixel's ray.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/engine/model/frame.h>
#include <scrim/engine/model/sub_lights.h>
#include <scrim/scene/view_scene.h>

#include <cstdint>
#include <optional>

namespace scrim {

/// The point on the first solid of the ray at raster position (x, y), if that solid catches shadows.
std::optional<Vec3> caughtAt(const Solids& solids, const RayFamily& rays, double x, double y);

/// Fills the layers `shadow` of `frame`: for each light with shadows (an extended one by its sub-lights), the fraction
/// of red, green and blue that reaches the first solid of a pixel through all volumes, averaged over the pixel's rays.
/// It is 1 where that solid does not catch shadows, or there is none. Solids cast no shadows here; the renderer that
/// draws them does that. Returns the number of rays that were marched. Calls `checkpoint` now and then.
std::uint64_t catchShadows(const ViewScene& scene, const SubLights& subLights, Frame& frame,
                           const Checkpoint& checkpoint);

}  // namespace scrim
