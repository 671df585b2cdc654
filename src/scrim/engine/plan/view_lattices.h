// SPDX-License-Identifier: Apache-2.0
// The rasters that per-view splatting has for every view (ZC02 section 3.2: the paper's image sheet and shadow sheets).
#pragma once

#include <scrim/engine/model/plan.h>
#include <scrim/geometry/lattice.h>
#include <scrim/scene/view_scene.h>

#include <vector>

namespace scrim {

/// The cells of the eye's own sheets: the pixels of `window` and some tiles around them.
Lattice eyeLattice(const ViewScene& scene, const PixelWindow& window, const Sheets& sheets);

/// The cells of a light's own sheets and shadow buffer around the volumes' corners: perpendicular
/// to the light, or parallel to the image plane, as the dial `shadow_plane` says. Sets
/// `part.coarser`. Throws Error (render) if the light's rays lie along the image plane.
Lattice lightLattice(const ViewScene& scene, const Light& light, const std::vector<Vec3>& wsCorners,
                     const Sheets& sheets, PlannedLight& part);

}  // namespace scrim
