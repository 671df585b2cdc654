// SPDX-License-Identifier: Apache-2.0
// Lights as a scene states them: in world space, with colours in the working space.
#pragma once

#include <scrim/geometry/bounds.h>
#include <scrim/geometry/spaces.h>
#include <scrim/image/texture.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>

namespace scrim {

class LightProfile;
struct ClearSky;
struct SkyParts;
struct TriangleMesh;

/// What the slide lets through beyond the picture's border.
enum class SlideOutside { black, clamp, repeat };

/// The slide of a projective textured light (ZC02 section 5): a picture that the light shines through.
struct Slide {
    std::string file;        ///< the path at this frame
    std::string colorspace;  ///< colour space of the file; "": as readTexture chooses
    std::string where;       ///< where the scene says `file`: "scene.toml:12:18"
    double fov = 30;         ///< horizontal field of view, degrees; distant lights have none
    double width = 1;        ///< distant lights: width of the picture, world units
    /// Distant lights: height of the picture, world units; 0: from `width` and the picture's aspect.
    double height = 0;
    double roll = 0;  ///< degrees, clockwise for a viewer who stands at the light and looks along it
    SlideOutside outside = SlideOutside::black;
    std::shared_ptr<const Texture> image;  ///< null until it is loaded
    bool split = true;                     ///< domes: suns in the picture become lights of their own
    /// Domes: the picture's suns and the rest (`image/sky_parts.h`), found where it is loaded; null: it is whole.
    std::shared_ptr<const SkyParts> parts = {};
    /// Domes: the sky whose picture `image` and `parts` become where they are loaded; there is no file then.
    std::shared_ptr<const ClearSky> sky = {};

    bool operator==(const Slide&) const = default;
};

/// The luminaire around a point or spot light: how its intensity depends on the direction.
struct Luminaire {
    std::string file;                                  ///< the path of a photometric file (IES LM-63) at this frame
    std::string where;                                 ///< where the scene says `ies`
    std::shared_ptr<const LightProfile> profile = {};  ///< null until it is loaded

    bool operator==(const Luminaire&) const = default;
};

enum class AreaShape { rectangle, disk, sphere, cylinder, mesh };

/// How a surface's radiance depends on the direction, if a grid in front of it holds back what
/// leaves it aslant: at an angle t to the normal it has the factor (tan a - tan t) / (tan a - a), a
/// half of the spread. The power stays the same (Cycles' definition).
class Spread {
  public:
    /// The full angle in degrees; 180: Lambert.
    explicit Spread(double degrees);
    bool any() const { return m_scale > 0; }
    double tangent() const { return m_tangent; }
    double scale() const { return m_scale; }
    /// The factor where the direction has this cosine to the normal.
    double at(double cosine) const;

  private:
    double m_tangent = 0, m_scale = 0;
};

/// Where the attenuation of a light is kept: in shadow buffers (ZC02), which resolve sharp shadows, or on cells, which
/// are cheaper for light from many directions or from within the volumes (engine/passes/light_cells.h).
enum class ShadowMethod { automatic, buffers, cells };

/// A light, in world space, with its colour in the working space.
struct Light {
    struct Distant {
        Distant() {}
        explicit Distant(double degrees) : angle(degrees) {}
        /// Full angle of the sun's disk, degrees; the irradiance is spread evenly over its solid angle.
        double angle{};
        bool operator==(const Distant&) const = default;
    };
    struct Point {
        double radius = 0;  ///< world units; irradiance grows no further within it, which keeps 1/r^2 finite
        bool decay = true;  ///< false: irradiance equals the intensity at any distance, as for the paper's lights
        bool operator==(const Point&) const = default;
    };
    struct Spot : Point {
        double coneAngle = 45;  ///< full angle, degrees
        double blend = 0.15;    ///< fraction of the cone, from its border inwards, over which the light fades
        bool operator==(const Spot&) const = default;
    };
    /// A small piece of a surface whose normal is wsDirection. Its radiant intensity is multiplied
    /// by the cosine to the normal; it sends nothing backwards.
    struct Element : Point {
        double spread = 180;  ///< full angle, degrees (see Spread)
        bool operator==(const Element&) const = default;
    };
    /// A surface around wsPosition that emits the same radiance in all directions (Lambert). Rectangles and disks emit
    /// only to the side that wsDirection points to, spheres, cylinders and closed meshes outwards, and open meshes to
    /// the side from which the corners of their triangles are counterclockwise. The slide of a rectangle is the picture
    /// on it (see pictureOfRectangle).
    struct Area {
        AreaShape shape = AreaShape::rectangle;
        double width = 1, height = 1;  ///< rectangle: edges across wsUp and along it; cylinder: its length (width)
        double radius = 0.5;           ///< disk, sphere and cylinder: world units
        double spread = 180;           ///< rectangle and disk: full angle, degrees (see Spread)
        std::string mesh = {};         ///< mesh: the name of the scene's mesh that shines
        bool normalize = false;        ///< mesh: shineFrom divides the intensity by the area
        std::shared_ptr<const TriangleMesh> surface = {};  ///< mesh: in world space; null until shineFrom
        double surfaceArea = 0;                            ///< mesh: that of `surface`
        Bounds wsSurface = {};                             ///< mesh: those of `surface`
        /// Area of the emitting surface, world units squared: w h, pi r^2, 4 pi r^2, without the
        /// ends 2 pi r w, or the sum of the triangles'.
        double area() const;
        bool operator==(const Area&) const = default;
    };
    /// The sky, infinitely far away. Its slide is a lat-long picture (see domeDirection).
    struct Dome {
        double rotation = 0;  ///< turn about wsUp, degrees
        bool operator==(const Dome&) const = default;
    };

    std::string name;
    std::string group;  ///< lights of one group share a layer, which has its name; "": the light has its own
    std::variant<Distant, Point, Spot, Element, Area, Dome> kind;
    Vec3 wsPosition{0};  ///< point and spot: the place; area: the centre; distant: the centre of the slide
    /// Unit; distant: direction of travel; else the axis of a cone, slide or luminaire, or the normal.
    Vec3 wsDirection{0, 0, -1};
    Vec3 wsUp{0, 1, 0};  ///< the up direction of a slide, luminaire, rectangle or sky; any length but 0
    /// Colour * intensity * 2^exposure. It is irradiance for distant lights and lights without
    /// decay, radiance for area lights and domes, and radiant intensity for all others: their
    /// irradiance is intensity / max(r^2, radius^2), r in world units.
    Rgb intensity{1};
    int samples = 0;  ///< sub-lights that represent an extended light; 0: as many as the dial light_error asks for
    std::optional<Slide> slide;          ///< multiplies the intensity; a projector is a point light with a slide
    std::optional<Luminaire> luminaire;  ///< points and spots: multiplies the intensity by 0 to 1
    bool shadows = true;
    bool visible = false;  ///< the camera sees it: of domes the sky behind the volumes, of area lights their surface
    ShadowMethod shadow = ShadowMethod::automatic;

    bool distant() const { return std::holds_alternative<Distant>(kind); }
    const Spot* spot() const { return std::get_if<Spot>(&kind); }
    const Element* element() const { return std::get_if<Element>(&kind); }
    const Area* area() const { return std::get_if<Area>(&kind); }
    const Dome* dome() const { return std::get_if<Dome>(&kind); }
    bool operator==(const Light&) const = default;
    /// True if the light shines from more than one point or direction. The engine represents such a
    /// light by several sub-lights.
    bool extended() const {
        const Distant* sun = std::get_if<Distant>(&kind);
        return area() || dome() || (sun && sun->angle > 0);
    }
    /// The members that points, spots and elements share. Only for these three kinds.
    const Point& point() const {
        if (const Spot* s = spot()) return *s;
        if (const Element* e = element()) return *e;
        return std::get<Point>(kind);
    }
    Point& point() { return const_cast<Point&>(std::as_const(*this).point()); }
};

/// The right, up and normal axes of an area light, a dome or a luminaire, in world space, as
/// orthonormal columns. The normal lies along light.wsDirection, and up is as near to light.wsUp as
/// possible. Right is on the right of a viewer whom the light shines at.
Mat3 lightFrame(const Light& light);

/// Makes a light whose shape is a mesh shine from `mesh`, which `wsFromMesh` places.
void shineFrom(Light& light, const TriangleMesh& mesh, const Mat4& wsFromMesh);

/// The factor of the light's luminaire, from 0 to 1, on light that travels along `wsTravel` (unit);
/// 1 without one, or before it is loaded. `frame`: that of the light.
double luminairePart(const Light& light, const Mat3& frame, const Vec3& wsTravel);

/// The point on a rectangle, world space, that shows (u, v) of its picture. A viewer whom the light shines at sees (0,
/// 0) at the top left corner and (1, 1) at the bottom right one, as on a screen.
Vec3 pictureOfRectangle(const Light& light, double u, double v);

/// The direction (unit, towards the sky) that shows (u, v) of a dome's picture; u runs from its left border in [0, 1),
/// v from its top. The mapping is UsdLux' lat-long: with up = [0, 1, 0] and no rotation the middle of the picture is
/// +z, a quarter to the right of it is -x, and the top is +y. `rotation` turns the sky about up, from +z towards +x.
Vec3 domeDirection(const Light& light, double u, double v);
/// The place (u, v) in a dome's picture, both in [0, 1], that shows this direction (unit, towards the sky).
Vec2 pictureOfDome(const Light& light, const Vec3& direction);

}  // namespace scrim
