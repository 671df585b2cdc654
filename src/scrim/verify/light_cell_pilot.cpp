// SPDX-License-Identifier: Apache-2.0
#include <scrim/verify/light_cell_pilot.h>

#include <scrim/engine/model/sub_lights.h>
#include <scrim/engine/passes/light_cells.h>
#include <scrim/engine/plan/expected_cost.h>
#include <scrim/engine/plan/transport_plan.h>
#include <scrim/scene/phase_over_caps.h>
#include <scrim/verify/seen_cells.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <vector>

namespace scrim {
namespace {

constexpr int kDirections = 24;  // that stand for a light on cells
constexpr int kFew = 3;          // points that stand for another light

// The scene whose lights on cells have few directions. Lobes that are as wide as the many caps of a sky, but narrower
// than the few, would take rays from every cell (passes/sky_peaks.h): they become even.
ViewScene withFewDirections(ViewScene scene, const CellLightPlan& plan) {
    for (const int i : plan.lights) {
        Light& light = scene.lights[std::size_t(i)];
        const int directions = subLightCount(scene, light);
        light.samples = std::min(directions, kDirections);
        for (ViewVolume& volume : scene.volumes)
            if (light.dome() && !needsCaps(volume.medium.phase, capOf(4 * std::numbers::pi / directions)))
                volume.medium.phase = {};
    }
    return scene;
}

// The scene with the lights that are not on cells.
ViewScene withLightsBeside(ViewScene scene, const CellLightPlan& plan) {
    for (const int i : plan.lights) scene.lights[std::size_t(i)].intensity = Rgb(0);
    return withFewSubLights(scene, kFew);
}

// The scene with cells so many times larger than the plan's: the smallest, and those of other levels.
ViewScene withLarger(ViewScene scene, double planned, double smallest, double others) {
    scene.dials.lightCell = smallest * planned;
    scene.dials.lightCellOthers = others;
    return scene;
}

// Light on cells by the levels that it is on.
struct ByLevel {
    std::vector<CellLight> smallest, others;
};

// The light of `few` on the cells that `scene` has.
ByLevel onCells(const ViewScene& scene, const ViewScene& few) {
    const CellLightPlan plan = planCellLights(scene);
    const std::size_t finest = finestLevel(plan);
    ByLevel out;
    CellLightWork work;
    for (std::size_t l = 0; l < plan.levels.size(); ++l)
        std::ranges::move(
            lightOnCells(
                LevelScene(few, plan, l), plan.lights, plan.levels[l].smallest(), Simd(scene.dials.simd), [] {}, work),
            std::back_inserter(l == finest ? out.smallest : out.others));
    return out;
}

std::vector<CellLight> sum(const std::vector<CellLight>& a, const std::vector<CellLight>& b) {
    std::vector<CellLight> all = a;
    all.insert(all.end(), b.begin(), b.end());
    return all;
}

bool mayGrow(const ViewScene& scene) {
    constexpr std::size_t kMostVolumes = 500;  // the rays ask each of them
    return !scene.dials.lightCell && !scene.dials.lightCellOthers && scene.volumes.size() <= kMostVolumes &&
           std::ranges::none_of(scene.volumes, [](const ViewVolume& volume) {
               return volume.classified != nullptr || scattersFully(volume);
           });
}

}  // namespace

std::optional<LightCellChoice> largerLightCells(const ViewScene& given, double error, double worthwhile) {
    // The pilot's cells are two and four times as large as the plan's, and have few directions: they take about a tenth
    // of the time. If the error grows with the power kOrder of the edge, the larger ones leave 1.5 times what the
    // pilot sees. Beside cells half as large as the plan's, ten plumes under a sun and a sky had 0.28 % with twice the
    // plan's, and forty 0.34 and 0.62 % with 1.4 times and twice; 0.30, 0.33 and 0.57 % are foreseen.
    constexpr double kFine = 2, kCoarse = 4, kOrder = 1.6, kOfDifference = 1.5;
    if (!mayGrow(given)) return std::nullopt;
    ViewScene scene = given;
    scene.layers.clear();
    scene.memoryLimit = 0;
    const CellLightPlan plan = planCellLights(scene);
    if (plan.levels.empty() || cellLightSeconds(scene, plan) < worthwhile) return std::nullopt;
    const double planned = smallestCell(scene, plan);
    const ViewScene few = withFewDirections(scene, plan), beside = withLightsBeside(scene, plan);
    const ByLevel fine = onCells(withLarger(scene, planned, kFine, kFine), few),
                  coarse = onCells(withLarger(scene, planned, kCoarse, kCoarse), few);
    const std::vector<CellLight> all = sum(fine.smallest, fine.others);
    const double ofSmallest = seenCells(beside, all, sum(coarse.smallest, fine.others)).difference;
    const double ofOthers =
        fine.others.empty() ? 0 : seenCells(beside, all, sum(fine.smallest, coarse.others)).difference;
    const auto errorOf = [&](double difference, double larger) {
        return larger > 1 ? kOfDifference * difference * std::pow(larger / kCoarse, kOrder) : 0;
    };
    // The least time counts, and where it is about the same, the least error.
    constexpr double kClearly = 0.9;
    std::optional<LightCellChoice> best;
    double least = kClearly * cellLightSeconds(scene, plan);
    for (const double smallest : {1.0, std::numbers::sqrt2, 2.0})
        for (const double others : {1.0, std::numbers::sqrt2, 2.0}) {
            const double expected = errorOf(ofSmallest, smallest) + errorOf(ofOthers, others);
            if (expected > error) continue;
            const ViewScene larger = withLarger(scene, planned, smallest, others);
            const double seconds = cellLightSeconds(larger, planCellLights(larger));
            if (seconds > least || (best && seconds > kClearly * least && expected >= best->expected)) continue;
            least = std::min(least, seconds);
            best = {std::round(100 * smallest * planned) / 100, std::round(100 * others) / 100, expected};
        }
    return best;
}

}  // namespace scrim
