// SPDX-License-Identifier: Apache-2.0
// Which lights share a sweep. ZC02 demands that all lights stand on one side of the viewer; here the work is
// partitioned into groups, each with its own axis and order, so that lights may stand anywhere.
#pragma once

#include <scrim/render/view_scene.h>

#include <vector>

namespace scrim {

/// A light, or the part of a light that falls into one window of directions: one light view.
struct LightPart {
    int light = 0;                   ///< index into ViewScene::lights
    std::vector<Vec3> wsDirections;  ///< unit directions of travel whose cone holds all rays that meet the volume
    std::vector<Vec3> wsWindows;     ///< axes of the windows that overlap this part's, itself included; or none
    int window = 0;                  ///< which of them is this part's
};

struct LightGroup {
    std::vector<LightPart> parts;
    bool sameSide = true;   ///< s = +1: the eye meets the same side of the sheets first as the lights
    Vec3 wsAxis{0, 0, -1};  ///< unit
    double slant = 0;       ///< largest angle of any ray of the eye or a light to the axis, radians
};

/// Half the opening of a window of a split light, and the limit beyond which a light's rays count as too wide
/// for one view; radians.
constexpr double kWindowAngle = 0.5585;  // 32 degrees
constexpr double kWidestView = 0.7854;   // 45 degrees

/// No ray may lean further than this from its sweep's axis; radians.
constexpr double kSlantLimit = 1.4835;  // 85 degrees

/// Directions (unit, away from the eye) whose cone holds the eye's rays that meet the volume.
std::vector<Vec3> eyeDirections(const ViewScene& scene, const std::vector<Vec3>& wsCorners);

/// The groups of a scene, at least one; the first is the primary one. Independent of the order of the lights.
/// Throws Error (render) where the eye's own rays are too wide for any sweep.
std::vector<LightGroup> groupLights(const ViewScene& scene, const std::vector<Vec3>& wsCorners);

}  // namespace scrim
