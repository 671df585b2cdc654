// SPDX-License-Identifier: Apache-2.0
// What a few rays over the whole picture see of light on cells, and of the light beside it.
#pragma once

#include <scrim/engine/lamps/cell_light.h>
#include <scrim/scene/view_scene.h>

#include <vector>

namespace scrim {

/// Light on two sizes of cells, relative to the mean of all light.
struct SeenCells {
    double difference = 0;  ///< RMS over the rays of what one size shows beside the other
    double ofEach = 0;      ///< likewise, each ray relative to its own light, or to a tenth of the mean
    double share = 0;       ///< the light on the finer cells
    double other = 0;       ///< the light on the other ones
};

/// Looks along 64 rays that meet something. The scene's lights, points and suns, are those that are
/// not on cells. All members of the result are 0 where nothing is seen.
SeenCells seenCells(const ViewScene& scene, const std::vector<CellLight>& fine, const std::vector<CellLight>& other);

}  // namespace scrim
