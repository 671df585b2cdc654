// SPDX-License-Identifier: Apache-2.0
// From shapes to blocks and tiles. Space is divided as an octree is: a cube that no shape's edge can reach is either
// empty or one tile, whatever its size, and only cubes on an edge are divided, down to blocks of 8 voxels. Time and
// memory so go with surfaces, not with volumes.
#pragma once

#include "shape.h"

#include <scrim/volume/scrim_source.h>

#include <cstdint>
#include <vector>

namespace primitives {

enum class Combine { max, sum };

/// Index space to world: voxel i has its centre at (i + 0.5) voxel, so that what is symmetric about the origin stays
/// so.
struct Raster {
    double voxel = 1;
    Combine combine = Combine::max;
};

/// Part of `shape` in a voxel, times its density: a ramp of the shape's `soft`, half of it outside of the surface.
/// Straight through a flat surface the integral of density is that of the hard one.
double softDensity(const Shape& shape, double distance);

/// Hands the voxels of `shapes` (those of one grid, each with `soft` > 0) to the host. Returns 0 or what the host
/// returned. `from` and `to`: the part of the whole progress.
int fillGrid(const scrim_host* host, int grid, const std::vector<Shape>& shapes, const Raster& raster, double from,
             double to);

}  // namespace primitives
