// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/block_index.h>

#include <algorithm>
#include <limits>
#include <set>

namespace scrim {

std::uint32_t& BlockIndex::entry(const Int3& cube) {
    const auto [found, isNew] = m_pages.try_emplace(cube >> 3, static_cast<std::uint32_t>(m_entries.size()));
    if (isNew) m_entries.emplace_back().fill(kNothing);
    return m_entries[found->second][inPage(cube)];
}

BlockIndex::BlockIndex(const SparseField& field)
    : m_field(field), m_lower(std::numeric_limits<int>::max()), m_upper(std::numeric_limits<int>::min()) {
    std::uint32_t number = 0;
    for (const Int3& origin : field.blockOrigins) {
        const Int3 cube = origin >> 3;
        entry(cube) = number++;
        m_lower = glm::min(m_lower, cube);
        m_upper = glm::max(m_upper, cube);
    }
    std::set<int> large;
    for (const ConstantTile& tile : field.tiles) {
        const Int3 first = firstCube(tile), last = lastCube(tile);
        m_lower = glm::min(m_lower, first);
        m_upper = glm::max(m_upper, last);
        if (const int edge = tile.edge / kBlockEdge; edge > kPageEdge) {
            large.insert(edge);
            m_large.emplace(first, number++);
            continue;
        }
        for (int x = first.x; x <= last.x; ++x)
            for (int y = first.y; y <= last.y; ++y)
                for (int z = first.z; z <= last.z; ++z) entry({x, y, z}) = number;
        ++number;
    }
    m_largeEdges.assign(large.begin(), large.end());
}

BlockIndex::Place BlockIndex::at(const Int3& cube) const {
    if (const auto page = m_pages.find(cube >> 3); page != m_pages.end()) {
        const std::uint32_t number = m_entries[page->second][inPage(cube)];
        return number == kNothing ? Place{} : placeOf(number);
    }
    for (const int edge : m_largeEdges)
        if (const auto found = m_large.find(cube & ~(edge - 1)); found != m_large.end())  // edges are powers of two
            if (const Place place = placeOf(found->second); place.cubes == edge) return place;
    return {nullptr, 0, nullptr, kPageEdge};
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
