// SPDX-License-Identifier: Apache-2.0
// Shading of a tile of samples of one sheet: turns extinction and light into radiance and opacity.
//
// The samples are texels (shared by all views, the default) or the points where pixels' rays meet the sheet. Work is
// divided into passes over 256 samples that fit the first-level cache. What a light or a volume does not need
// (distance, cone, slide, phase, shadow, octaves) is a pass that is not run, never a test for each sample. Passes are
// instantiated for the few things that change the form of a sample: shadowed or not and from which side, with or
// without a slide, one extinction or one for each channel, and the kinds of phase functions. These multiply only within
// a pass (scattering: 2 x 2 x 4 loops), so that a new effect is a new pass and does not double all others.
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/simd.h>
#include <scrim/geometry/sheets.h>
#include <scrim/geometry/spaces.h>
#include <scrim/engine/lamps/cell_light.h>
#include <scrim/engine/light/sheet_light.h>
#include <scrim/engine/model/frame.h>
#include <scrim/engine/model/plan.h>
#include <scrim/engine/model/eye_view.h>
#include <scrim/scene/classified.h>
#include <scrim/scene/medium.h>

#include <optional>
#include <span>
#include <vector>

namespace scrim {

/// A medium's contribution to a sheet.
struct SheetMedium {
    /// 256 values for each channel; the scattering coefficient, per world unit, is this times
    /// `albedo`. All three are the medium's extinction unless its albedo is a grid.
    const Real* scatter[3];
    Real albedo[3];  ///< multiplied by the extinction's tint
    Phase phase;
    Octaves octaves;
    /// For each light of the plan, whether it lights this medium; null: all do.
    const std::vector<bool>* lit = nullptr;
    bool ambient = true;                  ///< ambient light reaches the medium without shadows
    std::optional<int> output = {};       ///< its own, beside the beauty or its parts
    const PhaseOverCaps* caps = nullptr;  ///< of `phase`; null: no sub-light is wider than its lobes
};

/// Light on cells at a volume, which acts as an environment that differs from sample to sample.
struct SheetScattered {
    int medium = 0;           ///< index into ShadeInput::media
    int surface = -1;         ///< unless it is -1, index into ShadeInput::surfaces, in place of `medium`
    const Real* radiance[3];  ///< 256 values each
    Real share = 1;           ///< share that the sweep owns
    int output = 0;           ///< the beauty, or one of its parts
    bool again = false;       ///< it has scattered before
    ShownAs as = ShownAs::scattered;
};

/// A source of emission of a sheet: radiance per world unit is 256 coefficients times a colour.
struct SheetEmission {
    const Real* coefficient;
    Real color[3];
    std::optional<int> output = {};  ///< as in SheetMedium
};

/// A classified volume's contribution to a sheet: 256 values each, see ClassifiedTile.
struct SheetSurface {
    const Real* extinction;
    const Real* emission[3];  ///< extinction times colour
    const Real* normal[3];    ///< unit, in sweep space, pointing out of the denser side
    const Real* weight;       ///< weight of the normal
    Real ambient, diffuse, specular, exponent;
    bool twoSided;
    Real albedo[3];  ///< with `emission`, the scattering coefficient of light that has scattered before
    const std::vector<bool>* lit = nullptr;  ///< as in SheetMedium
    std::optional<int> output = {};          ///< as in SheetMedium
    int sceneVolume = 0;
};
/// Its look, without what differs from sample to sample.
SheetSurface surfaceOf(const Classified& look);

/// Buffers of samples (all rows and `outputs`) must be aligned to 64 bytes.
struct ShadeInput {
    const SampleTile* samples;
    Real texel, thickness;  ///< world units
    bool sameSide;          ///< eye and light meet the same side of a sheet first (s = +1)
    /// Total extinction of all volumes per world unit. If it is grey, it is one row of 256 values. If `coloured`, it is
    /// the sum over the extinction channels of a row times its tint, and so is tau at entry.
    const Real* extinction[ExtinctionChannels::kMost];
    /// The same for visible volumes only; nullptr: all are visible.
    const Real* seen[ExtinctionChannels::kMost];
    bool coloured;
    int channels;  ///< 1 if not coloured
    Real tints[ExtinctionChannels::kMost][3];
    std::span<const SheetMedium> media;
    std::span<const SheetSurface> surfaces;
    std::span<const SheetEmission> emissions;
    std::span<const SheetScattered> scattered;
    /// For outputs of volumes' opacities: their extinction, which a sheet makes into opacity as it
    /// makes emission into radiance.
    std::span<const SheetEmission> opacities;
    std::span<const SheetLight> lights;
    /// Tau at entry: `channels` x 256 values for each light; only read for shadowed lights, and of
    /// these in the channels that attenuate them.
    const Real* tauIn;
    /// Null, or 256 values for each shadowed light (if extinction is grey): tau where the eye's
    /// rays leave the sheet. `tauIn` is then tau where they enter it, and not where the light does.
    const Real* tauOut;
    /// 256 values for each light: the fraction that passes solids; nullptr: there are no solids.
    const Real* unblocked;
    Real ambient[3];        ///< radiance of an unshadowed environment; all 0: none
    const Real* motion[2];  ///< pixels per frame, to the right and up; only read for the motion output
    OutputLayout layout;
    Real* outputs;  ///< scratch: 3 x 256 floats for each output other than the beauty
    Simd simd;

    const Real* tauAtEntry(std::size_t light) const { return tauIn + light * std::size_t(channels * kTileSize); }
};

/// Writes the samples in the input's layout: layout.floats() x 256 floats. Returns the work done.
ShadeWork shadeTile(const ShadeInput& input, Real* out);

}  // namespace scrim
