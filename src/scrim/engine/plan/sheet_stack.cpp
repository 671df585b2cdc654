// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/plan/sheet_stack.h>

#include <scrim/base/error.h>
#include <scrim/geometry/enclosing_cone.h>
#include <scrim/engine/model/eye_view.h>
#include <scrim/engine/plan/light_groups.h>
#include <scrim/scene/slide_map.h>
#include <scrim/volume/kernel.h>

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
    const double front = std::floor(ts.lower.z);
    sheets.ssOrigin = Vec3(0, 0, front * sheets.thickness);
    sheets.count = std::max(1, addressable(ts.upper.z - front, "sheets"));
    return narrowed(sheets, corners);
}

Sheets narrowed(Sheets sheets, const std::vector<Vec3>& corners) {
    sheets.ssOrigin = Vec3(0, 0, sheets.ssOrigin.z);
    Bounds ts;
    for (const Vec3& corner : corners) ts.include(sheets.tsPoint(corner));
    // There is a margin of two texels of zeros, so that bilinear look-ups outside of the raster find nothing, and
    // behind it room for the rounded-up rows of footprints.
    const double left = std::floor(ts.lower.x) - 2, top = std::floor(ts.lower.y) - 2;
    sheets.ssOrigin = Vec3(left * sheets.texel, top * sheets.texel, sheets.ssOrigin.z);
    sheets.width = roundUpToTile(addressable(ts.upper.x - left + 8, "texels along the side of a sheet"));
    sheets.height = roundUpToTile(addressable(ts.upper.y - top + 8, "texels along the side of a sheet"));
    return sheets;
}

namespace {

// The most cells along one side of a raster. A light very close to a large volume gets coarser cells far away from it,
// instead of using all memory.
constexpr double kMostCells = 8192;

// The part that lies in both boxes; a point of `a` if there is none.
Box2<double> common(const Box2<double>& a, const Box2<double>& b) {
    auto both = Box2<double>::nothing();
    both.include(std::clamp(b.x0, a.x0, a.x1), std::clamp(b.y0, a.y0, a.y1));
    both.include(std::clamp(b.x1, a.x0, a.x1), std::clamp(b.y1, a.y0, a.y1));
    return both;
}

// How many times as large as `cell` cells must be to be no more than kMostCells along a side of the extent.
double coarserFor(const Box2<double>& extent, double cell) {
    return std::max(1.0, std::max(extent.x1 - extent.x0, extent.y1 - extent.y0) / (kMostCells * cell));
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

constexpr double kMargin = 8;  // cells; a footprint's rounded-up rows must lie within

// The smallest angle between rays and the sheets: half a degree, in radians.
constexpr double kLeastRise = 0.0087;
// The smallest angle between rays and the plane of the raster, in radians; rays may be slanted by 85 degrees at most.
constexpr double kLeastCrossing = 0.0872;

// A linear form on sweep space relative to a point, as a row that acts on (U, V, N, 1).
glm::dvec4 rowOf(const Vec3& ssForm, const Vec3& step, const Vec3& tsFrom) {
    const Vec3 form = ssForm * step;
    return {form.x, form.y, form.z, -glm::dot(form, tsFrom)};
}

Vec3 meanOf(const std::vector<Vec3>& directions) {
    Vec3 sum(0);
    for (const Vec3& d : directions) sum += d;
    return glm::normalize(sum);
}

// The lattice with cells of size `cell` around the extent, from the rows x, y and w, whose units `cell` and the extent
// have.
Lattice layRaster(const Box2<double>& extent, double cell, const glm::dvec4& x, const glm::dvec4& y,
                  const glm::dvec4& w, double& coarser) {
    coarser = coarserFor(extent, cell);
    cell *= coarser;
    const auto size = [&](double first, double last) {
        const int cells = static_cast<int>(std::ceil((last - first) / cell + 2 * kMargin));
        return roundUpToTile(cells);
    };
    Lattice raster;
    raster.kind = Lattice::Kind::parallel;
    raster.width = size(extent.x0, extent.x1);
    raster.height = size(extent.y0, extent.y1);
    const glm::dvec4 column = x / cell + (kMargin - extent.x0 / cell) * w;
    const glm::dvec4 row = y / cell + (kMargin - extent.y0 / cell) * w;
    for (int c = 0; c < 4; ++c) raster.rsFromTs[c] = {column[c], row[c], c == 2 ? 1.0 : 0.0, w[c]};
    return raster;
}

// The normal, in sweep space, of the planes in which a light's own sheets lie: along the light or along the viewing
// axis, as the dial says.
Vec3 planeNormal(const ViewScene& scene, const Light& light, const Sheets& sheets, const Vec3& along) {
    if (scene.dials.shadowPlane != ShadowPlane::image) return along;
    Vec3 normal = sheets.ssFromWs * viewingAxis(scene.camera);
    if (glm::dot(normal, along) < 0) normal = -normal;
    if (glm::dot(normal, along) < kLeastCrossing)
        throw Error(ErrorKind::render,
                    fmt::format("light '{}' runs along the image plane, to which its shadow buffer cannot be aligned; "
                                "shadow_plane = \"light\" can",
                                light.name));
    return normal;
}

// The lattice of a light's own sheets and shadow buffer.
Lattice lightLattice(const ViewScene& scene, const std::vector<Vec3>& corners, const Sheets& sheets,
                     PlannedLight& part) {
    const Light& light = scene.lights[part.light];
    const bool distant = light.distant();
    const Vec3 step(sheets.texel, sheets.texel, sheets.thickness);

    Vec3 along = sheets.ssFromWs * meanOf(part.wsDirections);
    if (std::abs(along.z) < kLeastRise) along = glm::normalize(Vec3(along.x, along.y, kLeastRise));
    const Vec3 normal = planeNormal(scene, light, sheets, along);
    const Mat3 frame = frameAround(normal);
    const Vec3 ey = frame[0], ex = -frame[1];

    auto extent = Box2<double>::nothing();
    if (distant) {
        // Projects points along the light onto the plane.
        const double crossing = glm::dot(normal, along);
        const Vec3 fx = ex - normal * (glm::dot(ex, along) / crossing);
        const Vec3 fy = ey - normal * (glm::dot(ey, along) / crossing);
        const glm::dvec4 x = rowOf(fx, step, Vec3(0)), y = rowOf(fy, step, Vec3(0)), w(0, 0, 0, 1);
        for (const Vec3& corner : corners) {
            const glm::dvec4 ts(sheets.tsPoint(corner), 1.0);
            extent.include(glm::dot(x, ts), glm::dot(y, ts));
        }
        return layRaster(extent, scene.dials.shadowTexel * sheets.texel, x, y, w, part.coarser);
    }

    const Vec3 source = sheets.tsPoint(light.wsPosition);
    const glm::dvec4 x = rowOf(ex, step, source), y = rowOf(ey, step, source), w = rowOf(normal, step, source);
    double farthest = 0;
    bool inFront = true;
    for (const Vec3& corner : corners) {
        const glm::dvec4 ts(sheets.tsPoint(corner), 1.0);
        const double depth = glm::dot(w, ts);
        farthest = std::max(farthest, depth);
        inFront = inFront && depth > 0.5 * sheets.thickness;
        if (inFront) extent.include(glm::dot(x, ts) / depth, glm::dot(y, ts) / depth);
    }
    if (!inFront || !part.wsWindows.empty()) {
        extent = Box2<double>::nothing();
        for (const Vec3& ws : part.wsDirections) {
            const Vec3 d = sheets.ssFromWs * ws;
            const double depth = std::max(glm::dot(normal, d), kLeastCrossing);
            extent.include(glm::dot(ex, d) / depth, glm::dot(ey, d) / depth);
        }
    }
    Lattice raster = layRaster(extent, scene.dials.shadowTexel * sheets.texel / std::max(farthest, sheets.thickness), x,
                               y, w, part.coarser);
    raster.kind = Lattice::Kind::perspective;
    return raster;
}

// The number of tiles around the picture that footprints of voxels just outside of it may reach.
int guardTiles(const ViewScene& scene, const Camera& camera, const Sheets& sheets) {
    if (camera.type != CameraType::orthographic) return 1;  // footprints are clipped at the border there
    const Lattice raster = EyeView(camera, sheets).lattice({0, 0, 1, 1}, 0);
    double reach = 0;
    for (const ViewVolume& volume : scene.volumes) {
        const Mat4 rsFromIs = raster.rsFromTs * sheets.tsFrom(volume.wsFromIs);
        for (int axis = 0; axis < 2; ++axis)
            reach = std::max(reach, kernelExtent(volume.kernel.value_or(scene.dials.kernel),
                                                 {rsFromIs[0][axis], rsFromIs[1][axis], rsFromIs[2][axis]}));
    }
    return static_cast<int>(std::ceil((2 * reach + 6) / kTileEdge));
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

PlannedLight planLight(const ViewScene& scene, const std::vector<Vec3>& corners, const Sheets& sheets, double slant,
                       PlannedLight planned) {
    const Light& light = scene.lights[planned.light];
    planned.shadowed = light.shadows;
    for (const Vec3& axis : planned.wsWindows) planned.ssWindows.push_back(sheets.ssFromWs * axis);
    if (scene.dials.splat == SplatMode::perView && light.shadows)
        planned.lattice = lightLattice(scene, corners, sheets, planned);

    LightView& view = planned.view;
    view.distant = light.distant();
    view.slopeScale = sheets.texel / sheets.thickness;
    if (view.distant)
        layDistant(scene, light, corners, sheets, planned);
    else
        layPoint(scene, light, corners, sheets, slant, planned);
    return planned;
}

Lattice eyeLattice(const ViewScene& scene, const PixelWindow& window, const Sheets& sheets) {
    const int n = scene.dials.antialias;
    const Camera camera = supersampled(scene.camera, n);
    return EyeView(camera, sheets).lattice(supersampled(window, n), guardTiles(scene, camera, sheets));
}

}  // namespace scrim
