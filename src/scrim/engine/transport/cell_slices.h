// SPDX-License-Identifier: Apache-2.0
// The cells of a grid as slices along one axis, through which light is passed from slice to slice.
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/transport/cell_field.h>
#include <scrim/engine/transport/cell_grid.h>
#include <scrim/geometry/spaces.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

namespace scrim {

/// Elements behind each row that vectors may read or add zeros to.
inline constexpr int kRowSlack = 16;

struct CellSpan {
    int begin = 0, end = 0;
    bool empty() const { return begin >= end; }
    /// The smallest span that contains both.
    CellSpan with(const CellSpan& o) const {
        return empty() ? o : o.empty() ? *this : CellSpan{std::min(begin, o.begin), std::max(end, o.end)};
    }
};

/// A box of cells as slices; within a slice there are rows along `i`, one beside the other along `j`. Coordinates are
/// in cells from the corner of the box, which is one cell larger on each side than the grid's stored blocks, because
/// light is looked up between the centres of cells.
class CellSlices {
  public:
    std::array<int, 3> axes{};              ///< the axes of the world along which i, j and the slices run
    std::array<int, 3> size{};              ///< in cells: along i, along j, number of slices
    std::vector<Real> extinction;           ///< per cell edge; rows and slices have a zero cell around them
    std::vector<CellSpan> full;             ///< for each row, likewise padded: where there is extinction
    std::vector<CellSpan> wanted;           ///< for each row, not padded: cells whose light is looked up
    std::array<std::vector<Real>, 3> sums;  ///< the result: light in each cell, not padded but for the slack

    /// `grid` must outlive this object.
    CellSlices(const CellGrid& grid, int axis);

    std::size_t stride() const { return std::size_t(size[0] + 2 + kRowSlack); }
    std::size_t paddedRow(int j, int k) const { return std::size_t(k) * std::size_t(size[1] + 2) + std::size_t(j + 1); }
    /// The extinction of row j of slice k from i = 0 on; -1 is also valid, and so is i = -1.
    const Real* row(int j, int k) const { return extinction.data() + paddedRow(j, k) * stride() + 1; }
    std::size_t sumStride() const { return std::size_t(size[0] + kRowSlack); }
    std::size_t rowIndex(int j, int k) const { return std::size_t(k) * std::size_t(size[1]) + std::size_t(j); }

    /// A world vector's components in the order of i, j and slices.
    Vec3 reordered(const Vec3& ws) const { return {ws[axes[0]], ws[axes[1]], ws[axes[2]]}; }
    /// The place of a world point in cells of the box, and that of a place in the world.
    Vec3 place(const Vec3& ws) const { return reordered(m_grid.csFromWs(ws) + 1.0); }
    Vec3 wsPlace(const Vec3& at) const;

    /// Takes the grid's extinction, per world unit. Light is wanted up to `reach` cells from where there is any.
    void fill(const std::vector<Real>& perWorldUnit, int reach);
    /// Takes out the extinction within a sphere, so that rays from within begin at its surface. Returns which elements
    /// to restore.
    std::vector<std::pair<std::size_t, Real>> hollow(const Vec3& ws, double radius);
    void clearSums(std::size_t colours);
    /// Takes from the sums what linear interpolation adds in the mean: between the centres of cells, which is a twelfth
    /// of the second differences, and in a slice from rays to cells. No sum exceeds those beside it by that. Cells
    /// beside one that is not wanted keep theirs.
    void sharpen(std::size_t colours);
    /// Adds the sums to a field, from its colour `to` on. Its grid may have other blocks of the same cells.
    void addTo(std::size_t colours, std::size_t to, CellField& field) const;
    /// Adds to `far` the light of `lamp`, whose transmittance the sums are, at cells far from it. `colour`: the only
    /// one that the sums are for; -1: all.
    void addFarLight(const CellField& lamp, int colour, CellField& far) const;
    std::size_t bytes() const;

  private:
    void findWanted(int reach);
    // Calls visit(ws, index into sums, values of the field) for all cells of the field, in parallel.
    template <class Visit>
    void visitCells(CellField& field, const Visit& visit) const;

    const CellGrid& m_grid;
};

}  // namespace scrim
