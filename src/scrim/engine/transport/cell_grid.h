// SPDX-License-Identifier: Apache-2.0
// Cells that scattered light is carried through: cubes along the world's axes, in blocks of 8^3, stored where volumes
// are and nowhere else. Cells stand still in the world, whatever camera, lights and volumes do.
#pragma once

#include <scrim/base/real.h>
#include <scrim/geometry/bounds.h>
#include <scrim/geometry/spaces.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace scrim {

inline constexpr int kCellEdge = 8;                                    ///< cells along a block's edge
inline constexpr int kBlockCells = kCellEdge * kCellEdge * kCellEdge;  ///< 512

/// Cells of a block lie x fastest.
constexpr int cellOffset(int x, int y, int z) {
    return (z * kCellEdge + y) * kCellEdge + x;
}

class CellGrid {
  public:
    /// Nothing.
    CellGrid() = default;
    /// Cubes of `edge` world units, whose corners lie at multiples of it: the blocks that meet any of `wsBoxes`.
    /// Throws Error(memory) where the box around them all has too many to number.
    CellGrid(double edge, const std::vector<Bounds>& wsBoxes);
    /// The same space in cells twice as large.
    static CellGrid coarser(const CellGrid& fine);

    double edge() const { return m_edge; }
    /// Blocks of the box around all of them.
    const Int3& blocks() const { return m_blocks; }
    /// Which of the stored blocks block `at` is; -1 where nothing is stored, or outside of the box.
    std::int32_t stored(const Int3& at) const {
        for (int axis = 0; axis < 3; ++axis)
            if (at[axis] < 0 || at[axis] >= m_blocks[axis]) return -1;
        return m_stored[(std::size_t(at.z) * std::size_t(m_blocks.y) + std::size_t(at.y)) * std::size_t(m_blocks.x) +
                        std::size_t(at.x)];
    }
    /// Where the stored blocks lie, in blocks from the corner of the box.
    const std::vector<Int3>& storedBlocks() const { return m_places; }
    /// Of all stored blocks: block b has the cells [512 b, 512 (b + 1)).
    std::size_t cells() const { return m_places.size() * kBlockCells; }
    /// Which cell is at `cell`, counted along each axis from the corner of the box; -1 where none is stored.
    std::ptrdiff_t index(const Int3& cell) const;
    /// And where cell `index` is, so counted.
    Int3 place(std::size_t index) const;

    /// Coordinates in cells from the corner of the box.
    Vec3 csFromWs(const Vec3& ws) const { return ws / m_edge - Vec3(m_origin); }
    Vec3 wsFromCs(const Vec3& cs) const { return (cs + Vec3(m_origin)) * m_edge; }
    /// The middle of a cell.
    Vec3 wsCenter(std::size_t index) const { return wsFromCs(Vec3(place(index)) + 0.5); }

    std::size_t bytes() const { return m_stored.size() * sizeof(std::int32_t) + m_places.size() * sizeof(Int3); }

  private:
    void number(std::vector<bool>&& wanted);

    double m_edge = 1;
    Int3 m_origin{0};  // of the box, in cells: multiples of 8
    Int3 m_blocks{0};
    std::vector<std::int32_t> m_stored;  // of each block of the box, x fastest
    std::vector<Int3> m_places;
};

}  // namespace scrim
