// SPDX-License-Identifier: Apache-2.0
// Finds what a field holds at a place: one hash of its blocks and constant tiles, which never overlap.
//
// A level set of radius 500 has 10^5 tiles, so no look-up may scan them. Everything that asks a field for single voxels
// asks here; the splatter, which streams whole fields, does not.
#pragma once

#include <scrim/volume/sparse_field.h>

#include <cstdint>
#include <unordered_map>
#include <vector>

#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

namespace scrim {

/// Safe to read from many threads.
class BlockIndex {
  public:
    /// `field` must outlive this. Takes about 40 bytes a block or tile.
    explicit BlockIndex(const SparseField& field);

    /// What fills a cube of 8^3 voxels: the 512 values of a block, or one constant (0 where the field has nothing).
    struct Place {
        const float* values = nullptr;
        float constant = 0;
        const ConstantTile* tile = nullptr;  ///< that the constant is of

        bool empty() const { return !values && !tile; }
        double voxel(const Int3& is) const {
            return values ? values[blockOffset(is.x & 7, is.y & 7, is.z & 7)] : constant;
        }
    };

    /// The cube with the voxels `cube` * 8 + [0, 8) on each axis.
    Place at(const Int3& cube) const;
    /// Calls visit(place, number) for every block and tile that has voxels in the cubes [lower, upper]: blocks by their
    /// number in the field, tiles by theirs behind them. A box of more cubes than there are blocks costs no more.
    template <class Visit>
    void visit(const Int3& lower, const Int3& upper, const Visit& visit) const;
    /// Does a block's cube, or a voxel of a tile, touch the box (index space, of any size)?
    bool anyIn(const Bounds& is) const;
    /// The value of voxel `is`; 0 where it is not active.
    double voxel(const Int3& is) const { return at(is >> 3).voxel(is); }

  private:
    struct Hash {
        std::size_t operator()(const Int3& cube) const {
            const auto part = [](int x) { return std::uint64_t{static_cast<std::uint32_t>(x)}; };
            const std::uint64_t h = (part(cube.x) << 42 ^ part(cube.y) << 21 ^ part(cube.z)) * 0x9E3779B97F4A7C15ULL;
            return h ^ h >> 32;
        }
    };
    Place placeOf(std::uint32_t number) const {
        if (number < m_field.blockCount()) return {m_field.block(number)};
        const ConstantTile& tile = m_field.tiles[number - m_field.blockCount()];
        return {nullptr, tile.value, &tile};
    }

    const SparseField& m_field;
    Int3 m_lower, m_upper;  // cubes of all that there is; m_upper below m_lower where there is nothing
    // By the first cube of each: blocks by their number, tiles behind them.
    std::unordered_map<Int3, std::uint32_t, Hash> m_entries;
    std::vector<int> m_tileCubes;  // edges of tiles that there are, in cubes, ascending; tiles of one cube need none
};

template <class Visit>
void BlockIndex::visit(const Int3& lower, const Int3& upper, const Visit& visit) const {
    const Int3 a = glm::max(lower, m_lower), b = glm::min(upper, m_upper);
    if (glm::any(glm::greaterThan(a, b))) return;
    const Vec3 cubes = Vec3(b) - Vec3(a) + 1.0;
    if (m_tileCubes.empty() && cubes.x * cubes.y * cubes.z <= double(m_entries.size())) {
        for (int x = a.x; x <= b.x; ++x)
            for (int y = a.y; y <= b.y; ++y)
                for (int z = a.z; z <= b.z; ++z)
                    if (const auto found = m_entries.find({x, y, z}); found != m_entries.end())
                        visit(placeOf(found->second), found->second);
        return;
    }
    for (const auto& [first, number] : m_entries) {
        const Place place = placeOf(number);
        const Int3 last = first + (place.tile ? place.tile->edge / kBlockEdge - 1 : 0);
        if (glm::all(glm::lessThanEqual(first, b)) && glm::all(glm::greaterThanEqual(last, a))) visit(place, number);
    }
}

}  // namespace scrim
