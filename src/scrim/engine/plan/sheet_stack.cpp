// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/plan/sheet_stack.h>

#include <scrim/base/error.h>
#include <scrim/geometry/enclosing_cone.h>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

constexpr double kWidestEye = 0.7854;  // 45 degrees: half the opening angle that one sweep serves well
constexpr double kPartAngle = 1.0472;  // 60 degrees: largest opening angle of a part along x or y
constexpr double kOverlap = 0.0698;    // 4 degrees: width of the overlap of two parts

// A box around the raster positions that the volume may cover.
Box2<double> coveredRaster(const ViewScene& scene, const RayFamily& rays, const std::vector<Vec3>& corners) {
    // A crop does not count, because its pixels must equal those of the whole picture.
    const Box2<double> all{double(std::min(0, scene.region.x0)), double(std::min(0, scene.region.y0)),
                           double(std::max(scene.camera.resolution.x, scene.region.x1)),
                           double(std::max(scene.camera.resolution.y, scene.region.y1))};
    const Mat3 rasterFromWs = glm::inverse(Mat3(rays.direction0, rays.directionX, rays.directionY));
    Box2<double> seen{all.x1, all.y1, all.x0, all.y0};
    for (const Vec3& corner : corners) {
        const Vec3 p = rasterFromWs * (corner - rays.origin0);  // (depth, depth * x, depth * y)
        if (p.x <= 0) return all;                               // the volume reaches behind the eye
        seen.include(p.y / p.x, p.z / p.x);
    }
    if (corners.empty() || seen.x0 >= all.x1 || seen.x1 <= all.x0 || seen.y0 >= all.y1 || seen.y1 <= all.y0) return all;
    return intersection(all, seen);
}

std::vector<Vec3> directionsTo(const RayFamily& rays, const Box2<double>& box) {
    std::vector<Vec3> directions;
    for (const double x : {box.x0, box.x1})
        for (const double y : {box.y0, box.y1}) directions.push_back(glm::normalize(rays.direction(x, y)));
    return directions;
}

// An axis of the picture divided at equal angles. Position p is seen at the angle atan((p - middle) / focal).
struct Cuts {
    std::vector<double> edges;    // first, cuts, last
    std::vector<double> overlap;  // half the width of the ramp at each edge; 0 at the ends

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
    Vec2 ramp(std::size_t edge) const { return {edges[edge] - overlap[edge], edges[edge] + overlap[edge]}; }
};

// The most sheets in a sweep, or texels along a side. A transform that squeezes one axis to a millionth would need
// millions of sheets, or more than an int holds.
constexpr int kMostAddressed = 1 << 20;

// Rays may cross image-aligned sheets at any slant (ZC02 Fig. 17); beyond this one, in radians, thinner sheets no
// longer help.
constexpr double kSteepestSlant = 1.0472;  // 60 degrees

// `count`, rounded up. `what` names the counted things in the error.
int addressable(double count, const std::string& what) {
    if (std::isfinite(count) && count <= kMostAddressed) return static_cast<int>(std::ceil(count));
    throw Error(ErrorKind::render,
                fmt::format("a sweep would have {:.3g} {}; expected at most {}. texel and sheet_thickness are in units "
                            "of the smallest voxel edge: raise them, or stretch the volumes less",
                            count, what, kMostAddressed));
}

}  // namespace

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
    const Box2<double> box = coveredRaster(scene, rays, corners);
    whole.wsDirections = directionsTo(rays, box);
    if (enclosingCone(whole.wsDirections).cosAngle >= std::cos(kWidestEye)) return {whole};

    // A step on the raster is a step of the ray's direction at depth 1.
    const double focalX = 1 / glm::length(rays.directionX), focalY = 1 / glm::length(rays.directionY);
    const Cuts x(box.x0, box.x1, 0.5 * scene.camera.resolution.x, focalX);
    const Cuts y(box.y0, box.y1, 0.5 * scene.camera.resolution.y, focalY);
    std::vector<EyePart> parts;
    for (std::size_t j = 0; j < y.parts(); ++j)
        for (std::size_t i = 0; i < x.parts(); ++i) {
            EyePart part;
            part.whole = false;
            part.left = x.ramp(i);
            part.right = x.ramp(i + 1);
            part.top = y.ramp(j);
            part.bottom = y.ramp(j + 1);
            const Box2<double> own{part.left.x, part.top.x, part.right.y, part.bottom.y};
            part.wsDirections = directionsTo(rays, own);
            part.window = intersection(
                everywhere, {static_cast<int>(std::floor(own.x0)), static_cast<int>(std::floor(own.y0)),
                             static_cast<int>(std::ceil(own.x1)) + 1, static_cast<int>(std::ceil(own.y1)) + 1});
            parts.push_back(part);
        }
    return parts;
}

// The stack of sheets around the volume. Planes lie at integer multiples of the thickness, texels at integer multiples
// of their size, measured from the middle of the volume, so that nothing depends on the camera's position.
Sheets sheetsAround(const ViewScene& scene, const std::vector<Vec3>& corners, const Vec3& wsAxis, double slant,
                    double voxel) {
    Bounds ws;
    for (const Vec3& corner : corners) ws.include(corner);

    Sheets sheets;
    sheets.wsAnchor = ws.center();
    sheets.ssFromWs = sweepRotation(wsAxis, scene.camera.wsFromCamera[1]);
    sheets.texel = scene.dials.texel * voxel;
    sheets.thickness = scene.dials.sheetThickness * voxel * std::cos(std::min(slant, kSteepestSlant));

    Bounds ts;  // with the origin at the anchor
    for (const Vec3& corner : corners) ts.include(sheets.tsPoint(corner));
    // There is a margin of two texels of zeros, so that bilinear look-ups outside of the raster find nothing, and
    // behind it room for the rounded-up rows of footprints.
    const double left = std::floor(ts.lower.x) - 2, top = std::floor(ts.lower.y) - 2;
    const double front = std::floor(ts.lower.z);
    sheets.ssOrigin = Vec3(left * sheets.texel, top * sheets.texel, front * sheets.thickness);
    sheets.width = roundUpToTile(addressable(ts.upper.x - left + 8, "texels along the side of a sheet"));
    sheets.height = roundUpToTile(addressable(ts.upper.y - top + 8, "texels along the side of a sheet"));
    sheets.count = std::max(1, addressable(ts.upper.z - front, "sheets"));
    return sheets;
}

}  // namespace scrim
