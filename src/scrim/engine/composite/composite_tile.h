// SPDX-License-Identifier: Apache-2.0
// Compositing: 256 pixels walk their rays through the shaded sheets of a batch (ZC02 eq. 1 and 2).
//
// A pixel's state is (C, -A), the radiance and opacity gathered so far; a shaded texel is (S, -alpha). Front to back,
// state += (1 - A) * texel; back to front, state = texel + (1 - alpha) * state, on all four channels. Opacity is kept
// instead of transmittance, because 1 - T would lose it where a volume is thin. The same holds for each quad of a
// sample's layout (OutputLayout), with the quad's own opacity or, where extinction is coloured, channel by channel with
// the opacity that all quads share.
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/simd.h>
#include <scrim/geometry/sheets.h>
#include <scrim/engine/composite/pixel_tiles.h>
#include <scrim/engine/model/plan.h>
#include <scrim/engine/model/eye_view.h>

#include <cstddef>
#include <cstdint>

namespace scrim {

struct SheetList {
    const Real* const* planes;  ///< RGBA texels of each sheet to walk, in sweep order
    const Real* steps;          ///< places of the sheets in the batch: planes from the batch's first
    int count;
    int width, height;  ///< of the planes, in texels
    OutputLayout layout = {};
    Simd simd = {};
    const std::uint8_t* closed = nullptr;  ///< pixels that receive nothing; null: none
};

/// A sample of less opacity than this does not count as the first visible one.
constexpr Real kLeastVisible = Real(1e-3);

/// Walks all sheets of the list. Back to front, no pixel is closed. `firstDepth`: for each of 256
/// pixels, receives the depth where the first sheet with more opacity than kLeastVisible begins
/// (back to front, the last one visited); null if it is not needed.
void compositeTile(const RayTile& rays, const SheetList& sheets, bool frontToBack, Real* state,
                   PixelTiles::FirstDepth* firstDepth = nullptr);

/// 256 shaded samples of one sheet, `at` planes from the batch's first, each with the fraction in
/// [0, 1] of the sheet that lies in front of the eye (nullptr: all of it).
struct SheetSamples {
    const Real* samples;
    const Real* part;
    const Real* at = nullptr;  ///< only read if the first depth is requested
    OutputLayout layout = {};
    Simd simd = {};
    const std::uint8_t* closed = nullptr;  ///< pixels that receive nothing; null: none
};
void compositeSamples(const RayTile& rays, const SheetSamples& sheet, bool frontToBack, Real* state,
                      PixelTiles::FirstDepth* firstDepth = nullptr);

/// The rest of a sample if only the fraction `part`, in [0, 1], of its sheet is visible: radiance
/// in proportion to opacity.
void keepSeenPart(const OutputLayout& layout, Real part, const Real* sample, Real* kept);

/// Texels of one shaded sheet.
struct ShadedPlane {
    const Real* texels;
    int width, height;
    OutputLayout layout = {};
};

/// Samples a plane at the rays' positions, `at[k]` planes from the batch's first.
void samplePlane(const RayTile& rays, const Real* at, const ShadedPlane& plane, Real* samples, Simd simd = {});

}  // namespace scrim
