// SPDX-License-Identifier: Apache-2.0
// Decides which lights share a sweep. ZC02 demands that all lights are on one side of the viewer. Here the work is
// divided into groups, each with its own axis and order, so that lights may be anywhere.
#pragma once

#include <scrim/engine/model/plan.h>
#include <scrim/base/messages.h>
#include <scrim/engine/plan/sheet_stack.h>
#include <scrim/geometry/enclosing_cone.h>

#include <string>
#include <vector>

namespace scrim {

constexpr double kWidestView = 0.7854;  // 45 degrees; rays that open wider than this need several views

/// The largest angle of any ray to its sweep's axis, radians.
constexpr double kSlantLimit = 1.4835;  // 85 degrees

/// The groups of `lights` that serve one part of the eye; at least one. They do not depend on the order of the lights.
/// Alpha and ambient light belong to the group whose light is closest to the eye's axis. Within the dial `cross_fade`
/// several groups share them, since another group's discretisation would show as a jump when it takes over.
///
/// A light that is perpendicular to the eye within the dial `cross_fade` is served from both sides, with shares that
/// change smoothly with its angle. Where it crosses, the axis turns by 90 degrees and the order of the sheets flips,
/// and two independent discretisations would meet in a visible jump (ZC02 section 6 admits it). `culled`: for each
/// light the reason why it is culled, if it is; empty: no light is. Throws Error (render) if the eye's own rays are too
/// wide for image-aligned sheets.
std::vector<GroupPlan> groupLights(
    const ViewScene& scene, const SubLights& lights, const std::vector<Vec3>& wsCorners, const EyePart& eye,
    const std::vector<std::string>& culled = {}, const Checkpoint& checkpoint = [] {});

/// Directions whose cone around light.wsDirection contains all of a light's rays, and half that
/// cone's angle in radians. For a light that shines all around there are no directions, and the
/// angle is 180 degrees. Not for distant lights.
struct Beam {
    std::vector<Vec3> directions;
    double angle = 0;
};
Beam beamOf(const Light& light);

/// Directions around the rim of a cone of half angle `angle` (radians), whose enclosing cone is that cone.
std::vector<Vec3> rimOfCone(const Vec3& axis, double angle);

/// The cone of directions from a point to the corners; these directions are added to `directions`.
/// The cone is wider than 90 degrees (cosAngle <= 0) if the point lies among the corners.
Cone coneToCorners(const Vec3& wsPoint, const std::vector<Vec3>& corners, std::vector<Vec3>& directions);

/// True if the beam misses everything in `cone`, as seen from the light.
bool passesBy(const Light& light, const Beam& beam, const Cone& cone);

/// A camera that sees all volumes along the most important light, so that sheets are perpendicular
/// to it: for light that no picture shows.
Camera cameraAlongLight(const ViewScene& scene);

}  // namespace scrim
