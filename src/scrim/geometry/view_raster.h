// SPDX-License-Identifier: Apache-2.0
// The raster of one view over the sheets of a sweep: where a view's rays name the points of space.
//
// A raster that is aligned with its view gives all points on one ray the same place (x, y): what ZC02 splats into. N
// stays what it is in texel space, so that a sheet is still a slab of N.
#pragma once

#include <scrim/geometry/sheets.h>
#include <scrim/geometry/spaces.h>

#include <glm/vec4.hpp>

namespace scrim {

struct ViewRaster {
    /// Homogeneous: (U, V, N, 1) goes to (x W, y W, N, W). Cells' centres are at whole x and y.
    Mat4 rsFromTs{1.0};
    bool parallel = true;  ///< all rays are: W is 1 everywhere
    int width = 0;         ///< cells, a multiple of kTileEdge
    int height = 0;

    /// (x, y, W); W <= 0 behind a view that is not parallel.
    Vec3 place(const Vec3& ts) const;

    /// The affine map that equals this one at `ts` to first order.
    Mat4 linearised(const Vec3& ts) const;

    /// The direction in texel space, of any length, of the ray that is named (x, y).
    Vec3 rayThrough(double x, double y) const;

    /// (U, V, 1) on the plane of N to (x W, y W, W).
    Mat3 fromPlane(double n) const;
};

/// The sheets' own raster, which all views share.
inline ViewRaster sharedRaster(const Sheets& sheets) {
    return {Mat4(1.0), true, sheets.width, sheets.height};
}

}  // namespace scrim
