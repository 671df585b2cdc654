// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/framing.h>

#include <scrim/scene/toml_text.h>
#include <scrim/base/parallel.h>
#include <scrim/geometry/camera.h>
#include <scrim/scene/field_rays.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace scrim {
namespace {

constexpr double kFov = 35;           // degrees
constexpr double kAzimuth = 25;       // degrees, from the front (+z) to the right (+x)
constexpr double kElevation = 12;     // degrees above the ground
constexpr double kMargin = 0.05;      // part of the picture that stays free on each side
constexpr double kMedianDepth = 3.5;  // optical depth that half of the rays through the volume exceed
constexpr double kAlbedo = 0.9, kG = 0.3;

// ---- numbers that read well

/// `v` rounded to a multiple of 10^exponent, as a number of TOML.
std::string rounded(double v, int exponent) {
    if (v == 0) return "0";
    const int digits = static_cast<int>(std::floor(std::log10(std::abs(v)))) - exponent + 1;
    if (digits < 0 || (digits == 0 && std::abs(v) < 0.5 * std::pow(10.0, exponent))) return "0";
    const bool plain = exponent >= -9 && std::abs(v) < 1e12;
    if (!plain) return fmt::format("{:.{}e}", v, std::clamp(digits - 1, 0, 16));
    if (exponent >= 0)
        return fmt::format("{:.0f}", std::round(v / std::pow(10.0, exponent)) * std::pow(10.0, exponent));
    std::string text = fmt::format("{:.{}f}", v, -exponent);
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
    return text == "-0" ? "0" : text;
}

std::string rounded(const Vec3& v, int exponent) {
    return fmt::format("[{}, {}, {}]", rounded(v.x, exponent), rounded(v.y, exponent), rounded(v.z, exponent));
}

/// `v` with so many significant digits.
std::string significant(double v, int digits) {
    return v == 0 ? "0" : rounded(v, static_cast<int>(std::floor(std::log10(std::abs(v)))) - digits + 1);
}

// ---- the camera

/// Columns: right, up, back.
Mat3 wsFromCamera() {
    const double azimuth = glm::radians(kAzimuth), elevation = glm::radians(kElevation);
    const Vec3 back(std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                    std::cos(azimuth) * std::cos(elevation));
    return lookAt(back, Vec3(0), Vec3(0, 1, 0));
}

struct Framing {
    Vec3 wsPosition{0}, wsTarget{0};
    double size = 1;  ///< of what is framed, world units
};

/// The nearest place for the eye, looking along -back, from which all points are within the margins. A point
/// at (x, y, z) of the camera's axes is inside where |x - ex| <= s (ez - z) for the slope s of the frame's
/// border, and so for y: linear bounds on the eye (ex, ey, ez), of which the tighter axis decides ez.
Framing frame(const std::vector<Vec3>& wsPoints, double aspect) {
    Bounds ws;
    for (const Vec3& p : wsPoints) ws.include(p);
    const Mat3 axes = wsFromCamera();
    const Vec3 center = ws.center();

    const double slopeX = std::tan(glm::radians(0.5 * kFov)) * (1 - 2 * kMargin);
    const double slopes[2] = {slopeX, slopeX / aspect};
    Vec3 eye(0, 0, -std::numeric_limits<double>::infinity());
    for (int axis = 0; axis < 2; ++axis) {
        double right = -std::numeric_limits<double>::infinity(), left = -right;
        for (const Vec3& wsPoint : wsPoints) {
            const Vec3 p = (wsPoint - center) * axes;  // a row vector: into the camera's axes
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

/// Optical depths at scale 1 of the rays through an n x n raster over the picture that meet something.
std::vector<double> opticalDepths(const std::vector<FieldRays>& fields, const Camera& camera, int n) {
    Camera coarse = camera;
    coarse.resolution = Int2(n, n);
    coarse.pixelAspect = camera.pixelAspect * camera.resolution.x / camera.resolution.y;
    const RayFamily rays = wsRays(coarse);
    std::vector<double> depths(std::size_t(n) * std::size_t(n));
    parallelFor(std::size_t(n), [&](std::size_t y) {
        for (int x = 0; x < n; ++x) {
            const Vec3 d = rays.direction(x + 0.5, static_cast<double>(y) + 0.5);
            for (const FieldRays& field : fields)
                depths[y * std::size_t(n) + std::size_t(x)] +=
                    field.integral(rays.origin(x + 0.5, static_cast<double>(y) + 0.5), d);
        }
    });
    std::erase_if(depths, [](double tau) { return !(tau > 0) || !std::isfinite(tau); });
    return depths;
}

/// Extinction per unit of the field at which the median ray has the wanted optical depth.
double densityScale(const std::vector<FieldRays>& fields, const Camera& camera) {
    // A thin volume is met by few rays of a coarse raster.
    constexpr std::size_t kEnoughRays = 200;
    std::vector<double> depths;
    for (const int n : {32, 128}) {
        depths = opticalDepths(fields, camera, n);
        if (depths.size() >= kEnoughRays) break;
    }
    if (depths.empty()) return 1;
    const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
    std::nth_element(depths.begin(), middle, depths.end());
    return std::clamp(kMedianDepth / *middle, 1e-30, 1e30);
}

/// A light's direction of travel, from where it stands as the camera sees it: right, up, towards the eye.
std::string travelFrom(const Vec3& place) {
    return rounded(wsFromCamera() * -glm::normalize(place), -3);
}

std::string volumeText(const std::string& assetFile, const FramedGrid& grid, double scale) {
    const bool named = !grid.grid.empty();
    return fmt::format(
        "[[volume]]\n"
        "name = {}\n"
        "file = {}\n"
        "density = {{ {}scale = {} }}\n"
        "[volume.medium]\n"
        "albedo = [{a}, {a}, {a}]\n"
        "phase = {{ type = \"hg\", g = {g} }}\n\n",
        tomlString(named ? grid.grid : "volume"), tomlString(assetFile),
        named ? fmt::format("grid = {}, ", tomlString(grid.grid)) : "", significant(scale, 3), fmt::arg("a", kAlbedo),
        fmt::arg("g", kG));
}

}  // namespace

std::string framingScene(const std::string& assetFile, const std::vector<FramedGrid>& grids, Int2 resolution) {
    std::vector<Vec3> wsPoints;
    std::vector<FieldRays> fields;
    for (const FramedGrid& grid : grids) {
        Bounds is = isOccupied(*grid.field);
        if (is.empty()) continue;
        // The linear kernel reaches half a voxel further than the cells.
        is.lower -= 0.5;
        is.upper += 0.5;
        for (const Vec3& corner : is.corners()) wsPoints.push_back(transformPoint(grid.field->wsFromIs, corner));
        fields.emplace_back(*grid.field);
    }
    if (wsPoints.empty())
        for (const Vec3& corner : Bounds{Vec3(-0.5), Vec3(0.5)}.corners()) wsPoints.push_back(corner);

    const Framing framing = frame(wsPoints, double(resolution.x) / resolution.y);
    Camera camera;
    camera.wsPosition = framing.wsPosition;
    camera.wsFromCamera = wsFromCamera();
    camera.fov = kFov;
    camera.resolution = resolution;

    // A thousandth of what is seen, or less, is far below the margin.
    const int exponent = static_cast<int>(std::floor(std::log10(framing.size))) - 3;
    std::string text = fmt::format(
        "# A scene for {}\n\n"
        "[camera]\n"
        "type = \"perspective\"\n"
        "position = {}\n"
        "target = {}\n"
        "up = [0, 1, 0]\n"
        "fov = {}\n"
        "resolution = [{}, {}]\n\n",
        tomlString(assetFile), rounded(framing.wsPosition, exponent), rounded(framing.wsTarget, exponent), kFov,
        resolution.x, resolution.y);
    const double scale = fields.empty() ? 1 : densityScale(fields, camera);
    for (const FramedGrid& grid : grids) text += volumeText(assetFile, grid, scale);
    text += fmt::format(
        "# From above, left of the camera\n"
        "[[light]]\n"
        "name = \"key\"\n"
        "type = \"distant\"\n"
        "direction = {}\n"
        "color = [1, 0.95, 0.88]\n"
        "intensity = 14\n\n"
        "# Lightens the shadows from the other side\n"
        "[[light]]\n"
        "name = \"fill\"\n"
        "type = \"distant\"\n"
        "direction = {}\n"
        "color = [0.72, 0.84, 1]\n"
        "intensity = 3\n\n"
        "[ambient]\n"
        "color = [0.07, 0.08, 0.1]\n\n"
        "[render]\n"
        "quality = \"standard\"\n",
        travelFrom({-0.8, 0.9, 0.45}), travelFrom({0.9, 0.15, 0.55}));
    return text;
}

}  // namespace scrim
