// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/plan/light_raster.h>

#include <scrim/engine/light/slide_map.h>
#include <scrim/engine/plan/rasters.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

namespace scrim {
namespace {

// Cells along one side of a raster at most: a light very close to a large volume gets coarser cells far away
// from it instead of all the memory.
constexpr double kMostCells = 8192;

struct Extent {
    double x0 = std::numeric_limits<double>::infinity(), x1 = -std::numeric_limits<double>::infinity();
    double y0 = x0, y1 = x1;

    void include(double x, double y) {
        x0 = std::min(x0, x);
        x1 = std::max(x1, x);
        y0 = std::min(y0, y);
        y1 = std::max(y1, y);
    }
};

// What lies in both; where nothing does, a point of `a`.
Extent common(const Extent& a, const Extent& b) {
    Extent both;
    both.include(std::clamp(b.x0, a.x0, a.x1), std::clamp(b.y0, a.y0, a.y1));
    both.include(std::clamp(b.x1, a.x0, a.x1), std::clamp(b.y1, a.y0, a.y1));
    return both;
}

// Lays cells over the extent, with a margin of two for look-ups between cells.
void layCells(const Extent& extent, LightView& view) {
    view.cell = std::max({view.cell, (extent.x1 - extent.x0) / kMostCells, (extent.y1 - extent.y0) / kMostCells});
    view.first = {(std::floor(extent.x0 / view.cell) - 2) * view.cell,
                  (std::floor(extent.y0 / view.cell) - 2) * view.cell};
    const auto cells = [&](double first, double last) {
        const int count = static_cast<int>(std::ceil((last - first) / view.cell)) + 4;
        return (count + kTileEdge - 1) / kTileEdge * kTileEdge;
    };
    view.width = cells(view.first.x, extent.x1);
    view.height = cells(view.first.y, extent.y1);
}

}  // namespace

LightPlan planLight(const ViewScene& scene, const std::vector<Vec3>& corners, const Sheets& sheets, double slant,
                    LightPart part) {
    const Light& light = scene.lights[static_cast<std::size_t>(part.light)];
    LightPlan plan;
    plan.light = part.light;
    plan.shadowed = light.shadows;
    for (const Vec3& axis : part.wsWindows) plan.ssWindows.push_back(sheets.ssFromWs * axis);
    plan.window = part.window;
    plan.share = part.share;
    if (scene.dials.splat == SplatMode::perView && light.shadows)
        plan.raster = lightRaster(scene, corners, sheets, part);

    LightView& view = plan.view;
    view.distant = light.type == LightType::distant;
    view.slopeScale = sheets.texel / sheets.thickness;
    Extent extent;
    if (view.distant) {
        Vec3 travel = sheets.tsVector(light.wsDirection);
        // Image-aligned sheets may have a light that runs within them.
        travel.z = std::max(travel.z, 1e-3 * glm::length(travel));
        view.tsSource = {travel.x / travel.z, travel.y / travel.z, 0};
        view.cell = scene.dials.shadowTexel;
        const auto covered = [&](const std::vector<Vec3>& points) {
            Extent all;
            for (const Vec3& point : points) {
                const Vec3 ts = sheets.tsPoint(point);
                all.include(ts.x - view.tsSource.x * ts.z, ts.y - view.tsSource.y * ts.z);
            }
            return all;
        };
        extent = covered(corners);
        if (light.slide && light.slide->outside == SlideOutside::black)
            extent = common(extent, covered(distantSlideCorners(light)));
        layCells(extent, view);
        return plan;
    }

    // Rays from a point are named by their slopes: those of the part's directions, or of the volume's corners
    // where that is less. No slope may exceed the sweep's slant.
    view.tsSource = sheets.tsPoint(light.wsPosition);
    const double steepest = std::tan(std::min(slant + 0.02, kSlantLimit)) / view.slopeScale;
    for (const Vec3& ws : part.wsDirections) {
        const Vec3 ts = sheets.tsVector(ws);
        if (ts.z > 0) extent.include(ts.x / ts.z, ts.y / ts.z);
    }
    double farthest = 1;
    bool inFront = true;
    Extent seen;
    for (const Vec3& corner : corners) {
        const Vec3 ts = sheets.tsPoint(corner) - view.tsSource;
        farthest = std::max(farthest, ts.z);
        inFront = inFront && ts.z > 0.5;
        if (inFront) seen.include(ts.x / ts.z, ts.y / ts.z);
    }
    if (inFront)
        extent = {std::max(extent.x0, seen.x0), std::min(extent.x1, seen.x1), std::max(extent.y0, seen.y0),
                  std::min(extent.y1, seen.y1)};
    extent = {std::clamp(extent.x0, -steepest, steepest), std::clamp(extent.x1, -steepest, steepest),
              std::clamp(extent.y0, -steepest, steepest), std::clamp(extent.y1, -steepest, steepest)};
    if (extent.x1 < extent.x0) std::swap(extent.x0, extent.x1);
    if (extent.y1 < extent.y0) std::swap(extent.y0, extent.y1);
    // Cells are largest where the light has gone furthest.
    view.cell = scene.dials.shadowTexel / farthest;
    layCells(extent, view);
    return plan;
}

}  // namespace scrim
