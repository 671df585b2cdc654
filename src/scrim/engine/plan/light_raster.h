// SPDX-License-Identifier: Apache-2.0
// Chooses the raster of a light's shadow buffer in one sweep.
#pragma once

#include <scrim/engine/plan/plan.h>

namespace scrim {

/// The view of one light part onto `sheets`: cells as large as the dial `shadow_texel` says where they are
/// largest, and as many as the rays that meet the volume need.
LightPlan planLight(const ViewScene& scene, const std::vector<Vec3>& wsCorners, const Sheets& sheets, double slant,
                    LightPart part);

}  // namespace scrim
