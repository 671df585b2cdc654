// SPDX-License-Identifier: Apache-2.0
// Where pixels' rays end: at solids that hide what is behind them.
#pragma once

#include <scrim/engine/composite/pixel_tiles.h>
#include <scrim/geometry/camera.h>
#include <scrim/solid/solids.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace scrim {

class EyeEnds {
  public:
    /// Traces the camera's rays through the centres of all pixels; camera and tiles count those of the antialiasing
    /// raster.
    EyeEnds(const Solids& solids, const Camera& camera, const PixelTiles& tiles);

    /// Depths along the viewing axis of a tile's 256 pixels; infinity where nothing hides. Null: nothing does in all of
    /// the tile.
    const double* depths(int tile) const {
        const std::vector<double>& own = m_depths[std::size_t(tile)];
        return own.empty() ? nullptr : own.data();
    }
    std::size_t bytes() const;
    std::uint64_t rays() const { return std::uint64_t{kTileSize} * m_depths.size(); }

  private:
    std::vector<std::vector<double>> m_depths;  // a tile each
};

}  // namespace scrim
