// SPDX-License-Identifier: Apache-2.0
// From what sweeps left in the pixels of their raster to the frame: sums over sweeps, means over a pixel's rays.
#pragma once

#include <scrim/engine/model/frame.h>
#include <scrim/engine/composite/pixel_tiles.h>
#include <scrim/engine/model/plan.h>

namespace scrim {

/// Black, with all layers that the scene wants.
Frame emptyFrame(const ViewScene& scene);

/// Adds what the sweep of `group` left in `tiles`.
void resolve(const ViewScene& scene, const Plan& plan, const GroupPlan& group, const PixelTiles& tiles, Frame& frame);

/// After all sweeps: what only their sum tells.
void finishLayers(Frame& frame);

}  // namespace scrim
