// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/kept_light.h>

#include <scrim/base/error.h>
#include <scrim/base/timed.h>
#include <scrim/engine/passes/light_cells.h>
#include <scrim/engine/solve/scattered_light.h>
#include <scrim/scene/field_rays.h>
#include <scrim/scene/phase_over_caps.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

void addSolved(const ViewScene& scene, const Plan& plan, const std::function<void()>& checkpoint, KeptLight& kept) {
    Solved solved;
    kept.light = scatteredLight(scene, plan.transport, plan.simd, checkpoint, solved, kept.work.bytes.scattered);
    kept.scatterError = solved.error;
    kept.scatterConverged = solved.converged;
    kept.work.scatterSweeps = static_cast<std::uint64_t>(solved.sweeps);
    kept.work.scatterDirections = solved.cellDirections;
}

void addExtended(const ViewScene& scene, const Plan& plan, const std::function<void()>& checkpoint, KeptLight& kept) {
    CellLightWork work;
    for (std::size_t l = 0; l < plan.cellLights.levels.size(); ++l) {
        const LevelScene level(scene, plan.cellLights, l);
        std::map<double, std::vector<int>> byEdge;  // lights whose cells have the same size are kept together
        for (std::size_t i = 0; i < plan.cellLights.lights.size(); ++i)
            byEdge[plan.cellLights.levels[l].edges[i]].push_back(plan.cellLights.lights[i]);
        for (const auto& [edge, lights] : byEdge)
            for (CellLight& light : lightOnCells(level, lights, edge, plan.simd, checkpoint, work))
                kept.light.push_back(std::move(light));
    }
    kept.work.bytes.scattered += work.bytes;
    kept.work.cellDirections = work.directions;
}

bool sameField(const ViewField& a, const ViewField& b) {
    return a.field == b.field && a.wsFromIs == b.wsFromIs && a.kernel == b.kernel;
}

bool sameVolume(const ViewVolume& a, const ViewVolume& b) {
    const auto sameSource = [](const ViewEmission& x, const ViewEmission& y) {
        return sameField(x.field, y.field) && x.color == y.color;
    };
    return a.field == b.field && a.wsFromIs == b.wsFromIs && a.kernel == b.kernel && a.medium == b.medium &&
           a.classified == b.classified && std::ranges::equal(a.scatter, b.scatter, sameField) &&
           std::ranges::equal(a.emission, b.emission, sameSource) && a.lights == b.lights && a.shadows == b.shadows &&
           a.holdout == b.holdout;
}

bool sameSolids(const std::shared_ptr<const Solids>& a, const std::shared_ptr<const Solids>& b) {
    return a == b || (a && b && a->all() == b->all());
}

bool sameTransport(const TransportPlan& a, const TransportPlan& b) {
    const auto sameTarget = [](const ScatterTarget& x, const ScatterTarget& y) {
        return x.output == y.output && x.lights == y.lights;
    };
    const auto sameDomain = [](const ScatterDomain& x, const ScatterDomain& y) {
        return x.volumes == y.volumes && x.edge == y.edge;
    };
    return std::ranges::equal(a.targets, b.targets, sameTarget) &&
           std::ranges::equal(a.domains, b.domains, sameDomain) && a.ordinates == b.ordinates;
}

bool sameCells(const CellLightPlan& a, const CellLightPlan& b) {
    const auto sameLevel = [](const CellLevel& x, const CellLevel& y) {
        return x.volumes == y.volumes && x.edges == y.edges;
    };
    return a.lights == b.lights && std::ranges::equal(a.levels, b.levels, sameLevel);
}

// Radians; of surfaces that of Phong's lobe, whose cosine to the power of the exponent falls to exp(-1/2).
double lobeOf(const ViewVolume& volume) {
    if (volume.classified)
        return volume.classified->specular > 0 ? 1 / std::sqrt(std::max(volume.classified->exponent, 1.0))
                                               : std::numbers::pi;
    return volume.medium.phase.isotropic() ? std::numbers::pi : lobeWidth(volume.medium.phase);
}

// The largest angle, radians, between the directions in which two eyes see a point of the box; pi if one is within.
double angleBetween(const Camera& a, const Camera& b, const Bounds& ws) {
    if (a.type != b.type) return std::numbers::pi;
    if (a.type == CameraType::orthographic)
        return std::acos(std::clamp(glm::dot(viewingAxis(a), viewingAxis(b)), -1.0, 1.0));
    const double nearest = ws.distance(a.wsPosition);
    const double way = glm::distance(a.wsPosition, b.wsPosition);
    return way < nearest ? std::asin(way / nearest) : way > 0 ? std::numbers::pi : 0;
}

bool sameTowardsEyes(const ViewVolume& volume, const Camera& a, const Camera& b) {
    constexpr double kPart = 0.1;
    const double lobe = lobeOf(volume);
    return lobe >= std::numbers::pi || volume.field->empty() ||
           angleBetween(a, b, transformed(volume.wsFromIs, volume.field->isBounds())) <= kPart * lobe;
}

}  // namespace

KeptLight keepLight(const ViewScene& scene, const Plan& plan, const ProgressSink& progress) {
    KeptLight kept;
    if (plan.groups.empty()) return kept;
    const auto goOn = [&] {
        if (progress && !progress(0)) throw Error(ErrorKind::interrupted, "the render was interrupted");
    };
    timed(kept.seconds, [&] {
        if (plan.transport.any()) addSolved(scene, plan, goOn, kept);
        addExtended(scene, plan, goOn, kept);
    });
    return kept;
}

void account(const KeptLight& kept, Frame& frame) {
    frame.scatterError = std::max(frame.scatterError, kept.scatterError);
    frame.scatterConverged = frame.scatterConverged && kept.scatterConverged;
    frame.work += kept.work;
    frame.times.scatter += kept.seconds;
}

bool lightServes(const ViewScene& scene, const Plan& plan, const ViewScene& other, const Plan& otherPlan) {
    return scene.lights == other.lights && scene.ambient == other.ambient && sameSolids(scene.solids, other.solids) &&
           sameTransport(plan.transport, otherPlan.transport) && sameCells(plan.cellLights, otherPlan.cellLights) &&
           std::ranges::equal(scene.volumes, other.volumes, sameVolume) &&
           std::ranges::all_of(scene.volumes, [&](const ViewVolume& volume) {
               return sameTowardsEyes(volume, scene.camera, other.camera);
           });
}

}  // namespace scrim
