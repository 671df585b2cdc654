// SPDX-License-Identifier: Apache-2.0
#include <scrim/verify/light_cell_pilot.h>

#include <scrim/engine/model/sub_lights.h>
#include <scrim/engine/passes/light_cells.h>
#include <scrim/engine/plan/expected_cost.h>
#include <scrim/engine/plan/transport_plan.h>
#include <scrim/scene/phase_over_caps.h>
#include <scrim/verify/pilot_volume.h>
#include <scrim/verify/seen_cells.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
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

bool mayDiffer(const ViewScene& scene) {
    constexpr std::size_t kMostVolumes = 500;  // the rays ask each of them
    return !scene.dials.lightCell && !scene.dials.lightCellOthers && scene.volumes.size() <= kMostVolumes &&
           std::ranges::none_of(scene.volumes, [](const ViewVolume& volume) {
               return volume.classified != nullptr || scattersFully(volume);
           });
}

// What cells leave of the picture, by how many times as large as the plan's they are. Cells twice
// and four times as large differ by `ofSmallest` and `ofOthers`.
struct LeftByCells {
    double ofSmallest, ofOthers;

    // If the error grows with the power 1.6 of the edge, those four times as large leave 1.5 times what the pilot sees.
    // Beside cells half as large as the plan's, ten plumes under a sun and a sky had 0.28 % with twice the plan's, and
    // forty 0.34 and 0.62 % with 1.4 times and twice; 0.30, 0.33 and 0.57 % are foreseen.
    double at(double smallest, double others) const { return at(smallest, others, kOrder); }
    // The most that smaller cells leave. A volume that a lamp is in throws the shadows of its own structure on larger
    // cells, which miss it until they are as fine: in haze around two balls 1, 0.5 and 0.25 of the plan's left 5.4, 1.9
    // and 0.8 % where 3.9, 2.0 and 1.0 are foreseen, and 1.7, 0.7 and 0.6 % where it was 7, 3.6 and 1.8.
    double atMost(double smallest, double others) const { return at(smallest, others, 1); }

  private:
    static constexpr double kCoarse = 4, kOrder = 1.6, kOfDifference = 1.5;
    double at(double smallest, double others, double order) const {
        return kOfDifference *
               (ofSmallest * std::pow(smallest / kCoarse, kOrder) + ofOthers * std::pow(others / kCoarse, order));
    }
};

// A choice of cells by the least time; where it is about the same, by the least error.
class Cheapest {
  public:
    explicit Cheapest(double most) : m_least(most) {}
    void offer(const LightCellChoice& choice, double seconds) {
        constexpr double kClearly = 0.9;
        if (seconds > m_least || (m_best && seconds > kClearly * m_least && choice.expected >= m_best->expected))
            return;
        m_least = std::min(m_least, seconds);
        m_best = choice;
    }
    const std::optional<LightCellChoice>& choice() const { return m_best; }

  private:
    double m_least;
    std::optional<LightCellChoice> m_best;
};

// True if a point or a sphere is on cells: what shines from elsewhere throws softer shadows than
// cells have edges. (A glowing mesh beside a ball in haze left 0.99 %, where 3 were foreseen.)
bool anyLamp(const ViewScene& scene, const CellLightPlan& plan) {
    return std::ranges::any_of(plan.lights, [&](int i) { return isLamp(scene.lights[std::size_t(i)]); });
}

// Smaller cells must be needed clearly, and may take only so much more time.
constexpr double kNeeded = 2;

// The cheapest of smaller cells that leave little more than `error`; if none do, those that leave least. `planned`: the
// plan's smallest cell, voxels, whose light takes `planSeconds`; `secondsAt`: what other cells take.
std::optional<LightCellChoice> smallerCells(const LeftByCells& left, double error, double planned, double planSeconds,
                                            const std::function<double(double, double)>& secondsAt) {
    constexpr double kTimes = 2, kMore = 1, kSmallest = 0.25;
    constexpr double kSmaller[] = {1, 0.71, 0.5, 0.35, 0.25};
    Cheapest enough(std::numeric_limits<double>::infinity());
    std::optional<LightCellChoice> finest;
    double least = std::numeric_limits<double>::infinity();
    for (const double smallest : kSmaller)
        for (const double others : kSmaller) {
            if (smallest < 1 && smallest * planned < kSmallest) continue;
            const double seconds = secondsAt(smallest, others), most = left.atMost(smallest, others);
            if (seconds > std::max(kTimes * planSeconds, planSeconds + kMore)) continue;
            const LightCellChoice choice{smallest * planned, others, left.at(smallest, others)};
            if (most <= kNeeded * error) enough.offer(choice, seconds);
            if (most < least) least = most, finest = choice;
        }
    return enough.choice() ? enough.choice() : finest;
}

std::optional<LightCellChoice> exactChoice(const ViewScene& given, double error, double worthwhile) {
    // The pilot's cells are two and four times as large as the plan's, and have few directions:
    // they take about a tenth of the time.
    constexpr double kFine = 2, kCoarse = 4;
    if (!mayDiffer(given)) return std::nullopt;
    ViewScene scene = given;
    scene.layers.clear();
    scene.memoryLimit = 0;
    const CellLightPlan plan = planCellLights(scene);
    const double planSeconds = cellLightSeconds(scene, plan);
    if (plan.levels.empty()) return std::nullopt;
    if (planSeconds < worthwhile && (plan.levels.size() < 2 || !anyLamp(scene, plan))) return std::nullopt;
    const double planned = smallestCell(scene, plan);
    const ViewScene few = withFewDirections(scene, plan), beside = withLightsBeside(scene, plan);
    const ByLevel fine = onCells(withLarger(scene, planned, kFine, kFine), few),
                  coarse = onCells(withLarger(scene, planned, kCoarse, kCoarse), few);
    const std::vector<CellLight> all = sum(fine.smallest, fine.others);
    const LeftByCells left{
        seenCells(beside, all, sum(coarse.smallest, fine.others)).difference,
        fine.others.empty() ? 0 : seenCells(beside, all, sum(fine.smallest, coarse.others)).difference};
    const auto secondsAt = [&](double smallest, double others) {
        const ViewScene tried = withLarger(scene, planned, smallest, others);
        return cellLightSeconds(tried, planCellLights(tried));
    };

    if (plan.levels.size() > 1 && anyLamp(scene, plan) && left.atMost(1, 1) > kNeeded * error)
        return smallerCells(left, error, planned, planSeconds, secondsAt);
    constexpr double kClearly = 0.9;
    if (planSeconds < worthwhile) return std::nullopt;
    Cheapest cheapest(kClearly * planSeconds);
    constexpr double kLarger[] = {1, std::numbers::sqrt2, kFine, kFine * std::numbers::sqrt2, kCoarse};
    for (const double smallest : kLarger)
        for (const double others : kLarger) {
            // What the plan's own cells leave is no part of this.
            const double expected = left.at(smallest > 1 ? smallest : 0, others > 1 ? others : 0);
            if (expected <= error) cheapest.offer({smallest * planned, others, expected}, secondsAt(smallest, others));
        }
    return cheapest.choice();
}

}  // namespace

std::optional<LightCellChoice> chosenLightCells(const ViewScene& scene, double error, double worthwhile) {
    // Rounded so that the setting is easy to read and to type again.
    std::optional<LightCellChoice> choice = exactChoice(scene, error, worthwhile);
    if (choice)
        for (double* dial : {&choice->cell, &choice->others}) *dial = std::round(100 * *dial) / 100;
    return choice;
}

}  // namespace scrim
