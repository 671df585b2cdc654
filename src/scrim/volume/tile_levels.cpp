// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/tile_levels.h>

#include <scrim/volume/block_index.h>
#include <scrim/volume/field_builder.h>

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <span>

#include <glm/common.hpp>

namespace scrim {
namespace {

// True if visit returns true for all cubes on the surface of the box [lower, upper] (in cubes).
template <class Visit>
bool allOfHull(const Int3& lower, const Int3& upper, const Visit& visit) {
    for (int x = lower.x; x <= upper.x; ++x)
        for (int y = lower.y; y <= upper.y; ++y) {
            const bool inside = x > lower.x && x < upper.x && y > lower.y && y < upper.y;
            for (int z = lower.z; z <= upper.z; z += inside ? std::max(upper.z - lower.z, 1) : 1)
                if (!visit(Int3(x, y, z))) return false;
        }
    return true;
}

}  // namespace

// Divides one level: moves all that a coarser level can hold to that level.
class TileLevels::Split {
  public:
    Split(TileLevels& own, std::span<const double> weights, const SparseField& tiles)
        : m_own(own), m_weights(weights), m_index(tiles) {
        m_coarse.name = tiles.name;
        for (const ConstantTile& tile : tiles.tiles) take(tile);
        for (const ConstantTile& tile : m_coarse.tiles) m_coarse.activeVoxels += voxelsOf(tile.edge);
    }

    const SparseField& coarse() const { return m_coarse; }

    // The rest of this level, without what the coarser level holds.
    TileLevel rest() {
        const BlockIndex coarse(m_coarse);
        for (const ConstantTile& tile : m_kept) keep(coarse, tile.origin, tile.value);
        for (const ConstantTile& tile : m_coarse.tiles) {
            const Int3 first = tile.origin >> 2, last = first + (tile.edge / 4 - 1);  // in cubes of this level
            allOfHull(first, last, [&](const Int3& cube) {
                keep(coarse, kBlockEdge * cube, tile.value);
                return true;
            });
        }
        std::sort(m_rests.begin(), m_rests.end(),
                  [](const auto& a, const auto& b) { return originLess(a.first, b.first); });
        SparseField field;
        field.name = m_coarse.name;
        field.tiles = std::move(m_tiles);
        TileLevel level;
        for (const auto& [origin, block] : m_rests) {
            field.blockOrigins.push_back(origin);
            level.values.push_back(block->data());
            field.activeVoxels += std::uint64_t(kBlockVoxels - std::count(block->begin(), block->end(), 0.0f));
        }
        for (const ConstantTile& tile : field.tiles) field.activeVoxels += voxelsOf(tile.edge);
        level.field = std::make_shared<SparseField>(std::move(field));
        return level;
    }

  private:
    static std::uint64_t voxelsOf(std::int32_t edge) {
        const auto e = static_cast<std::uint64_t>(edge);
        return e * e * e;
    }

    // Coarser voxels may fill a tile, or a part of it, if everything that their kernels reach
    // beyond it has the tile's value, too.
    void take(const ConstantTile& tile) {
        const auto alike = [&](const Int3& cube) {
            const BlockIndex::Place place = m_index.at(cube);
            return place.tile && place.constant == tile.value;
        };
        const Int3 cube = tile.origin >> 3;
        const int half = tile.edge / 2;
        if (half >= kBlockEdge && allOfHull(cube - 1, cube + tile.edge / kBlockEdge, alike))
            m_coarse.tiles.push_back({tile.origin / 2, half, tile.value});
        else if (half >= kBlockEdge)
            for (int i = 0; i < 8; ++i)
                take({tile.origin + half * Int3(i >> 2 & 1, i >> 1 & 1, i & 1), half, tile.value});
        else
            m_kept.push_back(tile);
    }

    // Keeps the part of the cube of 8^3 at `origin` that coarser voxels do not fill.
    void keep(const BlockIndex& coarse, const Int3& origin, float value) {
        const int reach = static_cast<int>(m_weights.size()) - 1;
        const Int3 first = (origin - reach + 1) >> 1,
                   last = (origin + (kBlockEdge - 1 + reach)) >> 1;  // coarser voxels
        const Int3 cube = first >> 3;
        int filled = 0, count = 0;  // one bit for each of the coarser cubes whose voxels reach this cube
        for (int i = 0; i < 8; ++i) {
            const Int3 at = glm::min(cube + Int3(i >> 2 & 1, i >> 1 & 1, i & 1), last >> 3);
            const bool fills = coarse.at(at).tile != nullptr;
            filled |= fills << i;
            count += fills;
        }
        if (count == 8) return;
        if (count == 0) {
            m_tiles.push_back({origin, kBlockEdge, value});
            return;
        }
        const Int3 odd = (origin >> 3) & 1;
        auto& block = m_own.m_blocks[{value, filled << 3 | odd.x << 2 | odd.y << 1 | odd.z}];
        if (!block) block = std::make_unique<const Block>(blockOf(origin, cube, filled, value));
        if (std::any_of(block->begin(), block->end(), [](float v) { return v > 0; }))
            m_rests.emplace_back(origin, block.get());
    }

    // The part of the block's voxels that the coarser cubes from `cube` on leave.
    Block blockOf(const Int3& origin, const Int3& cube, int filled, float value) const {
        const int reach = static_cast<int>(m_weights.size()) - 1;
        Block block;
        for (int n = 0; n < kBlockVoxels; ++n) {
            const Int3 voxel = origin + Int3(n >> 6, n >> 3 & 7, n & 7);
            const Int3 first = (voxel - reach + 1) >> 1, last = (voxel + reach) >> 1;
            double left = 1;
            for (int x = first.x; x <= last.x; ++x)
                for (int y = first.y; y <= last.y; ++y)
                    for (int z = first.z; z <= last.z; ++z) {
                        const Int3 corner = (Int3(x, y, z) >> 3) - cube, off = glm::abs(voxel - 2 * Int3(x, y, z));
                        if ((filled >> (corner.x << 2 | corner.y << 1 | corner.z) & 1) != 0)
                            left -= m_weights[std::size_t(off.x)] * m_weights[std::size_t(off.y)] *
                                    m_weights[std::size_t(off.z)];
                    }
            block[std::size_t(n)] = static_cast<float>(left * value);
        }
        return block;
    }

    TileLevels& m_own;
    std::span<const double> m_weights;
    const BlockIndex m_index;
    SparseField m_coarse;
    // Tiles of one cube each: all that are kept, and those of them that coarser voxels leave unchanged.
    std::vector<ConstantTile> m_kept, m_tiles;
    std::vector<std::pair<Int3, const Block*>> m_rests;
};

TileLevels::TileLevels(const SparseField& field, std::span<const double> weights, int levels) {
    SparseField tiles = field;
    for (int level = 0; level < levels; ++level) {
        Split split(*this, weights, tiles);
        if (split.coarse().tiles.empty()) break;
        m_levels.push_back(split.rest());
        tiles = split.coarse();
    }
    if (!m_levels.empty()) m_levels.push_back({std::make_shared<SparseField>(std::move(tiles)), {}});
}

}  // namespace scrim
