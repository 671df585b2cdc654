// SPDX-License-Identifier: Apache-2.0
// The positions of the sheets of one sweep, and texel space, in which the engine works.
//
// Texel space `ts` = (U, V, N) measures sweep space in the sweep's own steps: U and V count texels (texel centres at
// integers), N counts sheets (sheet n is the slab n <= N < n + 1, its plane lies at n + 1/2).
#pragma once

#include <scrim/geometry/spaces.h>

#include <cstddef>
#include <string_view>

namespace scrim {

constexpr int kTileEdge = 16;                     ///< texels, pixels or cells along a tile's edge
constexpr int kTileSize = kTileEdge * kTileEdge;  ///< 256

/// `count` rounded up to whole tiles.
constexpr int roundUpToTile(int count) {
    return (count + kTileEdge - 1) / kTileEdge * kTileEdge;
}

/// width x height of a raster of `what`, for code that plans or allocates one. Texels and tiles have 32-bit numbers, as
/// vector gathers need them: throws Error(render) where there are more than that.
std::size_t rasterArea(int width, int height, std::string_view what);

struct Sheets {
    Vec3 wsAnchor{0};      ///< world position of sweep space's origin; it depends on the scene, not on the camera
    Mat3 ssFromWs{1.0};    ///< rotation; its rows are u, v and w (the axis) in world space
    double texel = 1;      ///< edge of a texel, world units
    double thickness = 1;  ///< thickness of a sheet (the Delta of algorithm and paper), world units
    Vec3 ssOrigin{0};      ///< sweep-space position of texel space's origin: texel (0,0), N = 0
    int width = 0;         ///< texels along u, a multiple of kTileEdge
    int height = 0;        ///< texels along v, a multiple of kTileEdge
    int count = 0;         ///< sheets

    Vec3 tsStep() const { return {1 / texel, 1 / texel, 1 / thickness}; }
    Vec3 tsPoint(const Vec3& ws) const { return (ssFromWs * (ws - wsAnchor) - ssOrigin) * tsStep(); }
    Vec3 tsVector(const Vec3& ws) const { return ssFromWs * ws * tsStep(); }
    Vec3 wsPoint(const Vec3& ts) const;
    /// The affine map to texel space from a space that `wsFrom` maps to the world; composed in
    /// double before any rounding.
    Mat4 tsFrom(const Mat4& wsFrom) const;

    int tilesX() const { return width / kTileEdge; }
    int tilesY() const { return height / kTileEdge; }
};

/// The rotation whose third row is `axis` (unit) and whose second row is as near to `up` as
/// possible, negated where needed so that the rows (u, v, axis) are right-handed.
Mat3 sweepRotation(const Vec3& axis, const Vec3& up);

}  // namespace scrim
