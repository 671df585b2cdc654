// SPDX-License-Identifier: Apache-2.0
// Where the volume of a .vdb file is, known before any voxel is read: OpenVDB notes the active bounds of every grid
// in its metadata. Read by our own walker, which any bytes may be given to, in this process.
#pragma once

#include <scrim/geometry/bounds.h>
#include <scrim/volume/grid_request.h>
#include <scrim/volume/vdb_bytes.h>

#include <optional>
#include <string>
#include <vector>

namespace scrim {

/// The box, in the file's own world space, around the active voxels of the grids that `requests` mean, with two voxels
/// more on each side: whatever a kernel of reach 2 makes of them lies inside. Empty where they have no active voxel.
///
/// None where that cannot be known without reading them: the file cannot be read, is old, a pipe's or damaged, has no
/// such grid, or one without bounds or with a transform that is not affine. Never throws. What a file
/// claims is believed: its writer may have been wrong.
std::optional<Bounds> vdbBounds(const std::string& path, const std::vector<GridRequest>& requests);
std::optional<Bounds> vdbBounds(const VdbBytes& file, const std::vector<GridRequest>& requests);

}  // namespace scrim
