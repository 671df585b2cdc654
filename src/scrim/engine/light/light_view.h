// SPDX-License-Identifier: Apache-2.0
// A light as one sweep sees it: the raster of its shadow buffer and the map between raster and sheets.
//
// The raster is parallel to the sheets. A cell (i, j) is a light ray, named by where it crosses the plane N = 0
// (distant lights) or by its slope (point lights), and either way the cells of one sheet are a scaled and
// shifted lattice: texel = offset + cell * scale. The projective map of ZC02 eq. 4 thus separates into rows and
// columns; for distant lights the scale is 1 at every sheet and resampling is a streaming operation.
#pragma once

#include <scrim/geometry/sheets.h>
#include <scrim/geometry/spaces.h>

#include <algorithm>

namespace scrim {

/// Texel coordinates of cell (i, j) on one sheet: offset + (i, j) * scale.
struct CellMap {
    double offsetU = 0, offsetV = 0, scale = 1;
};

struct LightView {
    bool distant = true;
    Vec3 tsSource{0};  ///< distant: (dU/dN, dV/dN, 0) of all rays; point: the source's position
    Vec2 first{0};     ///< cell (0, 0): (U, V) at N = 0 (distant), (dU/dN, dV/dN) (point)
    double cell = 1;   ///< step from cell to cell in the units of `first`
    int width = 0;     ///< cells, a multiple of kTileEdge
    int height = 0;
    double slopeScale = 1;  ///< texel / thickness: turns dU/dN into the slope du/dw

    /// Does the light reach the middle plane of sheet n? A point light needs half a sheet of distance: closer
    /// than that its rays are no longer told apart.
    bool reaches(int n) const { return distant || n + 0.5 - tsSource.z >= 0.5; }

    /// The part in [0, 1] of sheet n's thickness that lies before a point light (all of it for a distant one): the
    /// sheet in which the light stands is lit in part.
    double litPart(int n) const { return distant ? 1.0 : std::clamp(n + 1 - tsSource.z, 0.0, 1.0); }

    /// Map at the middle plane of sheet n, which the light must reach.
    CellMap at(int n) const {
        const double middle = n + 0.5;
        if (distant) return {first.x + tsSource.x * middle, first.y + tsSource.y * middle, cell};
        const double z = middle - tsSource.z;
        return {tsSource.x + first.x * z, tsSource.y + first.y * z, cell * z};
    }
};

}  // namespace scrim
