// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/framing.h>

#include <scrim/base/error.h>
#include <scrim/scene/toml_text.h>
#include <scrim/base/parallel.h>
#include <scrim/image/blackbody.h>
#include <scrim/geometry/camera.h>
#include <scrim/scene/field_rays.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace scrim {
namespace {

constexpr double kFov = 35;           // degrees
constexpr double kAzimuth = 25;       // degrees, from the front to the right
constexpr double kElevation = 12;     // degrees above the ground
constexpr double kMargin = 0.03;      // fraction of the picture that stays free on each side
constexpr double kMedianDepth = 3.5;  // optical depth that half of the rays through the volume exceed
constexpr double kAlbedo = 0.9, kG = 0.3;
// Settings for assets with fire: smoke that lets it through, and lights dim enough that the fire shows.
constexpr double kSmokeDepth = 2, kSmokeAlbedo = 0.6, kDimmed = 0.25;
// Factor on the lights for classified volumes: surfaces reflect more light than media scatter.
constexpr double kOnSurfaces = 0.55;

// ---- the camera

/// The camera's axes in world space: right, up, back.
Mat3 wsFromCamera(const Mat3& wsFromUpright) {
    const double azimuth = glm::radians(kAzimuth), elevation = glm::radians(kElevation);
    const Vec3 back(std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                    std::cos(azimuth) * std::cos(elevation));
    return wsFromUpright * lookAt(back, Vec3(0), Vec3(0, 1, 0));
}

struct Framing {
    Vec3 wsPosition{0}, wsTarget{0};
    double size = 1;  ///< diagonal of the framed points' box, world units
};

/// Places the eye as near as possible, looking along -back, so that all points stay within the margins. A point at (x,
/// y, z) of the camera's axes is inside where |x - ex| <= s (ez - z), with the slope s of the picture's border, and
/// likewise for y. These are linear bounds on the eye (ex, ey, ez); the tighter axis decides ez.
Framing frame(const std::vector<Vec3>& wsPoints, const Mat3& axes, double aspect) {
    Bounds ws;
    for (const Vec3& p : wsPoints) ws.include(p);
    const Vec3 center = ws.center();

    const double slopeX = std::tan(glm::radians(0.5 * kFov)) * (1 - 2 * kMargin);
    const double slopes[2] = {slopeX, slopeX / aspect};
    Vec3 eye(0, 0, -std::numeric_limits<double>::infinity());
    for (int axis = 0; axis < 2; ++axis) {
        double right = -std::numeric_limits<double>::infinity(), left = -right;
        for (const Vec3& wsPoint : wsPoints) {
            const Vec3 p = (wsPoint - center) * axes;  // multiplied from the left, which maps it into the camera's axes
            right = std::max(right, p[axis] + slopes[axis] * p.z);
            left = std::min(left, p[axis] - slopes[axis] * p.z);
        }
        eye[axis] = 0.5 * (right + left);
        eye.z = std::max(eye.z, (right - left) / (2 * slopes[axis]));
    }
    Framing framing;
    framing.size = glm::length(ws.size());
    framing.wsPosition = center + axes * eye;
    framing.wsTarget = center + axes * Vec3(eye.x, eye.y, 0);
    return framing;
}

// ---- the density

/// The rays of an n x n raster over the picture.
RayFamily raysOver(const Camera& camera, int n) {
    Camera coarse = camera;
    coarse.resolution = Int2(n, n);
    coarse.pixelAspect = camera.pixelAspect * camera.resolution.x / camera.resolution.y;
    return wsRays(coarse);
}

/// The values of `measure(origin, direction)` for the rays of an n x n raster over the picture:
/// those above 0, in ascending order.
template <typename Measure>
std::vector<double> measured(const Camera& camera, int n, const Measure& measure) {
    const RayFamily rays = raysOver(camera, n);
    std::vector<double> values(std::size_t(n) * std::size_t(n));
    parallelFor(std::size_t(n), [&](std::size_t row) {
        const double y = static_cast<double>(row) + 0.5;
        for (int x = 0; x < n; ++x)
            values[row * std::size_t(n) + std::size_t(x)] =
                measure(rays.origin(x + 0.5, y), rays.direction(x + 0.5, y));
    });
    std::erase_if(values, [](double v) { return !(v > 0) || !std::isfinite(v); });
    std::sort(values.begin(), values.end());
    return values;
}

/// Drops the rays that meet next to nothing, where others meet much: they show nothing at any scale
/// at which the others can be told apart. `depths`: in ascending order.
void dropFaint(std::vector<double>& depths) {
    constexpr double kFaint = 1e-3;  // of the depth of the ray above which half of the sum lies
    const double sum = std::accumulate(depths.begin(), depths.end(), 0.0);
    double above = 0;
    auto core = depths.end();
    while (core != depths.begin() && 2 * above < sum) above += *--core;
    if (core != depths.end()) depths.erase(depths.begin(), std::lower_bound(depths.begin(), core, kFaint * *core));
}

/// Extinction per unit of the field at which the median ray has the wanted optical depth.
double densityScale(const FieldRays& field, const Camera& camera, double wantedDepth) {
    // A coarse raster may send only a few rays through a thin volume; a finer one is then tried.
    constexpr std::size_t kEnoughRays = 200;
    std::vector<double> depths;
    for (const int n : {32, 128}) {
        depths = measured(camera, n, [&](const Vec3& o, const Vec3& d) { return field.integral(o, d); });
        dropFaint(depths);
        if (depths.size() >= kEnoughRays) break;
    }
    return depths.empty() ? 1 : std::clamp(wantedDepth / depths[depths.size() / 2], 1e-30, 1e30);
}

// ---- the fire

/// The temperatures that grid values stand for, and how bright they are shown.
struct FireLook {
    std::string kelvin;  ///< key and value as the scene states them
    double scale = 1;    ///< kelvin = value * scale
    double intensity = 1;
};

/// Guesses the unit of a temperature grid: caches store values from 0 to 1, from 0 to some other small number, or
/// Kelvin. Numbers that are not Kelvin are taken as proportional to them: where a cache is half as hot, a sixteenth of
/// the light is left, so that smoke which cools shows as smoke, and the fire has no rim of its coldest red.
FireLook temperaturesOf(double hottest) {
    constexpr double kSurelyKelvin = 400, kHot = 1900;
    FireLook look;
    look.kelvin = "scale = 1";
    if (hottest > kSurelyKelvin || !(hottest > 0)) return look;
    const std::string one = tomlSignificant(kHot / hottest, 3);
    look.kelvin = fmt::format("kelvin = [0, {}]", one);
    look.scale = std::stod(one);
    return look;
}

/// Radiance of the fire, at intensity 1, along one ray, attenuated by the smoke in front of it.
double glow(const FieldRays& fire, const FieldRays& smoke, double extinction, const FireLook& look, const Bounds& ws,
            const Vec3& origin, const Vec3& direction) {
    constexpr int kSteps = 128;
    const auto [t0, t1] = ws.clip(origin, direction, 0, std::numeric_limits<double>::infinity());
    if (!(t1 > t0)) return 0;
    const double step = (t1 - t0) / kSteps, length = step * glm::length(direction);
    double radiance = 0, depth = 0;
    for (int i = 0; i < kSteps; ++i) {
        const Vec3 p = origin + (t0 + (i + 0.5) * step) * direction;
        depth += extinction * smoke.value(p) * length;
        if (const double v = fire.value(p); v > 0)
            radiance += blackbodyRadiance(v * look.scale) * std::exp(-depth) * length;
    }
    return radiance;
}

FireLook fireLook(const FramedFire& fire, const SparseField& smokeField, double extinction, const Camera& camera) {
    constexpr int kRays = 64;
    constexpr double kSeen = 0.05;  // fraction of the largest radiance above which a ray counts as burning
    // The quantile kBright of burning rays gets the radiance kRadiance.
    constexpr double kBright = 0.8, kRadiance = 1.2;
    FireLook look = temperaturesOf(fire.hottest);
    const FieldRays rays(*fire.field), smoke(smokeField);
    const Bounds ws = transformed(fire.field->wsFromIs, isOccupied(*fire.field));
    std::vector<double> glows = measured(
        camera, kRays, [&](const Vec3& o, const Vec3& d) { return glow(rays, smoke, extinction, look, ws, o, d); });
    if (glows.empty()) return look;
    const double least = kSeen * glows.back();
    glows.erase(glows.begin(), std::lower_bound(glows.begin(), glows.end(), least));
    const double bright = glows[static_cast<std::size_t>(kBright * static_cast<double>(glows.size() - 1))];
    look.intensity = std::clamp(kRadiance / bright, 1e-30, 1e30);
    return look;
}

// ---- the text

/// The text of one light. `place`: its position in the camera's axes (right, up, towards the eye).
std::string lightText(const std::string& comment, const std::string& name, const Mat3& wsFromCamera, const Vec3& place,
                      const std::string& color, double intensity) {
    return fmt::format(
        "# {}\n"
        "[[light]]\n"
        "name = \"{}\"\n"
        "type = \"distant\"\n"
        "direction = {}\n"
        "color = {}\n"
        "intensity = {}\n\n",
        comment, name, tomlRounded(wsFromCamera * -glm::normalize(place), -3), color, tomlSignificant(intensity, 3));
}

/// The text of the lights. `front`: how far the key light stands towards the viewer. Light from the
/// side shapes media, light from the front shapes surfaces.
std::string lightsText(const Mat3& wsFromCamera, double part, double front) {
    return lightText("From above, left of the camera", "key", wsFromCamera, {-0.8, 0.8, front}, "[1, 0.94, 0.85]",
                     28 * part) +
           lightText("Lightens the shadows from the other side", "fill", wsFromCamera, {0.9, 0.1, 0.55},
                     "[0.66, 0.82, 1]", 4 * part) +
           lightText("From behind: an edge against the background", "rim", wsFromCamera, {0.55, 0.5, -0.9},
                     "[0.85, 0.92, 1]", 14 * part);
}

/// The edge of a voxel in the middle of the volume, in pixels.
double pixelsPerVoxel(const SparseField& field, const Camera& camera, const Vec3& wsTarget) {
    double edge = 0;
    for (int axis = 0; axis < 3; ++axis) edge = std::max(edge, glm::length(Vec3(field.wsFromIs[axis])));
    return edge / pixelAt(camera, glm::distance(wsTarget, camera.wsPosition));
}

std::string mediumText(const FramedAsset& asset, double scale, const Camera& camera, const Vec3& wsTarget) {
    constexpr double kWide = 4;  // pixels of a voxel from which linear interpolation shows as stripes
    const bool smooth = pixelsPerVoxel(*asset.field, camera, wsTarget) > kWide;
    const std::string albedo = asset.albedoGrid.empty()
                                   ? fmt::format("[{0}, {0}, {0}]", asset.fire ? kSmokeAlbedo : kAlbedo)
                                   : fmt::format("{{ grid = {} }}", tomlString(asset.albedoGrid));
    std::string text = fmt::format(
        "[[volume]]\n"
        "name = {}\n"
        "file = {}\n"
        "density = {{ {}scale = {} }}\n"
        "{}"
        "[volume.medium]\n"
        "albedo = {}\n"
        "phase = {{ type = \"hg\", g = {g} }}\n",
        tomlString(asset.name), tomlString(asset.file),
        asset.grid.empty() ? "" : fmt::format("grid = {}, ", tomlString(asset.grid)), tomlSignificant(scale, 3),
        smooth ? "interpolation = \"smooth\"\n" : "", albedo, fmt::arg("g", kG));
    if (!asset.fire) return text;
    const FireLook look = fireLook(*asset.fire, *asset.field, scale, camera);
    return text + fmt::format("blackbody = {{ grid = {}, {}, intensity = {} }}\n", tomlString(asset.fire->grid),
                              look.kelvin, tomlSignificant(look.intensity, 3));
}

/// The points that the camera frames.
std::vector<Vec3> wsPointsOf(const FramedAsset& asset) {
    constexpr double kReach = 0.5;  // voxels by which the linear kernel reaches beyond the cells
    // Fraction of the hottest value that still glows: with about a hundredth of its light.
    constexpr float kGlows = 0.33f;
    std::vector<Vec3> wsPoints;
    const auto add = [&](const SparseField& field, float least) {
        for (const Vec3& p : isOutline(field, least, kReach)) wsPoints.push_back(transformPoint(field.wsFromIs, p));
    };
    if (!asset.field->empty()) add(*asset.field, faintValue(*asset.field));
    if (asset.fire) add(*asset.fire->field, kGlows * asset.fire->field->maxValue);
    if (wsPoints.empty())
        for (const Vec3& corner : Bounds{Vec3(-0.5), Vec3(0.5)}.corners()) wsPoints.push_back(corner);
    return wsPoints;
}

/// Refuses what no camera of a scene can stand away from far enough.
void checkReach(const FramedAsset& asset, const Framing& framing) {
    constexpr double kFarthest = 1e15;  // what a scene's positions may be
    double far = 0, edge = 0;
    for (int axis = 0; axis < 3; ++axis) {
        far = std::max({far, std::abs(framing.wsPosition[axis]), std::abs(framing.wsTarget[axis])});
        edge = std::max(edge, glm::length(Vec3(asset.field->wsFromIs[axis])));
    }
    if (far <= kFarthest) return;
    throw Error(
        ErrorKind::input,
        fmt::format("{}: has voxels of {:.3g} world units, and would be seen from {:.3g} away; expected at most "
                    "{:g}. A scene with transform = {{ scale = {:g} }} shows it",
                    asset.file, edge, far, kFarthest, std::pow(10.0, -std::ceil(std::log10(far)))));
}

}  // namespace

Mat3 wsFromUpright(const Vec3& wsUp) {
    const Vec3 right = wsUp.x != 0 ? Vec3(0, -wsUp.x, 0) : Vec3(wsUp.y < 0 ? -1 : 1, 0, 0);
    return Mat3(right, wsUp, glm::cross(right, wsUp));
}

std::string framingScene(const FramedAsset& asset, Int2 resolution) {
    Camera camera;
    camera.wsFromCamera = wsFromCamera(asset.wsFromUpright);
    camera.fov = kFov;
    camera.resolution = resolution;
    const Framing framing = frame(wsPointsOf(asset), camera.wsFromCamera, double(resolution.x) / resolution.y);
    checkReach(asset, framing);
    camera.wsPosition = framing.wsPosition;

    // Rounding to a thousandth of the framed size, or less, changes the framing by far less than the margin.
    const int exponent = static_cast<int>(std::floor(std::log10(framing.size))) - 3;
    std::string text = fmt::format(
        "# A scene for {}\n"
        "scene_version = 2\n\n"
        "[camera]\n"
        "type = \"perspective\"\n"
        "position = {}\n"
        "target = {}\n"
        "up = {}\n"
        "fov = {}\n"
        "resolution = [{}, {}]\n\n",
        tomlString(asset.file), tomlRounded(framing.wsPosition, exponent), tomlRounded(framing.wsTarget, exponent),
        tomlRounded(asset.wsFromUpright[1], 0), kFov, resolution.x, resolution.y);
    if (asset.volumeText.empty()) {
        const double depth = asset.fire ? kSmokeDepth : kMedianDepth;
        const double scale = asset.field->empty() ? 1 : densityScale(FieldRays(*asset.field), camera, depth);
        text += mediumText(asset, scale, camera, framing.wsTarget);
    } else {
        text += asset.volumeText;
    }
    const bool medium = asset.volumeText.empty();
    const double part = asset.fire ? kDimmed : medium ? 1 : kOnSurfaces;
    text += "\n" + lightsText(camera.wsFromCamera, part, medium ? 0.3 : 1);
    text += fmt::format("[ambient]\ncolor = {}\n\n", asset.fire ? "[0.02, 0.022, 0.026]" : "[0.07, 0.08, 0.1]");
    return text + "[render]\nquality = \"standard\"\n";
}

}  // namespace scrim
