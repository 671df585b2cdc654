// SPDX-License-Identifier: Apache-2.0
// Vectorised resampling between rasters: the loops of shadow buffers and of shading at pixels. Positions outside of a
// plane are clamped to its border. `nearest` rounds instead of interpolating.
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/simd.h>

#include <cstddef>

namespace scrim {

/// A plane of floats, `width` x `height`, at least 2 x 2, with rows `width` apart. It may be a window of a larger
/// plane: positions are then those of the larger one, in which the window's corner is (x0, y0). (Positions relative to
/// the window's corner would be rounded differently from window to window.)
struct FloatPlane {
    const Real* data;
    int width, height;
    int x0 = 0, y0 = 0;
    Simd simd = {};  ///< instructions to read it with
};

/// out[k] = plane at (u[k], v[k]) * scale + (firstU, firstV), for k in [0, count); count a multiple of 16.
void samplePoints(const FloatPlane& plane, const Real* u, const Real* v, bool nearest, int count, Real* out,
                  Real scale = 1, Real firstU = 0, Real firstV = 0);

/// out[j * 16 + i] = plane at (u + i * step, v + j * step), for i, j in [0, 16).
void sampleLattice(const FloatPlane& plane, Real u, Real v, Real step, bool nearest, Real* out);

/// One tile of a shadow raster on its way through one sheet.
struct AttenuateTile {
    FloatPlane extinction;  ///< per world unit
    Real u, v, step;        ///< texel under the tile's first cell, and texels between cells
    bool nearest;
    /// World length of the path through the sheet is path * sqrt(1 + a^2 + b^2) with the slopes a = slopeA + i *
    /// slopeStep, b = slopeB + j * slopeStep of cell (i, j).
    Real path, slopeA, slopeB, slopeStep;
    Real* tau;  ///< first cell; rows are tauStride apart
    std::ptrdiff_t tauStride;
    Real* entry;  ///< receives tau at entry; rows are entryStride apart
    std::ptrdiff_t entryStride;
};
void attenuateTile(const AttenuateTile& tile);

/// The cells of a tile, and one more on every side (but not at the corners).
struct HaloTile {
    /// The limits that prefiltered cells are clamped to: not below 0, or between their neighbours.
    enum class Limit { zero, neighbours };

    static constexpr int kStride = 48;  ///< floats from row to row
    Real* at(int x, int y) { return cells + (y + 1) * kStride + x + 16; }
    const Real* at(int x, int y) const { return cells + (y + 1) * kStride + x + 16; }
    alignas(64) Real cells[kStride * 18];
};

/// out = f - strength (second differences along x and y), with rows `stride` floats apart; returns the largest value.
Real prefilterTile(const HaloTile& halo, Real strength, HaloTile::Limit limit, Simd simd, Real* out,
                   std::ptrdiff_t stride);

}  // namespace scrim
