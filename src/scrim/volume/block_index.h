// SPDX-License-Identifier: Apache-2.0
// Finds the contents of a field at a place. One table leads to pages of 8^3 cubes; a cube is a
// block, a part of a constant tile, or empty.
//
// A level set of radius 500 has 10^5 blocks, and rays through it look up 10^8 places, so a look-up
// may neither scan the tiles nor try one size after another. All code that asks a field for single
// voxels uses this index; the splatter, which streams whole fields, does not.
#pragma once

#include <scrim/volume/sparse_field.h>

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

namespace scrim {

/// Safe to read from many threads at once.
class BlockIndex {
  public:
    /// `field` must outlive this object. Takes 2 KB for each 64^3 voxels that contain anything,
    /// about as much as a block.
    explicit BlockIndex(const SparseField& field);

    /// The contents of a cube of 8^3 voxels: the 512 values of a block, or a constant (0 where the field is empty).
    struct Place {
        const float* values = nullptr;
        float constant = 0;
        const ConstantTile* tile = nullptr;  ///< the tile that holds the constant
        /// Edge, in cubes, of a region of equal cubes around this one, aligned to a multiple of the
        /// edge; a power of two.
        int cubes = 1;

        bool empty() const { return !values && !tile; }
        double voxel(const Int3& is) const {
            return values ? values[blockOffset(is.x & 7, is.y & 7, is.z & 7)] : constant;
        }
    };

    /// The cube with the voxels `cube` * 8 + [0, 8) on each axis.
    Place at(const Int3& cube) const;
    /// Calls visit(place, number) for every block and tile that has voxels in the cubes [lower,
    /// upper]. Blocks have their number in the field; tiles are numbered after them. A box with
    /// more cubes than there are blocks costs no more than a loop over all blocks.
    template <class Visit>
    void visit(const Int3& lower, const Int3& upper, const Visit& visit) const;
    /// True if the cube of a block, or a voxel of a tile, touches the box (index space, of any size).
    bool anyIn(const Bounds& is) const;
    /// The value of voxel `is`; 0 where it is not active.
    double voxel(const Int3& is) const { return at(is >> 3).voxel(is); }
    /// Box around the centres of all voxels of blocks and tiles, in index space; empty where there are none.
    const Bounds& isBounds() const { return m_isBounds; }

  private:
    struct Hash {
        std::size_t operator()(const Int3& cube) const {
            const auto part = [](int x) { return std::uint64_t{static_cast<std::uint32_t>(x)}; };
            const std::uint64_t h = (part(cube.x) << 42 ^ part(cube.y) << 21 ^ part(cube.z)) * 0x9E3779B97F4A7C15ULL;
            return h ^ h >> 32;
        }
    };
    static constexpr int kPageEdge = 8;  // cubes
    static constexpr std::uint32_t kNothing = 0xFFFFFFFF;
    using Page = std::array<std::uint32_t, kPageEdge * kPageEdge * kPageEdge>;  // numbers

    static std::size_t inPage(const Int3& cube) { return std::size_t(blockOffset(cube.x & 7, cube.y & 7, cube.z & 7)); }
    std::uint32_t& entry(const Int3& cube);
    std::uint32_t& pageNumber(const Int3& page);
    /// The number of a page, or kNothing if it is empty.
    std::uint32_t pageAt(const Int3& page) const {
        if (m_table.empty()) {
            const auto found = m_pages.find(page);
            return found == m_pages.end() ? kNothing : found->second;
        }
        const Int3 at = page - m_firstPage;
        const auto x = std::uint32_t(at.x), y = std::uint32_t(at.y), z = std::uint32_t(at.z);
        if (x >= m_tableSize[0] || y >= m_tableSize[1] || z >= m_tableSize[2]) return kNothing;
        return m_table[(std::size_t(x) * m_tableSize[1] + y) * m_tableSize[2] + z];
    }
    void makeTable();
    Place placeOf(std::uint32_t number) const {
        if (number < m_field.blockCount()) return {m_field.block(number)};
        const ConstantTile& tile = m_field.tiles[number - m_field.blockCount()];
        return {nullptr, tile.value, &tile, tile.edge / kBlockEdge};
    }
    static Int3 firstCube(const ConstantTile& tile) { return tile.origin >> 3; }
    static Int3 lastCube(const ConstantTile& tile) { return firstCube(tile) + (tile.edge / kBlockEdge - 1); }

    const SparseField& m_field;
    Int3 m_lower, m_upper;  // range of the cubes in use; m_upper is below m_lower if there are none
    Bounds m_isBounds;
    // The pages, keyed by their first cube divided by 8: a table over their box, or a hash map
    // where the table would be too large.
    std::vector<std::uint32_t> m_table;
    Int3 m_firstPage{0};
    std::array<std::uint32_t, 3> m_tableSize{};
    std::unordered_map<Int3, std::uint32_t, Hash> m_pages;
    std::vector<Int3> m_pageOf;  // key of each element of m_entries
    std::vector<Page> m_entries;
    // Tiles larger than a page, keyed by their first cube, and their edges in cubes, ascending.
    std::unordered_map<Int3, std::uint32_t, Hash> m_large;
    std::vector<int> m_largeEdges;
};

template <class Visit>
void BlockIndex::visit(const Int3& lower, const Int3& upper, const Visit& visit) const {
    const Int3 a = glm::max(lower, m_lower), b = glm::min(upper, m_upper);
    if (glm::any(glm::greaterThan(a, b))) return;
    for (const auto& [first, number] : m_large)
        if (const Place place = placeOf(number);
            glm::all(glm::lessThanEqual(first, b)) && glm::all(glm::greaterThanEqual(lastCube(*place.tile), a)))
            visit(place, number);
    const auto visitPage = [&](const Int3& page, const Page& entries) {
        const Int3 from = glm::max(a, page * kPageEdge), to = glm::min(b, page * kPageEdge + (kPageEdge - 1));
        for (int x = from.x; x <= to.x; ++x)
            for (int y = from.y; y <= to.y; ++y)
                for (int z = from.z; z <= to.z; ++z) {
                    const std::uint32_t number = entries[inPage({x, y, z})];
                    if (number == kNothing) continue;
                    const Place place = placeOf(number);
                    // A tile is visited once, at the first of its cubes in the page.
                    if (!place.tile || glm::max(firstCube(*place.tile), from) == Int3(x, y, z)) visit(place, number);
                }
    };
    const Int3 firstPage = a >> 3, lastPage = b >> 3;
    const Vec3 pages = Vec3(lastPage) - Vec3(firstPage) + 1.0;
    if (pages.x * pages.y * pages.z > double(m_entries.size())) {
        for (std::size_t i = 0; i < m_entries.size(); ++i) visitPage(m_pageOf[i], m_entries[i]);
        return;
    }
    for (int x = firstPage.x; x <= lastPage.x; ++x)
        for (int y = firstPage.y; y <= lastPage.y; ++y)
            for (int z = firstPage.z; z <= lastPage.z; ++z)
                if (const std::uint32_t page = pageAt({x, y, z}); page != kNothing)
                    visitPage({x, y, z}, m_entries[page]);
}

/// The number of blocks that a field has if its tiles are divided into blocks; more than there is memory for, perhaps.
double dividedBlocks(const SparseField& field);

}  // namespace scrim
