// SPDX-License-Identifier: Apache-2.0
// Shading of a tile's worth of samples of one sheet: extinction and light in, radiance and opacity out.
//
// The samples may be texels (shared by all views, the default) or the points where pixels' rays meet the sheet.
// Work is cut into passes over 256 samples that fit the first-level cache; what a light or a volume does not need
// (distance, cone, slide, phase, shadow) is a pass that is not run, never a test per sample.
#pragma once

#include <scrim/geometry/sheets.h>
#include <scrim/geometry/spaces.h>
#include <scrim/light/slide_tile.h>

#include <vector>

namespace scrim {

/// 256 samples of one sheet, in texel coordinates of its raster.
struct SampleTile {
    alignas(64) float u[kTileSize];
    alignas(64) float v[kTileSize];
    alignas(64) float eyeA[kTileSize];  ///< slopes du/dw and dv/dw of the eye's ray
    alignas(64) float eyeB[kTileSize];
    SampleSpacing spacing;  ///< texels, unless said otherwise
};

/// Eye rays in texel space: parallel ones have constant slopes; those from a point meet at `tsEye`.
struct EyeSlopes {
    bool parallel = true;
    double a = 0, b = 0;  ///< parallel: du/dw and dv/dw
    Vec3 tsEye{0};        ///< otherwise
};

/// Fills in the 16 x 16 texels from (texelX, texelY) of the sheet whose plane is at N = `middle`.
void texelSamples(const Sheets& sheets, const EyeSlopes& eye, double middle, int texelX, int texelY,
                  SampleTile& samples);

/// A light over one sheet. Directions are in sweep space, along which the light travels with +w.
struct SheetLight {
    bool distant = true;
    bool spot = false;
    bool shadowed = true;
    bool withinSheet = true;  ///< counts what the sheet itself takes of the light
    bool decay = true;
    float slopeA = 0, slopeB = 0;           ///< distant: du/dw, dv/dw
    float texelU = 0, texelV = 0;           ///< otherwise: the source, in texels
    float distanceW = 0;                    ///< and its distance to the sheet's plane along w, world units, > 0
    float radius2 = 0;                      ///< world units squared, > 0 where decay
    float axisU = 0, axisV = 0, axisW = 1;  ///< spot
    float cosOuter = -1, cosInner = -0.9f;  ///< spot: light fades between them
    // Windows cut a light into overlapping parts (light close to the volume): this part's share of a direction
    // is its window's value there over the sum of all. None: 0.
    const std::vector<Vec3>* windows = nullptr;  ///< axes in sweep space
    int window = 0;
    float windowCos = 0;  ///< a window falls to 0 at this cosine from its axis
    float intensity[3] = {1, 1, 1};
    SheetSlide slide;
};

/// A volume's part in a sheet.
struct SheetMedium {
    const float* extinction;  ///< 256 values, per world unit
    float albedo[3];
    float g;  ///< Henyey-Greenstein; 0: isotropic
};

/// A classified volume's part in a sheet: 256 values each, see ClassifiedTile.
struct SheetSurface {
    const float* extinction;
    const float* emission[3];  ///< extinction times colour
    const float* normal[3];    ///< unit, in sweep space, out of the denser side
    const float* weight;       ///< of the normal
    float ambient, diffuse, specular, exponent;
    bool twoSided;
};

/// Buffers of samples (`extinction`, of media too, and `tauIn`) must be aligned to 64 bytes.
struct ShadeInput {
    const SampleTile* samples;
    float texel, thickness;   ///< world units
    bool sameSide;            ///< eye and light meet the same side of a sheet first (s = +1)
    const float* extinction;  ///< 256 values: the sum over all volumes, per world unit
    const SheetMedium* media;
    int mediumCount;
    const SheetSurface* surfaces;
    int surfaceCount;
    const SheetLight* lights;
    int lightCount;
    const float* tauIn;  ///< 256 values a light: tau at entry (read for shadowed lights)
    float ambient[3];    ///< radiance of an unshadowed environment; all 0: none
};

/// Writes, for each sample, (radiance S, -opacity) interleaved: 4 x 256 floats.
void shadeTile(const ShadeInput& input, float* out);

}  // namespace scrim
