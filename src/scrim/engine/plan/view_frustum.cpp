// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/plan/view_frustum.h>

#include <algorithm>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

constexpr double kAround = 0.5;  // pixels

// The faces of a parallelepiped, by its corners.
constexpr int kFaces[6][4] = {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}};

// Is the point in the parallelepiped?
bool contains(const std::array<Vec3, 8>& c, const Vec3& p) {
    const Mat3 edges(c[1] - c[0], c[2] - c[0], c[4] - c[0]);
    if (std::abs(glm::determinant(edges)) < 1e-300) return false;
    const Vec3 at = glm::inverse(edges) * (p - c[0]);
    return std::min({at.x, at.y, at.z}) >= 0 && std::max({at.x, at.y, at.z}) <= 1;
}

}  // namespace

double ViewFrustum::Plane::side(const Vec3& ws) const {
    return glm::dot(normal, ws) - offset;
}

ViewFrustum::ViewFrustum(const Camera& camera, const PixelWindow& window) {
    const RayFamily rays = wsRays(camera);
    const double x[2] = {window.x0 - kAround, window.x1 + kAround}, y[2] = {window.y0 - kAround, window.y1 + kAround};
    const Vec3 forward = viewingAxis(camera);
    const auto pointOn = [&](int i, int j, double t) {
        return rays.origin(x[i], y[j]) + t * rays.direction(x[i], y[j]);
    };
    const Vec3 inside = rays.origin(0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1])) +
                        (rays.near + 1) * rays.direction(0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1]));
    const auto add = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
        const Vec3 cross = glm::cross(b - a, c - a);
        if (glm::dot(cross, cross) == 0) return;
        Plane plane{glm::normalize(cross), 0};
        plane.offset = glm::dot(plane.normal, a);
        if (plane.side(inside) < 0) plane = {-plane.normal, -plane.offset};
        m_planes.push_back(plane);
    };
    // Each side holds an edge of the raster at two depths, beyond the eye where rays meet in a point.
    for (int i = 0; i < 2; ++i) {
        add(pointOn(i, 0, rays.near + 1), pointOn(i, 1, rays.near + 1), pointOn(i, 0, rays.near + 2));
        add(pointOn(0, i, rays.near + 1), pointOn(1, i, rays.near + 1), pointOn(0, i, rays.near + 2));
    }
    m_planes.push_back({forward, glm::dot(forward, pointOn(0, 0, rays.near))});
    for (int i = 0; i < 2; ++i)
        for (int j = 0; j < 2; ++j) m_corners.push_back(pointOn(i, j, rays.near));
}

std::vector<Vec3> ViewFrustum::visiblePart(const std::array<Vec3, 8>& wsCorners) const {
    std::vector<Vec3> visible;
    for (const auto& face : kFaces) {
        std::vector<Vec3> polygon;
        for (const int corner : face) polygon.push_back(wsCorners[static_cast<std::size_t>(corner)]);
        for (const Plane& plane : m_planes) {
            std::vector<Vec3> cut;
            for (std::size_t i = 0; i < polygon.size(); ++i) {
                const Vec3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
                const double sideA = plane.side(a), sideB = plane.side(b);
                if (sideA >= 0) cut.push_back(a);
                if ((sideA < 0) != (sideB < 0)) cut.push_back(a + sideA / (sideA - sideB) * (b - a));
            }
            polygon = std::move(cut);
        }
        visible.insert(visible.end(), polygon.begin(), polygon.end());
    }
    // The frustum may begin, and its edges may run, within the box.
    for (const Vec3& corner : m_corners)
        if (contains(wsCorners, corner)) visible.push_back(corner);
    return visible;
}

std::vector<Vec3> ViewFrustum::visibleParts(const std::vector<Vec3>& wsCorners) const {
    std::vector<Vec3> visible;
    std::array<Vec3, 8> box;
    for (std::size_t i = 0; i + box.size() <= wsCorners.size(); i += box.size()) {
        std::copy_n(wsCorners.begin() + static_cast<std::ptrdiff_t>(i), box.size(), box.begin());
        const std::vector<Vec3> part = visiblePart(box);
        visible.insert(visible.end(), part.begin(), part.end());
    }
    return visible;
}

}  // namespace scrim
