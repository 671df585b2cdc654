// SPDX-License-Identifier: Apache-2.0
// Where per-view splatting puts its rasters: the paper's image sheet and shadow sheets (ZC02 section 3.2).
#pragma once

#include <scrim/geometry/view_raster.h>
#include <scrim/engine/plan/light_groups.h>
#include <scrim/scene/view_scene.h>

namespace scrim {

/// The raster of a light's own sheets and shadow buffer: perpendicular to the light, or parallel to the image plane, as
/// the dial shadow_plane says. Throws Error (render) where a light's rays lie along the image plane.
ViewRaster lightRaster(const ViewScene& scene, const std::vector<Vec3>& wsCorners, const Sheets& sheets,
                       const LightPart& part);

/// Tiles around the picture that footprints of voxels just outside of it may reach: a parallel eye's raster needs them.
int guardTiles(const ViewScene& scene, const Camera& camera, const Sheets& sheets);

}  // namespace scrim
