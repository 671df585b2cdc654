// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/light.h>

#include <scrim/geometry/camera.h>
#include <scrim/image/light_profile.h>
#include <scrim/solid/shining_mesh.h>
#include <scrim/solid/triangle_mesh.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#define GLM_ENABLE_EXPERIMENTAL  // glm::rotation
#include <glm/geometric.hpp>
#include <glm/gtx/quaternion.hpp>
#include <glm/trigonometric.hpp>

namespace scrim {

Spread::Spread(double degrees) {
    constexpr double kAlmostAll = 179.9;
    if (degrees >= kAlmostAll) return;
    const double half = glm::radians(0.5 * degrees);
    m_tangent = std::tan(half);
    m_scale = 1 / (m_tangent - half);
}

double Spread::at(double cosine) const {
    if (!any()) return 1;
    if (cosine <= 0) return 0;
    return std::max(m_tangent - std::sqrt(std::max(1 - cosine * cosine, 0.0)) / cosine, 0.0) * m_scale;
}

double Light::Area::area() const {
    if (shape == AreaShape::rectangle) return width * height;
    if (shape == AreaShape::cylinder) return 2 * std::numbers::pi * radius * width;
    if (shape == AreaShape::mesh) return surfaceArea;
    return (shape == AreaShape::disk ? 1 : 4) * std::numbers::pi * radius * radius;
}

void shineFrom(Light& light, const TriangleMesh& mesh, const Mat4& wsFromMesh) {
    auto& area = std::get<Light::Area>(light.kind);
    auto surface = std::make_shared<TriangleMesh>(mesh);
    area.wsSurface = {};
    for (Vec3& point : surface->points) area.wsSurface.include(point = transformPoint(wsFromMesh, point));
    if (glm::determinant(wsFromMesh) < 0) turnOver(*surface);  // as a mirror does
    if (isInsideOut(*surface)) turnOver(*surface);
    // Even places in the order of the tree are even in space and among normals. In that of files
    // they may all be on one side of a tube, ring after ring.
    area.surface = std::make_shared<const TriangleMesh>(ShiningMesh(std::move(*surface)).mesh());
    area.surfaceArea = MeshPlaces(*area.surface).area();
    light.wsPosition = area.wsSurface.center();
    if (area.normalize && area.area() > 0) light.intensity /= area.area();
    area.normalize = false;
}

Mat3 lightFrame(const Light& light) {
    return lookAt(Vec3(0), -light.wsDirection, light.wsUp);
}

double luminairePart(const Light& light, const Mat3& frame, const Vec3& wsTravel) {
    if (!light.luminaire || !light.luminaire->profile) return 1;
    return light.luminaire->profile->at(wsTravel * frame);  // the transpose turns into the frame
}

Vec3 pictureOfRectangle(const Light& light, double u, double v) {
    const Mat3 frame = lightFrame(light);
    const Light::Area& area = *light.area();
    return light.wsPosition + (u - 0.5) * area.width * frame[0] + (0.5 - v) * area.height * frame[1];
}

namespace {

// The shortest turn from +y to wsUp carries +x and +z along.
Mat3 uprightDome(const Light& light) {
    return glm::mat3_cast(glm::rotation(Vec3(0, 1, 0), glm::normalize(light.wsUp)));
}

}  // namespace

Vec3 domeDirection(const Light& light, double u, double v) {
    const double longitude = std::numbers::pi * (1 - 2 * u) + glm::radians(light.dome()->rotation);
    const double latitude = std::numbers::pi * (0.5 - v);
    const Vec3 upright(std::cos(latitude) * std::sin(longitude), std::sin(latitude),
                       std::cos(latitude) * std::cos(longitude));
    return uprightDome(light) * upright;
}

Vec2 pictureOfDome(const Light& light, const Vec3& direction) {
    const Vec3 upright = glm::transpose(uprightDome(light)) * direction;
    const double longitude = std::atan2(upright.x, upright.z) - glm::radians(light.dome()->rotation);
    const double u = 0.5 - longitude / (2 * std::numbers::pi);
    return {u - std::floor(u), 0.5 - std::asin(std::clamp(upright.y, -1.0, 1.0)) / std::numbers::pi};
}

}  // namespace scrim
