// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/light/marched_light.h>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

// All lights by their sub-lights, whoever brings their light to the volumes.
SubLights allSubLights(const ViewScene& scene) {
    std::vector<ServedLight> served = servedLights(scene);
    for (ServedLight& light : served) light.inSweeps = true;
    return subLights(scene, served);
}

}  // namespace

MarchedLight::MarchedLight(const ViewScene& scene)
    : m_scene(scene), m_step(voxelUnit(scene)), m_subLights(allSubLights(scene)), m_parts(scene.lights.size()) {
    FieldSamplers samplers;
    for (const ViewVolume& volume : scene.volumes) {
        if (volume.field->empty()) continue;
        m_volumes.emplace_back(volume, Kernel::linear, samplers);
        for (const Vec3& corner : wsCorners(volume, scene.dials.kernel)) m_wsBounds.include(corner);
    }
    for (std::size_t i = 0; i < m_subLights.owners.size(); ++i)
        m_parts[std::size_t(m_subLights.owners[i])].emplace_back(m_subLights.lights[i]);
}

Rgb MarchedLight::transmittance(std::size_t light, const Part& part, const Vec3& ws) const {
    const double beyond = glm::distance(ws, m_wsBounds.center()) + glm::length(m_wsBounds.size());
    const Vec3 end = part.light->distant() ? ws - beyond * part.light->wsDirection : part.light->wsPosition;
    return glm::exp(-opticalDepth(m_volumes, m_wsBounds, m_step, ws, end, light));
}

Rgb MarchedLight::transmittance(std::size_t light, const Vec3& ws) const {
    const std::vector<Part>& parts = m_parts[light];
    if (parts.size() == 1) return transmittance(light, parts.front(), ws);
    Rgb sum(0);
    double weights = 0;
    for (const Part& part : parts) {
        const Rgb sent = part.at.at(ws).irradiance;
        const double weight = sent.x + sent.y + sent.z;
        if (weight <= 0) continue;
        sum += weight * transmittance(light, part, ws);
        weights += weight;
    }
    return weights > 0 ? sum / weights : Rgb(1);
}

Rgb MarchedLight::irradiance(const Vec3& ws, const Vec3& normal) const {
    constexpr double kOff = 1e-6;  // of the distance from the origin, by which a ray leaves its own surface
    const double off = kOff * (glm::length(ws) + 1);
    const bool solid = solidsBlock(m_scene);
    Rgb sum(0);
    for (std::size_t i = 0; i < m_parts.size(); ++i)
        for (const Part& part : m_parts[i]) {
            const Arriving arriving = part.at.at(ws);
            const double cosine = -glm::dot(arriving.travel, normal);
            if (!(cosine > 0) || arriving.irradiance == Rgb(0)) continue;
            Rgb sent = cosine * arriving.irradiance;
            if (m_scene.lights[i].shadows) {
                if (solid && m_scene.solids->firstHit(SolidRole::shadow, ws, -arriving.travel, off, arriving.distance) <
                                 arriving.distance)
                    continue;
                if (!m_volumes.empty()) sent *= transmittance(i, part, ws);
            }
            sum += sent;
        }
    return sum;
}

}  // namespace scrim
