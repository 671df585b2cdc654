// SPDX-License-Identifier: Apache-2.0
#include <scrim/verify/pilot_volume.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include <glm/common.hpp>
#include <glm/ext/scalar_constants.hpp>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

constexpr double kFourPi = 4 * glm::pi<double>();

double grey(const Rgb& v) {
    return glm::dot(v, Rgb(1.0 / 3));
}

// The phase function towards the eye, relative to even scattering: the mean over places in a box.
double meanPhase(const Phase& phase, const Light& light, const Camera& camera, const Bounds& ws) {
    if (phase.isotropic()) return 1;
    constexpr int kPlaces = 9;
    const auto corners = ws.corners();
    double sum = 0;
    for (int i = 0; i < kPlaces; ++i) {
        const Vec3 at = i == 0 ? ws.center() : 0.5 * (ws.center() + corners[std::size_t(i - 1)]);
        const Vec3 way = light.distant() ? light.wsDirection : at - light.wsPosition;
        const double length = glm::length(way);
        sum += length > 0 ? phaseValue(phase, glm::dot(way / length, travelToEye(camera, at))) : 1 / kFourPi;
    }
    return kFourPi * sum / kPlaces;
}

// The extinction of a medium, relative to that of the channel where it is largest, in the channel
// that has most of the light, if it has clearly more than that one.
double extinctionOfLight(const Medium& medium, const std::vector<PilotLight>& lights, const Rgb& ambient,
                         const Bounds& ws) {
    constexpr double kAlike = 0.8;
    const Rgb tint = medium.relativeTint();
    Rgb light = kFourPi * ambient;
    for (const PilotLight& one : lights)
        if (one.power > 0) light += one.light->intensity * (irradianceAt(*one.light, ws) / one.power);
    const auto most = [](const Rgb& v) { return v.x >= v.y && v.x >= v.z ? 0 : v.y >= v.z ? 1 : 2; };
    const int brightest = most(light), densest = most(tint);
    return light[densest] >= kAlike * light[brightest] ? 1 : tint[brightest];
}

}  // namespace

double irradianceAt(const Light& light, const Bounds& ws) {
    const double power = grey(light.intensity);
    if (light.distant() || !light.point().decay) return power;
    // A lamp that is among the volumes lights most of them from about half of their size.
    const double size = 0.5 * glm::length(ws.size());
    const double distance = std::max(glm::distance(light.wsPosition, ws.center()), size);
    return distance > 0 ? power / (distance * distance) : power;
}

std::vector<PilotLight> brightestLights(const ViewScene& scene) {
    const Bounds ws = wsBounds(scene);
    std::vector<std::pair<double, PilotLight>> all;
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        const Light& light = scene.lights[i];
        all.push_back({irradianceAt(light, ws), {&light, i, grey(light.intensity)}});
    }
    std::ranges::stable_sort(all, std::greater<>(), [](const auto& light) { return light.first; });
    if (all.size() > kMostPilotLights) all.resize(kMostPilotLights);
    std::vector<PilotLight> lights;
    for (const auto& [irradiance, light] : all) lights.push_back(light);
    return lights;
}

PilotVolume::PilotVolume(const ViewVolume& volume, FieldSamplers& samplers, const ViewScene& scene,
                         const std::vector<PilotLight>& lights)
    : m_optics(volume, Kernel::linear, samplers),
      m_hidden(volume.holdout),
      m_grid(!volume.scatter.empty() && !volume.classified) {
    for (const Vec3& corner : wsCorners(volume, scene.dials.kernel)) bounds.include(corner);
    for (const ViewEmission& emission : volume.emission)
        m_glow.push_back(m_hidden ? 0 : kFourPi * grey(emission.color));
    const Rgb albedo = volume.classified ? Rgb(1) : volume.medium.relativeTint() * volume.medium.albedo;
    if (!volume.classified) m_extinction = extinctionOfLight(volume.medium, lights, scene.ambient, bounds);
    if (!m_hidden) m_weights[kMostPilotLights] = Rgb(1.0 / 3);
    for (std::size_t i = 0; i < lights.size(); ++i) {
        const Light& light = *lights[i].light;
        m_shadows[i] = litBy(volume.shadows, lights[i].number);
        if (m_hidden || !litBy(volume.lights, lights[i].number) || light.intensity == Rgb(0)) continue;
        const double phase = volume.classified ? 1 : meanPhase(volume.medium.phase, light, scene.camera, bounds);
        m_weights[i] = phase * light.intensity / (3 * grey(light.intensity));
    }
    for (std::size_t i = 0; i < m_weights.size(); ++i) m_scattering[i] = glm::dot(albedo, m_weights[i]);
}

PilotStuff PilotVolume::at(const Vec3& ws) const {
    PilotStuff out;
    out.opacity = m_optics.mostExtinction(ws);
    out.shown = m_hidden ? 0 : out.opacity;
    out.extinction = m_extinction * out.opacity;
    for (std::size_t i = 0; i < m_glow.size(); ++i)
        out.glow += m_glow[i] * std::max(m_optics.emissionField(i, ws), 0.0);
    if (m_grid) {
        const Rgb scattering = m_optics.scattering(ws);
        for (std::size_t i = 0; i < m_weights.size(); ++i) out.scattering[i] = glm::dot(scattering, m_weights[i]);
    } else {
        for (std::size_t i = 0; i < m_weights.size(); ++i) out.scattering[i] = out.opacity * m_scattering[i];
    }
    return out;
}

double PilotVolume::brightest() const {
    double most = 0;
    for (std::size_t i = 0; i < kMostPilotLights; ++i)
        most = std::max(most, m_grid ? largest(m_weights[i]) : m_scattering[i]);
    return most;
}

void PilotVolume::divide(double by) {
    for (double& glow : m_glow) glow /= by;
    for (Rgb& weight : m_weights) weight /= by;
    for (double& part : m_scattering) part /= by;
}

void PilotVolume::takeWeights(const PilotVolume& other) {
    m_extinction = other.m_extinction;
    m_glow = other.m_glow;
    m_weights = other.m_weights;
    m_scattering = other.m_scattering;
}

void PilotVolume::showOpacity() {
    m_grid = false;
    m_extinction = 1;
    m_scattering.fill(0);
    m_scattering[kMostPilotLights] = m_hidden ? 0 : 1;
}

bool isLamp(const Light& light) {
    return light.area() ? light.area()->shape == AreaShape::sphere : !light.distant() && !light.dome();
}

Vec3 toLight(const Light& light, const Vec3& from) {
    const Vec3 way = light.distant() ? -light.wsDirection : light.wsPosition - from;
    return way == Vec3(0) ? way : glm::normalize(way);
}

}  // namespace scrim
