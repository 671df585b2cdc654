// SPDX-License-Identifier: Apache-2.0
// Lights, as a scene states them: in world space, with colours in the working space.
#pragma once

#include <scrim/geometry/spaces.h>

#include <string>

namespace scrim {

enum class LightType { distant, point, spot };

struct Light {
    std::string name;
    LightType type = LightType::distant;
    Vec3 wsDirection{0, 0, -1};  ///< unit; the way the light travels (distant), the cone's axis (spot)
    Vec3 wsPosition{0};          ///< point, spot
    /// Colour times intensity times 2^exposure. Distant, or without decay: irradiance. Otherwise radiant
    /// intensity: irradiance is intensity / max(r^2, radius^2), r in world units.
    Rgb intensity{1};
    double radius = 0;      ///< world units; keeps 1/r^2 finite
    bool decay = true;      ///< false: the paper's lights, whose intensity is the irradiance everywhere
    double coneAngle = 45;  ///< spot: full angle, degrees
    double blend = 0.15;    ///< spot: part of the cone, from its border inwards, over which light fades
    bool shadows = true;
};

}  // namespace scrim
