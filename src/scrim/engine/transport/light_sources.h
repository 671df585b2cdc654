// SPDX-License-Identifier: Apache-2.0
// The sources of a solve of the transport equation: light from lights where it scatters for the first time, emission,
// and light that enters from outside of all volumes.
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/model/plan.h>
#include <scrim/engine/transport/cell_media.h>
#include <scrim/engine/transport/solver.h>
#include <scrim/scene/view_scene.h>

#include <vector>

namespace scrim {

/// The direction of travel (unit) of light that goes from `ws` to the eye.
Vec3 travelToEye(const Camera& camera, const Vec3& ws);

/// Radiance of the target's skies and ambient light along each ordinate, for one colour: the mean over the directions
/// closest to the ordinate. Empty if there are none.
std::vector<Real> inflowOf(const ViewScene& scene, const ScatterTarget& target, const Ordinates& ordinates, int colour);

/// Fills the solver's source for colour `colour` of the target: the light that its lights, except for skies, bring to
/// each cell, and emission. Returns the part of that light which had scattered straight on before, because near a light
/// the eye sees the narrow lobe more sharply than ordinates resolve it: [class][row of the solver], radiance towards
/// the eye per unit of scattering coefficient; empty if there is none. A few points suffice for an extended light,
/// since light that scatters twice has no sharp shadows.
std::vector<std::vector<Real>> fillSource(const ViewScene& scene, const CellMedia& media,
                                          const std::vector<ScatterClass>& classes, const ScatterTarget& target,
                                          int colour, const Ordinates& ordinates, Simd simd, TransportSolver& solver);

}  // namespace scrim
