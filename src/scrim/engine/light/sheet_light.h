// SPDX-License-Identifier: Apache-2.0
// A light over one sheet, and its slide over a tile's worth of samples there, filtered.
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
#include <scrim/engine/model/samples.h>
#include <scrim/scene/slide_map.h>

#include <vector>

namespace scrim {

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

/// A light over one sheet. Directions are in sweep space, along which the light travels with +w.
struct SheetLight {
    bool distant = true;
    bool spot = false;
    bool oneSided = false;  ///< an element of a surface: the cosine to its axis, and nothing behind
    bool shadowed = true;
    bool withinSheet = true;  ///< counts what the sheet itself takes of the light
    bool decay = true;
    Real slopeA = 0, slopeB = 0;                ///< distant: du/dw, dv/dw
    Real texelU = 0, texelV = 0;                ///< otherwise: the source, in texels
    Real distanceW = 0;                         ///< and its distance to the sheet's plane along w, world units, > 0
    Real radius2 = 0;                           ///< world units squared, > 0 where decay
    Real axisU = 0, axisV = 0, axisW = 1;       ///< spot, element
    Real cosOuter = -1, cosInner = Real(-0.9);  ///< spot: light fades between them
    // Windows cut a light into overlapping parts (light close to the volume): this part's share of a direction
    // is its window's value there over the sum of all. None: 0.
    const std::vector<Vec3>* windows = nullptr;  ///< axes in sweep space
    int window = 0;
    Real windowCos = 0;  ///< a window falls to 0 at this cosine from its axis
    Real intensity[3] = {1, 1, 1};
    int output = 0;  ///< where what it lights goes: a part of the beauty, or the beauty
    int index = 0;   ///< among the lights of the plan
    SheetSlide slide;
};

}  // namespace scrim
