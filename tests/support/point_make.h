// SPDX-License-Identifier: Apache-2.0
// Writes small files of points: OpenVDB's, with attributes, and PLY. OpenVDB's headers stay behind the .cpp.
#pragma once

#include <scrim/geometry/spaces.h>

#include <string>
#include <vector>

namespace scrim::test {

struct MadePoint {
    Vec3 at{0};
    double radius = 0.1;
    Vec3 velocity{0};
    Vec3 colour{1};
};

/// Points with the attributes `pscale`, `v` and `Cd` in the grid `name`, whose voxels have the edge `voxel`. Places are
/// floats within voxels.
void makePointsVdb(const std::string& path, const std::vector<MadePoint>& points, const std::string& name = "spray",
                   double voxel = 0.5);

/// The same as a PLY file: "ascii", "binary_little_endian" or "binary_big_endian". Colours are bytes.
std::string plyOf(const std::vector<MadePoint>& points, const std::string& format);

}  // namespace scrim::test
