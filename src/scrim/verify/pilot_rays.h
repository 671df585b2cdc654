// SPDX-License-Identifier: Apache-2.0
// Estimates the detail that a raster of texels loses: a few rays are marched coarsely through the field as it is and
// through the field as texels reconstruct it.
#pragma once

#include <scrim/scene/view_scene.h>

namespace scrim {

/// A rough relative RMSE that texels of one voxel leave along `rays` rays over the whole picture. It serves to compare
/// scenes. 0 where nothing is visible.
double pilotError(const ViewScene& scene, int rays);

}  // namespace scrim
