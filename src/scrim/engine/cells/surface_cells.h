// SPDX-License-Identifier: Apache-2.0
// The surfaces of a classified volume in cells: what they hold back, and which way they face.
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/cells/cell_grid.h>
#include <scrim/scene/view_scene.h>

#include <array>
#include <cstddef>
#include <vector>

namespace scrim {

/// A value for each cell of a grid. Fields are those that the eye sees: interpolated, moved and clipped.
struct SurfaceCells {
    std::vector<Real> extinction;  ///< at the cell's centre, per world unit; 0: it shows nothing
    std::vector<Real> value;       ///< of the field there

    std::size_t bytes() const { return (extinction.size() + value.size()) * sizeof(Real); }
    /// Boxes around those `blocks` of `grid`, whose cells these are, that have a cell of the
    /// surfaces: `margin` world units beyond its cells, within the grid.
    std::vector<Bounds> boxes(const CellGrid& grid, const std::vector<bool>& blocks, double margin) const;
};

/// Which way surfaces face in each cell of a grid: the unit normal out of the denser side along the
/// axes of the world (0, 1, 2), and its weight (3; see normalWeight); 0 where nothing is near.
using SurfaceNormals = std::array<std::vector<Real>, 4>;

/// The integral of a transfer function's extinction over the field's values, so that its mean
/// between two values is a difference (see TransferTable of splat/).
struct ExtinctionIntegral {
    static constexpr int kCount = 1024;
    std::vector<Real> integral;  ///< kCount + 2 values from 0 on, `scale` of them per unit of the field
    std::vector<Real> mean;      ///< of the extinction between two of them
    Real scale = 1;
    Real empty = 0;  ///< values below this show nothing

    ExtinctionIntegral(const Classified& look, double most);
};

/// True if nothing but the field's value tells how dense the volume is at a place.
bool isByValueAlone(const ViewVolume& volume);

/// `volume` must be classified, and have voxels. `kernel`: for fields that have none of their own.
/// `voxel`: unit of the dials.
SurfaceCells surfaceCells(const CellGrid& grid, const ViewVolume& volume, Kernel kernel, double voxel);
SurfaceNormals surfaceNormals(const CellGrid& grid, const ViewVolume& volume, Kernel kernel, double voxel);

}  // namespace scrim
