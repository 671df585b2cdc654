// SPDX-License-Identifier: Apache-2.0
// Reconstruction kernels: how a voxel spreads into the space around it (ZC02 section 2). A field is the sum of all
// voxels' kernels; everything else in Scrim, and the reference it is checked against, follows from that.
#pragma once

#include <scrim/geometry/spaces.h>

#include <span>

namespace scrim {

/// The shape of a voxel's contribution to the space around it (ZC02 section 2).
enum class Kernel {
    linear,    ///< trilinear tent: an exact partition of unity, as in ray marchers
    gaussian,  ///< exp(-2 r^2) cut off at radius 2 voxels, ZC02's usual choice; ripples by about 1 %
    bspline,   ///< cubic B-spline: an exact and smooth partition of unity, which blurs
};

/// Half the edge of the box (index space, voxels) outside of which the kernel is 0.
inline double kernelRadius(Kernel kernel) {
    return kernel == Kernel::linear ? 1.0 : 2.0;
}

/// Half the extent of the region where the kernel is not 0, measured along a coordinate that is the linear form `row`
/// of index-space offsets.
double kernelExtent(Kernel kernel, const Vec3& row);

/// The kernel at `offset` (index space, voxels) from a voxel's centre. Its integral over index space is 1.
double kernelValue(Kernel kernel, const Vec3& offset);

/// The weights by which a kernel of twice the size is a sum of kernels of this size: by the distance from its centre
/// along each axis, in voxels. Empty for the Gaussian, which has no such weights.
std::span<const double> twoScaleWeights(Kernel kernel);

}  // namespace scrim
