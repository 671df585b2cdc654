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

enum class AreaShape { rectangle, disk, sphere };

/// A light, in world space, with its colour in the working space.
struct Light {
    struct Distant {
        Distant() {}
        explicit Distant(double degrees) : angle(degrees) {}
        double angle{};  ///< of the sun's disk, full, degrees; irradiance is spread evenly over its solid angle
    };
    struct Point {
        double radius = 0;  ///< world units; keeps 1/r^2 finite
        bool decay = true;  ///< false: the paper's lights, whose intensity is the irradiance everywhere
    };
    struct Spot : Point {
        double coneAngle = 45;  ///< full angle, degrees
        double blend = 0.15;    ///< part of the cone, from its border inwards, over which light fades
    };
    /// A small piece of a surface, around wsDirection: radiant intensity times the cosine to it, and nothing behind.
    struct Element : Point {};
    /// A surface around wsPosition that shines evenly into all directions (Lambert). Rectangle and disk shine to the
    /// side of wsDirection alone, a sphere outwards. A slide is a rectangle's picture (see pictureOfRectangle).
    struct Area {
        AreaShape shape = AreaShape::rectangle;
        double width = 1, height = 1;  ///< rectangle: world units, across wsUp and along it
        double radius = 0.5;           ///< disk and sphere: world units
        /// Of the surface that shines: w h, pi r^2 or 4 pi r^2, world units squared.
        double area() const;
    };
    /// The sky, infinitely far away. A slide is its picture, lat-long (see domeDirection).
    struct Dome {
        double rotation = 0;  ///< degrees, about wsUp
    };

    std::string name;
    std::variant<Distant, Point, Spot, Element, Area, Dome> kind;
    Vec3 wsPosition{0};          ///< point, spot; area: its centre; distant: the centre of the slide
    Vec3 wsDirection{0, 0, -1};  ///< unit; the way the light travels (distant), the axis of a cone or slide, the normal
    Vec3 wsUp{0, 1, 0};          ///< what is up on the slide, rectangle or sky; any length but 0
    /// Colour times intensity times 2^exposure. Distant, or without decay: irradiance. Area and dome: radiance.
    /// Otherwise radiant intensity: irradiance is intensity / max(r^2, radius^2), r in world units.
    Rgb intensity{1};
    int samples = 0;  ///< sub-lights that stand for an extended light; 0: as many as the dial light_error asks for
    std::optional<Slide> slide;  ///< multiplies the intensity; a projector is a point that has one
    bool shadows = true;

    bool distant() const { return std::holds_alternative<Distant>(kind); }
    const Spot* spot() const { return std::get_if<Spot>(&kind); }
    const Element* element() const { return std::get_if<Element>(&kind); }
    const Area* area() const { return std::get_if<Area>(&kind); }
    const Dome* dome() const { return std::get_if<Dome>(&kind); }
    /// Does it shine from more than one point or direction? The engine lets several lights stand for it.
    bool extended() const {
        const Distant* sun = std::get_if<Distant>(&kind);
        return area() || dome() || (sun && sun->angle > 0);
    }
    /// Of a light that shines from a point: what points, spots and elements have in common.
    const Point& point() const {
        if (const Spot* s = spot()) return *s;
        if (const Element* e = element()) return *e;
        return std::get<Point>(kind);
    }
    Point& point() { return const_cast<Point&>(std::as_const(*this).point()); }
};

/// Right, up and normal of a surface or of directions around light.wsDirection, as columns: orthonormal, and up is as
/// near to light.wsUp as can be. Right is that of a viewer whom the light shines at.
Mat3 lightFrame(const Light& light);

/// Where on a rectangle (u, v) of its picture lies: (0, 0) is the top left corner and (1, 1) the bottom right one for a
/// viewer whom the light shines at, as on a screen.
Vec3 pictureOfRectangle(const Light& light, double u, double v);

/// The direction (unit, towards the sky) of (u, v) of a dome's picture, u from its left border in [0, 1) and v from its
/// top: UsdLux' lat-long. With up = [0, 1, 0] and no rotation the middle of the picture is +z, a quarter to the right
/// of it is -x, the top is +y. `rotation` turns the sky about up, from +z towards +x.
Vec3 domeDirection(const Light& light, double u, double v);

}  // namespace scrim
