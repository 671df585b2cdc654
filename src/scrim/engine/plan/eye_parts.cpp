// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/plan/eye_parts.h>

#include <scrim/geometry/enclosing_cone.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

constexpr double kWidestEye = 0.7854;  // 45 degrees: half the opening that one sweep serves well
constexpr double kPartAngle = 1.0472;  // 60 degrees: the opening of a part along x or y, at most
constexpr double kOverlap = 0.0698;    // 4 degrees: where two parts share the picture

// Raster positions that the volume may cover.
struct Covered {
    double x0, x1, y0, y1;
};

Covered coveredRaster(const ViewScene& scene, const RayFamily& rays, const std::vector<Vec3>& corners) {
    // A crop does not count: its pixels must come out as in the whole picture.
    Covered all{double(std::min(0, scene.region.x0)), double(std::max(scene.camera.resolution.x, scene.region.x1)),
                double(std::min(0, scene.region.y0)), double(std::max(scene.camera.resolution.y, scene.region.y1))};
    const Mat3 rasterFromWs = glm::inverse(Mat3(rays.direction0, rays.directionX, rays.directionY));
    Covered seen{all.x1, all.x0, all.y1, all.y0};
    for (const Vec3& corner : corners) {
        const Vec3 p = rasterFromWs * (corner - rays.origin0);  // (depth, depth * x, depth * y)
        if (p.x <= 0) return all;                               // the volume reaches behind the eye
        seen = {std::min(seen.x0, p.y / p.x), std::max(seen.x1, p.y / p.x), std::min(seen.y0, p.z / p.x),
                std::max(seen.y1, p.z / p.x)};
    }
    if (corners.empty() || seen.x0 >= all.x1 || seen.x1 <= all.x0 || seen.y0 >= all.y1 || seen.y1 <= all.y0) return all;
    return {std::max(all.x0, seen.x0), std::min(all.x1, seen.x1), std::max(all.y0, seen.y0), std::min(all.y1, seen.y1)};
}

std::vector<Vec3> directionsTo(const RayFamily& rays, const Covered& box) {
    std::vector<Vec3> directions;
    for (const double x : {box.x0, box.x1})
        for (const double y : {box.y0, box.y1}) directions.push_back(glm::normalize(rays.direction(x, y)));
    return directions;
}

// An axis of the picture cut at equal angles. Positions p are seen at the angle atan((p - middle) / focal).
struct Cuts {
    std::vector<double> edges;    // first, cuts, last
    std::vector<double> overlap;  // half the width of the ramp at each of them; 0 at the ends

    Cuts(double from, double to, double middle, double focal) {
        const double first = std::atan((from - middle) / focal), last = std::atan((to - middle) / focal);
        const int count = std::max(1, static_cast<int>(std::ceil((last - first) / kPartAngle - 1e-9)));
        const auto position = [&](double angle) { return middle + focal * std::tan(angle); };
        for (int i = 0; i <= count; ++i) {
            const double angle = first + (last - first) * i / count;
            edges.push_back(i == 0 ? from : i == count ? to : position(angle));
            const bool cut = i > 0 && i < count;
            overlap.push_back(cut ? 0.5 * (position(angle + kOverlap / 2) - position(angle - kOverlap / 2)) : 0.0);
        }
    }
    std::size_t parts() const { return edges.size() - 1; }
    Fade fade(std::size_t edge) const { return {edges[edge] - overlap[edge], edges[edge] + overlap[edge]}; }
};

}  // namespace

double Fade::at(double position) const {
    if (from == to) return 1;
    const double t = std::clamp((position - from) / (to - from), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

double EyePart::weight(double x, double y) const {
    if (whole) return 1;
    const auto falling = [](const Fade& ramp, double position) {
        return ramp.from == ramp.to ? 1 : 1 - ramp.at(position);
    };
    return left.at(x) * falling(right, x) * top.at(y) * falling(bottom, y);
}

std::vector<EyePart> eyeParts(const ViewScene& scene, const std::vector<Vec3>& corners) {
    const RayFamily rays = wsRays(scene.camera);
    const PixelWindow everywhere{std::min(0, scene.region.x0), std::min(0, scene.region.y0),
                                 std::max(scene.camera.resolution.x, scene.region.x1),
                                 std::max(scene.camera.resolution.y, scene.region.y1)};
    EyePart whole;
    whole.window = everywhere;
    if (scene.camera.type == CameraType::orthographic) {
        whole.wsDirections = {glm::normalize(rays.direction0)};
        return {whole};
    }
    const Covered box = coveredRaster(scene, rays, corners);
    whole.wsDirections = directionsTo(rays, box);
    if (enclosingCone(whole.wsDirections).cosAngle >= std::cos(kWidestEye)) return {whole};

    // Raster steps are steps of the ray's direction at depth 1.
    const double focalX = 1 / glm::length(rays.directionX), focalY = 1 / glm::length(rays.directionY);
    const Cuts x(box.x0, box.x1, 0.5 * scene.camera.resolution.x, focalX);
    const Cuts y(box.y0, box.y1, 0.5 * scene.camera.resolution.y, focalY);
    std::vector<EyePart> parts;
    for (std::size_t j = 0; j < y.parts(); ++j)
        for (std::size_t i = 0; i < x.parts(); ++i) {
            EyePart part;
            part.whole = false;
            part.left = x.fade(i);
            part.right = x.fade(i + 1);
            part.top = y.fade(j);
            part.bottom = y.fade(j + 1);
            const Covered own{part.left.from, part.right.to, part.top.from, part.bottom.to};
            part.wsDirections = directionsTo(rays, own);
            part.window = intersection(
                everywhere, {static_cast<int>(std::floor(own.x0)), static_cast<int>(std::floor(own.y0)),
                             static_cast<int>(std::ceil(own.x1)) + 1, static_cast<int>(std::ceil(own.y1)) + 1});
            parts.push_back(part);
        }
    return parts;
}

}  // namespace scrim
