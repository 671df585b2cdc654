// SPDX-License-Identifier: Apache-2.0
// Multiply scattered light: light that has scattered before it reaches a point and is scattered there towards the eye.
// The transport solver computes it as radiance in cells, which shading looks up like an environment that differs from
// place to place.
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

/// The positions of a tile's samples: ws = origin + u perU + v perV.
struct SamplePlane {
    Vec3 wsOrigin{0}, wsPerU{0}, wsPerV{0};
};

class ScatteredLight {
  public:
    /// Solves for all of the plan's targets. Slides must be loaded. `checkpoint` is called between sweeps, and throws
    /// to stop. Throws Error(memory) if there are too many cells to number.
    ScatteredLight(const ViewScene& scene, const TransportPlan& plan, Simd simd,
                   const std::function<void()>& checkpoint);

    /// The index of the field for volume `volume` of the scene and target `target` of the plan; -1: the volume scatters
    /// light only once.
    int fieldOf(int volume, std::size_t target) const;
    std::size_t targets() const { return m_targets.size(); }
    const ScatterTarget& target(std::size_t i) const { return m_targets[i]; }

    /// Radiance towards the eye per unit of scattering coefficient, which equals that of an equivalent uniform
    /// environment: kTileSize values for each colour, interpolated linearly between the centres of cells.
    void lookUp(int field, const SamplePlane& plane, const Real* u, const Real* v, Real* const rgb[3]) const;

    const Solved& solved() const { return m_solved; }
    /// Peak memory.
    std::size_t bytes() const { return m_bytes; }

  private:
    // Blocks with one cell of their neighbours around them, four values per cell.
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
    std::vector<int> m_classOf;  // class of each volume of the scene; -1: none
    std::size_t m_classes = 0;
    std::vector<Field> m_fields;  // [target][class]
    Solved m_solved;
    std::size_t m_bytes = 0;
};

}  // namespace scrim
