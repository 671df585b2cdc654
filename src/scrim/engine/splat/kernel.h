// SPDX-License-Identifier: Apache-2.0
// Reconstruction kernels: how a voxel spreads into the space around it (ZC02 section 2). A field is the sum of
// all voxels' kernels; everything else in Scrim, and the reference it is checked against, follows from that.
#pragma once

#include <scrim/geometry/spaces.h>
#include <scrim/scene/dials.h>

namespace scrim {

/// Half the extent, along the direction whose coordinate is the linear form `row` of index space offsets, of the
/// region where the kernel is not 0.
double kernelExtent(Kernel kernel, const Vec3& row);

/// The kernel at `offset` (index space, voxels) from a voxel's centre. Its integral over index space is 1.
double kernelValue(Kernel kernel, const Vec3& offset);

}  // namespace scrim
