// SPDX-License-Identifier: Apache-2.0
// The slide of a light over a tile's worth of samples of one sheet, filtered.
//
// What a sample stands for is not a point: it is as wide as the samples are apart, and as long as the way of the eye's
// ray through the sheet. A ray marcher would see the slide's average along that way, and so does this: the footprint on
// the slide is the parallelepiped of the two spacings and the ray's segment, flattened; its covariance (a box of edge e
// has e^2 / 12) gives a long and a short axis. Along the long one several taps are averaged, the short one picks the
// level of the mip pyramid (between levels: trilinear). A footprint smaller than a pixel of the slide needs no filter:
// magnified slides stay as sharp as they are. The picture's border is sharp whatever the size of its pixels: a tap
// counts as much as the part of its box that lies within.
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/simd.h>
#include <scrim/scene/slide_map.h>

namespace scrim {

/// How far apart samples are on a sheet, along two directions: x * t and y * t, (u, v, N) in texels and sheets, with
/// t = t0 + u tu + v tv; what moves off the plane follows the eye's ray back to it. As it is here: one texel.
struct SampleSpacing {
    Real x[3] = {1, 0, 0}, y[3] = {0, 1, 0};
    Real t0 = 1, tu = 0, tv = 0;
};

/// 256 samples of one sheet, in texel coordinates of its raster.
struct SampleTile {
    alignas(64) Real u[kTileSize];
    alignas(64) Real v[kTileSize];
    alignas(64) Real eyeA[kTileSize];  ///< slopes du/dw and dv/dw of the eye's ray
    alignas(64) Real eyeB[kTileSize];
    SampleSpacing spacing;  ///< texels, unless said otherwise
    /// Depth along the viewing axis, world units, is depth + depthU u + depthV v: read for the output of it.
    Real depth = 0, depthU = 0, depthV = 0;
};

/// A slide over one sheet. Without an image there is none.
struct SheetSlide {
    const Texture* image = nullptr;
    SlideOutside outside = SlideOutside::black;
    SlideMap::OnSheet map;
    Simd simd = {};
};

/// Writes 3 x 256 floats, all reds first: what the light's intensity is multiplied by. False, and nothing written,
/// where that is 0 for all samples. `toTexels`: texels a sheet, which takes slopes du/dw to texels.
bool tintTile(const SheetSlide& slide, const SampleTile& samples, Real toTexels, Real* tint);

}  // namespace scrim
