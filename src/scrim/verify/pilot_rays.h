// SPDX-License-Identifier: Apache-2.0
// What a raster of texels would not see of a scene: a few rays, marched coarsely, through the field as it is and
// through the field as texels hold it.
#pragma once

#include <scrim/scene/view_scene.h>

namespace scrim {

/// The relative RMSE that texels of a voxel leave along `rays` rays of the whole picture, roughly: what counts is how
/// it differs from scene to scene. 0 where nothing is to be seen.
double pilotError(const ViewScene& scene, int rays);

}  // namespace scrim
