// SPDX-License-Identifier: Apache-2.0
// The eye as one sweep sees it: where pixels' rays cross the sheets, and which pixels see a texel;
// and the positions of a tile's 256 samples, at texels of a sheet or where pixels' rays meet it.
#pragma once

#include <scrim/geometry/camera.h>
#include <scrim/geometry/sheets.h>
#include <scrim/geometry/lattice.h>
#include <scrim/geometry/spaces.h>
#include <scrim/image/image.h>
#include <scrim/base/real.h>
#include <scrim/base/simd.h>

#include <optional>

namespace scrim {

/// The texel positions from which look-ups may use these tiles: a texel serves bilinear look-ups up to one texel away.
inline Box2<double> texelsAround(const Box2<int>& tiles) {
    return {double(tiles.x0 * kTileEdge - 1), double(tiles.y0 * kTileEdge - 1), double(tiles.x1 * kTileEdge),
            double(tiles.y1 * kTileEdge)};
}

/// The spacing of samples on a sheet in two directions: x * t and y * t, in (u, v, N), texels and sheets, with t = t0 +
/// u tu + v tv. A displacement off the plane is projected back to it along the eye's ray. By default it is one texel.
struct SampleSpacing {
    Real x[3] = {1, 0, 0}, y[3] = {0, 1, 0};
    Real t0 = 1, tu = 0, tv = 0;
};

/// The pixels of all tiles that `region` touches. Tiles begin at multiples of kTileEdge, so that a
/// crop has the tiles of the whole picture, and its pixels the same bits.
inline PixelWindow tilesAround(const PixelWindow& region) {
    const auto down = [](int x) { return (x >= 0 ? x : x - kTileEdge + 1) / kTileEdge * kTileEdge; };
    const auto up = [&](int x) { return -down(-x); };
    return {down(region.x0), down(region.y0), up(region.x1), up(region.y1)};
}

/// The rays of a tile of pixels: texel positions at the batch's first plane, and steps from plane to plane.
struct RayTile {
    alignas(64) Real u[kTileSize];
    alignas(64) Real v[kTileSize];
    alignas(64) Real stepU[kTileSize];
    alignas(64) Real stepV[kTileSize];
    alignas(64) Real startN[kTileSize];  ///< where the ray begins, in sheets from the batch's first plane
    alignas(64) Real depth[kTileSize];   ///< along the viewing axis, world units, at the batch's first plane
    alignas(64) Real stepDepth[kTileSize];
};

/// 256 samples of one sheet, in texel coordinates of its raster.
struct SampleTile {
    alignas(64) Real u[kTileSize];
    alignas(64) Real v[kTileSize];
    alignas(64) Real eyeA[kTileSize];  ///< slopes du/dw and dv/dw of the eye's rays
    alignas(64) Real eyeB[kTileSize];
    /// The rays that the samples lie on, if they all lie where these meet one plane: `step` planes
    /// from the rays' first.
    const RayTile* rays = nullptr;
    Real step = 0;
    /// For each sample the part of the sheet that its ray passes, in sheets, and the place of that part's middle, where
    /// the sample lies, in planes as `step`. Null: rays pass the whole sheet, and samples lie in its middle.
    const Real* part = nullptr;
    const Real* at = nullptr;
    SampleSpacing spacing;  ///< one texel unless set otherwise
    /// Depth along the viewing axis, world units, is depth + depthU u + depthV v; only read for the depth output.
    Real depth = 0, depthU = 0, depthV = 0;
};

class EyeView {
  public:
    EyeView(const Camera& camera, const Sheets& sheets, Simd simd = {});

    Simd simd() const { return m_simd; }

    /// One pixel's ray in texel space: (U, V) = position + slope * (N - reference). Its depth,
    /// along the viewing axis, is depth + stepDepth * (N - reference).
    struct Ray {
        double u, v;
        double slopeU, slopeV;  ///< texels per sheet
        double startN;          ///< N where the ray begins (at the eye or the near plane)
        double depth, stepDepth;
    };

    /// The ray through raster position (x, y), with its position on the plane N = `reference`.
    Ray ray(double x, double y, double reference) const;

    /// Smaller depths are not visible.
    double near() const { return m_ts.near; }

    /// The rays through the centres of the 16 x 16 pixels from (x0, y0), for a batch whose first
    /// plane is at N = `reference`.
    RayTile rays(int x0, int y0, double reference) const;

    /// N - reference of points on the rays of those pixels, given by their depths along the viewing
    /// axis. An infinite depth gives an infinite N in the direction of the ray.
    void planesAt(int x0, int y0, const double* depths, double reference, Real* planes) const;

    /// The lattice of the pixels in tiles of `region`, with `guardTiles` more tiles on each side, into which per-view
    /// splatting splats. The first pixel of tilesAround(region) is the first of tile (guardTiles, guardTiles).
    Lattice lattice(const PixelWindow& region, int guardTiles) const;

    /// Fills in the 16 x 16 texels from (texelX, texelY) of the sheet whose plane is at N = `middle`, with their depth.
    void setTexels(double middle, int texelX, int texelY, SampleTile& samples) const;

    /// The spacing of pixels on the plane N = `middle`, as a function of a sample's position.
    SampleSpacing pixelSpacing(double middle) const;

    /// Sets in `samples` the depth of positions on the plane N = `middle`.
    void setDepth(double middle, SampleTile& samples) const;

    /// A box, in raster positions, around the pixels whose rays may pass through a box of texels on
    /// the plane N = `middle`. No value if no bound is known (next to the eye and behind it).
    std::optional<Box2<double>> seenBy(const Box2<double>& texels, double middle) const;

  private:
    bool m_orthographic;
    Simd m_simd;
    RayFamily m_ts;               // origins and directions in texel space
    Mat3 m_rasterFromOffset;      // inverse of the ray family's linear part
    double m_texel, m_thickness;  // of the sheets, world units
};

}  // namespace scrim
