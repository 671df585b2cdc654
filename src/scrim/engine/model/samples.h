// SPDX-License-Identifier: Apache-2.0
// The positions of a tile's 256 samples, at texels of a sheet or where pixels' rays meet it.
#pragma once

#include <scrim/base/real.h>
#include <scrim/geometry/sheets.h>
#include <scrim/geometry/spaces.h>

namespace scrim {

/// The spacing of samples on a sheet in two directions: x * t and y * t, in (u, v, N), texels and sheets, with t = t0 +
/// u tu + v tv. A displacement off the plane is projected back to it along the eye's ray. By default it is one texel.
struct SampleSpacing {
    Real x[3] = {1, 0, 0}, y[3] = {0, 1, 0};
    Real t0 = 1, tu = 0, tv = 0;
};

/// 256 samples of one sheet, in texel coordinates of its raster.
struct SampleTile {
    alignas(64) Real u[kTileSize];
    alignas(64) Real v[kTileSize];
    alignas(64) Real eyeA[kTileSize];  ///< slopes du/dw and dv/dw of the eye's rays
    alignas(64) Real eyeB[kTileSize];
    SampleSpacing spacing;  ///< one texel unless set otherwise
    /// Depth along the viewing axis, world units, is depth + depthU u + depthV v; only read for the depth output.
    Real depth = 0, depthU = 0, depthV = 0;
};

/// Eye rays in texel space: parallel rays have constant slopes, others meet at `tsEye`.
struct EyeSlopes {
    bool parallel = true;
    double a = 0, b = 0;  ///< parallel: du/dw and dv/dw
    Vec3 tsEye{0};        ///< otherwise
};

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

}  // namespace scrim
