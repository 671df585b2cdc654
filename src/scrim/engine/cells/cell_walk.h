// SPDX-License-Identifier: Apache-2.0
// Rays through the media of cells, from cell to cell.
#pragma once

#include <scrim/engine/cells/cell_media.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include <glm/common.hpp>

namespace scrim {

/// Beyond this optical depth no visible light is left: e^-30 is 1e-13.
inline constexpr double kMostDepth = 30;

/// Calls visit(index of the cell, where the ray enters and leaves it, world units) for the cells along a ray with a
/// unit direction, until that returns false (J. Amanatides and A. Woo, A Fast Voxel Traversal Algorithm for Ray
/// Tracing, 1987). The index is -1 where no cell is stored. `distance`: world units, may be infinite.
template <class Visit>
void walkCells(const CellGrid& grid, const Vec3& ws, const Vec3& direction, double distance, const Visit& visit) {
    const Vec3 origin = grid.csFromWs(ws);
    const double length = distance / grid.edge();  // directions are unit in cells, too
    const Int3 size = grid.blocks() * kCellEdge;
    Int3 cell(glm::floor(origin)), step(0);
    Vec3 next(std::numeric_limits<double>::infinity()), each(std::numeric_limits<double>::infinity());
    for (int axis = 0; axis < 3; ++axis) {
        if (direction[axis] == 0) continue;
        step[axis] = direction[axis] > 0 ? 1 : -1;
        each[axis] = 1 / std::abs(direction[axis]);
        next[axis] = (cell[axis] + (step[axis] > 0 ? 1 : 0) - origin[axis]) / direction[axis];
    }
    double t = 0;
    CellGrid::LastBlock last;
    while (t < length) {
        const int axis = next.x < next.y ? (next.x < next.z ? 0 : 2) : (next.y < next.z ? 1 : 2);
        const double end = std::min(next[axis], length);
        if (!visit(grid.index(cell, last), t * grid.edge(), end * grid.edge())) return;
        t = next[axis];
        cell[axis] += step[axis];
        next[axis] += each[axis];
        if (step[axis] < 0 ? cell[axis] < 0 : cell[axis] >= size[axis]) break;
    }
}

/// What a ray passes, by colour.
struct Depths {
    Rgb tau{0};       ///< optical depth without scattering straight on
    Rgb straight{0};  ///< the depth of that scattering

    Depths& operator+=(const Depths& o) {
        tau += o.tau;
        straight += o.straight;
        return *this;
    }
};

/// The optical depths of the cells from `ws` along a direction (unit), over a distance that may be
/// infinite. Depths beyond `most` are not exact.
Depths opticalDepths(const CellMedia& media, const Vec3& ws, const Vec3& direction, double distance,
                     double most = kMostDepth);

/// Media that hold back the same light, each on cells of its own.
using MediaTogether = std::vector<const CellMedia*>;
/// The same through all of them.
Rgb opticalDepth(const MediaTogether& media, const Vec3& ws, const Vec3& direction, double distance,
                 double most = kMostDepth);

/// The same for a bundle of rays as wide as a cell, through extinction that is interpolated across the ray's main axis:
/// `tau` is the depth of the bundle's mean transmittance. A single ray along an axis stays in one row of cells until it
/// has drifted by half a cell, and then leaves it at once: in a cloud behind which the sun turned by half a degree a
/// frame, light that had scattered jumped by 5 %, and now by 0.4 %. With cells of 2 to 4 voxels, the error of that
/// light is also half as large.
Depths bundleDepths(const CellMedia& media, const Vec3& ws, const Vec3& direction, double distance);

}  // namespace scrim
