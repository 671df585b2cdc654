// SPDX-License-Identifier: Apache-2.0
// Interpolation from cells to cells half as large.
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/transport/cell_grid.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace scrim {

/// Which cells of a grid have a row of values, and its number; -1: none.
struct CellRows {
    const CellGrid* grid;
    const std::vector<std::int32_t>* rows;
};

/// Adds to the rows of the finer cells, `values` numbers each, the values of the coarser cells (CellGrid::coarser)
/// there, interpolated linearly between their centres. Cells without a row do not count.
void addInterpolated(const CellRows& coarse, const std::vector<Real>& from, const CellRows& fine, std::size_t values,
                     std::vector<Real>& to);

}  // namespace scrim
