// SPDX-License-Identifier: Apache-2.0
// Where the samples of a sheet lie: at the sheets' own texels, which all views share, or at the cells of one view.
//
// The lattice of a view gives all points on one of its rays the same place (x, y): what ZC02 splats into. N stays what
// it is in texel space, so that a sheet is still a slab of N. The plan makes one for the eye and one for every light;
// whoever treats them differently asks the lattice, not the plan.
#pragma once

#include <scrim/geometry/sheets.h>
#include <scrim/geometry/spaces.h>

#include <glm/vec4.hpp>

namespace scrim {

struct Lattice {
    enum class Kind {
        shared,       ///< the sheets' own texels
        parallel,     ///< of a view whose rays are all parallel: W is 1 everywhere
        perspective,  ///< of a view from a point
    };
    Kind kind = Kind::shared;
    /// Homogeneous: (U, V, N, 1) goes to (x W, y W, N, W). Cells' centres are at whole x and y.
    Mat4 rsFromTs{1.0};
    int width = 0;  ///< cells, a multiple of kTileEdge
    int height = 0;
    int guardTiles = 0;  ///< the eye's: tiles around the picture

    bool shared() const { return kind == Kind::shared; }
    bool parallel() const { return kind != Kind::perspective; }

    /// (x, y, W); W <= 0 behind a view that is not parallel.
    Vec3 place(const Vec3& ts) const;

    /// The affine map that equals this one at `ts` to first order.
    Mat4 linearised(const Vec3& ts) const;

    /// The direction in texel space, of any length, of the ray that is named (x, y).
    Vec3 rayThrough(double x, double y) const;

    /// (U, V, 1) on the plane of N to (x W, y W, W).
    Mat3 fromPlane(double n) const;
};

/// The sheets' own texels.
inline Lattice sharedLattice(const Sheets& sheets) {
    return {Lattice::Kind::shared, Mat4(1.0), sheets.width, sheets.height, 0};
}

}  // namespace scrim
