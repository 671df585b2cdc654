// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/plan/expected_cost.h>

#include <scrim/base/error.h>
#include <scrim/engine/lamps/lamp.h>
#include <scrim/engine/light/backdrop.h>
#include <scrim/engine/model/sub_lights.h>
#include <scrim/engine/plan/make_plan.h>

#include <algorithm>
#include <numbers>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

// Seconds on one thread of the solves of scattered light: a cell of Disney's cloud at a sixteenth
// took 10 ns for each direction and sweep, with 64 to 256 directions and cells of 1.4 to 6 voxels;
// solves took 12 to 22 sweeps, all but the last along half of the directions.
double scatterSeconds(const TransportPlan& plan) {
    constexpr double kCellDirection = 1e-8, kSweeps = 10;
    return plan.any() ? plan.cells * plan.ordinates * kSweeps * kCellDirection : 0;
}

// Seconds on one thread of looking up lamps on cells: samples near one find how much of the solid angle around it their
// cell has. 1 to 20 points in haze, with a plume or without, took 90 to 320 ns for each sample, 4 in 10 of them near.
double lampSeconds(const ViewScene& scene, const Plan& plan) {
    constexpr double kNearSample = 4e-7;
    const Vec3 size = wsBounds(scene).size();
    double near = 0;  // of the samples, summed over lamps
    for (std::size_t i = 0; i < plan.cellLights.lights.size(); ++i) {
        const Light& light = scene.lights[std::size_t(plan.cellLights.lights[i])];
        if (!isLampOnCells(scene, light)) continue;
        double edge = 0;
        for (const CellLevel& level : plan.cellLights.levels) edge = std::max(edge, level.edges[i]);
        const double across = 2 * nearestFar(light, edge);
        near += std::min(across / size.x, 1.0) * std::min(across / size.y, 1.0) * std::min(across / size.z, 1.0);
    }
    return kNearSample * near * double(plan.work.pixelSheets);
}

// Seconds on one thread of surfaces that are seen, on half of all rays. Those that catch shadows ask for each
// sub-light: a floor of 2,000 triangles under a dome took 0.8 us for each. Volumes light surfaces along cones, 256 at a
// place that is not between others of like light: the same floor, which is rough, took 120 us a ray, and an even one a
// tenth of that.
double surfaceSeconds(const ViewScene& scene, const Plan& plan) {
    constexpr double kSeen = 0.5, kCaught = 8e-7, kLitByVolumes = 3e-5;
    double each = backdropIsLitByVolumes(scene) ? kLitByVolumes : 0;
    if (scene.solids && scene.solids->any(SolidRole::catcher))
        for (const Light& light : scene.lights) each += kCaught * subLightCount(scene, light);
    return kSeen * each * double(plan.region.pixelCount());
}

std::string timeText(double seconds) {
    constexpr double kMinute = 60, kHour = 3600;
    if (seconds < kMinute) return fmt::format("{:.2g} s", seconds);
    return seconds < 2 * kHour ? fmt::format("{:.0f} minutes", seconds / kMinute)
                               : fmt::format("{:.0f} hours", seconds / kHour);
}

}  // namespace

double cellLightSeconds(const ViewScene& scene, const CellLightPlan& plan) {
    // For each byte of their cells, plumes under a sky, and scans of 8 and 16 million voxels, took 4 to 8 ns and 0.05
    // to 0.1 ns more for each direction that stands for a light. A square's points in haze took 0.4 ns each.
    constexpr double kByte = 4e-9, kByteDirection = 5e-11, kPoint = 8;
    double directions = 0;
    for (const int i : plan.lights) {
        const Light& light = scene.lights[std::size_t(i)];
        directions += pointsOnCells(scene, light) * (light.distant() || light.dome() ? 1 : kPoint);
    }
    return plan.lights.empty() ? 0 : double(plan.bytes) * (kByte + kByteDirection * directions);
}

double pixelsOf(const Camera& camera, const Bounds& ws) {
    const double distance = ws.distance(camera.wsPosition);
    const double across = glm::length(ws.size()) / std::numbers::sqrt3 / std::max(pixelAt(camera, distance), 1e-300);
    return across * across;
}

int renderCount(const ViewScene& scene) {
    return scene.lens ? scene.lens->samples : scene.shutter ? scene.shutter->samples : 1;
}

double roughPictureSeconds(const ViewScene& scene, const Plan& plan, int threads) {
    const double beside = scatterSeconds(plan.transport) + cellLightSeconds(scene, plan.cellLights) +
                          lampSeconds(scene, plan) + surfaceSeconds(scene, plan);
    return renderCount(scene) * (expectedSeconds(scene, plan, threads) + beside / threads);
}

std::string costWarning(const ViewScene& scene, const Plan& plan, std::size_t fieldBytes, int threads) {
    constexpr double kLong = 600;  // seconds
    constexpr std::size_t kMuch = std::size_t{4} << 30;
    const double seconds = roughPictureSeconds(scene, plan, threads);
    const std::size_t bytes = plan.bytes + fieldBytes;
    // Whoever states a limit of memory has been asked.
    const bool large = bytes > kMuch && scene.memoryLimit == 0;
    if (seconds <= kLong && !large) return "";
    const double scattered = renderCount(scene) * scatterSeconds(plan.transport) / threads;
    std::string text =
        fmt::format("the picture is expected to take about {} and {}", timeText(seconds), bytesText(bytes));
    if (scattered > 0.5 * seconds)
        return text + fmt::format(
                          "; most of it is for {:.2g} million cells of scattered light, and a coarser preset, a "
                          "larger scatter_cell or a smaller density needs fewer",
                          plan.transport.cells / 1e6);
    return text + "; a coarser preset or a smaller picture takes less";
}

}  // namespace scrim
