// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/light_at.h>

#include <algorithm>
#include <cmath>
#include <numbers>

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

namespace {

// The first t > 0 at which origin + t direction, both across the axis, meets a circle from outside; infinity if it does
// not.
double meetsCircle(const Vec2& origin, const Vec2& direction, double radius) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const double a = glm::dot(direction, direction), b = glm::dot(origin, direction);
    const double c = glm::dot(origin, origin) - radius * radius, root = b * b - a * c;
    return a == 0 || c <= 0 || root < 0 || b > 0 ? kInfinity : (-b - std::sqrt(root)) / a;
}

}  // namespace

SeenLight seenLight(const Light& light, const Vec3& ws, const Vec3& toLight) {
    const Light::Area* area = light.area();
    if (!area) {
        const double half = std::sin(glm::radians(0.25 * std::get<Light::Distant>(light.kind).angle));
        const double depth = 2 * half * half;  // 1 - cos of half the angle
        if (!(1 + glm::dot(toLight, light.wsDirection) <= depth)) return {};
        return {light.intensity / (2 * std::numbers::pi * depth)};
    }
    const Mat3 frame = lightFrame(light);
    const Vec3 from = (ws - light.wsPosition) * frame, way = toLight * frame;  // right, up, normal
    if (area->shape == AreaShape::sphere) {
        const double along = -glm::dot(way, from), r2 = glm::dot(from, from);
        const double inside = area->radius * area->radius - (r2 - along * along);
        if (inside < 0 || along < 0 || r2 <= area->radius * area->radius) return {};
        return {light.intensity, along - std::sqrt(inside)};
    }
    if (area->shape == AreaShape::cylinder) {
        const double t = meetsCircle({from.y, from.z}, {way.y, way.z}, area->radius);
        if (!(std::abs(from.x + t * way.x) <= 0.5 * area->width)) return {};
        return {light.intensity, t};
    }
    if (way.z >= 0 || from.z <= 0) return {};
    const double t = -from.z / way.z, x = from.x + t * way.x, y = from.y + t * way.y;
    const Rgb radiance = Spread(area->spread).at(-way.z) * light.intensity;
    if (area->shape == AreaShape::disk)
        return x * x + y * y <= area->radius * area->radius ? SeenLight{radiance, t} : SeenLight{};
    const double u = x / area->width + 0.5, v = 0.5 - y / area->height;
    if (u < 0 || v < 0 || u > 1 || v > 1) return {};
    if (!light.slide) return {radiance, t};
    const Texture::Level& picture = light.slide->image->levels().front();
    const float* p = picture.pixel(std::min(static_cast<int>(u * picture.width), picture.width - 1),
                                   std::min(static_cast<int>(v * picture.height), picture.height - 1));
    return {radiance * Rgb(p[0], p[1], p[2]), t};
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
