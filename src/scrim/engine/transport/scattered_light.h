// SPDX-License-Identifier: Apache-2.0
// Multiply scattered light: light that has scattered before it reaches a point and is scattered there towards the eye.
// The transport solver computes it as radiance in cells, which shading looks up like an environment that differs from
// place to place.
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/model/plan.h>
#include <scrim/engine/transport/cell_field.h>
#include <scrim/engine/transport/solver.h>
#include <scrim/scene/view_scene.h>

#include <functional>
#include <memory>
#include <vector>

namespace scrim {

class ScatteredLight {
  public:
    /// Solves for all of the plan's targets. Slides must be loaded. `checkpoint` is called between sweeps, and throws
    /// to stop. Throws Error(memory) if there are too many cells to number.
    ScatteredLight(const ViewScene& scene, const TransportPlan& plan, Simd simd,
                   const std::function<void()>& checkpoint);

    /// One for each target of the plan; volumes that scatter light only once have none of it.
    std::vector<CellLight> lights() const;

    const Solved& solved() const { return m_solved; }
    /// Peak memory.
    std::size_t bytes() const { return m_bytes; }

  private:
    void solve(const ViewScene& scene, const CellMedia& media, const std::vector<ScatterClass>& classes,
               const TransportPlan& plan, Simd simd, const std::function<void()>& checkpoint);
    void keep(const ViewScene& scene, const TransportSolver& solver, const Phase& phase, const Real* straight,
              const Ordinates& ordinates, Simd simd, const Rgb& colours, CellField& field) const;
    void extrapolate(const ViewScene& scene, const TransportPlan& plan, Simd simd,
                     const std::function<void()>& checkpoint);
    void fillBorders(const TransportSolver& solver, CellField& field) const;

    std::shared_ptr<const CellGrid> m_grid;
    std::vector<ScatterTarget> m_targets;
    std::vector<int> m_classOf;  // class of each volume of the scene; -1: none
    std::size_t m_classes = 0;
    std::vector<std::shared_ptr<CellField>> m_fields;  // [target][class]
    Solved m_solved;
    std::size_t m_bytes = 0;
};

}  // namespace scrim
