// SPDX-License-Identifier: Apache-2.0
// A mesh in memory, and the two steps from its file to blocks and tiles. The steps share nothing but this, so that only
// one file includes the mesh library and only one OpenVDB.
#pragma once

#include <scrim/volume/scrim_source.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace mesh {

using Point = std::array<double, 3>;

struct Mesh {
    std::vector<Point> points;  ///< finite, in world units
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// The triangles of an OBJ or PLY file, at least one; polygons are cut into triangles, all else is left out. Throws
/// std::runtime_error "`path`: ..." where there is no triangle or the file is missing or damaged. `alone`: this process
/// was made for that, and gets limits; where it was not, a damaged file may crash it.
Mesh readMesh(const std::string& path, bool alone);

struct Fog {
    double voxel = 1;    ///< edge, in world units; voxel i has its centre at (i + 0.5) voxel
    double density = 1;  ///< inside
    double soft = 1;     ///< width of the edge's ramp, in world units
    bool fill = true;    ///< the inside of closed surfaces; false: the surfaces alone
};

/// Turns the mesh to fog and hands it to the host as one grid, "density". Returns 0 or what the host returned; throws
/// std::runtime_error where the fog would be too large or has no inside.
int emitFog(const scrim_host* host, const Mesh& mesh, const Fog& fog);

}  // namespace mesh
