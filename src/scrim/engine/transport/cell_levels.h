// SPDX-License-Identifier: Apache-2.0
// From cells to those half as large.
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/transport/cell_grid.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace scrim {

/// Which cells of a grid have a row of values, and which one; -1: none.
struct CellRows {
    const CellGrid* grid;
    const std::vector<std::int32_t>* rows;
};

/// Adds to the rows of the finer cells, `values` numbers each, what those of the coarser ones (CellGrid::coarser) have
/// there: linear between their middles. Cells without a row do not count.
void addInterpolated(const CellRows& coarse, const std::vector<Real>& from, const CellRows& fine, std::size_t values,
                     std::vector<Real>& to);

}  // namespace scrim
