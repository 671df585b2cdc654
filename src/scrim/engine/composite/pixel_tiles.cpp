// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/composite/pixel_tiles.h>
#include <scrim/base/parallel.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

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

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool holds(const Solids* solids) {
    return solids != nullptr && solids->any(SolidRole::holdout);
}

}  // namespace

bool EyeEnds::any(const ViewScene& scene) {
    return holds(scene.solids.get()) || scene.depths;
}

EyeEnds::EyeEnds(const ViewScene& scene, const PixelTiles& tiles)
    : m_picture(scene.depths),
      m_rayFamily(wsRays(supersampled(scene.camera, scene.dials.antialias))),
      m_antialias(scene.dials.antialias),
      m_depths(std::size_t(tiles.count())),
      m_thin(std::size_t(tiles.count())) {
    const Solids* const solids = holds(scene.solids.get()) ? scene.solids.get() : nullptr;
    if (solids) m_rays = std::uint64_t{kTileSize} * m_depths.size();
    const auto keep = [](const std::vector<double>& from, std::vector<double>& to) {
        if (*std::min_element(from.begin(), from.end()) < kInfinity) to = from;
    };
    parallelFor(m_depths.size(), [&](std::size_t i) {
        const auto tile = static_cast<int>(i);
        std::vector<double> depths(kTileSize, kInfinity), thin(kTileSize, kInfinity);
        for (std::size_t k = 0; k < kTileSize; ++k) {
            const double x = tiles.cornerX(tile) + static_cast<int>(k) % kTileEdge + 0.5,
                         y = tiles.cornerY(tile) + static_cast<int>(k) / kTileEdge + 0.5;
            // Directions are scaled so that the ray's parameter is depth.
            if (solids)
                depths[k] = solids->firstHit(SolidRole::holdout, m_rayFamily.origin(x, y), m_rayFamily.direction(x, y),
                                             m_rayFamily.near, kInfinity);
            const DepthPicture::Pieces pieces = piecesAt(x, y);
            if (pieces.empty()) continue;
            depths[k] = std::min(depths[k], opaqueFrom(pieces) / unitAt(x, y));
            if (std::isfinite(pieces.front().tau)) thin[k] = pieces.front().begin / unitAt(x, y);
        }
        keep(depths, m_depths[i]);
        keep(thin, m_thin[i]);
    });
}

// All rays of a pixel see the pieces of the one pixel in the depth picture.
DepthPicture::Pieces EyeEnds::piecesAt(double x, double y) const {
    if (!m_picture) return {};
    return m_picture->at(static_cast<int>(std::floor(x / m_antialias)), static_cast<int>(std::floor(y / m_antialias)));
}

// What the picture stores for a depth of 1 along the viewing axis.
double EyeEnds::unitAt(double x, double y) const {
    return m_picture && m_picture->alongRay ? glm::length(m_rayFamily.direction(x, y)) : 1;
}

double EyeEnds::seenShare(double x, double y, double near, double far, double tau) const {
    const double unit = unitAt(x, y);
    return scrim::seenShare(piecesAt(x, y), near * unit, far * unit, tau);
}

std::size_t EyeEnds::bytes() const {
    std::size_t sum = 0;
    for (const auto* tiles : {&m_depths, &m_thin})
        for (const std::vector<double>& own : *tiles) sum += own.size() * sizeof(double);
    return sum;
}

}  // namespace scrim
