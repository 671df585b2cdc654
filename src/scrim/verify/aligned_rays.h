// SPDX-License-Identifier: Apache-2.0
// Pictures whose rays run through the centres of voxels.
#pragma once

#include <scrim/verify/promise.h>

namespace scrim {

/// Adds to what is expected beyond the promise, where many rays of the picture run along lines through voxels' centres:
/// there interpolation bends, and what texels lose does not even out. `promised`: with the dials that are chosen.
void addAlignedRays(const ViewScene& scene, PromisedDials& promised);

}  // namespace scrim
