// SPDX-License-Identifier: Apache-2.0
#include <scrim/verify/scatter_pilot.h>

#include <scrim/base/parallel.h>
#include <scrim/engine/model/sub_lights.h>
#include <scrim/engine/plan/transport_plan.h>
#include <scrim/engine/cells/cell_levels.h>
#include <scrim/engine/cells/ordinates.h>
#include <scrim/engine/solve/scatter_domains.h>
#include <scrim/engine/solve/scattered_light.h>
#include <scrim/scene/light_at.h>
#include <scrim/scene/optics.h>
#include <scrim/verify/pilot_rays.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include <fmt/format.h>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

constexpr double kFewestAlong = 24, kMostAlong = 50;  // cells of the finer solve along the volumes' longest edge
constexpr int kRays = 64, kTries = 8;                 // rays that see something, and rays for each of them at most
constexpr int kSteps = 64;                            // along a ray through the volumes
constexpr int kLights = 3;                            // points that represent an extended light
constexpr double kOpaque = 1e-4;                      // transmittance at which a ray ends
constexpr double kCoarsest = 6;                       // cells that are chosen, voxels

double grey(const Rgb& v) {
    return (v.x + v.y + v.z) / 3;
}

// The scene as the rays of the pilot see it.
class Look {
  public:
    Look(const ViewScene& scene, const std::vector<CellLight>& fine, const std::vector<CellLight>& coarse)
        : m_scene(scene), m_solves{&fine, &coarse}, m_bounds(wsBounds(scene)), m_voxel(voxelUnit(scene)) {
        FieldSamplers samplers;
        for (const ViewVolume& volume : scene.volumes) m_volumes.emplace_back(volume, scene.dials.kernel, samplers);
        const bool border = skiesFromBorder(scene);
        for (const Light& light : scene.lights)
            if (!border || !light.dome()) m_lights.emplace_back(light);
    }

    // Light that scattered once or was emitted, and by each solve light that scattered more than once.
    struct Seen {
        double direct = 0, again[2] = {0, 0}, alpha = 0;
    };
    Seen along(const Vec3& origin, const Vec3& direction, double near, double jitter) const {
        Seen seen;
        const auto [begin, end] = m_bounds.clip(origin, direction, near, kFar);
        if (!(begin < end)) return seen;
        const double step = (end - begin) / kSteps;
        double left = 1;
        for (int i = 0; i < kSteps && left > kOpaque; ++i) {
            const Vec3 ws = origin + (begin + (i + jitter) * step) * direction;
            const double tau = step * extinction(ws), passed = std::exp(-tau);
            // The light of a step is attenuated within the step.
            add(ws, direction, left * step * (tau > 1e-6 ? (1 - passed) / tau : 1), seen);
            left *= passed;
        }
        seen.alpha = 1 - left;
        return seen;
    }

  private:
    static constexpr double kFar = 1e300;

    double extinction(const Vec3& ws) const {
        double sum = 0;
        for (const VolumeOptics& v : m_volumes) sum += grey(v.extinction(ws));
        return sum;
    }
    void add(const Vec3& ws, const Vec3& direction, double weight, Seen& seen) const {
        for (std::size_t v = 0; v < m_volumes.size(); ++v) {
            seen.direct += weight * grey(m_volumes[v].emission(ws));
            const ViewVolume& volume = m_volumes[v].volume();
            const Rgb scattering = m_volumes[v].scattering(ws);
            if (scattering == Rgb(0) || volume.holdout) continue;
            for (const LightAt& light : m_lights) seen.direct += weight * grey(lit(light, m_volumes[v], ws, direction));
            for (std::size_t s = 0; s < 2; ++s)
                for (const CellLight& light : *m_solves[s]) {
                    if (!light.ofVolume[v]) continue;
                    Real rgb[3];
                    light.ofVolume[v]->sample(ws, rgb);
                    seen.again[s] += weight * grey(scattering * Rgb(rgb[0], rgb[1], rgb[2]));
                }
        }
    }
    // What the volume sends against `direction` of the light that comes straight from a light.
    Rgb lit(const LightAt& light, const VolumeOptics& volume, const Vec3& ws, const Vec3& direction) const {
        constexpr int kShadowSteps = 24;
        const Arriving in = light.at(ws);
        if (in.irradiance == Rgb(0)) return Rgb(0);
        const double end = m_bounds.clip(ws, -in.travel, 0, in.distance).second, step = end / kShadowSteps;
        double tau = 0;
        for (int i = 0; i < kShadowSteps && tau < -std::log(kOpaque); ++i)
            tau += step * extinction(ws - (i + 0.5) * step * in.travel);
        if (volume.volume().classified)
            return std::exp(-tau) * in.irradiance * volume.reflected(ws, m_voxel, -in.travel, -direction);
        const double phase = phaseValue(volume.volume().medium.phase, -glm::dot(in.travel, direction));
        return volume.scattering(ws) * (phase * std::exp(-tau) * in.irradiance);
    }

    const ViewScene& m_scene;
    const std::vector<CellLight>* m_solves[2];
    Bounds m_bounds;
    double m_voxel;
    std::vector<VolumeOptics> m_volumes;
    std::vector<LightAt> m_lights;
};

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
        most = std::max(most, largest(wsBounds(own).size()) / voxelUnit(own));
    }
    return most;
}

// True if a pilot with such cells takes little memory.
bool isSmall(const ViewScene& scene, double cell) {
    constexpr std::size_t kMostBytes = 500'000'000;
    const std::size_t most = scene.memoryLimit > 0 ? std::min(kMostBytes, scene.memoryLimit / 2) : kMostBytes;
    return planTransport(withCells(scene, cell)).bytes <= most;
}

std::vector<CellLight> solved(const ViewScene& with) {
    TransportPlan plan = planTransport(with);
    plan.coarse = true;
    plan.brightest = true;
    Solved solved;
    std::size_t bytes = 0;
    return scatteredLight(with, plan, {}, {}, solved, bytes);
}

// What rays over the whole picture see of two solves: the RMS difference, and the light that scattered more than once,
// relative to all light.
struct Compared {
    double difference = 0, share = 0;
};
Compared compare(const ViewScene& scene, const std::vector<CellLight>& fine, const std::vector<CellLight>& other) {
    const Look eye(scene, fine, other);
    const RayFamily rays = wsRays(scene.camera);
    const Int2 size = scene.camera.resolution;
    double squares = 0, all = 0, again = 0;
    int count = 0;
    for (int first = 0; first < kTries * kRays && count < kRays; first += kRays) {
        std::vector<Look::Seen> seen(kRays);
        parallelFor(seen.size(), [&](std::size_t k) {
            const Vec3 place = pilotPlace(first + static_cast<int>(k));
            const double x = place.x * size.x, y = place.y * size.y;
            seen[k] = eye.along(rays.origin(x, y), glm::normalize(rays.direction(x, y)), rays.near, place.z);
        });
        for (const Look::Seen& s : seen) {
            if (count == kRays || s.alpha < 1e-3) continue;
            ++count;
            squares += std::pow(s.again[0] - s.again[1], 2);
            again += s.again[0];
            all += s.direct + s.again[0];
        }
    }
    if (!(all > 0)) return {};
    return {std::sqrt(squares / count) / (all / count), again / all};
}

}  // namespace

// The power of their edge by which the error of cells grows.
double ScatterPilot::order() const {
    return surfaces ? 1.3 : 1.6;
}

double ScatterPilot::ofCells(double cell) const {
    // In smoke by lot (tests/tools/bench/promises_scenes.py) and in a ball of smoke of 64 voxels, cells of 1.5 to 4
    // voxels left 0.2 to 0.48 of this; in a brain, cells of 1.1 and 2.3 voxels 1.4 and 1.6.
    return (surfaces ? 1.6 : 0.45) * difference * std::pow(cell / edge, order());
}

double ScatterPilot::ofDirections(std::size_t i) const {
    // In clouds of g = 0.75 and 0.9, 64 and 128 ordinates left 0.07 to 0.15 of this and 256 ones 0.05 to 0.09; in a
    // ball 29 mean free paths thick of g = 0.9, 256 ones left about 0.12.
    constexpr double kPerStraight[] = {0.2, 0.2, 0.12};
    // Ray effects: bright spots send light along ordinates, and none between them. Cells as large as the pilot's blur
    // them: beside 1,024 ordinates, 24 scenes by lot had 0.2 to 3.1 of this with 64 (half of them at most 1.6), 0.2 to
    // 1.8 with 128 (0.7), and 0.1 to 1.3 with 256 (0.3).
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
    ViewScene scene = withFewSubLights(given, kLights);
    scene.layers.clear();
    const double longest = mostVoxelsAlong(scene);
    pilot.edge = 2 * std::max(longest / kFewestAlong, 1.0);
    std::vector<CellLight> coarse = solved(withCells(scene, 2 * pilot.edge)),
                           fine = solved(withCells(scene, pilot.edge));
    Compared seen = compare(scene, fine, coarse);
    // Cells that are too large for what is in a volume all miss it, and hardly differ: in a cloud of 350 voxels by 20,
    // 16, 17 and 13 % with cells of 29, 15, 7 and 4 voxels. Then finer ones tell more: on a cloud of 200 voxels the
    // error was 3.8 % with the cells that those of 8 voxels suggest, and 1.8 % with those that 4 do, where 2 % are
    // promised.
    constexpr double kFalls = 0.6;
    double before = 0;
    do {
        coarse = std::move(fine);
        before = seen.difference;
        pilot.edge /= 2;
        fine = solved(withCells(scene, pilot.edge));
        seen = compare(scene, fine, coarse);
    } while (seen.difference > kFalls * before && pilot.edge >= 2 && longest / pilot.edge < kMostAlong / 2 &&
             isSmall(scene, pilot.edge / 2));
    pilot.difference = seen.difference;
    pilot.share = seen.share;
    pilot.rayEffects = compare(scene, fine, solved(withCells(scene, pilot.edge, kOrdinateCounts[1]))).difference;
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
    // Where directions alone leave more than is promised, cells that are much finer would cost time for nothing. What
    // directions leave is smooth, though, and cells blur relief, so these leave no more than is promised: Disney's
    // cloud of droplets, of which directions leave 5 %, differs by 3.2 and 1.2 % from cells of one voxel with cells of
    // 4 and 2, which take 1.6 and 2.7 s.
    constexpr double kBeside = 0.75, kLeast = 0.5, kMostOfDirections = 0.866;
    // Time relative to 64 ordinates: more of them are in the last sweep only, or half of them are.
    constexpr double kCost[] = {1, 1.6, 2.2};
    const auto cellBeside = [&](double ofDirections) {
        const double left = std::max({std::sqrt(std::max(error * error - ofDirections * ofDirections, 0.0)),
                                      kLeast * error, std::min(kBeside * ofDirections, error)});
        double cell = kCoarsest;
        if (pilot.difference > 0) cell = pilot.edge * std::pow(left / pilot.ofCells(pilot.edge), 1 / pilot.order());
        cell = steadyCell(std::min({cell, kCoarsest, 2 * pilot.edge}));
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
    choice.why = fmt::format(
        "cells of {:.4g} voxels are expected to leave {:.2g} %, since solves with cells of {:.3g} and {:.3g} voxels "
        "differ by {:.2g} %; {} directions leave {:.2g} %, since twice 64 change {:.2g} %, and {:.2g} % of the light "
        "goes on too straight for them",
        choice.cell, 100 * ofCells, pilot.edge, 2 * pilot.edge, 100 * pilot.difference, choice.directions,
        100 * directions, 100 * pilot.rayEffects, 100 * pilot.straight[i]);
    return choice;
}

}  // namespace scrim
