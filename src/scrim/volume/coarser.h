// SPDX-License-Identifier: Apache-2.0
// A field at half the resolution, for views in which voxels are much smaller than pixels.
#pragma once

#include <scrim/volume/sparse_field.h>

namespace scrim {

/// Every coarse voxel is the mean of the 2^3 fine voxels it covers, empty ones counting as 0, so that the optical depth
/// through the whole field is preserved; its centre is the centre of the eight. Coarse voxel c covers the fine voxels
/// 2c and 2c + 1 on each axis, also for negative c. The counts of cleaned values are copied.
SparseField coarser(const SparseField& fine);

}  // namespace scrim
