// SPDX-License-Identifier: Apache-2.0
// Vectorised resampling between rasters: the loops that shadow buffers, and shading at pixels, are made of.
// Positions outside of a plane are clamped to its border. `nearest` rounds instead of interpolating.
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/simd.h>

#include <cstddef>

namespace scrim {

/// A plane of floats, `width` x `height`, rows `width` apart, at least 2 x 2. It may be a window of a larger
/// plane: positions are those of the larger one, where the window's corner is (x0, y0). (Positions that counted
/// from the window's corner would round differently from window to window.)
struct FloatPlane {
    const Real* data;
    int width, height;
    int x0 = 0, y0 = 0;
    Simd simd = {};  ///< to read it with
};

/// out[k] = plane at (u[k], v[k]), for k in [0, count); count a multiple of 16.
void samplePoints(const FloatPlane& plane, const Real* u, const Real* v, bool nearest, int count, Real* out);

/// out[j * 16 + i] = plane at (u + i * step, v + j * step), for i, j in [0, 16).
void sampleLattice(const FloatPlane& plane, Real u, Real v, Real step, bool nearest, Real* out);

/// One tile of a shadow raster through one sheet.
struct AttenuateTile {
    FloatPlane extinction;  ///< per world unit
    Real u, v, step;        ///< texel under the tile's first cell, and texels from cell to cell
    bool nearest;
    /// World length of the path through the sheet is path * sqrt(1 + a^2 + b^2) with the slopes
    /// a = slopeA + i * slopeStep, b = slopeB + j * slopeStep of cell (i, j).
    Real path, slopeA, slopeB, slopeStep;
    Real* tau;  ///< first cell; rows tauStride apart
    std::ptrdiff_t tauStride;
    Real* entry;  ///< receives tau as it was; rows entryStride apart
    std::ptrdiff_t entryStride;
};
void attenuateTile(const AttenuateTile& tile);

}  // namespace scrim
