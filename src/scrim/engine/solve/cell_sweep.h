// SPDX-License-Identifier: Apache-2.0
// One sweep of all ordinates through the cells: computes the radiance that passes through every
// cell from what all cells emit.
//
// The scheme is diamond differences: the radiance in a cell is the mean of what enters and leaves it, along each axis.
// It conserves energy, is of second order in the cell's edge, and remains correct where a cell is many mean free paths
// thick and light diffuses (E. W. Larsen, J. E. Morel, W. F. Miller, J. Comput. Phys. 69, 1987), unlike schemes that
// follow rays. As any linear scheme beyond first order, it may go below zero (Godunov). Therefore the last sweep, whose
// result is visible, sets negative outflow of a cell to zero and balances the cell again.
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/simd.h>
#include <scrim/engine/cells/cell_grid.h>
#include <scrim/engine/cells/ordinates.h>
#include <scrim/engine/solve/border_light.h>

#include <cstdint>
#include <vector>

namespace scrim {

/// The number of ordinates that are swept together, in the lanes of vectors.
inline constexpr int kOrdinateLanes = 8;

struct CellSweep {
    const CellGrid* grid = nullptr;
    const Ordinates* ordinates = nullptr;
    const Real* extinction = nullptr;  ///< one value for each cell
    const Inflow* inflow = nullptr;    ///< what enters from outside of all cells; nullptr: nothing
    bool notBelowZero = false;
    Simd simd;
    /// Whether an even `inflow` gets past walls to the cells at the border: 1 or 0 for each ordinate of each face. The
    /// faces across x are numbered z ny + y, those across y follow as z nx + x, then those across z as y nx + x, with
    /// nx, ny and nz cells along the edges. nullptr or empty: it does.
    const std::vector<std::uint8_t>* border = nullptr;
    /// One value for each side of the grid's walls (CellGrid::sides): the radiance that comes from
    /// there, the mean over the face. nullptr: no wall sends light back.
    const Real* back = nullptr;
    std::vector<Real>* caught = nullptr;  ///< receives the irradiance on each side divided by pi, before absorption
};

/// The number of bundles of ordinates that are swept together, for each of which sweepIsotropic has a row of scratch.
std::size_t bundlesOf(Simd simd, int ordinates);

/// For cells that emit the same in all directions: `source` is their emission, one value for each
/// cell, radiance per world unit; `mean` receives the mean radiance over all directions, one value
/// for each cell. `scratch` is memory that is reused.
void sweepIsotropic(const CellSweep& sweep, const std::vector<Real>& source, std::vector<Real>& mean,
                    std::vector<Real>& scratch);

/// For a source that differs by direction. `slots` has one value for each cell: its row of
/// ordinates in `radiance`; -1 if it emits nothing and its radiance is not needed. On entry
/// `radiance` holds the emission of the cells per world unit, on return their radiance.
void sweepDirectional(const CellSweep& sweep, const std::vector<std::int32_t>& slots, std::vector<Real>& radiance);

}  // namespace scrim
