// SPDX-License-Identifier: Apache-2.0
// The last sweep of a solve, whose result is visible. Few ordinates show as rays of a bright spot's light, unless it
// has scattered many times. Therefore the last sweep, which light passes just before it is seen, has more ordinates
// than the solve. It sweeps a part of them at a time, as many as the solve has, and keeps of each part only what is
// seen, so that rows are no longer than those of the solve.
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/simd.h>
#include <scrim/engine/cells/cell_media.h>
#include <scrim/engine/cells/ordinates.h>
#include <scrim/engine/solve/solver.h>
#include <scrim/geometry/camera.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace scrim {

/// The number of ordinates of a solve whose last sweep has `ordinates`: a half of them, but no fewer than 64. In clouds
/// of g = 0, 0.5 and 0.75, 64 ordinates differed by 0.6 to 1.4 % from 1,024; with 128 in the last sweep by 0.3 to 0.9 %
/// (a solve with 128: 0.3 to 0.8 %); 128 with 256 in the last sweep by 0.1 to 0.5 % (with 256: the same).
int solvedOrdinates(int ordinates);

/// Media as they are with phase functions split as those of `to`, not as those of `from`.
CellMedia splitAgain(const CellMedia& media, const std::vector<ScatterClass>& from,
                     const std::vector<ScatterClass>& to);

class LastSweep {
  public:
    /// What is kept of radiance: what `eye` sees of it after one more scattering. If that is null, it is the mean over
    /// all directions and, with `flux`, the mean of radiance times x, y and z of its direction of travel.
    struct Keeps {
        const Camera* eye = nullptr;
        bool flux = false;
    };
    /// `media` and `classes` are those of `solver`, whose source becomes memory of the sweeps. What
    /// is referred to must outlive this.
    LastSweep(const ViewScene& scene, const CellMedia& media, const std::vector<ScatterClass>& classes, int ordinates,
              const Keeps& keeps, TransportSolver& solver, Simd simd);

    /// The directions of the sweep, and the classes and media with phase functions that are split for these directions.
    const Ordinates& ordinates() const { return m_ordinates; }
    const std::vector<ScatterClass>& classes() const { return m_classes; }
    const CellMedia& media() const { return m_split.extinction.empty() ? m_solved : m_split; }

    /// What enters each part of the sweep, of the same radiance everywhere along each of ordinates(); empty: nothing.
    std::vector<Inflow> divided(const std::vector<Real>& inflow) const;

    /// Adds light to a source along ordinates.
    using Source = std::function<void(const Ordinates&, std::vector<Real>&)>;
    /// Is told what all cells send along ordinates, radiance per world unit, and what enters along these.
    using Send = std::function<void(const Ordinates&, const Inflow&, const std::vector<Real>&)>;
    /// What is kept for each class, and then of the flux along x, y and z: [kept][row of the solver], radiance per unit
    /// of scattering coefficient; it may be below zero. It is the sum of three parts of the light of colour `colour`:
    /// - `inflow`: what comes in from outside.
    /// - `solved`: the light that scatters as the last solve found it; that must have been for the same light.
    /// - `addSource`: adds light along the ordinates that it is called with; null: none.
    /// `send`: is called for the ordinates of the solve, if these are others, and then for those of each part.
    std::vector<std::vector<Real>> pass(std::size_t colour, const PassInflow& inflow, bool solved,
                                        const Source& addSource, const Send& send = {});

    /// Adds to a source along `along` what classes that scatter once, or the others, send on of
    /// `radiance`, the result of a solve.
    void addScattered(bool once, std::size_t colour, const std::vector<Real>& radiance, const Ordinates& along,
                      std::vector<Real>& source) const;
    /// Peak memory so far.
    std::size_t bytes() const {
        return (m_split.extinction.empty() ? 0 : m_split.bytes()) + m_kept +
               (m_mean.capacity() + m_scratch.capacity()) * sizeof(Real);
    }
    /// Cells times ordinates, over all sweeps.
    std::uint64_t cellDirections() const { return m_cellDirections; }

  private:
    void sweep(std::size_t part, std::size_t colour, const Inflow* inflow, std::vector<Real>& rows);
    void keep(const Ordinates& along, const std::vector<Real>& rows, std::vector<std::vector<Real>>& kept,
              std::vector<std::vector<Real>>& lobes) const;

    const CellMedia& m_solved;
    const Camera* m_eye;
    bool m_flux;
    TransportSolver& m_solver;
    Simd m_simd;
    Ordinates m_ordinates, m_ofSolve;
    std::vector<Ordinates> m_parts;
    std::vector<std::vector<std::uint8_t>> m_borders;  // see CellSweep, of each part
    std::vector<ScatterClass> m_classes;
    CellMedia m_split;                    // empty: splitting for more ordinates changes nothing
    std::vector<Real> m_mean, m_scratch;  // memory of sweeps
    std::size_t m_kept = 0;               // bytes of what a pass keeps
    std::uint64_t m_cellDirections = 0;
};

}  // namespace scrim
