// SPDX-License-Identifier: Apache-2.0
// Reconstruction kernels: how a voxel spreads into the space around it (ZC02 section 2). A field is the sum of
// all voxels' kernels; everything else in Scrim, and the reference it is checked against, follows from that.
#pragma once

#include <scrim/geometry/spaces.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace scrim {

enum class Kernel {
    linear,    ///< trilinear tent: an exact partition of unity, what ray marchers show
    gaussian,  ///< exp(-2 r^2) cut off at radius 2 voxels, ZC02's usual choice; ripples by about 1 %
    bspline,   ///< cubic B-spline, an exact and smooth partition of unity; blurs
};

std::optional<Kernel> kernelFromName(std::string_view name);
std::string kernelName(Kernel kernel);
std::vector<std::string> kernelNames();

/// Half the edge of the box (index space, voxels) outside of which the kernel is 0.
double kernelRadius(Kernel kernel);

/// Half the extent, along the direction whose coordinate is the linear form `row` of index space offsets, of the
/// region where the kernel is not 0.
double kernelExtent(Kernel kernel, const Vec3& row);

/// The kernel at `offset` (index space, voxels) from a voxel's centre. Its integral over index space is 1.
double kernelValue(Kernel kernel, const Vec3& offset);

}  // namespace scrim
