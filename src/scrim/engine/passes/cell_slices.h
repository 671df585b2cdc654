// SPDX-License-Identifier: Apache-2.0
// The cells of a grid as slices along one axis, through which light is passed from slice to slice.
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/cells/cell_field.h>
#include <scrim/engine/cells/cell_grid.h>
#include <scrim/engine/cells/surface_cells.h>
#include <scrim/engine/lamps/lamp_field.h>
#include <scrim/engine/passes/row_spans.h>
#include <scrim/geometry/spaces.h>

#include <array>
#include <cstddef>
#include <functional>
#include <tuple>
#include <utility>
#include <vector>

#include <glm/common.hpp>

namespace scrim {

/// Cells of slices: along i, along j, and the slices.
struct CellBox {
    std::array<int, 3> begin{}, end{};
};

/// A box of cells as slices; within a slice there are rows along `i`, one beside the other along `j`. Coordinates are
/// in cells from the corner of the box, which is one cell larger on each side than the grid's stored blocks, because
/// light is looked up between the centres of cells. Rows keep only those cells that are used.
class CellSlices {
  public:
    std::array<int, 3> axes{};  ///< the axes of the world along which i, j and the slices run
    std::array<int, 3> size{};  ///< in cells: along i, along j, number of slices
    RowSpans crossed;           ///< by `paddedRow`: where there is extinction in this row or the next
    RowSpans beside;            ///< by `paddedRow`: where values of a field may be read in this row and the next one
    RowSpans wanted;            ///< by `rowIndex`: cells whose light is looked up
    CellBox wantedBox;          ///< around them
    /// For each slice the rows j that have any of these; those of `crossed` and `beside` are j + 1.
    std::vector<std::vector<int>> crossedRows, besideRows, wantedRows;

    static constexpr std::size_t kMostSums = 6;
    static constexpr int kEverywhere = -1;

    /// `grid` must outlive this object.
    explicit CellSlices(const CellGrid& grid) : m_grid(grid) {}
    /// Lays slices along an axis of the world, without extinction; must be called first. Memory is used again.
    void layAlong(int axis);

    double edge() const { return m_grid.edge(); }
    CellBox whole() const { return {{0, 0, 0}, size}; }
    std::size_t paddedRow(int j, int k) const { return std::size_t(k) * std::size_t(size[1] + 2) + std::size_t(j + 1); }
    std::size_t rowIndex(int j, int k) const { return std::size_t(k) * std::size_t(size[1]) + std::size_t(j); }
    /// The extinction, per cell edge, of row j of slice k, as from i = 0 on. It may be read where a
    /// row is wanted, or there is extinction in this one or one beside it, and from one cell before
    /// that to kRowSlack behind. It is 0 beyond the box.
    const Real* row(int j, int k) const { return m_extinction.data() + m_rowAt[paddedRow(j, k)]; }
    /// The result: one of kMostSums sums of light, such as that of a colour, in row j of slice k, as from i = 0 on.
    /// Only where the row is wanted; up to kRowSlack cells behind that may be written.
    Real* sums(std::size_t sum, int j, int k) { return m_sums[sum].data() + m_sumAt[rowIndex(j, k)]; }

    /// A world vector's components in the order of i, j and slices.
    Vec3 reordered(const Vec3& ws) const { return {ws[axes[0]], ws[axes[1]], ws[axes[2]]}; }
    /// The place of a world point in cells of the box, and that of a place in the world.
    Vec3 place(const Vec3& ws) const { return reordered(m_grid.csFromWs(ws) + 1.0); }
    Vec3 wsPlace(const Vec3& at) const;

    /// What the luminaire of a light sends along the unit vector w of these axes, relative to its intensity:
    /// even + linear . w + w . quadratic w, or nothing where that is below 0. It is what spherical harmonics up to the
    /// second order have of the profile, scaled so that towards the corners of `wsVolumes` its mean is the profile's.
    std::tuple<double, Vec3, Mat3> seriesOf(const Light& light, const Bounds& wsVolumes) const;

    /// Takes the normals of surfaces in the cells of `of`, which are those of the grid, in the axes
    /// of the slices, and their weights. Elsewhere they are 0.
    void face(const CellGrid& of, const SurfaceNormals& normals);
    /// The normal's components along i, j and the slices (0, 1, 2) and its weight (3) in row j of
    /// slice k, as `sums` has light.
    const Real* facing(std::size_t part, int j, int k) const { return m_facing[part].data() + m_sumAt[rowIndex(j, k)]; }

    /// From now on the values of a field say what holds light back, by the integral of its
    /// extinction, and not `row`; null: row does. Both must outlive this, or the next call.
    void classify(const SurfaceCells* surfaces, const ExtinctionIntegral* integral);
    const ExtinctionIntegral* integral() const { return m_integral; }
    /// The field's values, as `row` has the extinction.
    const Real* values(int j, int k) const { return m_values.data() + m_rowAt[paddedRow(j, k)]; }
    /// Takes the grid's extinction, per world unit. Light is wanted up to `reach` cells from where there is any;
    /// kEverywhere: wherever `shown` says.
    /// `values`: those of a field will be asked for.
    /// `shown`: grids of the same cells; light is wanted in their blocks alone, and beside them. None: everywhere.
    void fill(const std::vector<Real>& perWorldUnit, int reach, bool values = false,
              const std::vector<const CellGrid*>& shown = {});
    /// Takes another extinction, which is 0 where that of `fill` was. Light is wanted where it was.
    void refill(const std::vector<Real>& perWorldUnit);
    /// Takes out the extinction within a sphere, so that rays from within begin at its surface.
    /// Returns what `restore` needs to undo it.
    std::vector<std::pair<std::size_t, Real>> hollow(const Vec3& ws, double radius);
    void restore(const std::vector<std::pair<std::size_t, Real>>& before);
    void clearSums(std::size_t sums);
    /// Subtracts from each sum the mean error of interpolation (Sharpened), as far as its neighbours are wanted.
    void sharpen(std::size_t count, bool steep);
    /// Adds `count` sums from `first` on to a field, from its colour `to` on. Its grid may have
    /// other blocks of the same cells.
    void addTo(std::size_t first, std::size_t count, std::size_t to, CellField& field) const;
    /// Marks the grid's stored blocks that have a cell whose first sum is more than `least`.
    void markBlocks(Real least, std::vector<bool>& marked) const;
    /// Adds to `far` the light of `lamp`, whose transmittance at a knot the sums are, at cells far
    /// from it. `colour`: the only one that the sums are for; -1: all.
    void addFarLight(const LampField& lamp, std::size_t knot, int colour, CellField& far) const;
    std::size_t bytes() const;

  private:
    // What `rowIndex` and, with `around` = 1, `paddedRow` are made of.
    struct RowPlace {
        int j, k;
    };
    RowPlace placeOf(std::size_t row, int around = 0) const {
        const auto across = std::size_t(size[1] + 2 * around);
        return {static_cast<int>(row % across) - around, static_cast<int>(row / across)};
    }
    // The cell of the box that is cell 0 of a grid of the same cells.
    Int3 firstOf(const CellGrid& grid) const { return Int3(glm::round(m_grid.csFromWs(grid.wsFromCs(Vec3(0))))) + 1; }
    RowSpans everywhere() const;
    CellBox boxOfWanted() const;
    RowSpans near(int reach) const;
    RowSpans within(const std::vector<const CellGrid*>& shown) const;
    void keepRows();
    // Calls visit(cell of the field's grid, light of the row from that cell on, values of the field) for all wanted
    // cells of the blocks whose centre, in cells of that grid, `wantsBlock`, in parallel.
    template <class Visit, class Wanted>
    void visitCells(CellField& field, const Visit& visit, const Wanted& wantsBlock) const;
    // Calls visit(row, i of its first cell, index of that cell in values of `grid`, which has the
    // same cells, and its step) for all rows of cells in its stored blocks.
    template <class Visit>
    void visitRows(const CellGrid& grid, const Visit& visit) const;

    const CellGrid& m_grid;
    RowSpans m_full;  // by `paddedRow`: where there is extinction
    std::vector<Real> m_extinction;
    std::vector<CellSpan> m_kept;  // by `paddedRow`: cells whose extinction is kept
    // For each row the element of its cell 0, which need not be kept.
    std::vector<std::size_t> m_rowAt, m_sumAt;
    std::vector<std::size_t> m_sliceAt;  // for each slice, and behind the last: its first element of the sums
    std::array<std::vector<Real>, kMostSums> m_sums;
    std::array<std::vector<Real>, 4> m_facing;
    std::vector<Real> m_values;  // as m_extinction
    const ExtinctionIntegral* m_integral = nullptr;
};

}  // namespace scrim
