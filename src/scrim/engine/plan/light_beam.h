// SPDX-License-Identifier: Apache-2.0
// What a light shines into by itself: the cone of a spot, the picture of a slide.
#pragma once

#include <scrim/geometry/enclosing_cone.h>
#include <scrim/scene/light.h>

#include <vector>

namespace scrim {

/// Directions whose cone around light.wsDirection holds all of a light's, and half that cone's angle in radians. A light
/// that shines all around has no directions and 180 degrees. Not of distant lights.
struct Beam {
    std::vector<Vec3> directions;
    double angle = 0;
};
Beam beamOf(const Light& light);

/// Directions around the rim of a cone of half angle `angle`: their enclosing cone is that cone.
std::vector<Vec3> rimOfCone(const Vec3& axis, double angle);

/// The cone of directions from a point to the corners, which are added to `directions`; wider than 90 degrees (cosAngle
/// <= 0) where the point stands among them.
Cone coneToCorners(const Vec3& wsPoint, const std::vector<Vec3>& corners, std::vector<Vec3>& directions);

/// Does the beam pass by all that lies in `cone`, seen from the light?
bool passesBy(const Light& light, const Beam& beam, const Cone& cone);

}  // namespace scrim
