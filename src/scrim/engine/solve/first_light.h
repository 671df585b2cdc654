// SPDX-License-Identifier: Apache-2.0
// The sources of a solve of the transport equation: light from lights where it scatters for the
// first time, emission, and light that enters from outside of all volumes.
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/model/plan.h>
#include <scrim/engine/cells/cell_media.h>
#include <scrim/engine/cells/ordinates.h>
#include <scrim/engine/solve/border_light.h>
#include <scrim/engine/solve/solver.h>
#include <scrim/scene/view_scene.h>

#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

namespace scrim {

/// Radiance of the target's skies and ambient light along each ordinate, for one colour: the mean
/// over the directions closest to the ordinate. Empty if there are none.
std::vector<Real> inflowOf(const ViewScene& scene, const ScatterTarget& target, const Ordinates& ordinates, int colour);

/// Light from a target's lights, except for skies, where it scatters for the first time, and emission, in one colour.
/// An extended light counts as a few points, because light that scatters twice has no sharp shadows.
class FirstLight {
  public:
    /// The cells of a solve.
    struct Cells {
        const CellMedia& media;
        const CellMedia& last;                     ///< with phase functions split for the last sweep
        const std::vector<ScatterClass>& classes;  ///< likewise
        bool moments;                              ///< what the last sweep keeps: see straight()
        const Around* around = nullptr;            ///< what lies around the cells; null: nothing
    };
    /// `solver` must outlive this object.
    FirstLight(const ViewScene& scene, const ScatterTarget& target, int colour, const Cells& cells,
               const TransportSolver& solver);
    /// Becomes the same light in another colour where that is a factor. Otherwise it does not change, and returns
    /// false: where media attenuate colours differently, a light has a picture or none of its present colour, lights of
    /// several colours go straight on together, or walls send some back. `media`, `last`: as in Cells.
    bool turnTo(int colour, const CellMedia& media, const CellMedia& last);
    /// The same light where classes that scatter once send it on, without emission.
    FirstLight ofOnce() const;

    /// Adds it to a source as TransportSolver::source has it, along ordinates. `classes` and `media` belong to these.
    void addTo(const Ordinates& along, const std::vector<ScatterClass>& classes, const CellMedia& media, Simd simd,
               std::vector<Real>& source) const;
    /// Light that had scattered straight on before and now scatters, because near a light the eye sees the narrow lobe
    /// more sharply than ordinates resolve it: [class][row of the solver], radiance towards the eye per unit of
    /// scattering coefficient; empty if there is none. With `moments` it is instead the mean over all directions of
    /// that light, and of it times its direction of travel along x, y and z: [moment][row].
    const std::vector<std::vector<Real>>& straight() const { return m_straight; }
    std::size_t bytes() const;
    /// The number of points that the lights of a target become, each of which takes a value for every row.
    static std::size_t points(const ViewScene& scene, const ScatterTarget& target);

  private:
    // Light that arrives at a place after it scattered straight on, in a depth of such scattering.
    struct Straight {
        Vec3 travel;
        double irradiance, depth;
        Vec3 ws;
    };
    void addStraight(const ViewScene& scene, const Cells& cells, std::size_t owner, const Straight& light,
                     std::size_t row);

    int m_colour;
    bool m_once = false, m_emission;
    const TransportSolver& m_solver;
    std::vector<std::pair<std::size_t, Light>> m_points;  // indices of lights in the scene, and points of them
    std::vector<std::vector<Real>> m_irradiance;          // [point][row], as the solve's media attenuate it
    // Light that arrives near lamps, where m_irradiance has 0: [point] rows, its directions of travel, and irradiance.
    std::vector<std::vector<std::tuple<std::int32_t, Vec3, Real>>> m_near;
    std::vector<std::vector<Real>> m_straight;
    std::vector<Real> m_onSides;  // of walls: the radiance that they send back
};

}  // namespace scrim
