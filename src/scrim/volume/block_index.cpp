// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/block_index.h>

#include <algorithm>
#include <limits>
#include <set>

namespace scrim {

BlockIndex::BlockIndex(const SparseField& field)
    : m_field(field), m_lower(std::numeric_limits<int>::max()), m_upper(std::numeric_limits<int>::min()) {
    m_entries.reserve(field.blockCount() + field.tiles.size());
    std::set<int> edges;
    const auto add = [&](const Int3& origin, int edge) {
        const Int3 first = origin >> 3;
        m_entries.emplace(first, static_cast<std::uint32_t>(m_entries.size()));
        m_lower = glm::min(m_lower, first);
        m_upper = glm::max(m_upper, first + (edge / kBlockEdge - 1));
        if (edge > kBlockEdge) edges.insert(edge / kBlockEdge);
    };
    for (const Int3& origin : field.blockOrigins) add(origin, kBlockEdge);
    for (const ConstantTile& tile : field.tiles) add(tile.origin, tile.edge);
    m_tileCubes.assign(edges.begin(), edges.end());
}

BlockIndex::Place BlockIndex::at(const Int3& cube) const {
    if (const auto found = m_entries.find(cube); found != m_entries.end()) return placeOf(found->second);
    for (const int edge : m_tileCubes) {
        const auto found = m_entries.find(cube & ~(edge - 1));  // edges are powers of two
        if (found == m_entries.end()) continue;
        // A block or a smaller tile may lie in the corner of where a larger one would.
        if (const Place place = placeOf(found->second); place.tile && place.tile->edge == edge * kBlockEdge)
            return place;
    }
    return {};
}

bool BlockIndex::anyIn(const Bounds& is) const {
    constexpr double kFar = 1 << 30;
    const auto voxel = [](const Vec3& at) { return Int3(glm::clamp(at, Vec3(-kFar), Vec3(kFar))); };
    bool any = false;
    visit(voxel(glm::floor(is.lower)) >> 3, voxel(glm::ceil(is.upper)) >> 3, [&](const Place& place, std::uint32_t) {
        any = any || !place.tile ||
              (glm::all(glm::lessThanEqual(Vec3(place.tile->origin), is.upper)) &&
               glm::all(glm::greaterThanEqual(Vec3(place.tile->origin + (place.tile->edge - 1)), is.lower)));
    });
    return any;
}

}  // namespace scrim
