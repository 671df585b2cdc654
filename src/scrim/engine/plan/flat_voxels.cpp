// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/plan/flat_voxels.h>

#include <scrim/geometry/enclosing_cone.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

// Voxels are flat if their second edge is so many times as long as their shortest one. Others keep
// the axis between eye and lights, which changes smoothly from frame to frame.
constexpr double kFlat = 2;
// An axis across flat voxels is taken if the sweep has so many times fewer texels.
constexpr double kWorthwhile = 2;
// How far rays may lean from an axis across flat voxels: as far as they cross no more than a voxel's long edge in the
// time that they cross its short one, or 75 degrees; and no farther than 84 degrees.
constexpr double kLeastCosine = 0.2588, kLeastOfAll = 0.1045;

// The gradients of a field's three coordinates: each is perpendicular to two axes of the grid, and
// its length is the inverse of the distance between planes of voxels.
Mat3 gradientsOf(const ViewField& field) {
    return glm::transpose(glm::inverse(Mat3(field.wsFromIs)));
}

// The number of texels around the corners, but for a factor that all axes share.
double texelsAround(const std::vector<Vec3>& corners, const Vec3& wsAxis, double across) {
    const Mat3 frame = frameAround(wsAxis);
    Bounds box;
    for (const Vec3& corner : corners)
        box.include(Vec3(glm::dot(frame[0], corner), glm::dot(frame[1], corner), glm::dot(frame[2], corner)));
    const Vec3 size = box.size() + across;
    return size.x * size.y * size.z / (across * across);
}

// To which side of an axis rays run.
struct Side {
    double sign;       // 1: along the axis; -1: against it
    double least = 1;  // smallest cosine to that side

    Side(const std::vector<Vec3>& rays, const Vec3& axis) : sign(glm::dot(rays.front(), axis) < 0 ? -1 : 1) {
        for (const Vec3& ray : rays) least = std::min(least, sign * glm::dot(ray, axis));
    }
};

Vec3 sumOf(const std::vector<Vec3>& directions) {
    return std::accumulate(directions.begin(), directions.end(), Vec3(0));
}

}  // namespace

double edgeAcross(const ViewScene& scene, const VolumeLevel& level, const Vec3& wsAxis) {
    double steepest = 0;
    for (std::size_t v = 0; v < scene.volumes.size(); ++v) {
        if (!level.volumes[v]) continue;
        for (const ViewField& field : fieldsOf(scene.volumes[v])) {
            const Mat3 gradients = gradientsOf(field);
            for (int i = 0; i < 3; ++i)
                steepest = std::max(steepest, glm::length(gradients[i] - glm::dot(gradients[i], wsAxis) * wsAxis));
        }
    }
    return steepest > 0 && 1 / steepest > kFlat * level.voxel ? 1 / steepest : level.voxel;
}

FlatVoxels::FlatVoxels(const ViewScene& scene) : m_scene(scene), m_finest(volumeLevels(scene).back()) {
    if (scene.dials.sheets == SheetAxis::imageAligned || scene.dials.splat == SplatMode::perView) return;
    double steepest = 0;
    for (std::size_t v = 0; v < scene.volumes.size(); ++v) {
        if (!m_finest.volumes[v]) continue;
        const Mat3 gradients = gradientsOf(densityOf(scene.volumes[v]));
        double lengths[3];
        for (int i = 0; i < 3; ++i) lengths[i] = glm::length(gradients[i]);
        const int most = static_cast<int>(std::max_element(lengths, lengths + 3) - lengths);
        const double second = std::max(lengths[(most + 1) % 3], lengths[(most + 2) % 3]);
        if (!(lengths[most] > kFlat * second) || !(lengths[most] > steepest)) continue;
        steepest = lengths[most];
        m_across = gradients[most] / steepest;
        m_ratio = steepest / second;
    }
    if (m_across) m_corners = wsCorners(scene, m_finest);
}

std::optional<FlatSheets> FlatVoxels::sheets(const std::vector<Vec3>& wsEye, const std::vector<Vec3>& wsLight) const {
    if (!m_across) return std::nullopt;
    const Side eye(wsEye, *m_across), light = wsLight.empty() ? eye : Side(wsLight, *m_across);
    const double least = std::min(eye.least, light.least);
    if (least < std::clamp(1 / m_ratio, kLeastOfAll, kLeastCosine)) return std::nullopt;
    const Vec3 axis = light.sign * *m_across;
    const double across = edgeAcross(m_scene, m_finest, axis);
    const FlatSheets flat{axis, eye.sign == light.sign, std::acos(least), across / m_finest.voxel};

    std::vector<Vec3> rays = wsLight;
    const bool opposite = !wsLight.empty() && glm::dot(sumOf(wsEye), sumOf(wsLight)) < 0;
    for (const Vec3& ray : wsEye) rays.push_back(opposite ? -ray : ray);
    const Cone cone = enclosingCone(rays);
    if (cone.cosAngle < kLeastOfAll) return flat;
    const double halfWay = texelsAround(m_corners, cone.axis, edgeAcross(m_scene, m_finest, cone.axis)) / cone.cosAngle;
    if (halfWay < kWorthwhile * texelsAround(m_corners, axis, across) / least) return std::nullopt;
    return flat;
}

}  // namespace scrim
