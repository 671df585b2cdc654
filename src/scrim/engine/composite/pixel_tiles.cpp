// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/composite/pixel_tiles.h>

#include <algorithm>
#include <cmath>

namespace scrim {

ImageTiles::TileBox ImageTiles::tilesIn(double x0, double y0, double x1, double y1) const {
    const auto tile = [](double position, int origin, int tiles) {
        return static_cast<int>(std::clamp(std::floor((position - origin) / kTileEdge), -1.0, double(tiles)));
    };
    return {std::max(0, tile(x0, m_region.x0, m_tilesX)), std::max(0, tile(y0, m_region.y0, m_tilesY)),
            std::min(m_tilesX - 1, tile(x1, m_region.x0, m_tilesX)),
            std::min(m_tilesY - 1, tile(y1, m_region.y0, m_tilesY))};
}

bool ImageTiles::anyOpen(double x0, double y0, double x1, double y1) const {
    const TileBox box = tilesIn(x0, y0, x1, y1);
    for (int ty = box.y0; ty <= box.y1; ++ty)
        for (int tx = box.x0; tx <= box.x1; ++tx)
            if (!opaque(ty * m_tilesX + tx)) return true;
    return false;
}

}  // namespace scrim
