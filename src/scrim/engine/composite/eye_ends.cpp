// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/composite/eye_ends.h>

#include <scrim/base/parallel.h>

#include <limits>

namespace scrim {

EyeEnds::EyeEnds(const Solids& solids, const Camera& camera, const PixelTiles& tiles)
    : m_depths(std::size_t(tiles.count())) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const RayFamily rays = wsRays(camera);
    parallelFor(m_depths.size(), [&](std::size_t i) {
        const auto tile = static_cast<int>(i);
        std::vector<double> depths(kTileSize, kInfinity);
        bool any = false;
        for (int k = 0; k < kTileSize; ++k) {
            const double x = tiles.cornerX(tile) + k % kTileEdge + 0.5, y = tiles.cornerY(tile) + k / kTileEdge + 0.5;
            // Directions are scaled so that the parameter is depth.
            depths[std::size_t(k)] =
                solids.firstHit(SolidRole::holdout, rays.origin(x, y), rays.direction(x, y), rays.near, kInfinity);
            any = any || depths[std::size_t(k)] < kInfinity;
        }
        if (any) m_depths[i] = std::move(depths);
    });
}

std::size_t EyeEnds::bytes() const {
    std::size_t sum = 0;
    for (const std::vector<double>& own : m_depths) sum += own.size() * sizeof(double);
    return sum;
}

}  // namespace scrim
