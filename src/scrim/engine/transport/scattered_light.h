// SPDX-License-Identifier: Apache-2.0
// Light that has scattered before it reaches a point and is scattered there into the eye: what the transport solver
// finds, as radiance in cells that shading looks up. An environment that differs from place to place.
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/model/plan.h>
#include <scrim/engine/transport/cell_grid.h>
#include <scrim/engine/transport/solver.h>
#include <scrim/geometry/sheets.h>
#include <scrim/scene/view_scene.h>

#include <functional>
#include <vector>

namespace scrim {

/// Where the samples of a tile are: ws = origin + u perU + v perV.
struct SamplePlane {
    Vec3 wsOrigin{0}, wsPerU{0}, wsPerV{0};
};

class ScatteredLight {
  public:
    /// Solves for all of the plan's targets. Slides must be loaded. `checkpoint` is asked between sweeps, and throws to
    /// stop. Throws Error(memory) where the cells are too many to be numbered.
    ScatteredLight(const ViewScene& scene, const TransportPlan& plan, Simd simd,
                   const std::function<void()>& checkpoint);

    /// Which of its own: volume `volume` of the scene sees target `target` of the plan as field
    /// fieldOf(volume, target); -1: it scatters light but once.
    int fieldOf(int volume, std::size_t target) const;
    std::size_t targets() const { return m_targets.size(); }
    const ScatterTarget& target(std::size_t i) const { return m_targets[i]; }

    /// Radiance per unit of scattering coefficient, that is what an even environment would have to shine with, towards
    /// the eye: kTileSize values a colour, linear between the middles of cells.
    void lookUp(int field, const SamplePlane& plane, const Real* u, const Real* v, Real* const rgb[3]) const;

    const Solved& solved() const { return m_solved; }
    /// The most that there was at a time.
    std::size_t bytes() const { return m_bytes; }

  private:
    // Blocks with a cell of their neighbours around them, four values a cell.
    static constexpr int kPadded = kCellEdge + 2;
    static constexpr std::size_t kPaddedCells = std::size_t(kPadded) * kPadded * kPadded;
    using Field = std::vector<Real>;
    static std::size_t paddedOf(std::size_t cell);

    void solve(const ViewScene& scene, const CellMedia& media, const std::vector<ScatterClass>& classes,
               const TransportPlan& plan, Simd simd, const std::function<void()>& checkpoint);
    void keep(const ViewScene& scene, const TransportSolver& solver, const Phase& phase, const Real* straight,
              const Ordinates& ordinates, Simd simd, const Rgb& colours, Field& field) const;
    void sample(const Field& field, const Vec3& at, Real (&rgb)[3]) const;
    void extrapolate(const ViewScene& scene, const TransportPlan& plan, Simd simd,
                     const std::function<void()>& checkpoint);
    void fillBorders(const TransportSolver& solver, Field& field) const;

    CellGrid m_grid;
    std::vector<ScatterTarget> m_targets;
    std::vector<int> m_classOf;  // of each volume of the scene; -1: none
    std::size_t m_classes = 0;
    std::vector<Field> m_fields;  // [target][class]
    Solved m_solved;
    std::size_t m_bytes = 0;
};

}  // namespace scrim
