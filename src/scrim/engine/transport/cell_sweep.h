// SPDX-License-Identifier: Apache-2.0
// One sweep of all ordinates through the cells: from what every cell sends out, the radiance that passes through it.
//
// Diamond differences: radiance in a cell is the mean of what enters and leaves it, along each axis. That conserves
// energy, is of second order in the cell's edge, and stays right where a cell is many mean free paths thick and light
// diffuses (E. W. Larsen, J. E. Morel, W. F. Miller, J. Comput. Phys. 69, 1987), which schemes that follow rays do not.
// As any linear scheme beyond first order it may fall below zero (Godunov): the last sweep, whose result is seen, sets
// what would leave a cell with less than nothing to nothing and balances the cell anew.
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/simd.h>
#include <scrim/engine/transport/cell_grid.h>
#include <scrim/engine/transport/ordinates.h>

#include <cstdint>
#include <vector>

namespace scrim {

/// Lanes that ordinates are swept in: as many go together.
inline constexpr int kOrdinateLanes = 8;

struct CellSweep {
    const CellGrid* grid = nullptr;
    const Ordinates* ordinates = nullptr;
    const Real* extinction = nullptr;  ///< one value a cell
    /// One value an ordinate, of the radiance that enters from beyond all cells; nullptr: none does.
    const Real* inflow = nullptr;
    bool notBelowZero = false;
    Simd simd;
};

/// Where all cells send the same into all directions: `source` is that, one value a cell, radiance per world unit;
/// `mean` becomes the mean radiance over all directions, one value a cell. `scratch` is memory to be used again.
void sweepIsotropic(const CellSweep& sweep, const std::vector<Real>& source, std::vector<Real>& mean,
                    std::vector<Real>& scratch);

/// With a source that differs from direction to direction. `slots` has one value a cell: which of `radiance`'s rows of
/// ordinates is its own; -1 where it sends nothing, and nobody wants to know. On entry `radiance` holds what the cells
/// send out per world unit, on return the radiance in them.
void sweepDirectional(const CellSweep& sweep, const std::vector<std::int32_t>& slots, std::vector<Real>& radiance);

}  // namespace scrim
