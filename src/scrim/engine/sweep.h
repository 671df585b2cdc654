// SPDX-License-Identifier: Apache-2.0
// One sweep: batch by batch through the sheets of a group, each stage parallel, the batch boundary the only
// barrier between stages.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/engine/frame.h>
#include <scrim/engine/composite/pixel_tiles.h>
#include <scrim/engine/plan/plan.h>

namespace scrim {

/// Called after each batch with the finished part of the sweep in [0, 1].
using SweepProgress = std::function<void(double)>;

/// Runs the sweep of `group` into `tiles`, which must be freshly reset. `camera` has the resolution of the
/// antialiasing raster.
void runSweep(const ViewScene& scene, const Camera& camera, const Plan& plan, const GroupPlan& group, ImageTiles& tiles,
              RenderWork& work, StageTimes& times, const SweepProgress& progress);

}  // namespace scrim
