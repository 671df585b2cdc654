// SPDX-License-Identifier: Apache-2.0
// Triangles in memory.
#pragma once

#include <scrim/geometry/spaces.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace scrim {

struct TriangleMesh {
    std::vector<Vec3> points;                             ///< finite, in the file's own space
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices of points

    std::size_t bytes() const { return points.size() * sizeof(Vec3) + triangles.size() * sizeof(triangles[0]); }
};

}  // namespace scrim
