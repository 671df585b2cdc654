// SPDX-License-Identifier: Apache-2.0
// Lights, as a scene states them: in world space, with colours in the working space.
#pragma once

#include <scrim/geometry/spaces.h>
#include <scrim/image/texture.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>

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

/// A light, in world space, with its colour in the working space.
struct Light {
    struct Distant {};
    struct Point {
        double radius = 0;  ///< world units; keeps 1/r^2 finite
        bool decay = true;  ///< false: the paper's lights, whose intensity is the irradiance everywhere
    };
    struct Spot : Point {
        double coneAngle = 45;  ///< full angle, degrees
        double blend = 0.15;    ///< part of the cone, from its border inwards, over which light fades
    };

    std::string name;
    std::variant<Distant, Point, Spot> kind;
    Vec3 wsPosition{0};          ///< point, spot; distant: the centre of the slide
    Vec3 wsDirection{0, 0, -1};  ///< unit; the way the light travels (distant), the axis of a cone or slide
    Vec3 wsUp{0, 1, 0};          ///< what is up on the slide; any length but 0
    /// Colour times intensity times 2^exposure. Distant, or without decay: irradiance. Otherwise radiant
    /// intensity: irradiance is intensity / max(r^2, radius^2), r in world units.
    Rgb intensity{1};
    std::optional<Slide> slide;  ///< multiplies the intensity; a projector is a point that has one
    bool shadows = true;

    bool distant() const { return std::holds_alternative<Distant>(kind); }
    const Spot* spot() const { return std::get_if<Spot>(&kind); }
    /// Of a light that is not distant: what points and spots have in common.
    const Point& point() const {
        if (const Spot* s = spot()) return *s;
        return std::get<Point>(kind);
    }
    Point& point() { return const_cast<Point&>(std::as_const(*this).point()); }
};

}  // namespace scrim
