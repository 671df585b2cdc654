// SPDX-License-Identifier: Apache-2.0
// Which lights share a sweep. ZC02 demands that all lights stand on one side of the viewer; here the work is
// partitioned into groups, each with its own axis and order, so that lights may stand anywhere.
#pragma once

#include <scrim/engine/model/plan.h>
#include <scrim/base/messages.h>
#include <scrim/engine/plan/sheet_stack.h>
#include <scrim/geometry/enclosing_cone.h>

#include <string>
#include <vector>

namespace scrim {

constexpr double kWidestView = 0.7854;   // 45 degrees

/// No ray may lean further than this from its sweep's axis; radians.
constexpr double kSlantLimit = 1.4835;  // 85 degrees

/// The groups that serve one part of the eye, at least one. Independent of the order of the lights. Alpha and ambient
/// are those of the group whose light stands nearest to the eye's axis; within the dial `cross_fade` several share
/// them, since another group's discretisation would show as a jump where it takes over.
///
/// A light that is perpendicular to the eye to within the dial `cross_fade` is served from both sides, in shares that
/// change smoothly with its angle: where it crosses, the axis turns by 90 degrees and the order of the sheets flips,
/// and two independent discretisations would meet in a visible jump (ZC02 section 6 admits it). `culled`: for each
/// light why it is culled, if it is; none: all take part. Throws Error (render) where the eye's own rays are too wide
/// for image-aligned sheets.
std::vector<GroupPlan> groupLights(
    const ViewScene& scene, const std::vector<Vec3>& wsCorners, const EyePart& eye,
    const std::vector<std::string>& culled = {}, const Checkpoint& checkpoint = [] {});

/// Directions whose cone around light.wsDirection holds all of a light's, and half that cone's angle in radians. A
/// light that shines all around has no directions and 180 degrees. Not of distant lights.
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
