// SPDX-License-Identifier: Apache-2.0
// Looks light on cells up at the samples of a tile, several at a time.
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/simd.h>
#include <scrim/engine/cells/cell_grid.h>
#include <scrim/engine/cells/sheet_path.h>

#include <cstddef>

namespace scrim {

/// The values of a CellField, for each stored block of its grid as CellField::block has them.
struct CellValues {
    const CellGrid* grid;  ///< has no walls
    const Real* values;
    std::size_t colours;  ///< 1 or 3
    Real tint[3];
};

/// CellField::lookUp for those samples alone that lie in a stored block, and where the sheet is thin (SheetPath). The
/// others with extinction get 0; their indices go to `left`, which has room for kTileSize. Returns their number.
int lookUpThin(const CellValues& field, const SamplePlane& plane, const SampleTile& samples, const Real* extinction,
               Real* const rgb[3], int* left);

}  // namespace scrim
