// SPDX-License-Identifier: Apache-2.0
// The cells that carry scattered light: cubes along the world's axes, in blocks of 8^3, stored only where there are
// volumes. Cells have fixed places in the world, independent of camera, lights and volumes.
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

/// Offset of a cell within its block; x varies fastest.
constexpr int cellOffset(int x, int y, int z) {
    return (z * kCellEdge + y) * kCellEdge + x;
}

class CellGrid {
  public:
    /// An empty grid.
    CellGrid() = default;
    /// Cubes of `edge` world units, one of which has a corner at `wsCorner`, in all blocks that meet any of `wsBoxes`.
    /// Throws Error(memory) if the box around all blocks has too many to number.
    CellGrid(double edge, const std::vector<Bounds>& wsBoxes, const Vec3& wsCorner = Vec3(0));
    /// The same space in cells twice as large.
    static CellGrid coarser(const CellGrid& fine);

    double edge() const { return m_edge; }
    /// The size, in blocks, of the box around all blocks.
    const Int3& blocks() const { return m_blocks; }
    /// The index of block `at` among the stored blocks; -1 if it is not stored, or outside of the box.
    std::int32_t stored(const Int3& at) const {
        for (int axis = 0; axis < 3; ++axis)
            if (at[axis] < 0 || at[axis] >= m_blocks[axis]) return -1;
        return m_stored[numberInBox(at)];
    }
    /// The places of the stored blocks, in blocks from the corner of the box.
    const std::vector<Int3>& storedBlocks() const { return m_places; }
    /// The number of cells in all stored blocks: block b has the cells [512 b, 512 (b + 1)).
    std::size_t cells() const { return m_places.size() * kBlockCells; }
    /// The index of the cell at `cell`, counted along each axis from the corner of the box; -1 if it is not stored.
    std::ptrdiff_t index(const Int3& cell) const;
    /// The place of cell `index`, counted likewise.
    Int3 place(std::size_t index) const;

    /// Coordinates in cells from the corner of the box.
    Vec3 csFromWs(const Vec3& ws) const { return (ws - m_corner) / m_edge - Vec3(m_origin); }
    Vec3 wsFromCs(const Vec3& cs) const { return (cs + Vec3(m_origin)) * m_edge + m_corner; }
    /// The centre of a cell.
    Vec3 wsCenter(std::size_t index) const { return wsFromCs(Vec3(place(index)) + 0.5); }

    std::size_t bytes() const { return m_stored.size() * sizeof(std::int32_t) + m_places.size() * sizeof(Int3); }

  private:
    // The number of a block of the box; x varies fastest.
    std::size_t numberInBox(const Int3& at) const {
        return (std::size_t(at.z) * std::size_t(m_blocks.y) + std::size_t(at.y)) * std::size_t(m_blocks.x) +
               std::size_t(at.x);
    }
    void number(std::vector<bool>&& wanted);

    double m_edge = 1;
    Vec3 m_corner{0};  // world
    Int3 m_origin{0};  // corner of the box, in cells: multiples of 8
    Int3 m_blocks{0};
    std::vector<std::int32_t> m_stored;  // for each block of the box, x fastest
    std::vector<Int3> m_places;
};

}  // namespace scrim
