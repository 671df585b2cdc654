// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/light/marched_light.h>

#include <numbers>

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

double offSurface(const Vec3& ws) {
    constexpr double kOff = 1e-6;  // of the distance from the origin
    return kOff * (glm::length(ws) + 1);
}

Rgb MarchedLight::left(std::size_t light, const Part& part, const Arriving& arriving, const Vec3& ws) const {
    if (!m_scene.lights[light].shadows) return arriving.irradiance;
    if (solidsBlock(m_scene) && m_scene.solids->firstHit(SolidRole::shadow, ws, -arriving.travel, offSurface(ws),
                                                         arriving.distance) < arriving.distance)
        return Rgb(0);
    return m_volumes.empty() ? arriving.irradiance : arriving.irradiance * transmittance(light, part, ws);
}

Rgb MarchedLight::irradiance(const Vec3& ws, const Vec3& normal) const {
    Rgb sum(0);
    for (std::size_t i = 0; i < m_parts.size(); ++i)
        for (const Part& part : m_parts[i]) {
            const Arriving arriving = part.at.at(ws);
            const double cosine = -glm::dot(arriving.travel, normal);
            if (cosine > 0 && arriving.irradiance != Rgb(0)) sum += cosine * left(i, part, arriving, ws);
        }
    return sum;
}

FromAllSides MarchedLight::fromAllSides(const Vec3& ws, const std::vector<bool>& lights, double edge) const {
    // The mean of 1 / r^2 over a ball is 3 / radius^2.
    const double radius = 0.62 * edge;  // of a ball as large as the cell
    FromAllSides out;
    for (std::size_t i = 0; i < m_parts.size(); ++i)
        for (const Part& part : m_parts[i]) {
            if (!litBy(lights, i)) continue;
            const Arriving arriving = part.at.at(ws);
            if (arriving.irradiance == Rgb(0)) continue;
            Rgb mean = left(i, part, arriving, ws) / (4 * std::numbers::pi);
            const double within = arriving.distance / radius;
            if (within < 1 && part.light->point().decay) mean *= 3 * within * within;
            out.mean += mean;
            for (std::size_t c = 0; c < 3; ++c) out.flow[c] += mean[int(c)] * arriving.travel;
        }
    return out;
}

}  // namespace scrim
