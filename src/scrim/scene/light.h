// SPDX-License-Identifier: Apache-2.0
// Lights, as a scene states them: in world space, with colours in the working space.
#pragma once

#include <scrim/geometry/spaces.h>
#include <scrim/image/texture.h>

#include <memory>
#include <optional>
#include <string>

namespace scrim {

/// What the light is like beyond the picture's border.
enum class SlideOutside { black, clamp, repeat };

/// The slide of a projective textured light (ZC02 section 5): a picture that the light shines through.
struct Slide {
    std::string file;        ///< at this frame
    std::string colorspace;  ///< of the file; "": as readTexture chooses
    std::string where;       ///< of `file` in the scene: "scene.toml:12:18"
    double fov = 30;         ///< horizontal field of view, degrees; not of distant lights
    double width = 1;        ///< distant lights: world units across the picture
    double height = 0;       ///< distant lights: world units; 0: from `width` and the picture's aspect
    double roll = 0;         ///< degrees, clockwise for a viewer who stands at the light and looks along it
    SlideOutside outside = SlideOutside::black;
    std::shared_ptr<const Texture> image;  ///< null until it is loaded
};

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
