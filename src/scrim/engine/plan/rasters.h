// SPDX-License-Identifier: Apache-2.0
// Places a sweep's rasters: those of shadow buffers on the shared sheets, and those that per-view splatting uses for
// every view (ZC02 section 3.2: the paper's image sheet and shadow sheets).
#pragma once

#include <scrim/engine/model/plan.h>
#include <scrim/geometry/lattice.h>
#include <scrim/scene/view_scene.h>

namespace scrim {

/// Completes a light of a group by its view onto `sheets`. Where cells are largest they have the size that the dial
/// `shadow_texel` states, and there are as many as the rays that meet the volume need. With per-view splatting the
/// light also gets its own sheets: perpendicular to the light, or parallel to the image plane, as the dial
/// `shadow_plane` says. Throws Error(render) if a light's rays lie along the image plane.
PlannedLight planLight(const ViewScene& scene, const std::vector<Vec3>& wsCorners, const Sheets& sheets, double slant,
                       PlannedLight light);

/// For per-view splatting: the cells of the eye's own sheets, which are the pixels of `window` and some tiles around
/// them.
Lattice eyeLattice(const ViewScene& scene, const PixelWindow& window, const Sheets& sheets);

}  // namespace scrim
