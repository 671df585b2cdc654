// SPDX-License-Identifier: Apache-2.0
// The transport equation of light that has scattered, one colour at a time, by discrete ordinates:
//
//   w_m . grad I_m + sigma_t I_m = sigma_s sum_n w_n p(n -> m) I_n + Q_m
//
// I_m is the radiance along ordinate m, Q_m what scatters for the first time, or glows. The unknown is X, what a unit
// of scattering coefficient sends out: one number a cell where all phase functions are isotropic, else one an ordinate.
// X = G(X), one sweep, is a contraction; alone it needs a sweep for every time that light scatters. So what a sweep
// leaves to do is solved for on cells twice as large, where it costs an eighth, down to a few cells, which are solved
// by Anderson's acceleration (multigrid: A. Brandt, Math. Comp. 31, 1977; D. G. Anderson, J. ACM 12, 1965).
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/simd.h>
#include <scrim/engine/transport/cell_media.h>
#include <scrim/engine/transport/cell_sweep.h>
#include <scrim/engine/transport/ordinates.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace scrim {

/// How far a solve came.
struct Solved {
    int sweeps = 0;                    ///< of the finest cells
    std::uint64_t cellDirections = 0;  ///< cells times ordinates, of all sweeps and cell sizes
    double change = 0;                 ///< of the scattered light by the last sweep, relative
    bool converged = true;

    Solved& operator+=(const Solved& o);
};

class TransportSolver {
  public:
    struct Settings {
        Ordinates ordinates;
        double tolerance = 0.002;  ///< relative change by a sweep that is small enough
        int mostSweeps = 60;       ///< of the finest cells
        bool accelerate = true;    ///< false: plain iteration, for comparison
        Simd simd;
        std::function<void()> checkpoint;  ///< asked before each sweep; throws to stop
    };
    /// `media` and `classes` must outlive this.
    TransportSolver(const CellMedia& media, const std::vector<ScatterClass>& classes, Settings settings);

    /// Are all phase functions isotropic? Then rows have one value, else one an ordinate.
    bool isotropic() const { return m_isotropic; }
    std::size_t valuesPerRow() const { return m_isotropic ? 1 : std::size_t(m_settings.ordinates.count()); }
    /// Which row a cell has: -1 where its light is of no interest.
    std::int32_t rowOf(std::size_t cell) const { return m_levels.front().rows[cell]; }
    std::size_t rows() const { return m_levels.front().rowCount; }

    /// The source Q of the next solve, radiance per world unit, rows() x valuesPerRow(), to be filled in; all 0.
    std::vector<Real>& clearedSource();
    /// Solves for colour `colour` of the media. `inflow`: radiance along each ordinate from beyond all volumes; empty:
    /// none. Afterwards `radiance()` holds, for each row, the radiance along each ordinate, or its mean over all
    /// directions; never below 0.
    Solved solve(std::size_t colour, const std::vector<Real>& inflow);
    const std::vector<Real>& radiance() const { return m_levels.front().next; }

    std::size_t bytes() const;

  private:
    struct Level {
        CellMedia media;  // of all but the first, which is the caller's
        const CellMedia* own = nullptr;
        std::vector<std::int32_t> rows;  // of each cell
        std::vector<std::size_t> cellOf;
        std::size_t rowCount = 0;
        std::vector<Real> extinction, scattering;  // of the colour at hand: one value a cell, one a row
        std::vector<std::vector<Real>> shares;     // of each class in `scattering`, one value a row; one class: none
        std::vector<Real> x, next, source;

        const CellMedia& cells() const { return own ? *own : media; }
    };
    class Anderson;

    void numberRows(Level& level) const;
    void chooseColour(Level& level, std::size_t colour) const;
    void sweep(Level& level, const Real* inflow, bool last);
    void scatter(Level& level) const;
    double changeOf(const Level& level) const;
    void start(std::size_t level, const Real* inflow);
    double iterate(std::size_t level, const Real* inflow, double tolerance, int mostSweeps, bool* ahead);
    void restrict(const Level& fine, Level& coarse, bool residual) const;
    void prolong(const Level& coarse, Level& fine, bool add) const;

    const std::vector<ScatterClass>& m_classes;
    Settings m_settings;
    bool m_isotropic;
    std::vector<std::vector<Real>> m_matrices;  // of each class, see scatteringMatrix
    std::vector<Level> m_levels;                // from the finest
    std::vector<Real> m_mean, m_scratch;        // of sweeps, kept since fresh memory is dear
    Solved m_solved;
};

}  // namespace scrim
