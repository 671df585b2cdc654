// SPDX-License-Identifier: Apache-2.0
// Reconstruction kernels: how a voxel spreads into the space around it (ZC02 section 2). A field is the sum of all
// voxels' kernels; everything else in Scrim, and the reference it is checked against, follows from that.
#pragma once

#include <scrim/geometry/spaces.h>

#include <span>

namespace scrim {

/// How a voxel spreads into the space around it (ZC02 section 2).
enum class Kernel {
    linear,    ///< trilinear tent: an exact partition of unity, what ray marchers show
    gaussian,  ///< exp(-2 r^2) cut off at radius 2 voxels, ZC02's usual choice; ripples by about 1 %
    bspline,   ///< cubic B-spline, an exact and smooth partition of unity; blurs
};

/// Half the edge of the box (index space, voxels) outside of which the kernel is 0.
inline double kernelRadius(Kernel kernel) {
    return kernel == Kernel::linear ? 1.0 : 2.0;
}

/// Half the extent, along the direction whose coordinate is the linear form `row` of index space offsets, of the
/// region where the kernel is not 0.
double kernelExtent(Kernel kernel, const Vec3& row);

/// The kernel at `offset` (index space, voxels) from a voxel's centre. Its integral over index space is 1.
double kernelValue(Kernel kernel, const Vec3& offset);

/// The kernel of voxels twice as large is the sum of such kernels: their weights, by the distance along each axis from
/// its middle, in voxels. Empty where it is not (the Gaussian's).
std::span<const double> twoScaleWeights(Kernel kernel);

}  // namespace scrim
