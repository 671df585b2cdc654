// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/read_sections.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/trigonometric.hpp>

namespace scrim {
namespace {

const CameraKeys& k = keysOf<CameraKeys>();

double pictureAspect(const Camera& camera) {
    return camera.pixelAspect * camera.resolution.x / camera.resolution.y;
}

/// The size of the film back in mm; the height is 0 where only the width is given.
Vec2 readAperture(const TomlValue& value, double frame) {
    const auto read = [](const TomlValue& v) {
        if (v.isNumber()) return Vec3(v.number(), 0, 0);
        const auto sides = v.items(2);
        return Vec3(sides[0].number(), sides[1].number(), 0);
    };
    const Vec3 film = value.keysOf<Vec3>(read).at(frame);
    return {film.x, film.y};
}

/// Half the picture's width at depth 1, from the focal length and the film back.
double readLens(TomlTable& table, const TomlValue& focalLength, const ReadContext& context, double aspect) {
    const double f = focalLength.numberAt(context.frame);
    const TomlValue aperture = table.require(k.aperture);
    const Vec2 film = readAperture(aperture, context.frame);
    const auto fit = table.find(k.fit);
    if (fit && film.y == 0)
        fit->fail(fmt::format("{} needs the height of the film; expected {} = [width, height]", k.fit, k.aperture));
    const double filmAspect = film.y == 0 ? aspect : film.x / film.y;
    // The order is that of the key's words.
    const bool keepsWidth[] = {true, false, aspect >= filmAspect, aspect < filmAspect};
    return keepsWidth[fit ? fit->choice() : 0] ? 0.5 * film.x / f : 0.5 * film.y / f * aspect;
}

/// Horizontal field of view in degrees, as given or from the focal length and the film back.
double readFov(TomlTable& table, const ReadContext& context, double aspect) {
    const auto focalLength = table.find(k.focalLength);
    if (!focalLength)
        if (const auto film = table.find(k.aperture)) table.require(k.focalLength);
    if (!focalLength && table.choice(k.fovAxis) == 0) return table.numberAt(context.frame, k.fov);
    double half = 0;
    if (focalLength) {
        half = readLens(table, *focalLength, context, aspect);
    } else {
        const double slope = std::tan(glm::radians(0.5 * table.numberAt(context.frame, k.fov)));
        const double widths[] = {1, aspect, aspect / std::hypot(aspect, 1.0)};  // in the order of the key's words
        half = slope * widths[table.choice(k.fovAxis)];
    }
    return glm::degrees(2 * std::atan(half));
}

/// The axes of a camera's matrix with their scale removed. Throws where they are not at right angles, or mirrored.
Mat3 rigidAxes(const TomlValue& value, const Mat4& m) {
    constexpr double kSquare = 1e-4;  // tolerance for right angles: matrices printed with five digits miss them by less
    Mat3 axes;
    for (int i = 0; i < 3; ++i) axes[i] = glm::normalize(Vec3(m[i]));
    const bool square = std::abs(glm::dot(axes[0], axes[1])) < kSquare &&
                        std::abs(glm::dot(axes[1], axes[2])) < kSquare &&
                        std::abs(glm::dot(axes[2], axes[0])) < kSquare;
    if (!square) value.fail(fmt::format("{} is sheared; expected perpendicular axes", k.matrix));
    if (glm::dot(glm::cross(axes[0], axes[1]), axes[2]) < 0)
        value.fail(
            fmt::format("{} is mirrored; expected a right-handed frame of a camera that looks along -z", k.matrix));
    // Axes that are orthonormal up to rounding are kept unchanged.
    const Mat3 given(m);
    const Mat3 product = glm::transpose(given) * given;
    double off = 0;
    for (int i = 0; i < 3; ++i) off = std::max(off, glm::length(product[i] - Mat3(1.0)[i]));
    if (off < 1e-14) return given;
    axes[0] = glm::normalize(glm::cross(axes[1], axes[2]));
    axes[1] = glm::cross(axes[2], axes[0]);
    return axes;
}

/// The camera's place and axes at the frame. Places are interpolated between keys like positions,
/// rotations along the shorter arc.
void readPose(const TomlValue& value, const ReadContext& context, Camera& camera) {
    std::vector<Mat3> axes;
    const Keyed<Vec3> places = value.keysOf<Vec3>([&](const TomlValue& item) {
        const Mat4 m = readMatrix(item);
        axes.push_back(rigidAxes(item, m));
        return Vec3(m[3]);
    });
    camera.wsPosition = places.at(context.frame);
    camera.wsFromCamera = axes.front();  // a single matrix is kept to the last bit
    if (axes.size() == 1) return;
    Keyed<double> numbers{{}, places.interpolation};
    for (std::size_t i = 0; i < places.keys.size(); ++i)
        numbers.keys.emplace_back(places.keys[i].first, static_cast<double>(i));
    const double number = numbers.at(context.frame);
    const auto i = static_cast<std::size_t>(number), next = std::min(i + 1, axes.size() - 1);
    camera.wsFromCamera = glm::mat3_cast(
        glm::slerp(glm::quat_cast(axes[i]), glm::quat_cast(axes[next]), number - static_cast<double>(i)));
}

/// Reads position, target and up, or an orbit in place of the position.
void readView(TomlTable& table, const ReadContext& context, Camera& camera) {
    const auto upValue = table.find(k.up), orbit = table.find(k.orbit);
    const Vec3 up = upValue ? readDirection(*upValue, context.frame) : Vec3(0, 1, 0);
    Vec3 wsTarget(0);
    if (orbit) {
        const Orbit o = readOrbit(*orbit, table.description(), up, true, context);
        wsTarget = o.wsCenter;
        camera.wsPosition = o.wsCenter + o.radius * o.toPlace;
    } else {
        camera.wsPosition = table.require(k.position).vec3At(context.frame);
    }
    const auto target = orbit ? table.find(k.target) : table.require(k.target);
    if (target) wsTarget = target->vec3At(context.frame);
    const Vec3 forward =
        directionBetween(camera.wsPosition, wsTarget, target ? *target : *orbit,
                         fmt::format("the camera is at the same point as its {}", k.target), context.frame);
    camera.wsFromCamera = lookAt(-forward, Vec3(0), up);
}

std::optional<Shutter> readShutter(const TomlValue& value) {
    if (value.isString()) {
        if (value.string() != "off") value.failExpecting(k.shutter.form);
        return std::nullopt;
    }
    const auto ends = value.items(2);
    const Shutter shutter{ends[0].number(), ends[1].number()};
    if (!(shutter.close > shutter.open))
        value.fail(fmt::format("{} is [{}, {}]; expected [open, close] with open < close", k.shutter, shutter.open,
                               shutter.close));
    return shutter;
}

/// The focal length in mm, as given or that of a film of 36 mm.
double focalLengthOf(TomlTable& table, double frame, const Camera& camera) {
    constexpr double kFilm = 36;
    if (const auto f = table.find(k.focalLength)) return f->numberAt(frame);
    return 0.5 * kFilm / std::tan(glm::radians(0.5 * camera.fov));
}

/// The lens; none where everything is sharp.
std::optional<Lens> readLensOf(TomlTable& table, double frame, const Camera& camera) {
    const auto fstop = table.find(k.fstop), radius = table.find(k.lensRadius), focus = table.find(k.focusDistance);
    const double unit = table.number(k.worldUnit);
    Lens lens;
    if (focus) lens.focus = focus->numberAt(frame);
    if (radius) lens.radius = radius->numberAt(frame);
    if (fstop) lens.radius = focalLengthOf(table, frame, camera) / (2 * fstop->numberAt(frame) * unit);
    if (lens.radius == 0) return std::nullopt;
    if (!focus) table.require(k.focusDistance);
    return lens;
}

Int2 readResolution(const TomlValue& value) {
    const auto sides = value.items(2);
    return {sides[0].integer(), sides[1].integer()};
}

}  // namespace

void readCamera(TomlTable table, const ReadContext& context, Scene& scene) {
    Camera& camera = scene.camera;
    for (const Key* key : {&k.near, &k.overscan}) table.read(*key, context.frame, scene);
    if (const auto shutter = table.find(k.shutter)) scene.shutter = readShutter(*shutter);
    const auto resolution = table.find(k.resolution);
    if (resolution) camera.resolution = readResolution(*resolution);
    if (const auto exr = table.find(k.exr)) {
        table.describe("[camera] of a picture");
        const FramePath path = context.path(*exr);
        scene.moves = path.hasFrame();
        scene.plate = PlateCamera{path.at(context.fileFrame()), exr->where(),
                                  static_cast<NdcRange>(table.choice(k.ndc)), !resolution};
        scene.lens = readLensOf(table, context.frame, camera);
        return table.finish();
    }
    table.read(k.type, context.frame, scene);
    const bool perspective = camera.type == CameraType::perspective;
    table.describe(fmt::format("[camera] of type '{}'", k.type.words[perspective ? 0 : 1]));
    if (const auto matrix = table.find(k.matrix))
        readPose(*matrix, context, camera);
    else
        readView(table, context, camera);
    table.read(k.pixelAspect, context.frame, scene);
    if (perspective) {
        camera.fov = readFov(table, context, pictureAspect(camera));
        scene.lens = readLensOf(table, context.frame, camera);
    } else
        table.read(k.height, context.frame, scene);
    if (const auto shift = table.find(k.shift)) camera.shift = shift->pairAt(context.frame);
    table.finish();
}

}  // namespace scrim
