// SPDX-License-Identifier: Apache-2.0
// Reconstruction kernels: how a voxel spreads into the space around it (ZC02 section 2). A field is the sum of all
// voxels' kernels; everything else in Scrim, and the reference it is checked against, follows from that.
#pragma once

#include <scrim/geometry/spaces.h>
#include <scrim/volume/sparse_field.h>

#include <span>

namespace scrim {

/// Half the extent of the region where the kernel is not 0, measured along a coordinate that is the
/// linear form `row` of index-space offsets.
double kernelExtent(Kernel kernel, const Vec3& row);

/// The kernel at `offset` (index space, voxels) from a voxel's centre. Its integral over index space is 1.
double kernelValue(Kernel kernel, const Vec3& offset);

/// The weights by which a kernel of twice the size is a sum of kernels of this size: by the distance from its centre
/// along each axis, in voxels. Empty for the Gaussian, which has no such weights.
std::span<const double> twoScaleWeights(Kernel kernel);

}  // namespace scrim
