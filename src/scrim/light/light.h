// SPDX-License-Identifier: Apache-2.0
// Lights, as a scene states them: in world space, with colours in the working space.
#pragma once

#include <scrim/geometry/spaces.h>
#include <scrim/light/slide.h>

#include <optional>
#include <string>

namespace scrim {

enum class LightType { distant, point, spot, projector };

struct Light {
    std::string name;
    LightType type = LightType::distant;
    Vec3 wsDirection{0, 0, -1};  ///< unit; the way the light travels (distant), the axis of a cone or slide
    Vec3 wsPosition{0};          ///< point, spot, projector; distant: the centre of the slide
    Vec3 wsUp{0, 1, 0};          ///< what is up on the slide; any length but 0
    /// Colour times intensity times 2^exposure. Distant, or without decay: irradiance. Otherwise radiant
    /// intensity: irradiance is intensity / max(r^2, radius^2), r in world units.
    Rgb intensity{1};
    double radius = 0;           ///< world units; keeps 1/r^2 finite
    bool decay = true;           ///< false: the paper's lights, whose intensity is the irradiance everywhere
    double coneAngle = 45;       ///< spot: full angle, degrees
    double blend = 0.15;         ///< spot: part of the cone, from its border inwards, over which light fades
    std::optional<Slide> slide;  ///< multiplies the intensity; a projector always has one
    bool shadows = true;
};

}  // namespace scrim
