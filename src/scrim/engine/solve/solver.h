// SPDX-License-Identifier: Apache-2.0
// Solves the transport equation of scattered light, one colour at a time, by discrete ordinates:
//
//   w_m . grad I_m + sigma_t I_m = sigma_s sum_n w_n p(n -> m) I_n + Q_m
//
// I_m is the radiance along ordinate m; Q_m is light that scatters for the first time, or emission. The unknown is X,
// what a unit of scattering coefficient emits: one number per cell if all phase functions are isotropic, else one for
// each ordinate. X = G(X), one sweep, is a contraction, but alone it needs a sweep for every order of scattering.
// Therefore the residual of a sweep is solved for on cells twice as large, where that costs an eighth, and so on down
// to a few cells, which are solved with Anderson's acceleration (multigrid: A. Brandt, Math. Comp. 31, 1977). Larger
// cells have other walls, through which a correction would leak, so in grids with walls Anderson's acceleration stands
// alone. Where walls send light back, what arrives at them is unknown, too, and belongs to X.
#pragma once

#include <scrim/base/anderson.h>
#include <scrim/base/real.h>
#include <scrim/base/simd.h>
#include <scrim/engine/cells/cell_media.h>
#include <scrim/engine/solve/cell_sweep.h>
#include <scrim/engine/cells/ordinates.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace scrim {

/// The outcome of a solve.
struct Solved {
    int sweeps = 0;                    ///< sweeps of the finest cells
    std::uint64_t cellDirections = 0;  ///< cells times ordinates, over all sweeps and cell sizes
    double error = 0;  ///< what further sweeps would change, relative to the scattered light: an estimate
    bool converged = true;

    Solved& operator+=(const Solved& o) {
        sweeps += o.sweeps;
        cellDirections += o.cellDirections;
        error = std::max(error, o.error);
        converged = converged && o.converged;
        return *this;
    }
};

class TransportSolver {
  public:
    struct Settings {
        Ordinates ordinates;
        double tolerance = 0.005;  ///< iteration ends where Solved::error is less
        int mostSweeps = 60;       ///< sweeps of the finest cells
        Simd simd;
        std::function<void()> checkpoint;  ///< called before each sweep; throws to stop
        bool directional = false;          ///< rows hold all ordinates, even if all phase functions are isotropic
    };
    /// `media` and `classes` must outlive this object.
    TransportSolver(const CellMedia& media, const std::vector<ScatterClass>& classes, Settings settings);
    ~TransportSolver();

    /// True if rows have one value, because all phase functions are isotropic; else they have one for each ordinate.
    bool isotropic() const { return m_isotropic; }
    std::size_t valuesPerRow() const { return m_isotropic ? 1 : std::size_t(m_settings.ordinates.count()); }
    /// The row of each cell; -1 if its light is not needed.
    const std::vector<std::int32_t>& rowOfCell() const;
    const std::vector<std::size_t>& cellOfRow() const;
    std::size_t rows() const { return cellOfRow().size(); }

    /// The source Q of the next solve, filled with 0: radiance per world unit, rows() x valuesPerRow(). After that
    /// comes one value for each of the grid's sides of walls: the radiance that it sends back of light from lights, as
    /// a mean over the face. The caller adds to it.
    std::vector<Real>& clearedSource();
    std::vector<Real>& source();
    /// Solves for colour `colour` of the media. `inflow`: what enters from outside of all cells.
    /// Afterwards `radiance()` holds, for each row, the radiance along each ordinate, or its mean
    /// over all directions; never below 0.
    Solved solve(std::size_t colour, const Inflow& inflow);
    const std::vector<Real>& radiance() const;

    /// Peak memory so far.
    std::size_t bytes() const;

    /// Smaller grids are not made coarser.
    static constexpr std::size_t kFewestCells = 4 * kBlockCells;
    /// Steps that Anderson's acceleration mixes, of the coarsest cells and, if rows have one value,
    /// of the finest: few for cells that have a value for each ordinate and walls.
    static constexpr std::size_t kHistory = 6, kShortHistory = 3;

  private:
    struct Level;

    void numberRows(Level& level) const;
    void chooseColour(Level& level, std::size_t colour) const;
    void sweep(Level& level, const Inflow* inflow, bool last);
    void scatter(Level& level) const;
    double dot(const Real* a, const Real* b) const;
    double product(const Level& level, const std::vector<Real>& a, const std::vector<Real>& b) const;
    double lightOf(const Level& level, const std::vector<Real>& values, const std::vector<Real>* minus = nullptr) const;
    double relative(const Level& level, double light) const;
    void start(std::size_t level, const Inflow* inflow);
    AndersonMixing mixing(std::size_t level) const;
    double improve(std::size_t level, double residual, AndersonMixing& anderson);
    void reduce(std::size_t level, const Inflow* inflow, int mostSweeps);
    double iterate(const Inflow* inflow, bool* ahead);
    void restrict(const Level& fine, Level& coarse, bool residual) const;
    void prolong(const Level& coarse, Level& fine, bool add) const;

    const std::vector<ScatterClass>& m_classes;
    Settings m_settings;
    bool m_isotropic;
    std::size_t m_full = 0;                     // classes before those that scatter once
    std::vector<std::vector<Real>> m_matrices;  // for each class, see scatteringMatrix
    std::vector<Real> m_ones;                   // a row
    double m_sphere = 1;                        // the sum of a row's weights
    std::vector<Level> m_levels;                // starting with the finest
    std::vector<Real> m_mean, m_scratch;        // memory of sweeps, kept because fresh memory is slow
    std::vector<std::uint8_t> m_border;         // see CellSweep
    std::vector<Real> m_back, m_caught;         // for each side of walls (see CellSweep)
    std::size_t m_mixed = 0;                    // the most bytes of steps that were mixed
    double m_gain = 1;                          // of the current solve: the error of x, relative to its residual
    Solved m_solved;
};

/// Whether light from outside of all cells gets past the walls of `grid`, see CellSweep::border; empty: it has none.
std::vector<std::uint8_t> openBorder(const CellGrid& grid, const Ordinates& ordinates);

}  // namespace scrim
