// SPDX-License-Identifier: Apache-2.0
// The buffers of a batch of sheets: a few planes of texels, of which only touched tiles cost anything.
//
// Planes are dense in address space, so that rows are rows, but memory is only used where something was
// written: they start as untouched zero pages, and each plane remembers its tiles of 16 x 16. A tile that is not
// active reads as zeros; the work of clearing follows the tiles that were written, never the plane's size.
#pragma once

#include <scrim/geometry/sheets.h>

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
    float* plane(int p) { return m_data + p * m_planeStride; }
    const float* plane(int p) const { return m_data + p * m_planeStride; }

    int tilesX() const { return m_width / kTileEdge; }
    int tilesY() const { return m_height / kTileEdge; }
    bool active(int p, int tx, int ty) const { return m_state[tileIndex(p, tx, ty)] == kActive; }
    /// Is any tile active that the closed range of tiles touches? The range is clipped to the plane.
    bool anyActive(int p, int tx0, int ty0, int tx1, int ty1) const;

    /// The smallest box of tiles around the active ones, closed; x1 < x0 where there are none.
    struct TileBounds {
        int x0, y0, x1, y1;
    };
    TileBounds activeBounds(int p) const;

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
    /// What is below 0 in active tiles becomes 0.
    void raiseToZero(int p);
    /// Makes tiles inactive that hold nothing but zeros (of a plane with one channel).
    void dropEmpty(int p);

    /// Bytes of address space a stack of this shape takes, at most all of it in memory.
    static std::size_t bytes(int planes, int width, int height, int channels);

  private:
    enum State : std::uint8_t { kClean, kStale, kActive };
    std::size_t tileIndex(int p, int tx, int ty) const {
        return (static_cast<std::size_t>(p) * static_cast<std::size_t>(tilesY()) + static_cast<std::size_t>(ty)) *
                   static_cast<std::size_t>(tilesX()) +
               static_cast<std::size_t>(tx);
    }
    void clearTile(int p, int tx, int ty);

    struct Release {
        void operator()(void* memory) const noexcept;
    };
    int m_planes, m_width, m_height, m_channels;
    std::ptrdiff_t m_planeStride;
    std::unique_ptr<void, Release> m_memory;
    float* m_data;
    std::vector<std::uint8_t> m_state;
};

}  // namespace scrim
