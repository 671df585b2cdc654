// SPDX-License-Identifier: Apache-2.0
// The buffers of a batch of sheets: a few planes of texels, of which only touched tiles cost anything; and vectorised
// resampling between rasters, the loops of shadow buffers and of shading at pixels.
//
// Planes are dense in address space, so that rows are contiguous, but memory is used only where
// something was written: they start as untouched zero pages, and each plane records the states of
// its tiles of 16 x 16. A tile that is not active reads as zeros. The work of clearing depends on
// the number of tiles that were written, never on the plane's size.
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/zeroed_array.h>
#include <scrim/geometry/box2.h>
#include <scrim/geometry/sheets.h>
#include <scrim/base/simd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

namespace scrim {

/// A plane of floats, `width` x `height`, at least 2 x 2, with rows `width` apart. It may be a window of a larger
/// plane: positions are then those of the larger one, in which the window's corner is (x0, y0). (Positions relative to
/// the window's corner would be rounded differently from window to window.) Positions outside of it are clamped to its
/// border. `nearest` rounds instead of interpolating.
struct FloatPlane {
    const Real* data;
    int width, height;
    int x0 = 0, y0 = 0;
    Simd simd = {};  ///< instructions to read it with
};

/// Calls visit(i) for each i below `count` with states[i] == state, ascending. Most tiles of a large sheet are empty,
/// and passing over them should cost next to nothing. `visit` may change states up to its own.
template <class State, class Visit>
void forTilesIn(State* states, int count, std::uint8_t state, const Visit& visit) {
    State* const end = states + count;
    for (State* at = states; at < end; ++at) {
        at = static_cast<State*>(std::memchr(at, state, static_cast<std::size_t>(end - at)));
        if (at == nullptr) return;
        visit(static_cast<int>(at - states));
    }
}

class PlaneStack {
  public:
    /// `width` and `height` in texels, multiples of kTileEdge; `channels` floats per texel,
    /// interleaved. Throws Error (memory) if the address space is not available.
    PlaneStack(int planes, int width, int height, int channels);

    int planes() const { return m_planes; }
    int width() const { return m_width; }
    int height() const { return m_height; }
    int channels() const { return m_channels; }
    int rowStride() const { return m_width * m_channels; }  ///< floats
    std::ptrdiff_t planeStride() const { return m_planeStride; }
    /// Which of all planes is plane 0 from now on: a part of a batch counts its planes from there.
    void countFrom(int first) { m_first = first; }
    Real* plane(int p) { return m_data.data() + (m_first + p) * m_planeStride; }
    const Real* plane(int p) const { return m_data.data() + (m_first + p) * m_planeStride; }
    /// The first float of a tile.
    Real* tile(int p, int tx, int ty) { return plane(p) + tileOffset(tx, ty); }
    const Real* tile(int p, int tx, int ty) const { return plane(p) + tileOffset(tx, ty); }
    /// Plane p, to be read with look-ups (of a stack with one channel).
    FloatPlane view(int p, Simd simd) const { return {plane(p), m_width, m_height, 0, 0, simd}; }

    int tilesX() const { return m_width / kTileEdge; }
    int tilesY() const { return m_height / kTileEdge; }
    bool active(int p, int tx, int ty) const { return m_state[tileIndex(p, tx, ty)] == kActive; }
    /// Calls visit(tx) for the active tiles of a row, ascending; it may make that tile inactive.
    template <class Visit>
    void forActive(int p, int ty, const Visit& visit) const {
        forTilesIn(m_state.data() + tileIndex(p, 0, ty), tilesX(), kActive, visit);
    }
    /// True if any of these tiles is active; tiles outside of the plane are not.
    bool anyActive(int p, const Box2<int>& tiles) const;
    int activeCount(int p) const;
    /// The smallest box of tiles around the active ones.
    Box2<int> activeBounds(int p) const;

    // The life of a plane in a batch: begin, then any mix of activate (before adding to a tile) and
    // replace (before writing all of a tile), then finish. Different threads may handle different
    // planes, and different tiles of one plane.

    /// Forgets the plane's contents. Old tiles are cleared when they are next touched, or by finish.
    void begin(int p);
    /// Makes a tile active and fills it with zeros, unless it is active already.
    void activate(int p, int tx, int ty);
    /// Makes a tile active without clearing it.
    void replace(int p, int tx, int ty) { m_state[tileIndex(p, tx, ty)] = kActive; }
    /// Clears the rest of the old contents. `finishRow` does so for one row of tiles.
    void finish(int p);
    void finishRow(int p, int ty);
    /// Compensates for the blur of later look-ups: f - 1/12 (second differences along u and v), but not below 0, for a
    /// finished plane with one channel. See forPrefilteredTiles. Tiles of zeros become inactive.
    void prefilter(int p, Simd simd = {});
    /// Sets values below 0 in active tiles to 0.
    void raiseToZero(int p);
    /// Makes tiles inactive that contain only zeros (for a plane with one channel).
    void dropEmpty(int p);

    std::size_t bytes() const { return bytes(m_planes, m_width, m_height, m_channels); }
    /// Bytes of address space of a stack of this shape; memory use is at most as large.
    static std::size_t bytes(int planes, int width, int height, int channels);

  private:
    // The states of a tile.
    static constexpr std::uint8_t kClean = 0, kStale = 1, kActive = 2;

    std::size_t tileIndex(int p, int tx, int ty) const {
        return (std::size_t(m_first + p) * std::size_t(tilesY()) + std::size_t(ty)) * std::size_t(tilesX()) +
               std::size_t(tx);
    }
    std::ptrdiff_t tileOffset(int tx, int ty) const {
        return static_cast<std::ptrdiff_t>(ty * kTileEdge) * rowStride() + tx * kTileEdge * m_channels;
    }
    void clearTile(int p, int tx, int ty);

    int m_planes, m_width, m_height, m_channels;
    int m_first = 0;
    std::ptrdiff_t m_planeStride;
    ZeroedArray<Real> m_data;
    std::vector<std::uint8_t> m_state;
};

/// True if look-ups in a box of texel positions may meet active tiles of plane p.
bool anyActiveNear(const PlaneStack& planes, int p, const Box2<double>& texels);

/// From places (u, v) to those of a plane: (u, v) * scale + (firstU, firstV).
struct PlaneMap {
    Real scale = 1, firstU = 0, firstV = 0;
};

/// out[k] = plane at map(u[k], v[k]), for k in [0, count); count a multiple of 16.
void samplePoints(const FloatPlane& plane, const Real* u, const Real* v, bool nearest, int count, Real* out,
                  const PlaneMap& map = {});

/// The field at both faces and in the middle of a sheet, 256 samples each, from its values on the
/// planes of sheets n - 1, n and n + 1; in buffers aligned to 64 bytes, which may be the same.
///
/// These values are means over sheets, and the field is taken to be linear between them. Both make it smoother: by a
/// 24th of the second difference over a sheet, and by a twelfth on average between planes. An eighth of it is therefore
/// subtracted (as PlaneStack::prefilter does within the sheet), which halves the error of sharp transfer functions.
void runThroughSheet(const Real* before, const Real* here, const Real* behind, Simd simd, Real* front, Real* middle,
                     Real* back);

/// The least and the greatest of a box of values, at least 16 wide, whose rows begin `stride` values apart.
std::pair<Real, Real> rangeOf(const Real* values, int width, int height, std::ptrdiff_t stride, Simd simd);

/// out[j * 16 + i] = plane at (u + i * step, v + j * step), for i, j in [0, 16).
void sampleLattice(const FloatPlane& plane, Real u, Real v, Real step, bool nearest, Real* out);

/// One tile of a shadow raster on its way through one sheet.
struct AttenuateTile {
    FloatPlane extinction;  ///< per world unit
    Real u, v, step;        ///< texel under the tile's first cell, and texels between cells
    bool nearest;
    /// World length of the path through the sheet is path * sqrt(1 + a^2 + b^2) with the slopes a =
    /// slopeA + i * slopeStep, b = slopeB + j * slopeStep of cell (i, j).
    Real path, slopeA, slopeB, slopeStep;
    Real* tau;  ///< first cell; rows are tauStride apart
    std::ptrdiff_t tauStride;
    Real* entry;  ///< receives tau at entry; rows are entryStride apart
    std::ptrdiff_t entryStride;
};
void attenuateTile(const AttenuateTile& tile);

/// The cells of a tile, and one more on every side (but not at the corners).
struct HaloTile {
    static constexpr int kStride = 48;  ///< floats from row to row
    Real* at(int x, int y) { return cells + (y + 1) * kStride + x + 16; }
    const Real* at(int x, int y) const { return cells + (y + 1) * kStride + x + 16; }
    alignas(64) Real cells[kStride * 18];
};

/// out = f - strength (second differences along x and y), with rows `stride` floats apart; returns the largest value.
/// The result is not below 0, or (second function) lies between the values of a cell and its neighbours.
Real prefilterAboveZero(const HaloTile& halo, Real strength, Simd simd, Real* out, std::ptrdiff_t stride);
Real prefilterBetween(const HaloTile& halo, Real strength, Simd simd, Real* out, std::ptrdiff_t stride);

/// Prefilters a plane of tilesX x tilesY tiles in place; rows are `rowStride` floats apart. forActive(ty, visit) calls
/// visit(tx) for the active tiles of a row, ascending, and filter(tx, ty, halo, out) is called for each of them: the
/// halo holds the original values of its cells and those around it, and `out` is its first cell. Cells outside of the
/// plane are zeros, and so are those of inactive tiles to the left and above.
///
/// The reason is that views look sheets up between texels, bilinearly. Averaged over all positions between texels, that
/// adds a twelfth of the second difference along each axis: a blur that every view sees and that does not average out.
/// Subtracting it beforehand leaves an error that changes sign from texel to texel and sheet to sheet, and averages out
/// along a ray (quasi-interpolation; compare T. Blu, P. Thevenaz, M. Unser, "Linear Interpolation Revitalized", IEEE
/// Transactions on Image Processing, 2004). Constant and linear fields stay as they are.
template <class ForActive, class Filter>
void forPrefilteredTiles(Real* plane, int tilesX, int tilesY, std::ptrdiff_t rowStride, const ForActive& forActive,
                         const Filter& filter) {
    HaloTile halo;
    // The original values of the last rows of tiles above, and the rows of tiles that they are of.
    std::vector<Real> above(std::size_t(tilesX * kTileEdge));
    std::vector<int> aboveRow(std::size_t(tilesX), -2);
    for (int ty = 0; ty < tilesY; ++ty) {
        int last = -2;
        forActive(ty, [&](int tx) {
            Real* const aboveTile = above.data() + tx * kTileEdge;
            const bool leftActive = last == tx - 1;
            Real* const first = plane + ty * kTileEdge * rowStride + tx * kTileEdge;
            const bool endsX = tx + 1 == tilesX, endsY = ty + 1 == tilesY;
            for (int y = 0; y < kTileEdge; ++y) {
                Real* row = halo.at(0, y);
                row[-1] = leftActive ? row[kTileEdge - 1] : Real(0);  // original values of the tile to the left
                std::copy_n(first + y * rowStride, kTileEdge, row);
                row[kTileEdge] = endsX ? Real(0) : first[y * rowStride + kTileEdge];
            }
            if (aboveRow[std::size_t(tx)] == ty - 1)
                std::copy_n(aboveTile, kTileEdge, halo.at(0, -1));
            else
                std::fill_n(halo.at(0, -1), kTileEdge, Real(0));
            if (endsY)
                std::fill_n(halo.at(0, kTileEdge), kTileEdge, Real(0));
            else
                std::copy_n(first + kTileEdge * rowStride, kTileEdge, halo.at(0, kTileEdge));
            std::copy_n(halo.at(0, kTileEdge - 1), kTileEdge, aboveTile);
            aboveRow[std::size_t(tx)] = ty;
            last = tx;
            filter(tx, ty, halo, first);
        });
    }
}

}  // namespace scrim
