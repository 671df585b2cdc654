// SPDX-License-Identifier: Apache-2.0
#include <scrim/verify/light_cell_pilot.h>

#include <scrim/engine/model/sub_lights.h>
#include <scrim/engine/passes/light_cells.h>
#include <scrim/engine/plan/expected_cost.h>
#include <scrim/engine/plan/transport_plan.h>
#include <scrim/verify/seen_cells.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace scrim {
namespace {

constexpr int kDirections = 24;  // that stand for a light on cells
constexpr int kFew = 3;          // points that stand for another light

// The scene whose lights on cells have few directions.
ViewScene withFewDirections(ViewScene scene, const CellLightPlan& plan) {
    for (const int i : plan.lights) {
        Light& light = scene.lights[std::size_t(i)];
        light.samples = std::min(subLightCount(scene, light), kDirections);
    }
    return scene;
}

// The scene with the lights that are not on cells.
ViewScene withLightsBeside(ViewScene scene, const CellLightPlan& plan) {
    for (const int i : plan.lights) scene.lights[std::size_t(i)].intensity = Rgb(0);
    return withFewSubLights(scene, kFew);
}

bool mayGrow(const ViewScene& scene) {
    constexpr std::size_t kMostVolumes = 500;  // the rays ask each of them
    return !scene.dials.lightCell && scene.volumes.size() <= kMostVolumes &&
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
    if (plan.levels.size() != 1 || cellLightSeconds(scene, plan) < worthwhile) return std::nullopt;
    const ViewScene few = withFewDirections(scene, plan);
    const double planned = plan.levels.front().smallest();
    const auto onCells = [&](double larger) {
        CellLightWork work;
        return lightOnCells(
            LevelScene(few), plan.lights, larger * planned, Simd(scene.dials.simd), [] {}, work);
    };
    const SeenCells seen = seenCells(withLightsBeside(scene, plan), onCells(kFine), onCells(kCoarse));
    const auto errorOf = [&](double larger) {
        return kOfDifference * seen.difference * std::pow(larger / kCoarse, kOrder);
    };
    for (const double larger : {2.0, std::sqrt(2.0)})
        if (errorOf(larger) <= error)
            return LightCellChoice{std::round(100 * larger * planned / voxelUnit(scene)) / 100, errorOf(larger)};
    return std::nullopt;
}

}  // namespace scrim
