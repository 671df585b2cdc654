// SPDX-License-Identifier: Apache-2.0
// Solids made in code.
#pragma once

#include <scrim/solid/solids.h>

#include <cmath>
#include <memory>
#include <utility>

#include <glm/geometric.hpp>

namespace scrim::test {

/// A square of edge 2 * `half` around `middle`, at right angles to `normal`.
inline std::shared_ptr<const TriangleMesh> squareMesh(const Vec3& middle, const Vec3& normal, double half) {
    const Vec3 n = glm::normalize(normal);
    const Vec3 u = half * glm::normalize(glm::cross(std::abs(n.x) < 0.9 ? Vec3(1, 0, 0) : Vec3(0, 1, 0), n));
    const Vec3 v = glm::cross(n, u);
    auto mesh = std::make_shared<TriangleMesh>();
    mesh->points = {middle - u - v, middle + u - v, middle + u + v, middle - u + v};
    mesh->triangles = {{0, 1, 2}, {0, 2, 3}};
    return mesh;
}

/// A ball of so many rings of triangles, whose corners lie on it.
inline std::shared_ptr<const TriangleMesh> ballMesh(const Vec3& middle, double radius, int rings = 128) {
    const double pi = std::acos(-1.0);
    const auto sectors = static_cast<std::uint32_t>(2 * rings);
    auto mesh = std::make_shared<TriangleMesh>();
    for (int i = 0; i <= rings; ++i)
        for (std::uint32_t j = 0; j < sectors; ++j) {
            const double polar = pi * i / rings, around = 2 * pi * j / sectors;
            mesh->points.push_back(middle + radius * Vec3(std::sin(polar) * std::cos(around),
                                                          std::sin(polar) * std::sin(around), std::cos(polar)));
        }
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(rings); ++i)
        for (std::uint32_t j = 0; j < sectors; ++j) {
            const std::uint32_t a = i * sectors + j, b = i * sectors + (j + 1) % sectors;
            mesh->triangles.push_back({a, b, b + sectors});
            mesh->triangles.push_back({a, b + sectors, a + sectors});
        }
    return mesh;
}

/// The faces of a box, each a rectangle; one of them may have a rectangular window, whose corners are fractions of the
/// face along the next two axes. `face`: 2 axis, + 1 for the upper one; -1: none.
inline std::shared_ptr<const TriangleMesh> roomMesh(const Vec3& lower, const Vec3& upper, int face = -1,
                                                    const Vec2& from = Vec2(0), const Vec2& to = Vec2(0)) {
    auto mesh = std::make_shared<TriangleMesh>();
    const auto add = [&](int side, const Vec2& a, const Vec2& b) {
        const int axis = side / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
        const auto first = static_cast<std::uint32_t>(mesh->points.size());
        for (const Vec2& at : {a, Vec2(b.x, a.y), b, Vec2(a.x, b.y)}) {
            Vec3 point(0);
            point[axis] = side % 2 == 1 ? upper[axis] : lower[axis];
            point[u] = lower[u] + at.x * (upper[u] - lower[u]);
            point[v] = lower[v] + at.y * (upper[v] - lower[v]);
            mesh->points.push_back(point);
        }
        mesh->triangles.push_back({first, first + 1, first + 2});
        mesh->triangles.push_back({first, first + 2, first + 3});
    };
    for (int side = 0; side < 6; ++side) {
        if (side != face) {
            add(side, Vec2(0), Vec2(1));
            continue;
        }
        add(side, Vec2(0), Vec2(1, from.y));
        add(side, Vec2(0, to.y), Vec2(1));
        add(side, Vec2(0, from.y), Vec2(from.x, to.y));
        add(side, Vec2(to.x, from.y), Vec2(1, to.y));
    }
    return mesh;
}

/// One solid, which hides and throws shadows.
inline std::shared_ptr<const Solids> oneSolid(std::shared_ptr<const TriangleMesh> mesh, bool holdout = true,
                                              bool shadows = true, bool catches = false, const Rgb& albedo = Rgb(0)) {
    return std::make_shared<const Solids>(
        std::vector<Solid>{{"solid", std::move(mesh), Mat4(1.0), holdout, shadows, catches, albedo}});
}

}  // namespace scrim::test
