// SPDX-License-Identifier: Apache-2.0
// Shading of a tile's worth of samples of one sheet: extinction and light in, radiance and opacity out.
//
// The samples may be texels (shared by all views, the default) or the points where pixels' rays meet the sheet.
// Work is cut into passes over 256 samples that fit the first-level cache; what a light or a volume does not need
// (distance, cone, slide, phase, shadow, octaves) is a pass that is not run, never a test per sample. Passes are
// instantiated on the few things that change what a sample is: shadowed or not and from which side, with a slide or
// not, one extinction or one for each channel, and the kinds of phase functions. They multiply only within a pass
// (scattering: 2 x 2 x 4 loops), so that a new effect is a new pass and not twice as many of all the others.
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/simd.h>
#include <scrim/geometry/sheets.h>
#include <scrim/geometry/spaces.h>
#include <scrim/engine/light/sheet_light.h>
#include <scrim/engine/model/frame.h>
#include <scrim/engine/model/outputs.h>
#include <scrim/engine/model/samples.h>
#include <scrim/scene/medium.h>

#include <span>
#include <vector>

namespace scrim {

/// Fills in the 16 x 16 texels from (texelX, texelY) of the sheet whose plane is at N = `middle`.
void texelSamples(const Sheets& sheets, const EyeSlopes& eye, double middle, int texelX, int texelY,
                  SampleTile& samples, Simd simd = {});

/// A medium's part in a sheet.
struct SheetMedium {
    /// 256 values for each channel: scattering coefficient, per world unit, is this times `albedo`. All three are the
    /// medium's extinction, unless its albedo is a grid.
    const Real* scatter[3];
    Real albedo[3];  ///< times extinction's tint
    Phase phase;
    Octaves octaves;
    const std::vector<bool>* lit = nullptr;  ///< for each light of the scene, does it light this medium? Null: all do
    bool ambient = true;                     ///< does ambient light reach it as if nothing shadowed it?
    int output = 0;                          ///< where what it shows goes beside the beauty or its parts; 0: nowhere
};

/// Light that scattered before, at a medium: an environment that differs from sample to sample.
struct SheetScattered {
    int medium = 0;           ///< index into ShadeInput::media
    const Real* radiance[3];  ///< 256 values each
    Real share = 1;           ///< that the sweep owns of it
    int output = 0;
};

/// A part of what a sheet sends out by itself: 256 coefficients times a colour are radiance per world unit.
struct SheetEmission {
    const Real* coefficient;
    Real color[3];
    int output = 0;  ///< as a medium's
};

/// A classified volume's part in a sheet: 256 values each, see ClassifiedTile.
struct SheetSurface {
    const Real* extinction;
    const Real* emission[3];  ///< extinction times colour
    const Real* normal[3];    ///< unit, in sweep space, out of the denser side
    const Real* weight;       ///< of the normal
    Real ambient, diffuse, specular, exponent;
    bool twoSided;
    const std::vector<bool>* lit = nullptr;  ///< as a medium's
    int output = 0;                          ///< the same
    int sceneVolume = 0;
};

/// Buffers of samples (all rows and `outputs`) must be aligned to 64 bytes.
struct ShadeInput {
    const SampleTile* samples;
    Real texel, thickness;  ///< world units
    bool sameSide;          ///< eye and light meet the same side of a sheet first (s = +1)
    /// Extinction per world unit, summed over all volumes, is a row of 256 values where it is grey. Where `coloured` it
    /// is the sum over the extinction channels of a row times its tint, and so is tau at entry.
    const Real* extinction[3];
    /// The same of volumes that are seen; nullptr: they all are.
    const Real* seen[3];
    bool coloured;
    int channels;  ///< 1, where not coloured
    Real tints[3][3];
    std::span<const SheetMedium> media;
    std::span<const SheetSurface> surfaces;
    std::span<const SheetEmission> emissions;
    std::span<const SheetScattered> scattered;
    std::span<const SheetLight> lights;
    const Real* tauIn;  ///< `channels` x 256 values a light: tau at entry (read for shadowed lights)
    /// 256 values a light, of what gets past solids; nullptr: there are none.
    const Real* unblocked;
    Real ambient[3];        ///< radiance of an unshadowed environment; all 0: none
    const Real* motion[2];  ///< pixels a frame, to the right and up: read for the output of it
    OutputLayout layout;
    Real* outputs;  ///< scratch: 3 x 256 floats for each output beyond the beauty
    Simd simd;
};

/// Writes the samples in the input's layout: layout.floats() x 256 floats. Returns what it did.
ShadeWork shadeTile(const ShadeInput& input, Real* out);

}  // namespace scrim
