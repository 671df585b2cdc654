// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/plan/rasters.h>

#include <scrim/base/error.h>
#include <scrim/engine/composite/eye_rays.h>
#include <scrim/engine/splat/kernel.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

constexpr double kMostCells = 8192;  // along one side of a raster, as for shared rasters
constexpr double kMargin = 8;        // cells: a footprint's rounded-up rows must lie within

// Rays may not lie within the sheets: half a degree is what they keep to them.
constexpr double kLeastRise = 0.0087;
// Nor along the plane of the raster: 85 degrees is the limit.
constexpr double kLeastCrossing = 0.0872;

struct Extent {
    double x0 = std::numeric_limits<double>::infinity(), x1 = -x0, y0 = x0, y1 = -x0;
    void include(double x, double y) {
        x0 = std::min(x0, x);
        x1 = std::max(x1, x);
        y0 = std::min(y0, y);
        y1 = std::max(y1, y);
    }
};

// A linear form on sweep space relative to a point, as a row on (U, V, N, 1).
glm::dvec4 rowOf(const Vec3& ssForm, const Vec3& step, const Vec3& tsFrom) {
    const Vec3 form = ssForm * step;
    return {form.x, form.y, form.z, -glm::dot(form, tsFrom)};
}

Vec3 meanOf(const std::vector<Vec3>& directions) {
    Vec3 sum(0);
    for (const Vec3& d : directions) sum += d;
    return glm::normalize(sum);
}

// Rows to a raster, whose cells have the size 1 / `perCell` in the units of the rows, around the extent.
ViewRaster layRaster(const Extent& extent, double cell, const glm::dvec4& x, const glm::dvec4& y, const glm::dvec4& w) {
    cell = std::max({cell, (extent.x1 - extent.x0) / kMostCells, (extent.y1 - extent.y0) / kMostCells});
    const auto size = [&](double first, double last) {
        const int cells = static_cast<int>(std::ceil((last - first) / cell + 2 * kMargin));
        return (cells + kTileEdge - 1) / kTileEdge * kTileEdge;
    };
    ViewRaster raster;
    raster.width = size(extent.x0, extent.x1);
    raster.height = size(extent.y0, extent.y1);
    const glm::dvec4 column = x / cell + (kMargin - extent.x0 / cell) * w;
    const glm::dvec4 row = y / cell + (kMargin - extent.y0 / cell) * w;
    for (int c = 0; c < 4; ++c) raster.rsFromTs[c] = {column[c], row[c], c == 2 ? 1.0 : 0.0, w[c]};
    return raster;
}

}  // namespace

ViewRaster lightRaster(const ViewScene& scene, const std::vector<Vec3>& corners, const Sheets& sheets,
                       const LightPart& part) {
    const Light& light = scene.lights[static_cast<std::size_t>(part.light)];
    const bool distant = light.type == LightType::distant;
    const Vec3 step(sheets.texel, sheets.texel, sheets.thickness);
    const bool image = scene.dials.shadowPlane == ShadowPlane::image;

    Vec3 along = sheets.ssFromWs * meanOf(part.wsDirections);
    if (std::abs(along.z) < kLeastRise) along = glm::normalize(Vec3(along.x, along.y, kLeastRise));
    Vec3 normal = along;
    if (image) {
        normal = sheets.ssFromWs * viewingAxis(scene.camera);
        if (glm::dot(normal, along) < 0) normal = -normal;
        if (glm::dot(normal, along) < kLeastCrossing)
            throw Error(
                ErrorKind::render,
                fmt::format("light '{}' runs along the image plane, to which its shadow buffer cannot be aligned; "
                            "shadow_plane = \"light\" can",
                            light.name));
    }
    const Vec3 other = std::abs(normal.x) < 0.7 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
    const Vec3 ey = glm::normalize(glm::cross(normal, other)), ex = glm::cross(ey, normal);

    Extent extent;
    if (distant) {
        // Slide points along the light onto the plane.
        const double crossing = glm::dot(normal, along);
        const Vec3 fx = ex - normal * (glm::dot(ex, along) / crossing);
        const Vec3 fy = ey - normal * (glm::dot(ey, along) / crossing);
        const glm::dvec4 x = rowOf(fx, step, Vec3(0)), y = rowOf(fy, step, Vec3(0)), w(0, 0, 0, 1);
        for (const Vec3& corner : corners) {
            const glm::dvec4 ts(sheets.tsPoint(corner), 1.0);
            extent.include(glm::dot(x, ts), glm::dot(y, ts));
        }
        return layRaster(extent, scene.dials.shadowTexel * sheets.texel, x, y, w);
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
        extent = {};
        for (const Vec3& ws : part.wsDirections) {
            const Vec3 d = sheets.ssFromWs * ws;
            const double depth = std::max(glm::dot(normal, d), kLeastCrossing);
            extent.include(glm::dot(ex, d) / depth, glm::dot(ey, d) / depth);
        }
    }
    ViewRaster raster =
        layRaster(extent, scene.dials.shadowTexel * sheets.texel / std::max(farthest, sheets.thickness), x, y, w);
    raster.parallel = false;
    return raster;
}

int guardTiles(const ViewScene& scene, const Camera& camera, const Sheets& sheets) {
    if (camera.type != CameraType::orthographic) return 1;  // footprints are cut at the border there
    const ViewRaster raster = EyeView(camera, sheets).raster({0, 0, 1, 1}, 0);
    double reach = 0;
    for (const ViewVolume& volume : scene.volumes) {
        const Mat4 rsFromIs = raster.rsFromTs * sheets.tsFrom(volume.wsFromIs);
        for (int axis = 0; axis < 2; ++axis)
            reach = std::max(
                reach, kernelExtent(scene.dials.kernel, {rsFromIs[0][axis], rsFromIs[1][axis], rsFromIs[2][axis]}));
    }
    return static_cast<int>(std::ceil((2 * reach + 6) / kTileEdge));
}

}  // namespace scrim
