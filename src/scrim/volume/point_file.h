// SPDX-License-Identifier: Apache-2.0
// Reads points of PLY files and of NumPy arrays. Both are simple enough that each length is checked
// against the file before anything is allocated.
#pragma once

#include <scrim/volume/point_cloud.h>
#include <scrim/volume/vdb_bytes.h>

#include <string>

namespace scrim {

/// "PLY" or "NumPy" by the file's first bytes; "" where it is neither.
std::string pointFormat(const VdbBytes& bytes);

/// True for names that end in .ply, and for NumPy's files that hold no volume: an array of two dimensions.
bool isPointFile(const std::string& path);

/// The points of such a file, called "points". Of PLY: x, y, z of the vertices; vx, vy, vz become
/// the attribute `v`, red, green, blue the attribute `Cd` (bytes by 1/255), and every other number
/// one of its own name. Of NumPy: an array of floats or doubles (n, 3), (n, 4) with radii, (n, 7)
/// with radii and velocities, or (n, 10) with colours, too. Throws Error(input) "path: ...".
PointCloud readPointFile(const VdbBytes& bytes);

}  // namespace scrim
