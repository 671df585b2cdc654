// SPDX-License-Identifier: Apache-2.0
// The cells that carry scattered light: cubes along the world's axes, in blocks of 8^3, stored only where there are
// volumes. Cells have fixed places in the world, independent of camera, lights and volumes.
//
// Solids are walls between cells. A face is closed if a wall separates the centres of the cells on both sides of it, so
// walls move by up to half a cell, and slanting ones become stairs; but whatever is closed remains closed, however thin
// it is, and light that crosses stairs is the light that would cross the wall.
#pragma once

#include <scrim/base/real.h>
#include <scrim/geometry/bounds.h>
#include <scrim/geometry/spaces.h>
#include <scrim/solid/solids.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace scrim {

inline constexpr int kCellEdge = 8;                                    ///< cells along a block's edge
inline constexpr int kBlockCells = kCellEdge * kCellEdge * kCellEdge;  ///< 512
/// Cells along an edge of a block, with one cell of its neighbours on either side.
inline constexpr int kPaddedEdge = kCellEdge + 2;
inline constexpr std::size_t kPaddedCells = std::size_t(kPaddedEdge) * kPaddedEdge * kPaddedEdge;
/// What is open of a face without walls.
inline constexpr int kAllOpen = 16;
/// What CellGrid::onSideOf gives where no wall stands between any of the cells.
inline constexpr unsigned kAllSides = 255;

/// Offset of a cell within its block; x varies fastest.
constexpr int cellOffset(int x, int y, int z) {
    return (z * kCellEdge + y) * kCellEdge + x;
}
/// The same with the cells around the block, whose own first cell is (1, 1, 1).
constexpr int paddedOffset(int x, int y, int z) {
    return (z * kPaddedEdge + y) * kPaddedEdge + x;
}
/// The cell at such an offset.
inline Int3 paddedCell(int offset) {
    return {offset % kPaddedEdge, offset / kPaddedEdge % kPaddedEdge, offset / (kPaddedEdge * kPaddedEdge)};
}

class CellGrid {
  public:
    /// An empty grid.
    CellGrid() = default;
    /// Cubes of `edge` world units, one of which has a corner at `wsCorner`, in all blocks that meet any of `wsBoxes`.
    /// Throws Error(memory) if the box around all blocks has too many to number.
    CellGrid(double edge, const std::vector<Bounds>& wsBoxes, const Vec3& wsCorner = Vec3(0));
    /// The same space in cells twice as large, without walls.
    static CellGrid coarser(const CellGrid& fine);
    /// `row`, which has a value for each cell, on the grid that `coarser` made from this one: means over 2^3 cells.
    std::vector<Real> means(const std::vector<Real>& row, const CellGrid& coarse) const;
    /// Boxes within all blocks of such a grid that solids which stop light pass closely, for its
    /// constructor: those in `wsNear`, or in `wsFar` where they also send light back.
    static std::vector<Bounds> boxesOfWalls(const Solids& solids, double edge, const Bounds& wsNear,
                                            const Bounds& wsFar);

    double edge() const { return m_edge; }
    /// A corner of a cell, and how many cells from it the box around all blocks begins.
    const Vec3& wsCorner() const { return m_corner; }
    const Int3& origin() const { return m_origin; }
    /// The size, in blocks, of the box around all blocks.
    const Int3& blocks() const { return m_blocks; }
    /// The index of block `at` among the stored blocks; -1 if it is not stored, or outside of the box.
    std::int32_t stored(const Int3& at) const {
        for (int axis = 0; axis < 3; ++axis)
            if (at[axis] < 0 || at[axis] >= m_blocks[axis]) return -1;
        return m_stored[numberInBox(at)];
    }
    /// The block that was asked for last; neighbouring cells are mostly in the same one.
    struct LastBlock {
        Int3 at{1 << 30};          ///< in blocks
        std::int32_t stored = -1;  ///< its number among the stored blocks; -1: it is not stored
    };
    std::int32_t stored(const Int3& at, LastBlock& last) const {
        if (at != last.at) last = {at, stored(at)};
        return last.stored;
    }
    /// The places of the stored blocks, in blocks from the corner of the box.
    const std::vector<Int3>& storedBlocks() const { return m_places; }
    /// The number of cells in all stored blocks: block b has the cells [512 b, 512 (b + 1)).
    std::size_t cells() const { return m_places.size() * kBlockCells; }
    /// The index of the cell at `cell`, counted along each axis from the corner of the box; -1 if it is not stored.
    std::ptrdiff_t index(const Int3& cell) const {
        LastBlock last;
        return index(cell, last);
    }
    std::ptrdiff_t index(const Int3& cell, LastBlock& last) const {
        const std::int32_t block = stored(cell >> 3, last);  // also rounds down below 0
        if (block < 0) return -1;
        return std::ptrdiff_t(block) * kBlockCells + cellOffset(cell.x & 7, cell.y & 7, cell.z & 7);
    }
    /// The place of cell `index`, counted likewise.
    Int3 place(std::size_t index) const;

    /// Coordinates in cells from the corner of the box.
    Vec3 csFromWs(const Vec3& ws) const { return (ws - m_corner) / m_edge - Vec3(m_origin); }
    Vec3 wsFromCs(const Vec3& cs) const { return (cs + Vec3(m_origin)) * m_edge + m_corner; }
    /// The centre of a cell.
    Vec3 wsCenter(std::size_t index) const { return wsFromCs(Vec3(place(index)) + 0.5); }

    /// Makes walls of the solids that stop light. The blocks of boxesOfWalls must be stored.
    void raiseWalls(std::shared_ptr<const Solids> solids);
    bool hasWalls() const { return !m_walled.empty(); }
    /// The number of block `b` among the blocks with walls; -1: it has none.
    std::int32_t walled(std::size_t b) const { return m_walled.empty() ? -1 : m_walled[b]; }
    /// What is open of the lower face across `axis` of each cell of a block with walls, and of the
    /// cells around it (kPaddedCells values), in parts of kAllOpen.
    const std::uint8_t* open(std::int32_t walled, int axis) const {
        return m_open.data() + (std::size_t(walled) * 3 + std::size_t(axis)) * kPaddedCells;
    }
    /// True if no wall stands between two points.
    bool sees(const Vec3& wsFrom, const Vec3& wsTo) const;
    /// A point near the centre of a cell, which stands for the cell where walls are concerned. It
    /// lies beside the places that walls like, such as the middle between two voxels.
    Vec3 wsInside(const Int3& place) const { return wsFromCs(Vec3(place) + Vec3(0.5113, 0.5171, 0.5237)); }
    /// A bit for each of eight neighbouring cells: it is set if the cell is on the same side of the
    /// walls as `ws`, which lies between their centres. Bit a of a bit's number says whether its
    /// cell is the upper one along axis a. `low`: the place of the first cell in the padded block.
    unsigned onSideOf(const Vec3& ws, std::size_t block, const Int3& low) const;

    /// Sides of walls that send light back, as a cell sees one of its faces: 2 axis, + 1 for the upper one.
    std::size_t sides() const { return m_sides.size(); }
    std::size_t cellOfSide(std::size_t side) const { return m_sides[side] / 6; }
    /// For each face the sides at the cells of a block with walls, kBlockCells values; -1: none.
    const std::int32_t* sidesAt(std::int32_t walled, int face) const {
        return m_sideAt.data() + (std::size_t(walled) * 6 + std::size_t(face)) * kBlockCells;
    }
    /// The part of the light on the whole face of a side that is sent back. It differs from the albedo a of the wall:
    /// - Faces that stand for a slanted wall are stairs with k times its surface, which lose light that they send to
    ///   each other. Their albedo is b = a k / (1 + a (k - 1)).
    /// - In the corner of a room a face stands for walls of r times its area, and absorbs as much light as they do: it
    ///   sends back 1 - r (1 - b), at least 0.
    const Rgb& albedoOfSide(std::size_t side) const { return m_albedos[side]; }
    /// The part of light straight from lights that is sent back: the irradiance, times the sum of the cosines of
    /// pointsOfSide, times this part / pi, is the radiance that comes from the whole face.
    const Rgb& firstOfSide(std::size_t side) const { return m_firsts[side]; }
    /// Points of the solid that a side stands for, each with the normal towards the cell.
    std::vector<std::pair<Vec3, Vec3>> pointsOfSide(std::size_t side) const;

    std::size_t bytes() const;

  private:
    // The number of a block of the box; x varies fastest.
    std::size_t numberInBox(const Int3& at) const {
        return (std::size_t(at.z) * std::size_t(m_blocks.y) + std::size_t(at.y)) * std::size_t(m_blocks.x) +
               std::size_t(at.x);
    }
    void number(std::vector<bool>&& wanted);
    std::vector<bool> nearWalls() const;
    std::uint8_t openFace(const Int3& upper, int axis) const;
    void findSides();
    std::int32_t sideFor(const Vec3& ws) const;
    std::vector<double> areasOfSides() const;
    std::vector<std::pair<Vec3, SolidHit>> hitsOfFace(const Int3& cell, int face) const;

    double m_edge = 1;
    Vec3 m_corner{0};  // world
    Int3 m_origin{0};  // corner of the box, in cells: multiples of 8
    Int3 m_blocks{0};
    std::vector<std::int32_t> m_stored;  // for each block of the box, x fastest
    std::vector<Int3> m_places;

    std::shared_ptr<const Solids> m_solids;
    std::vector<std::int32_t> m_walled;  // for each stored block
    std::vector<std::uint8_t> m_open;    // [block with walls][axis][padded cell]
    std::vector<std::int32_t> m_sideAt;  // [block with walls][face][cell]; empty: no wall sends light back
    std::vector<std::size_t> m_sides;    // 6 cell + face
    std::vector<Rgb> m_albedos, m_firsts;
};

}  // namespace scrim
