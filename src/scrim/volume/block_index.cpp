// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/block_index.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace scrim {

// Makes the table of pages unless it would be too large: at most 1 MB, enough for a box of 4,096^3 voxels.
void BlockIndex::makeTable() {
    constexpr double kMostPages = 1 << 18;
    if (glm::any(glm::greaterThan(m_lower, m_upper))) return;
    m_firstPage = m_lower >> 3;
    const Vec3 size = Vec3(m_upper >> 3) - Vec3(m_firstPage) + 1.0;
    if (size.x * size.y * size.z > kMostPages) return;
    for (int axis = 0; axis < 3; ++axis) m_tableSize[std::size_t(axis)] = static_cast<std::uint32_t>(size[axis]);
    m_table.assign(std::size_t(size.x * size.y * size.z), kNothing);
}

std::uint32_t& BlockIndex::pageNumber(const Int3& page) {
    if (m_table.empty()) return m_pages.try_emplace(page, kNothing).first->second;
    const Int3 at = page - m_firstPage;
    return m_table[(std::size_t(at.x) * m_tableSize[1] + std::size_t(at.y)) * m_tableSize[2] + std::size_t(at.z)];
}

std::uint32_t& BlockIndex::entry(const Int3& cube) {
    std::uint32_t& number = pageNumber(cube >> 3);
    if (number == kNothing) {
        number = static_cast<std::uint32_t>(m_entries.size());
        m_entries.emplace_back().fill(kNothing);
        m_pageOf.push_back(cube >> 3);
    }
    return m_entries[number][inPage(cube)];
}

BlockIndex::BlockIndex(const SparseField& field)
    : m_field(field), m_lower(std::numeric_limits<int>::max()), m_upper(std::numeric_limits<int>::min()) {
    const auto include = [&](const Int3& first, const Int3& last) {
        m_lower = glm::min(m_lower, first);
        m_upper = glm::max(m_upper, last);
        m_isBounds.include(Vec3(first) * double(kBlockEdge));
        m_isBounds.include(Vec3(last) * double(kBlockEdge) + double(kBlockEdge - 1));
    };
    for (const Int3& origin : field.blockOrigins) include(origin >> 3, origin >> 3);
    for (const ConstantTile& tile : field.tiles) include(firstCube(tile), lastCube(tile));
    makeTable();
    std::uint32_t number = 0;
    for (const Int3& origin : field.blockOrigins) entry(origin >> 3) = number++;
    std::set<int> large;
    for (const ConstantTile& tile : field.tiles) {
        const Int3 first = firstCube(tile), last = lastCube(tile);
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
    if (const std::uint32_t page = pageAt(cube >> 3); page != kNothing) {
        const std::uint32_t number = m_entries[page][inPage(cube)];
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

double dividedBlocks(const SparseField& field) {
    double count = double(field.blockCount());
    for (const ConstantTile& tile : field.tiles) count += std::pow(double(tile.edge / kBlockEdge), 3);
    return count;
}

}  // namespace scrim
