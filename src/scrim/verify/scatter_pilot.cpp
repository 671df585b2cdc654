// SPDX-License-Identifier: Apache-2.0
#include <scrim/verify/scatter_pilot.h>

#include <scrim/base/percent.h>
#include <scrim/engine/model/served_lights.h>
#include <scrim/engine/model/sub_lights.h>
#include <scrim/engine/plan/transport_plan.h>
#include <scrim/engine/cells/cell_levels.h>
#include <scrim/engine/cells/ordinates.h>
#include <scrim/engine/solve/scatter_domains.h>
#include <scrim/engine/solve/scattered_light.h>
#include <scrim/scene/optics.h>
#include <scrim/verify/pilot_volume.h>
#include <scrim/verify/seen_cells.h>
#include <scrim/volume/coarser.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace scrim {
namespace {

constexpr double kFewestAlong = 24, kMostAlong = 50;  // cells of the finer solve along the volumes' longest edge
constexpr int kLights = 3;                            // points that represent an extended light
constexpr double kCoarsest = 6;                       // cells that are chosen, voxels

// True if some of a light's cone may meet the box.
bool mayMeet(const Light& light, const Bounds& ws) {
    const Light::Spot* spot = light.spot();
    if (spot == nullptr) return true;
    const Vec3 way = ws.center() - light.wsPosition;
    const double distance = glm::length(way), radius = 0.5 * glm::length(ws.size());
    if (distance <= radius) return true;
    const double angle = std::acos(std::clamp(glm::dot(way, light.wsDirection) / distance, -1.0, 1.0));
    return angle - std::asin(radius / distance) < glm::radians(0.5 * spot->coneAngle);
}

// Of very many small lights the brightest, with the light of all: solves take time for each.
void keepBrightest(ViewScene& scene) {
    constexpr std::size_t kMost = 24;
    const Bounds ws = wsBounds(scene);
    std::vector<std::pair<double, Light*>> small;
    double all = 0, kept = 0;
    for (Light& light : scene.lights) {
        if (light.dome() || light.area()) continue;
        all += small.emplace_back(mayMeet(light, ws) ? irradianceAt(light, ws) : 0, &light).first;
    }
    if (small.size() <= kMost) return;
    std::ranges::stable_sort(small, std::greater<>(), [](const auto& light) { return light.first; });
    for (std::size_t i = 0; i < kMost; ++i) kept += small[i].first;
    if (kept == 0) return;
    for (std::size_t i = 0; i < small.size(); ++i) small[i].second->intensity *= i < kMost ? all / kept : 0;
}

// The scene with a few points for each light. Pictures add up of which each holds out what the
// other shows: cells must be the same in both.
ViewScene roughly(const ViewScene& scene, Skies skies) {
    ViewScene few = withFewSubLights(scene, kLights, skies);
    few.layers.clear();
    for (ViewVolume& volume : few.volumes) volume.holdout = false;
    keepBrightest(few);
    return few;
}

ViewScene withCells(const ViewScene& scene, double cell, int directions = kOrdinateCounts[0]) {
    ViewScene with = scene;
    with.dials.scatterCell = cell;
    with.dials.scatterDirections = directions;
    with.memoryLimit = 0;
    return with;
}

// The voxels along the longest edge of volumes that are solved for together.
double mostVoxelsAlong(const ViewScene& scene) {
    double most = 1;
    for (const ScatterDomain& domain : scatterDomains(scene, 1)) {
        const ViewScene own = withVoxelsOf(scene, domain.volumes);
        most = std::max(most, largest(wsOccupiedSize(own)) / voxelUnit(own));
    }
    return most;
}

// True if a pilot with such cells takes little memory. `limited`: it does, but more than the memory limit leaves.
bool isSmall(const ViewScene& scene, double cell, bool& limited) {
    constexpr std::size_t kMostBytes = 500'000'000;
    const std::size_t most = scene.memoryLimit > 0 ? std::min(kMostBytes, scene.memoryLimit / 2) : kMostBytes;
    const std::size_t bytes = planTransport(withCells(scene, cell)).bytes;
    limited = bytes > most && bytes <= kMostBytes;
    return bytes <= most;
}

// Cells must resolve how light passes through the thinnest volume; pilots' larger ones all miss it,
// and hardly differ. In a layer of about 4 voxels cells of 2, 1 and 0.5 voxels left 11, 2.4 and 1.9
// %, and in ground fog of 12 flat ones cells of 5, 4 and 3 left 10, 5 and 1.3.
constexpr double kAcross = 5;

// The number of layers of voxels across an axis of a grid that hold what it holds: n where n hold
// the same. Thick grids count as all of their layers.
double layersAcross(const SparseField& field, int axis) {
    constexpr double kThick = 64;
    constexpr std::size_t kFew = 4096;  // blocks that are looked at
    const Bounds is = field.isBounds();
    const double all = is.size()[axis] + 1;
    if (all > kThick || !field.tiles.empty() || field.blockCount() == 0) return all;
    std::vector<double> layers(static_cast<std::size_t>(all) + kBlockEdge);
    const std::size_t step = std::max<std::size_t>(1, field.blockCount() / kFew);
    for (std::size_t b = 0; b < field.blockCount(); b += step)
        for (int n = 0; n < kBlockVoxels; ++n) {
            const Int3 inside(n / (kBlockEdge * kBlockEdge), n / kBlockEdge % kBlockEdge, n % kBlockEdge);
            const double layer = field.blockOrigins[b][axis] + inside[axis] - is.lower[axis];
            const auto at = static_cast<std::size_t>(std::clamp(layer, 0.0, double(layers.size() - 1)));
            layers[at] += double(field.block(b)[n]);
        }
    double sum = 0, squares = 0;
    for (const double layer : layers) sum += layer, squares += layer * layer;
    return squares > 0 ? sum * sum / squares : all;
}

// Sets ScatterPilot::layers and, as far as memory allows, ScatterPilot::thickest.
void lookAtThickness(const ViewScene& scene, ScatterPilot& pilot) {
    for (const ViewVolume& volume : scene.volumes) {
        if (!scattersFully(volume) || volume.field->empty()) continue;
        const Vec3 edges = voxelEdges(volume.wsFromIs) / voxelUnit(volume);
        for (int axis = 0; axis < 3; ++axis)
            pilot.layers = std::min(pilot.layers, edges[axis] * layersAcross(*volume.field, axis));
    }
    bool limited = false;
    pilot.thickest = pilot.layers / kAcross;
    while (pilot.thickest < pilot.layers && !isSmall(scene, pilot.thickest, limited)) pilot.thickest *= 1.2;
}

// The scene without light that enters at the border.
ViewScene withoutSkies(ViewScene scene) {
    scene.ambient = Rgb(0);
    for (std::size_t i = 0; i < scene.lights.size(); ++i)
        if (entersAtBorder(scene, i)) scene.lights[i].intensity = Rgb(0);
    return scene;
}

bool hasSkies(const ViewScene& scene) {
    return scene.ambient != Rgb(0) || std::ranges::any_of(scene.lights, [&](const Light& light) {
               return light.intensity != Rgb(0) && entersAtBorder(scene, std::size_t(&light - scene.lights.data()));
           });
}

bool anyFire(const ViewScene& scene) {
    return std::ranges::any_of(scene.volumes, [](const ViewVolume& volume) {
        return std::ranges::any_of(volume.emission, [](const ViewEmission& e) { return !e.field.field->empty(); });
    });
}

std::vector<CellLight> solved(const ViewScene& with) {
    TransportPlan plan = planTransport(with);
    plan.coarse = true;
    plan.brightest = true;
    Solved solved;
    std::size_t bytes = 0;
    return scatteredLight(with, plan, {}, {}, solved, bytes);
}

}  // namespace

// The power of their edge by which the error of cells grows.
double ScatterPilot::order() const {
    return surfaces ? 1.3 : 1.6;
}

double ScatterPilot::byDifference(double cell) const {
    // In smoke by lot (tests/tools/bench/promises_scenes.py) and in a ball of smoke of 64 voxels, cells of 1.5 to 4
    // voxels left 0.2 to 0.48 of this; in a brain, cells of 1.1 and 2.3 voxels 1.4 and 1.6. Skies have all of their
    // light on cells, which blur where it first scatters, too: in smoke, a dense plume and a hundred balls under a
    // dome, cells of 1 to 4 voxels left 0.3 to 0.95.
    const double ofMedia = 0.45 + ofSkies * (0.8 - 0.45);
    return (surfaces ? 1.6 : ofMedia) * difference * std::pow(cell / edge, order());
}

double ScatterPilot::ofCells(double cell) const {
    constexpr double kOfTwo = 0.1, kClearly = 1.1;  // see kAcross
    const double left = byDifference(cell);
    return kAcross * cell > kClearly * layers ? std::max(left, kOfTwo * std::pow(2 * cell / layers, order())) : left;
}

double ScatterPilot::ofDirections(std::size_t i) const {
    // In clouds of g = 0.75 and 0.9, 64 and 128 ordinates left 0.07 to 0.15 of this and 256 ones
    // 0.05 to 0.09; in a ball 29 mean free paths thick of g = 0.9, 256 ones left about 0.12.
    constexpr double kPerStraight[] = {0.2, 0.2, 0.12};
    // Ray effects: bright spots send light along ordinates, and none between them. Cells as large
    // as the pilot's blur them: beside 1,024 ordinates, 24 scenes by lot had 0.2 to 3.1 of this
    // with 64 (half of them at most 1.6), 0.2 to 1.8 with 128 (0.7), and 0.1 to 1.3 with 256 (0.3).
    constexpr double kPerRayEffect[] = {2.2, 1.0, 0.45};
    return std::max(kPerStraight[i] * straight[i] * share, kPerRayEffect[i] * rayEffects);
}

std::optional<ScatterPilot> scatterPilot(const ViewScene& given) {
    if (given.dials.scatterCell && given.dials.scatterDirections) return std::nullopt;
    if (std::none_of(given.volumes.begin(), given.volumes.end(), scattersFully)) return std::nullopt;
    ScatterPilot pilot;
    pilot.surfaces = scattersInSurfaces(given);
    for (const ViewVolume& volume : given.volumes) {
        if (!scattersFully(volume)) continue;
        for (std::size_t i = 0; i < pilot.straight.size(); ++i)
            pilot.straight[i] = std::max(
                pilot.straight[i], SplitPhase(volume.medium.phase, resolvedMoments(kOrdinateCounts[i])).straight());
    }
    // Skies enter the solves whole, at their border. What rays see beside the solves is what buffers serve.
    const ViewScene scene = roughly(given, Skies::whole), seenBeside = roughly(given, Skies::parted);
    const double longest = mostVoxelsAlong(scene);
    lookAtThickness(scene, pilot);
    pilot.edge = 2 * std::max(longest / kFewestAlong, 1.0);
    std::vector<CellLight> coarse = solved(withCells(scene, 2 * pilot.edge)),
                           fine = solved(withCells(scene, pilot.edge));
    SeenCells seen = seenCells(seenBeside, fine, coarse);
    if (hasSkies(scene)) {
        const SeenCells lights = seenCells(seenBeside, coarse, solved(withCells(withoutSkies(scene), 2 * pilot.edge)));
        if (lights.share > 0) pilot.ofSkies = std::clamp(1 - lights.other / lights.share, 0.0, 1.0);
    }
    // Cells that are too large for what is in a volume all miss it, and hardly differ: in a cloud of 350 voxels by 20,
    // 16, 17 and 13 % with cells of 29, 15, 7 and 4 voxels. Then finer ones tell more: on a cloud of 200 voxels the
    // error was 3.8 % with the cells that those of 8 voxels suggest, and 1.8 % with those that 4 do, where 2 % are
    // promised. Under a dome, cells of 19 and 9 voxels of dense smoke differed by 7.4 %, and those of 9 were 14 % off.
    constexpr double kFalls = 0.6, kMostlySkies = 0.5;
    double before = 0;
    do {
        coarse = std::move(fine);
        before = seen.difference;
        pilot.edge /= 2;
        fine = solved(withCells(scene, pilot.edge));
        seen = seenCells(seenBeside, fine, coarse);
    } while ((seen.difference > kFalls * before || pilot.ofSkies > kMostlySkies) && pilot.edge >= 2 &&
             longest / pilot.edge < kMostAlong / 2 && isSmall(scene, pilot.edge / 2, pilot.limited));
    // Walls are as coarse as cells, and lie anywhere in them: of two pairs of solves one may agree by chance. A room of
    // 20 voxels with a window: 10 % too dark with cells of 2.4 voxels, 11 % too bright with 1.7, and 1 % with 4.
    constexpr double kOfWalls = 0.5;
    const double least = solidsBlock(scene) ? kOfWalls * before : 0;
    if (least > seen.difference) seen.ofEach *= least / seen.difference;
    pilot.difference = std::max(seen.difference, least);
    pilot.ofEach = seen.ofEach;
    pilot.share = seen.share;
    pilot.rayEffects = seenCells(seenBeside, fine, solved(withCells(scene, pilot.edge, kOrdinateCounts[1]))).difference;
    // Fire that is small from where it is seen lights by a few ordinates or none: smoke of 1.2 units, 12 units from a
    // ball of fire of 4, had from none to 12 times its light. Solves that find none are then alike.
    constexpr double kMissed = 2.2, kMost = 10;
    if (seen.share == 0 && seen.other == 0 && anyFire(scene)) pilot.rayEffects = kMissed;
    for (double* error : {&pilot.difference, &pilot.ofEach, &pilot.rayEffects}) *error = std::min(*error, kMost);
    return pilot;
}

namespace {

// The nearest of the steps by a quarter of an octave, rounded down to a hundredth so that it is easy to read and to
// type again. Frames of a sequence, whose pilots differ a little, so have the same cells: with cells of 1.03, 1.02
// and 1.01 voxels in three frames, light that had scattered changed by 4 % from frame to frame, and by 0.5 % with one
// size.
double steadyCell(double cell) {
    constexpr double kStepsOfAnOctave = 4;
    return std::floor(100 * std::exp2(std::round(kStepsOfAnOctave * std::log2(cell)) / kStepsOfAnOctave)) / 100;
}

}  // namespace

ScatterChoice chooseScattering(const ScatterPilot& pilot, const Dials& dials, double error) {
    // Where directions alone leave more than is promised, cells much finer than that would cost time for nothing. What
    // directions leave is smooth, though, and cells blur relief and thin rims: lit from behind with g = 0.85, Disney's
    // cloud (0.15 of optical depth a voxel) is 3.5, 2.4 and 2.0 % off with cells of 4, 2.8 and 2 voxels, and 1.8 % off
    // with cells of one. So cells get half of what is promised at least. Nor are cells as fine as the brightest pixels
    // ask, where these have nearly all of the error: with a lamp in that cloud, and droplets, one pixel of 1000 times
    // the mean asked for cells of half a voxel (95 s and 15 GB).
    constexpr double kLeast = 0.5, kMostOfDirections = 0.866;
    // Time relative to 64 ordinates: more of them are in the last sweep only, or half of them are.
    constexpr double kCost[] = {1, 1.6, 2.2};
    const auto cellBeside = [&](double ofDirections) {
        const double left =
            std::max(std::sqrt(std::max(error * error - ofDirections * ofDirections, 0.0)), kLeast * error);
        double cell = kCoarsest, all = pilot.byDifference(pilot.edge);
        if (ofDirections > error && pilot.ofEach < pilot.difference) all *= pilot.ofEach / pilot.difference;
        if (pilot.difference > 0) cell = pilot.edge * std::pow(left / all, 1 / pilot.order());
        cell = steadyCell(std::min({cell, kCoarsest, 2 * pilot.edge, std::max(pilot.thickest, kFinestScatterCell)}));
        return dials.scatterCell.value_or(std::max(cell, kFinestScatterCell));
    };
    const auto costOf = [&](std::size_t i) { return kCost[i] / std::pow(cellBeside(pilot.ofDirections(i)), 3); };
    std::optional<std::size_t> chosen;
    for (std::size_t i = 0; i < std::size(kOrdinateCounts); ++i) {
        if (dials.scatterDirections && *dials.scatterDirections != kOrdinateCounts[i]) continue;
        // Few directions with fine cells may cost less than many with coarse ones.
        const bool enough = chosen && pilot.ofDirections(*chosen) <= kMostOfDirections * error;
        if (!enough || costOf(i) < costOf(*chosen)) chosen = i;
    }
    const std::size_t i = *chosen;
    ScatterChoice choice{cellBeside(pilot.ofDirections(i)), kOrdinateCounts[i], 0, {}};
    const double ofCells = pilot.ofCells(choice.cell), directions = pilot.ofDirections(i);
    choice.expected = std::hypot(ofCells, directions);
    choice.limited = pilot.limited && !dials.scatterCell;
    choice.why = fmt::format(
        "cells of {:.4g} voxels are expected to leave {} %, since solves with cells of {:.3g} and {:.3g} voxels "
        "differ by {} %; {} directions leave {} %, since solves along 64 and 128 directions differ by {} %, and {} % "
        "of the light goes on too straight for {}",
        choice.cell, percentText(ofCells), pilot.edge, 2 * pilot.edge, percentText(pilot.difference), choice.directions,
        percentText(directions), percentText(pilot.rayEffects), percentText(pilot.straight[i]), choice.directions);
    return choice;
}

}  // namespace scrim
