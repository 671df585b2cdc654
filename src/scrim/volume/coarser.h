// SPDX-License-Identifier: Apache-2.0
// A field at half the resolution, for views in which voxels are much smaller than pixels.
#pragma once

#include <scrim/volume/sparse_field.h>

namespace scrim {

/// Every coarse voxel is the mean of the 2^3 fine ones it covers, empty ones counting as 0, so that optical
/// depth through the whole of the field is kept; its centre is theirs. Coarse voxel c covers the fine ones 2c
/// and 2c + 1 on each axis, also for negative c. What cleaning counted is handed on.
SparseField coarser(const SparseField& fine);

}  // namespace scrim
