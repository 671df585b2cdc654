// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/plan/sheet_stack.h>

#include <scrim/base/error.h>
#include <scrim/geometry/enclosing_cone.h>
#include <scrim/engine/plan/light_groups.h>
#include <scrim/engine/plan/view_lattices.h>
#include <scrim/scene/slide_map.h>

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

// A box around the raster positions of `window` that the volume may cover.
Box2<double> coveredRaster(const PixelWindow& window, const RayFamily& rays, const std::vector<Vec3>& corners) {
    const Box2<double> all{double(window.x0), double(window.y0), double(window.x1), double(window.y1)};
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

// The most sheets in a sweep, or texels along a side. A transform that squeezes one axis to a
// millionth would need millions of sheets, or more than an int holds.
constexpr int kMostAddressed = 1 << 20;

// Rays may cross image-aligned sheets at any slant (ZC02 Fig. 17); beyond this one, in radians,
// thinner sheets no longer help.
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
    // A crop does not count, because its pixels must equal those of the whole picture.
    const PixelWindow everywhere = wholePicture(scene);
    EyePart whole;
    whole.window = everywhere;
    if (scene.camera.type == CameraType::orthographic) {
        whole.wsDirections = {glm::normalize(rays.direction0)};
        return {whole};
    }
    const Box2<double> box = coveredRaster(everywhere, rays, corners);
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
                    const VoxelEdges& edges) {
    Bounds ws;
    for (const Vec3& corner : corners) ws.include(corner);

    Sheets sheets;
    sheets.wsAnchor = ws.center();
    sheets.ssFromWs = sweepRotation(wsAxis, scene.camera.wsFromCamera[1]);
    sheets.texel = scene.dials.texel * edges.across;
    sheets.thickness = scene.dials.sheetThickness * edges.through * std::cos(std::min(slant, kSteepestSlant));

    Bounds ts;  // with the origin at the anchor
    for (const Vec3& corner : corners) ts.include(sheets.tsPoint(corner));
    const double front = std::floor(ts.lower.z);
    sheets.ssOrigin = Vec3(0, 0, front * sheets.thickness);
    sheets.count = std::max(1, addressable(ts.upper.z - front, "sheets"));
    return narrowed(sheets, corners);
}

Sheets narrowed(Sheets sheets, const std::vector<Vec3>& corners) {
    sheets.ssOrigin = Vec3(0, 0, sheets.ssOrigin.z);
    Bounds ts;
    for (const Vec3& corner : corners) ts.include(sheets.tsPoint(corner));
    // There is a margin of two texels of zeros, so that bilinear look-ups outside of the raster
    // find nothing, and behind it room for the rounded-up rows of footprints.
    const double left = std::floor(ts.lower.x) - 2, top = std::floor(ts.lower.y) - 2;
    sheets.ssOrigin = Vec3(left * sheets.texel, top * sheets.texel, sheets.ssOrigin.z);
    sheets.width = roundUpToTile(addressable(ts.upper.x - left + 8, "texels along the side of a sheet"));
    sheets.height = roundUpToTile(addressable(ts.upper.y - top + 8, "texels along the side of a sheet"));
    return sheets;
}

double coarserFor(const Box2<double>& extent, double cell) {
    // A light very close to a large volume gets coarser cells far away from it, instead of using all memory.
    constexpr double kMostCells = 8192;
    return std::max(1.0, std::max(extent.x1 - extent.x0, extent.y1 - extent.y0) / (kMostCells * cell));
}

namespace {

// The part that lies in both boxes; a point of `a` if there is none.
Box2<double> common(const Box2<double>& a, const Box2<double>& b) {
    auto both = Box2<double>::nothing();
    both.include(std::clamp(b.x0, a.x0, a.x1), std::clamp(b.y0, a.y0, a.y1));
    both.include(std::clamp(b.x1, a.x0, a.x1), std::clamp(b.y1, a.y0, a.y1));
    return both;
}

// Lays cells over the extent, with a margin of two cells for look-ups between cells.
void layCells(const Box2<double>& extent, PlannedLight& planned) {
    LightView& view = planned.view;
    planned.coarser = std::max(planned.coarser, coarserFor(extent, view.cell));
    view.cell *= coarserFor(extent, view.cell);
    view.first = {(std::floor(extent.x0 / view.cell) - 2) * view.cell,
                  (std::floor(extent.y0 / view.cell) - 2) * view.cell};
    const auto cells = [&](double first, double last) {
        const int count = static_cast<int>(std::ceil((last - first) / view.cell)) + 4;
        return roundUpToTile(count);
    };
    view.width = cells(view.first.x, extent.x1);
    view.height = cells(view.first.y, extent.y1);
}

// Lays the raster of a distant light over the volumes' corners, or over the part of them that a slide lights.
void layDistant(const ViewScene& scene, const Light& light, const std::vector<Vec3>& corners, const Sheets& sheets,
                PlannedLight& planned) {
    LightView& view = planned.view;
    Vec3 travel = sheets.tsVector(light.wsDirection);
    // A light may run within image-aligned sheets.
    travel.z = std::max(travel.z, 1e-3 * glm::length(travel));
    view.tsSource = {travel.x / travel.z, travel.y / travel.z, 0};
    view.cell = scene.dials.shadowTexel;
    const auto covered = [&](const std::vector<Vec3>& points) {
        auto all = Box2<double>::nothing();
        for (const Vec3& point : points) {
            const Vec3 ts = sheets.tsPoint(point);
            all.include(ts.x - view.tsSource.x * ts.z, ts.y - view.tsSource.y * ts.z);
        }
        return all;
    };
    Box2<double> extent = covered(corners);
    if (light.slide && light.slide->outside == SlideOutside::black)
        extent = common(extent, covered(distantSlideCorners(light)));
    layCells(extent, planned);
}

// Lays the raster of a light that shines from a point, in its directions.
void layPoint(const ViewScene& scene, const Light& light, const std::vector<Vec3>& corners, const Sheets& sheets,
              double slant, PlannedLight& planned) {
    LightView& view = planned.view;
    // Rays from a point are identified by their slopes. The extent is that of the part's directions, or of the volume's
    // corners if that is smaller. No slope may exceed the sweep's slant.
    auto extent = Box2<double>::nothing();
    view.tsSource = sheets.tsPoint(light.wsPosition);
    const double steepest = std::tan(std::min(slant + 0.02, kSlantLimit)) / view.slopeScale;
    for (const Vec3& ws : planned.wsDirections) {
        const Vec3 ts = sheets.tsVector(ws);
        if (ts.z > 0) extent.include(ts.x / ts.z, ts.y / ts.z);
    }
    double farthest = 1;
    bool inFront = true;
    auto seen = Box2<double>::nothing();
    for (const Vec3& corner : corners) {
        const Vec3 ts = sheets.tsPoint(corner) - view.tsSource;
        farthest = std::max(farthest, ts.z);
        inFront = inFront && ts.z > 0.5;
        if (inFront) seen.include(ts.x / ts.z, ts.y / ts.z);
    }
    if (inFront) extent = intersection(extent, seen);
    extent = {std::clamp(extent.x0, -steepest, steepest), std::clamp(extent.y0, -steepest, steepest),
              std::clamp(extent.x1, -steepest, steepest), std::clamp(extent.y1, -steepest, steepest)};
    if (extent.x1 < extent.x0) std::swap(extent.x0, extent.x1);
    if (extent.y1 < extent.y0) std::swap(extent.y0, extent.y1);
    // Cells are largest where the light has travelled furthest.
    view.cell = scene.dials.shadowTexel / farthest;
    layCells(extent, planned);
}

}  // namespace

PlannedLight planLight(const ViewScene& scene, const Light& light, const std::vector<Vec3>& corners,
                       const Sheets& sheets, double slant, PlannedLight planned) {
    planned.shadowed = light.shadows;
    for (const Vec3& axis : planned.wsWindows) planned.ssWindows.push_back(sheets.ssFromWs * axis);
    if (scene.dials.splat == SplatMode::perView && light.shadows)
        planned.lattice = lightLattice(scene, light, corners, sheets, planned);

    LightView& view = planned.view;
    view.distant = light.distant();
    view.slopeScale = sheets.texel / sheets.thickness;
    if (view.distant)
        layDistant(scene, light, corners, sheets, planned);
    else
        layPoint(scene, light, corners, sheets, slant, planned);
    return planned;
}

}  // namespace scrim
