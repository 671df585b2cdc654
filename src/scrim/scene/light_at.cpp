// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/light_at.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace scrim {

SpotEdges::SpotEdges(const Light::Spot& spot) {
    const double half = glm::radians(0.5 * spot.coneAngle);
    outer = std::cos(half);
    inner = std::cos(std::min(half * (1 - spot.blend), half - 1e-4));
}

double SpotEdges::part(double cosine) const {
    const double t = std::clamp((cosine - outer) / (inner - outer), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

LightAt::LightAt(const Light& light, double leastRadius) : m_light(light) {
    if (light.slide) m_slide = slideMap(light);
    if (light.luminaire) m_frame = lightFrame(light);
    if (const Light::Spot* spot = light.spot()) m_edges.emplace(*spot);
    if (const Light::Element* element = light.element()) m_spread = Spread(element->spread);
    if (light.distant()) return;
    const double radius = std::max(light.point().radius, leastRadius);
    m_radius2 = radius * radius;
}

Arriving LightAt::at(const Vec3& ws) const {
    Arriving out{m_light.intensity, m_light.wsDirection};
    if (!m_light.distant()) {
        const Vec3 way = ws - m_light.wsPosition;
        out.distance = glm::length(way);
        if (out.distance == 0 && m_radius2 == 0) return {Rgb(0), m_light.wsDirection, 0};
        if (out.distance > 0) out.travel = way / out.distance;
        if (m_light.point().decay) out.irradiance /= std::max(glm::dot(way, way), m_radius2);
        const double along = glm::dot(out.travel, m_light.wsDirection);
        if (m_edges) out.irradiance *= m_edges->part(along);
        if (m_light.luminaire) out.irradiance *= luminairePart(m_light, m_frame, out.travel);
        if (m_light.element()) out.irradiance *= std::max(along, 0.0) * m_spread.at(along);
    }
    if (m_slide) out.irradiance *= slideValue(m_light, *m_slide, ws);
    return out;
}

}  // namespace scrim
