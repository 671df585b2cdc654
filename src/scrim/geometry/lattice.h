// SPDX-License-Identifier: Apache-2.0
// The positions of a sheet's samples: the sheets' own texels, which all views share, or the cells of one view.
//
// The lattice of a view gives all points on one of its rays the same place (x, y); ZC02 splats into such a raster. N
// stays what it is in texel space, so a sheet is still a slab in N. The plan makes one lattice for the eye and one for
// every light; code that treats them differently asks the lattice, not the plan.
#pragma once

#include <scrim/geometry/sheets.h>
#include <scrim/geometry/spaces.h>

#include <glm/vec4.hpp>

namespace scrim {

struct Lattice {
    enum class Kind {
        shared,       ///< the sheets' own texels
        parallel,     ///< the cells of a view whose rays are all parallel: W is 1 everywhere
        perspective,  ///< the cells of a view from a point
    };
    Kind kind = Kind::shared;
    /// Homogeneous map: (U, V, N, 1) goes to (x W, y W, N, W). The centres of cells are at whole x and y.
    Mat4 rsFromTs{1.0};
    int width = 0;  ///< in cells, a multiple of kTileEdge
    int height = 0;
    int guardTiles = 0;  ///< of the eye's lattice: tiles around the picture

    bool shared() const { return kind == Kind::shared; }
    bool parallel() const { return kind != Kind::perspective; }

    /// (x, y, W) of a point; W <= 0 behind a perspective view.
    Vec3 place(const Vec3& ts) const;

    /// The affine map that agrees with this one at `ts` to first order.
    Mat4 linearised(const Vec3& ts) const;

    /// The direction, in texel space and of any length, of the ray at (x, y).
    Vec3 rayThrough(double x, double y) const;

    /// The map from (U, V, 1) on the plane of N to (x W, y W, W).
    Mat3 fromPlane(double n) const;
};

/// The lattice of the sheets' own texels.
inline Lattice sharedLattice(const Sheets& sheets) {
    return {Lattice::Kind::shared, Mat4(1.0), sheets.width, sheets.height, 0};
}

}  // namespace scrim
