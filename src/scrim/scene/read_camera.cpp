// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/read_sections.h>

#include <cmath>

#include <glm/trigonometric.hpp>

namespace scrim {
namespace {

/// What OpenEXR viewers and our rasters (antialiased 16 x 16) can count.
constexpr int kMostPixels = 65536;

/// Horizontal field of view in degrees: given, or from a lens and its film.
double readFov(TomlTable& table, const ReadContext& context, double fallback) {
    const auto fov = table.find("fov"), focalLength = table.find("focal_length"), aperture = table.find("aperture");
    if (fov && (focalLength || aperture))
        (focalLength ? *focalLength : *aperture)
            .fail("[camera] has both 'fov' and a lens; expected 'fov', or 'focal_length' and 'aperture'");
    if (!focalLength && !aperture)
        return fov ? fov->numberAt(context.frame, Range::between(0, 180, "degrees")) : fallback;
    const Range range{0, 1e6, true, false, "mm"};
    const double f = table.require("focal_length", "the focal length in mm").numberAt(context.frame, range);
    const double width = table.require("aperture", "the film's horizontal width in mm").numberAt(context.frame, range);
    return glm::degrees(2 * std::atan(0.5 * width / f));
}

}  // namespace

CameraSection readCamera(TomlTable table, const ReadContext& context) {
    CameraSection out;
    Camera& camera = out.camera;
    const bool perspective = table.choice("type", {"perspective", "orthographic"}, 0) == 0;
    camera.type = perspective ? CameraType::perspective : CameraType::orthographic;
    table.describe(perspective ? "[camera] of type 'perspective'" : "[camera] of type 'orthographic'");

    const char* const kPoint = "a point [x, y, z]";
    camera.wsPosition = table.require("position", kPoint).vec3At(context.frame, Range::coordinate());
    const TomlValue target = table.require("target", kPoint);
    const Vec3 wsTarget = target.vec3At(context.frame, Range::coordinate());
    const Vec3 forward =
        directionBetween(camera.wsPosition, wsTarget, target, "the camera stands at its own 'target'", context.frame);
    const auto up = table.find("up");
    camera.wsFromCamera = lookAt(-forward, Vec3(0), up ? readDirection(*up, context.frame) : Vec3(0, 1, 0));

    if (perspective)
        camera.fov = readFov(table, context, camera.fov);
    else
        camera.height = table.require("height", "the picture's height in world units")
                            .numberAt(context.frame, Range::positiveLength());
    camera.near = table.numberAt(context.frame, "near", camera.near, Range::length());
    if (const auto resolution = table.find("resolution")) {
        const auto sides = resolution->items(2, "[width, height] in pixels");
        camera.resolution = {sides[0].integer(1, kMostPixels, "pixels"), sides[1].integer(1, kMostPixels, "pixels")};
    }
    camera.pixelAspect = table.numberAt(context.frame, "pixel_aspect", 1, Range::fromTo(0.01, 100));
    out.overscan = table.integer("overscan", 0, 0, kMostPixels, "pixels");
    table.finish();
    return out;
}

}  // namespace scrim
