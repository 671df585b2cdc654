// SPDX-License-Identifier: Apache-2.0
// The buffers of a batch of sheets: a few planes of texels, of which only touched tiles cost anything.
//
// Planes are dense in address space, so that rows are rows, but memory is only used where something was
// written: they start as untouched zero pages, and each plane remembers its tiles of 16 x 16. A tile that is not
// active reads as zeros; the work of clearing follows the tiles that were written, never the plane's size.
#pragma once

#include <scrim/base/real.h>
#include <scrim/geometry/box2.h>
#include <scrim/geometry/sheets.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace scrim {

class PlaneStack {
  public:
    /// `width` and `height` in texels, multiples of kTileEdge; `channels` floats a texel, interleaved.
    /// Throws Error (memory) where the address space cannot be had.
    PlaneStack(int planes, int width, int height, int channels);

    int planes() const { return m_planes; }
    int width() const { return m_width; }
    int height() const { return m_height; }
    int channels() const { return m_channels; }
    int rowStride() const { return m_width * m_channels; }  ///< floats
    std::ptrdiff_t planeStride() const { return m_planeStride; }
    Real* plane(int p) { return m_data + p * m_planeStride; }
    const Real* plane(int p) const { return m_data + p * m_planeStride; }

    int tilesX() const { return m_width / kTileEdge; }
    int tilesY() const { return m_height / kTileEdge; }
    bool active(int p, int tx, int ty) const { return m_state[tileIndex(p, tx, ty)] == kActive; }
    /// Is any of these tiles active? Tiles beyond the plane are not.
    bool anyActive(int p, const Box2<int>& tiles) const;
    /// The smallest box of tiles around the active ones.
    Box2<int> activeBounds(int p) const;

    // The life of a plane in a batch: begin, then any mix of activate (before adding to a tile) and replace
    // (before writing all of a tile), then finish. Different planes, and different tiles of one plane, may be
    // handled by different threads.

    /// Forgets the plane's content; old tiles are cleared when they are next touched, or by finish.
    void begin(int p);
    /// Makes a tile active with zeros in it, unless it is active already.
    void activate(int p, int tx, int ty);
    /// Makes a tile active without clearing it.
    void replace(int p, int tx, int ty) { m_state[tileIndex(p, tx, ty)] = kActive; }
    /// Clears what is left of the old content. `finishRow` does so for one row of tiles.
    void finish(int p);
    void finishRow(int p, int ty);
    /// Makes up for the blur of the look-ups to come: f - 1/12 (second differences along u and v), but not below 0, of a
    /// plane with one channel that is finished. See forPrefilteredSpans.
    void prefilter(int p);
    /// What is below 0 in active tiles becomes 0.
    void raiseToZero(int p);
    /// Makes tiles inactive that hold nothing but zeros (of a plane with one channel).
    void dropEmpty(int p);

    /// Bytes of address space a stack of this shape takes, at most all of it in memory.
    static std::size_t bytes(int planes, int width, int height, int channels);

  private:
    // States of a tile.
    static constexpr std::uint8_t kClean = 0, kStale = 1, kActive = 2;

    std::size_t tileIndex(int p, int tx, int ty) const {
        return (static_cast<std::size_t>(p) * static_cast<std::size_t>(tilesY()) + static_cast<std::size_t>(ty)) *
                   static_cast<std::size_t>(tilesX()) +
               static_cast<std::size_t>(tx);
    }
    void clearTile(int p, int tx, int ty);

    int m_planes, m_width, m_height, m_channels;
    std::ptrdiff_t m_planeStride;
    std::unique_ptr<void, void (*)(void*)> m_memory;
    Real* m_data;
    std::vector<std::uint8_t> m_state;
};

/// Prefilters a plane of tilesX x tilesY tiles in place; rows are `rowStride` floats apart. span(tx, y, above, here, below,
/// out) is called for the 16 cells that row y has in an active tile. It reads the cells as they were, `here` with one on
/// either side, and writes `out`. Beyond the plane are zeros.
///
/// Why: views look sheets up between texels, bilinearly. Over all positions between texels that adds, on average, a
/// twelfth of the second difference along each axis: a blur that every view sees and that does not average out. Taking it
/// away beforehand leaves an error that changes sign from texel to texel and sheet to sheet, and does average out along a
/// ray (quasi-interpolation; compare T. Blu, P. Thevenaz, M. Unser, "Linear Interpolation Revitalized", IEEE Transactions
/// on Image Processing, 2004). Constant and linear fields stay as they are.
template <class Active, class Span>
void forPrefilteredSpans(Real* plane, int tilesX, int tilesY, std::ptrdiff_t rowStride, const Active& active,
                         const Span& span) {
    const int width = tilesX * kTileEdge, height = tilesY * kTileEdge;
    std::vector<Real> above(std::size_t(width) + 2, Real(0)), here(above);
    const std::vector<Real> zeros(std::size_t(width), Real(0));
    for (int y = 0; y < height; ++y) {
        Real* row = plane + y * rowStride;
        std::copy_n(row, width, here.begin() + 1);
        const Real* below = y + 1 < height ? row + rowStride : zeros.data();
        for (int tx = 0; tx < tilesX; ++tx) {
            const int x = tx * kTileEdge;
            if (active(tx, y / kTileEdge))
                span(tx, y, above.data() + 1 + x, here.data() + 1 + x, below + x, row + x);
        }
        std::swap(above, here);
    }
}

}  // namespace scrim
