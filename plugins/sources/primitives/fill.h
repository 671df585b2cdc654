// SPDX-License-Identifier: Apache-2.0
// Turns shapes into blocks and tiles. Space is divided like an octree: a cube that no shape's edge can reach is either
// empty or one tile, whatever its size, and only cubes at an edge are divided, down to blocks of 8 voxels. Time and
// memory are therefore proportional to surfaces, not to volumes.
#pragma once

#include "shape.h"

#include <scrim/volume/scrim_source.h>

#include <cstdint>
#include <vector>

namespace primitives {

enum class Combine { max, sum };

/// The map from index space to the world: the centre of voxel i is at (i + 0.5) voxel, so that shapes that are
/// symmetric about the origin stay symmetric.
struct Raster {
    double voxel = 1;
    Combine combine = Combine::max;
};

/// The shape's density times the fraction of it in a voxel at `distance`: a ramp of width `soft`, half of it outside of
/// the surface. Along a line straight through a flat surface, the integral of density equals that of the hard edge.
double softDensity(const Shape& shape, double distance);

/// Passes the voxels of `shapes` (those of one grid, each with `soft` > 0) to the host. Returns 0 or the host's result.
/// The work reports progress `from` .. `to`.
int fillGrid(const scrim_host* host, int grid, const std::vector<Shape>& shapes, const Raster& raster, double from,
             double to);

}  // namespace primitives
