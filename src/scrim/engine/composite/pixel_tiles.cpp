// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/composite/pixel_tiles.h>

#include <algorithm>
#include <cmath>

namespace scrim {

Box2<int> PixelTiles::tilesIn(const Box2<double>& positions) const {
    const auto tile = [](double position, int origin, int tiles) {
        return static_cast<int>(std::clamp(std::floor((position - origin) / kTileEdge), -1.0, double(tiles)));
    };
    return intersection<int>(
        {0, 0, m_tilesX, m_tilesY},
        {tile(positions.x0, m_region.x0, m_tilesX), tile(positions.y0, m_region.y0, m_tilesY),
         tile(positions.x1, m_region.x0, m_tilesX) + 1, tile(positions.y1, m_region.y0, m_tilesY) + 1});
}

bool PixelTiles::anyOpen(const Box2<int>& tiles) const {
    const Box2<int> box = intersection(tiles, {0, 0, m_tilesX, m_tilesY});
    for (int ty = box.y0; ty < box.y1; ++ty)
        for (int tx = box.x0; tx < box.x1; ++tx)
            if (!opaque(ty * m_tilesX + tx)) return true;
    return false;
}

}  // namespace scrim
