// SPDX-License-Identifier: Apache-2.0
// A sweep through the sheets of several levels. Sheets of the coarsest level are swept in their order; one in which
// there are volumes of finer levels is followed by their sheets, which the pixels that see them walk in its place.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/engine/composite/deep_rays.h>
#include <scrim/engine/composite/pixel_tiles.h>
#include <scrim/engine/model/frame.h>
#include <scrim/engine/model/plan.h>
#include <scrim/engine/lamps/cell_light.h>
#include <scrim/scene/view_scene.h>

#include <functional>
#include <vector>

namespace scrim {

/// The rays of a sweep.
struct SweptRays {
    PixelTiles& tiles;    ///< to which the result is added
    const EyeEnds* ends;  ///< objects that hide parts of rays; null: none
    DeepRays* deep;       ///< records the samples of every ray; may be null
};

/// Sweeps `group`, which has finer levels. `progress` is called with the part that is done. Returns
/// the work, with the bytes of the buffers.
RenderWork sweepLevels(const ViewScene& scene, const Plan& plan, const GroupPlan& group,
                       const std::vector<CellLight>& cellLight, const SweptRays& rays,
                       const std::function<void(double)>& progress);

}  // namespace scrim
