// SPDX-License-Identifier: Apache-2.0
// Finds the place of a .vdb file's volume before any voxel is read: OpenVDB stores the active bounds of every grid in
// its metadata. Our own walker reads them in this process; it is safe on any bytes.
#pragma once

#include <scrim/geometry/bounds.h>
#include <scrim/volume/grid_request.h>
#include <scrim/volume/vdb_bytes.h>

#include <optional>
#include <string>
#include <vector>

namespace scrim {

/// The box, in the file's own world space, around the active voxels of the grids that `requests`
/// mean, extended by two voxels on each side so that it contains everything a kernel of reach 2
/// makes of them. Empty where they have no active voxels.
///
/// No value where the box cannot be known without reading the voxels: the file cannot be read, is old, was written to a
/// pipe or is damaged, or it lacks such a grid, the grid's bounds or an affine transform. Never throws. The file's
/// statement is believed, although its writer may have been wrong.
std::optional<Bounds> vdbBounds(const std::string& path, const std::vector<GridRequest>& requests);
std::optional<Bounds> vdbBounds(const VdbBytes& file, const std::vector<GridRequest>& requests);

/// True if the file is one of points, or has a grid of them, as far as its header tells. Never throws.
bool holdsPoints(const std::string& path);
bool holdsPoints(const VdbBytes& file);

}  // namespace scrim
