// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/passes/sources.h>

#include <scrim/engine/cells/cell_media.h>
#include <scrim/engine/model/sub_lights.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace scrim {
namespace {

bool isMesh(const Light& light) {
    return light.area() && light.area()->shape == AreaShape::mesh;
}

// The light of all if it has one colour.
void findTint(Sources& sources) {
    if (sources.lights.empty()) return;
    sources.tint = sources.lights.front().intensity;
    for (const Light& light : sources.lights)
        if (!sameColour(sources.tint, light.intensity)) sources.colours = 3;
    if (sources.colours == 1) sources.tint /= largest(sources.tint);
}

}  // namespace

Sources sourcesOfLamp(const Light& light, int count) {
    const std::vector<Vec3> points = pointsOfLamp(light, count);
    Sources lamp;
    lamp.lamp = true;
    lamp.lights.assign(points.size(), light);
    lamp.owners.assign(points.size(), 0);
    for (std::size_t i = 0; i < points.size(); ++i) {
        lamp.lights[i].kind = Light::Point();
        lamp.lights[i].wsPosition = points[i];
        lamp.lights[i].intensity = Rgb(4 * std::numbers::pi / double(points.size()));
    }
    return lamp;
}

Sources sourcesOf(const ViewScene& scene, const std::vector<int>& lights) {
    Sources out;
    if (const Light& first = scene.lights[std::size_t(lights.front())]; isLampOnCells(scene, first))
        out = sourcesOfLamp(first, pointsOnCells(scene, first));
    if (out.lamp) return out;
    ViewScene alone = scene;
    alone.lights.clear();
    for (const int i : lights) alone.lights.push_back(scene.lights[std::size_t(i)]);
    out.blocked = isBlocked(scene, std::size_t(lights.front()));
    for (Light& light : alone.lights) light.samples = pointsOnCells(scene, light);
    const SubLights all = subLights(alone);
    for (std::size_t i = 0; i < all.lights.size(); ++i)
        if (all.lights[i].intensity != Rgb(0) && !all.suns[i]) {
            out.lights.push_back(all.lights[i]);
            out.owners.push_back(all.owners[i]);
            out.parts.push_back(all.parts[i]);
        }
    out.ofScene = lights;
    findTint(out);
    return out;
}

Sources sourcesForSurfaces(const ViewScene& scene, const std::vector<int>& lights) {
    constexpr int kForEdges = 2;  // times as many points as media need, since shadows on surfaces have edges
    if (!isLampOnCells(scene, scene.lights[std::size_t(lights.front())])) return sourcesOf(scene, lights);
    Sources out;
    out.blocked = isBlocked(scene, std::size_t(lights.front()));
    for (std::size_t owner = 0; owner < lights.size(); ++owner) {
        const Light& lamp = scene.lights[std::size_t(lights[owner])];
        const std::vector<Vec3> points = pointsOfLamp(lamp, kForEdges * pointsOnCells(scene, lamp));
        for (const Vec3& point : points) {
            Light& light = out.lights.emplace_back(lamp);
            out.owners.push_back(static_cast<int>(owner));
            if (!lamp.area()) continue;
            const double radius = lamp.area()->radius;
            light.kind = Light::Point{0.5 * radius};
            light.wsPosition = point;
            light.intensity *= std::numbers::pi * radius * radius / double(points.size());
        }
    }
    out.parts.assign(out.lights.size(), 0);
    out.ofScene = lights;
    findTint(out);
    return out;
}

std::vector<WidePhase> widePhases(const ViewScene& scene, const Sources& sources, const Phase& phase) {
    const Bounds box = wsBounds(scene);
    std::vector<double> widest(sources.ofScene.size(), 0.0);
    for (std::size_t i = 0; i < sources.lights.size(); ++i) {
        double& own = widest[std::size_t(sources.owners[i])];
        own = std::max(own, widestCap(sources.lights[i], sources.parts[i], box));
    }
    std::vector<WidePhase> all(widest.size());
    for (std::size_t owner = 0; owner < all.size(); ++owner) {
        const Light& light = scene.lights[std::size_t(sources.ofScene[owner])];
        const double own = widest[owner];
        if (isMesh(light) || !needsCaps(phase, light.dome() ? own : kCapsOfSurfaces * own)) continue;
        // The edge of a square as large as the cap.
        if (light.dome())
            all[owner].ofSky.emplace(phase, std::sqrt(std::numbers::pi) * own);
        else if (light.distant())
            all[owner].ofSun = PhaseOverCaps(phase, own).row(own);
        else
            all[owner].ofSurface = std::make_shared<const PhaseOverCaps>(phase, own);
    }
    return all;
}

}  // namespace scrim
