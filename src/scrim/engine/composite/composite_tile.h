// SPDX-License-Identifier: Apache-2.0
// Compositing: 256 pixels walk their rays through the shaded sheets of a batch (ZC02 eq. 1 and 2).
//
// A pixel's state is (C, -A): radiance and opacity gathered; a shaded texel is (S, -alpha). Front to back is state +=
// (1 - A) * texel, back to front state = texel + (1 - alpha) * state, on all four channels. Opacity and not
// transmittance is what is kept: where a volume is thin, 1 - T would lose it. So it is for each quad of a sample's
// layout (outputs.h), under its own opacity or, where extinction is coloured, channel by channel under that of
// all.
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/simd.h>
#include <scrim/geometry/sheets.h>
#include <scrim/engine/composite/pixel_tiles.h>
#include <scrim/engine/model/outputs.h>
#include <scrim/engine/model/samples.h>

#include <cstddef>

namespace scrim {

struct SheetList {
    const Real* const* planes;  ///< RGBA texels of each sheet to walk, in sweep order
    const Real* steps;          ///< its place in the batch: planes from the batch's first
    int count;
    int width, height;  ///< of the planes, texels
    OutputLayout layout = {};
    Simd simd = {};
};

/// A sample of less opacity than this is no first thing that a ray shows.
constexpr Real kLeastVisible = Real(1e-3);

/// Walks all sheets of the list. `frontToBack`: a pixel that has less transmittance than `cutoff` stops. `firstDepth`:
/// of 256 pixels, where what first sheet has more opacity than kLeastVisible begins (the last to come, back to front);
/// null where nobody asks, as where there is nothing but the beauty.
void compositeTile(const RayTile& rays, const SheetList& sheets, bool frontToBack, Real cutoff, Real* state,
                   PixelTiles::FirstDepth* firstDepth = nullptr);

/// 256 shaded samples of one sheet, `at` planes from the batch's first, each with the part in [0, 1] of the sheet that
/// lies before the eye (nullptr: all of it).
struct SheetSamples {
    const Real* samples;
    const Real* part;
    const Real* at = nullptr;  ///< read where the first depth is asked for
    OutputLayout layout = {};
    Simd simd = {};
};
void compositeSamples(const RayTile& rays, const SheetSamples& sheet, bool frontToBack, Real* state,
                      PixelTiles::FirstDepth* firstDepth = nullptr);

/// What is left of a sample where only a part, in [0, 1], of its sheet is seen: radiance in proportion to opacity.
void keepSeenPart(const OutputLayout& layout, Real part, const Real* sample, Real* kept);

/// Samples one plane at the rays' positions `at[k]` planes from the batch's first.
void samplePlane(const RayTile& rays, const Real* at, const Real* plane, int width, int height,
                 const OutputLayout& layout, Real* samples, Simd simd = {});

}  // namespace scrim
