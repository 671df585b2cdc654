// SPDX-License-Identifier: Apache-2.0
#include <scrim/render/image_tiles.h>

#include <algorithm>
#include <cmath>

namespace scrim {

bool ImageTiles::anyOpen(double x0, double y0, double x1, double y1) const {
    const auto tile = [](double position, int origin, int tiles) {
        return static_cast<int>(std::clamp(std::floor((position - origin) / kTileEdge), -1.0, double(tiles)));
    };
    const int tx0 = std::max(0, tile(x0, m_region.x0, m_tilesX));
    const int tx1 = std::min(m_tilesX - 1, tile(x1, m_region.x0, m_tilesX));
    const int ty0 = std::max(0, tile(y0, m_region.y0, m_tilesY));
    const int ty1 = std::min(m_tilesY - 1, tile(y1, m_region.y0, m_tilesY));
    for (int ty = ty0; ty <= ty1; ++ty)
        for (int tx = tx0; tx <= tx1; ++tx)
            if (!opaque(ty * m_tilesX + tx)) return true;
    return false;
}

}  // namespace scrim
