// SPDX-License-Identifier: Apache-2.0
// The sources of a solve of the transport equation: light from lights where it scatters for the first time, emission,
// and light that enters from outside of all volumes.
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/model/plan.h>
#include <scrim/engine/transport/cell_media.h>
#include <scrim/engine/transport/solver.h>
#include <scrim/scene/view_scene.h>

#include <utility>
#include <vector>

namespace scrim {

/// Gauss' and Legendre's four points in [0, 1] and their weights.
inline constexpr std::pair<double, double> kFourPoints[] = {{0.0694318442, 0.1739274226},
                                                            {0.3300094782, 0.3260725774},
                                                            {0.6699905218, 0.3260725774},
                                                            {0.9305681558, 0.1739274226}};

/// The direction of travel (unit) of light that goes from `ws` to the eye.
Vec3 travelToEye(const Camera& camera, const Vec3& ws);

/// Radiance of the target's skies and ambient light along each ordinate, for one colour: the mean over the directions
/// closest to the ordinate. Empty if there are none.
std::vector<Real> inflowOf(const ViewScene& scene, const ScatterTarget& target, const Ordinates& ordinates, int colour);

/// Fills the solver's source for colour `colour` of the target: the light that its lights, except for skies, bring to
/// each cell, and emission. With `once` it is the light that classes which scatter once send on, and no emission.
/// Returns the part of that light which had scattered straight on before, because near a light the eye sees the narrow
/// lobe more sharply than ordinates resolve it: [class][row of the solver], radiance towards the eye per unit of
/// scattering coefficient; empty if there is none. With `moments` it is instead the mean over all directions of that
/// light, and of it times its direction of travel along x, y and z: [moment][row]. A few points suffice for an extended
/// light, since light that scatters twice has no sharp shadows.
std::vector<std::vector<Real>> fillSource(const ViewScene& scene, const CellMedia& media,
                                          const std::vector<ScatterClass>& classes, const ScatterTarget& target,
                                          int colour, const Ordinates& ordinates, Simd simd, bool once, bool moments,
                                          TransportSolver& solver);

/// The mean of the phase function over light that comes from a cone whose axis has the cosine `toEye` to the direction
/// towards the eye: two circles by Gauss and Legendre, six directions on each. `cosine`: of the cone's half angle.
double phaseOver(const Phase& phase, double cosine, double toEye);

/// The radius of a lamp that is a sphere; 0: it is a point.
inline double radiusOfSphere(const Light& lamp) {
    return lamp.area() ? lamp.area()->radius : 0;
}

/// The way of light from a lamp to a place at distance r of its centre: of a sphere the mean over the solid angle that
/// it fills there, which is that of t = r mu - sqrt(r^2 mu^2 - h^2) for mu from h / r to 1, with h^2 = r^2 - radius^2.
double wayFrom(const Light& lamp, double r);

/// The optical depth of what is left, on the way to `ws` outside of it, of a sphere's light: of its mean over the solid
/// angle that the sphere fills there, by 24 rays through the cells.
Rgb depthFromSphere(const CellMedia& media, const Vec3& wsCenter, double radius, const Vec3& ws);

}  // namespace scrim
