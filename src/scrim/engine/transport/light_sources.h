// SPDX-License-Identifier: Apache-2.0
// What a solve of the transport equation begins with: light of lights where it scatters for the first time, what glows,
// and what shines in from beyond all volumes.
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/model/plan.h>
#include <scrim/engine/transport/cell_media.h>
#include <scrim/engine/transport/solver.h>
#include <scrim/scene/view_scene.h>

#include <vector>

namespace scrim {

/// The way that light travels which reaches the eye from `ws`, unit.
Vec3 travelToEye(const Camera& camera, const Vec3& ws);

/// Radiance of the target's skies and ambient light along each ordinate, of one colour: the mean over the directions
/// that are nearest to it. Empty where there are none.
std::vector<Real> inflowOf(const ViewScene& scene, const ScatterTarget& target, const Ordinates& ordinates, int colour);

/// Light of lights that scattered straight on, in which the eye sees more of a narrow lobe than ordinates know of:
/// [class][row of the solver], radiance towards the eye per unit of scattering coefficient. Empty where none does.
using StraightLight = std::vector<std::vector<Real>>;

/// The solver's source for colour `colour` of the target: what its lights, skies not among them, bring to each cell,
/// and what glows; returns what of it scattered straight on before. Of an extended light a few points are enough: what
/// scatters twice has lost its edges.
StraightLight fillSource(const ViewScene& scene, const CellMedia& media, const std::vector<ScatterClass>& classes,
                         const ScatterTarget& target, int colour, const Ordinates& ordinates, Simd simd,
                         TransportSolver& solver);

}  // namespace scrim
