// SPDX-License-Identifier: Apache-2.0
// Turns the results of sweeps, which are in the pixels of their raster, into the frame: sums over sweeps, means over a
// pixel's rays.
#pragma once

#include <scrim/engine/model/frame.h>
#include <scrim/engine/composite/pixel_tiles.h>
#include <scrim/engine/model/plan.h>

namespace scrim {

/// A black frame with all layers that the scene requests.
Frame emptyFrame(const ViewScene& scene);

/// Adds the result of the sweep of `group`, which is in `tiles`.
void resolve(const ViewScene& scene, const Plan& plan, const GroupPlan& group, const PixelTiles& tiles, Frame& frame);

/// Completes the layers that depend on the sum of all sweeps.
void finishLayers(Frame& frame);

}  // namespace scrim
