// SPDX-License-Identifier: Apache-2.0
// The picture while a sweep is under way: pixels in tiles of 16 x 16, so that a task's states lie together.
#pragma once

#include <scrim/base/real.h>
#include <scrim/geometry/sheets.h>
#include <scrim/image/image.h>
#include <scrim/engine/plan/outputs.h>

#include <cstdint>
#include <vector>

namespace scrim {

class PixelTiles {
  public:
    /// `depth`: keeps the depth of the first thing visible, too.
    explicit PixelTiles(const PixelWindow& region, const OutputLayout& layout = {}, bool depth = false)
        : m_region(region),
          m_layout(layout),
          m_keepsDepth(depth),
          m_tilesX((region.width() + kTileEdge - 1) / kTileEdge),
          m_tilesY((region.height() + kTileEdge - 1) / kTileEdge) {
        reset();
    }

    /// All pixels black and transparent.
    void reset() {
        m_states.assign(static_cast<std::size_t>(count()) * tileFloats(), Real(0));
        m_depth.assign(m_keepsDepth ? static_cast<std::size_t>(count()) * kTileSize : 0, Real(0));
        m_opaque.assign(static_cast<std::size_t>(count()), 0);
    }

    const PixelWindow& region() const { return m_region; }
    int count() const { return m_tilesX * m_tilesY; }
    Box2<int> all() const { return {0, 0, m_tilesX, m_tilesY}; }
    int tilesX() const { return m_tilesX; }
    int tilesY() const { return m_tilesY; }
    /// Raster position of the tile's corner.
    int cornerX(int tile) const { return m_region.x0 + tile % m_tilesX * kTileEdge; }
    int cornerY(int tile) const { return m_region.y0 + tile / m_tilesX * kTileEdge; }
    const OutputLayout& layout() const { return m_layout; }
    /// Of the tile's 256 pixels: (C, -A) in the layout, see composite_tile.h.
    Real* states(int tile) { return m_states.data() + static_cast<std::size_t>(tile) * tileFloats(); }
    const Real* states(int tile) const { return m_states.data() + static_cast<std::size_t>(tile) * tileFloats(); }
    /// Of pixel (x, y) of the region.
    const Real* state(int x, int y) const {
        const Place at = placeOf(x, y);
        return states(at.tile) + at.pixel * m_layout.floats();
    }
    /// Depths of a tile's pixels; 0: nothing is visible. Only where they are kept.
    bool keepsDepth() const { return m_keepsDepth; }
    Real* depths(int tile) { return m_depth.data() + static_cast<std::size_t>(tile) * kTileSize; }
    Real depth(int x, int y) const {
        const Place at = placeOf(x, y);
        return m_depth[static_cast<std::size_t>(at.tile) * kTileSize + static_cast<std::size_t>(at.pixel)];
    }
    std::size_t bytes() const { return (m_states.size() + m_depth.size()) * sizeof(Real); }
    bool opaque(int tile) const { return m_opaque[static_cast<std::size_t>(tile)] != 0; }
    void setOpaque(int tile) { m_opaque[static_cast<std::size_t>(tile)] = 1; }

    /// The tiles that a box of raster positions touches.
    Box2<int> tilesIn(const Box2<double>& positions) const;

    /// Is one of the tiles not opaque? Those beyond the picture do not count.
    bool anyOpen(const Box2<int>& tiles) const;
    bool anyOpen(const Box2<double>& positions) const { return anyOpen(tilesIn(positions)); }

  private:
    struct Place {
        int tile, pixel;
    };
    Place placeOf(int x, int y) const {
        const int dx = x - m_region.x0, dy = y - m_region.y0;
        return {dy / kTileEdge * m_tilesX + dx / kTileEdge, dy % kTileEdge * kTileEdge + dx % kTileEdge};
    }
    std::size_t tileFloats() const { return static_cast<std::size_t>(kTileSize * m_layout.floats()); }

    PixelWindow m_region;
    OutputLayout m_layout;
    bool m_keepsDepth;
    int m_tilesX, m_tilesY;
    std::vector<Real> m_states, m_depth;
    std::vector<std::uint8_t> m_opaque;
};

}  // namespace scrim
