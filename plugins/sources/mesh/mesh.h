// SPDX-License-Identifier: Apache-2.0
// A mesh in memory, and the two steps from its file to blocks and tiles. The steps share only this header, so that one
// file includes the mesh library and another one OpenVDB.
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

/// The triangles of an OBJ or PLY file, at least one. Polygons are divided into triangles; everything else is left out.
/// Throws std::runtime_error "`path`: ..." where there is no triangle or the file is missing or damaged. `alone`: this
/// process was made for the work, and sets itself limits; otherwise a damaged file may crash it.
Mesh readMesh(const std::string& path, bool alone);

struct Fog {
    double voxel = 1;    ///< edge, in world units; the centre of voxel i is at (i + 0.5) voxel
    double density = 1;  ///< inside
    double soft = 1;     ///< width of the edge's ramp, in world units
    bool fill = true;    ///< fills the inside of closed surfaces; false: shows the surfaces only
};

/// Turns the mesh into fog and passes it to the host as one grid, "density". Returns 0 or the host's result; throws
/// std::runtime_error where the fog would be too large or has no inside.
int emitFog(const scrim_host* host, const Mesh& mesh, const Fog& fog);

}  // namespace mesh
