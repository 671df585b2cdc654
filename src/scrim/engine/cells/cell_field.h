// SPDX-License-Identifier: Apache-2.0
// Values on cells, which shading looks up at any point.
#pragma once

#include <scrim/base/parallel.h>
#include <scrim/base/real.h>
#include <scrim/base/zeroed_array.h>
#include <scrim/engine/cells/cell_grid.h>
#include <scrim/engine/cells/sheet_path.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace scrim {

/// Light on cells: radiance towards the eye per unit of scattering coefficient, which equals that
/// of an equivalent uniform environment. It is interpolated linearly between the centres of those
/// cells that are on the same side of the grid's walls.
class CellField {
  public:
    using LastBlock = CellGrid::LastBlock;

    /// Black. With one value per cell instead of three, the light is that value times `tint`.
    CellField(std::shared_ptr<const CellGrid> grid, int colours, const Rgb& tint = Rgb(1));

    /// A black one on the same cells.
    CellField blackAlike() const { return {m_grid, static_cast<int>(m_colours), {m_tint[0], m_tint[1], m_tint[2]}}; }

    const CellGrid& grid() const { return *m_grid; }
    std::size_t colours() const { return m_colours; }
    /// The values of block `b`: `colours` for each of its kPaddedCells cells, x fastest.
    Real* block(std::size_t b) { return m_values.data() + b * kPaddedCells * m_colours; }
    const Real* block(std::size_t b) const { return m_values.data() + b * kPaddedCells * m_colours; }
    /// The values of a stored cell, in its own block.
    Real* cell(std::size_t index);
    /// Calls visit(place, values) once for each cell of all blocks, and for those around a block
    /// that no other block has, in parallel; then fills what is around blocks. Places are counted
    /// along each axis from the corner of the grid's box.
    template <class Visit>
    void forCells(const Visit& visit);
    /// Adds light(centre) to every cell: to the first colour, or to all three. `light` is called by many threads.
    void add(const std::function<Rgb(const Vec3& ws)>& light);
    /// Adds the values of one that is alike.
    void add(const CellField& other);
    /// Copies the values of stored cells to where they are around other blocks.
    void fillAround();
    /// The light at a point, 0 beyond the stored cells.
    void sample(const Vec3& ws, Real (&rgb)[3]) const;
    void sample(const Vec3& ws, LastBlock& last, Real (&rgb)[3]) const;
    /// The light at a tile of samples: kTileSize values for each colour, 0 where `extinction`, likewise kTileSize
    /// values per world unit, is. `nearer`: null, or that of the halves of the sheet that are nearer to the eye.
    void lookUp(const SamplePlane& plane, const SampleTile& samples, const Real* extinction, Real* const rgb[3],
                const Real* nearer = nullptr) const;

    std::size_t bytes() const { return m_values.size() * sizeof(Real); }

  private:
    std::shared_ptr<const CellGrid> m_grid;
    std::size_t m_colours;
    Real m_tint[3];
    ZeroedArray<Real> m_values;  // [block][padded cell][colour]
};

template <class Visit>
void CellField::forCells(const Visit& visit) {
    parallelFor(m_grid->storedBlocks().size(), [&](std::size_t b) {
        const Int3& own = m_grid->storedBlocks()[b];
        Real* values = block(b);
        for (int i = 0; i < static_cast<int>(kPaddedCells); ++i, values += m_colours) {
            const Int3 cell = own * kCellEdge - 1 + paddedCell(i);
            if (cell >> 3 == own || m_grid->stored(cell >> 3) < 0) visit(cell, values);
        }
    });
    fillAround();
}

}  // namespace scrim
