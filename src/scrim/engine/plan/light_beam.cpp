// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/plan/light_beam.h>

#include <scrim/engine/light/slide_map.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace scrim {

std::vector<Vec3> rimOfCone(const Vec3& axis, double angle) {
    const Vec3 other = std::abs(axis.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
    const Vec3 x = glm::normalize(glm::cross(axis, other)), y = glm::cross(axis, x);
    std::vector<Vec3> directions;
    constexpr int kPoints = 16;
    for (int i = 0; i < kPoints; ++i) {
        const double t = 2 * std::acos(-1.0) * i / kPoints;
        directions.push_back(std::cos(angle) * axis + std::sin(angle) * (std::cos(t) * x + std::sin(t) * y));
    }
    return directions;
}

Cone coneToCorners(const Vec3& wsPoint, const std::vector<Vec3>& corners, std::vector<Vec3>& directions) {
    for (const Vec3& corner : corners)
        if (glm::distance(corner, wsPoint) > 0) directions.push_back(glm::normalize(corner - wsPoint));
    return enclosingCone(directions);
}

Beam beamOf(const Light& light) {
    const double pi = std::acos(-1.0);
    Beam beam{{}, pi};
    if (light.type == LightType::spot) {
        beam.angle = 0.5 * light.coneAngle * pi / 180;
        beam.directions = rimOfCone(light.wsDirection, beam.angle);
    }
    if (!light.slide) return beam;
    if (light.slide->outside == SlideOutside::black) {
        const double angle = slideHalfAngle(light);
        if (angle < beam.angle) beam = {slideCorners(light), angle};
    }
    beam.angle = std::min(beam.angle, 0.5 * pi);  // nothing behind a slide is lit
    return beam;
}

bool passesBy(const Light& light, const Beam& beam, const Cone& cone) {
    if (cone.cosAngle <= 0) return false;
    const double between = std::acos(std::clamp(glm::dot(light.wsDirection, cone.axis), -1.0, 1.0));
    return between > beam.angle + std::acos(std::min(cone.cosAngle, 1.0));
}

}  // namespace scrim
