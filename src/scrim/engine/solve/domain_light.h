// SPDX-License-Identifier: Apache-2.0
// Multiply scattered light of one domain (solve/scatter_domains.h).
#pragma once

#include <scrim/base/simd.h>
#include <scrim/engine/cells/cell_field.h>
#include <scrim/engine/cells/cell_media.h>
#include <scrim/engine/model/plan.h>
#include <scrim/engine/solve/border_light.h>
#include <scrim/engine/solve/last_sweep.h>
#include <scrim/engine/solve/solver.h>
#include <scrim/scene/view_scene.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace scrim {

class FirstLight;

/// What the cells keep of radiance along ordinates: what an eye sees of it after one more
/// scattering, its mean over all directions, or that and its flux.
enum class KeptLight { towardsEye, mean, meanAndFlux };

/// The parts of a target that are solved for one by one, and the colour of each solve's light, relative to its largest
/// component. Where all media are grey, a part is all light of one colour; else it is red, green or blue.
std::vector<std::pair<ScatterTarget, Rgb>> partsOf(const ViewScene& scene, const TransportPlan& plan,
                                                   const ScatterTarget& target);

/// The border of a domain: its cells, what lies around them, and what enters in each pass of the
/// solves, in their order, as the domain around it finds it.
struct DomainBorder {
    CellGrid grid;
    std::shared_ptr<const Around> around;
    std::vector<PassInflow> passes = {};

    std::size_t bytes() const;
};

class DomainLight {
  public:
    struct Settings {
        const ViewScene& scene;
        const TransportPlan& plan;
        const std::vector<ScatterClass>& classes;
        KeptLight kept;
        Simd simd;
        const std::function<void()>& checkpoint;
    };
    /// Solves for all targets. `border`: null for the domain of the whole scene. What enters `inner`, the domains
    /// inside of this one, is added to them. What is referred to need not outlive this object.
    DomainLight(const Settings& settings, const CellMedia& media, const DomainBorder* border,
                const std::vector<DomainBorder*>& inner);

    /// Extrapolates from the light of cells twice as large. `surfaces`: scattersInSurfaces.
    void improveBy(const DomainLight& twice, bool surfaces);
    /// Takes what has not scattered before out of the fields.
    void separate();
    void limitFlux();

    /// [target][class], and likewise what of it comes in from outside and has not scattered before;
    /// null: nothing, or nobody asks for it.
    const std::vector<std::shared_ptr<CellField>>& fields() const { return m_fields; }
    const std::vector<std::shared_ptr<CellField>>& unscattered() const { return m_unscattered; }
    /// Of all targets, along x, y and z; null unless it is kept.
    const std::array<std::shared_ptr<CellField>, 3>& flux() const { return m_flux; }

    const Solved& solved() const { return m_solved; }
    /// Memory of the fields, and the peak of all that is gone.
    std::size_t bytes() const;
    std::size_t peak() const { return m_peak; }

  private:
    enum { full = 1, once = 2 };
    struct Passes;
    void solve(const Settings& settings, const CellMedia& media, const DomainBorder* border,
               const std::vector<DomainBorder*>& inner);
    void solvePart(const Settings& settings, const CellMedia& media, Passes& passes, const FirstLight& first,
                   std::size_t t, const ScatterTarget& target, const Rgb& colours);
    void keep(const std::vector<ScatterClass>& classes, const TransportSolver& solver,
              const std::vector<std::vector<Real>>& kept, const std::vector<std::vector<Real>>& straight, int which,
              const Rgb& colours, const std::shared_ptr<CellField>* fields) const;
    void keepFlux(const TransportSolver& solver, const std::vector<std::vector<Real>>& kept,
                  const std::vector<std::vector<Real>>& straight, const Rgb& colours);
    std::vector<std::uint8_t> fillAround(const TransportSolver& solver, CellField& field) const;
    void fillBorders(const TransportSolver& solver, CellField& field) const;

    KeptLight m_kept;
    std::shared_ptr<const CellGrid> m_grid;
    std::size_t m_classes;
    int m_rings;  // of cells around those with a row, that kernels reach
    std::vector<std::shared_ptr<CellField>> m_fields, m_unscattered;
    std::array<std::shared_ptr<CellField>, 3> m_flux;
    Solved m_solved;
    std::size_t m_peak = 0;
};

}  // namespace scrim
