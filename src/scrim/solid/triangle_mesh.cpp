// SPDX-License-Identifier: Apache-2.0
#include <scrim/solid/triangle_mesh.h>

#include <scrim/geometry/bounds.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include <glm/geometric.hpp>

namespace scrim {
namespace {

bool isBefore(const Vec3& a, const Vec3& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

// For each point the same number as for others at its place.
std::vector<std::uint32_t> numbersOf(const std::vector<Vec3>& points) {
    std::vector<std::uint32_t> order(points.size()), numbers(points.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return isBefore(points[a], points[b]); });
    for (std::size_t i = 0; i < order.size(); ++i)
        numbers[order[i]] = i > 0 && points[order[i]] == points[order[i - 1]] ? numbers[order[i - 1]] : order[i];
    return numbers;
}

// Each edge of a closed surface belongs to two triangles, which run along it in opposite directions.
bool isClosed(const TriangleMesh& mesh) {
    const std::vector<std::uint32_t> numbers = numbersOf(mesh.points);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const auto& triangle : mesh.triangles)
        for (std::size_t i = 0; i < 3; ++i) {
            const auto a = numbers[triangle[i]], b = numbers[triangle[(i + 1) % 3]];
            if (a != b) edges[std::minmax(a, b)] += a < b ? 1 : -1;
        }
    return std::all_of(edges.begin(), edges.end(), [](const auto& edge) { return edge.second == 0; });
}

}  // namespace

Vec3 TriangleMesh::cross(std::size_t triangle) const {
    const Vec3& a = corner(triangle, 0);
    return glm::cross(corner(triangle, 1) - a, corner(triangle, 2) - a);
}

Vec3 TriangleMesh::middle(std::size_t triangle) const {
    return (corner(triangle, 0) + corner(triangle, 1) + corner(triangle, 2)) / 3.0;
}

Vec3 TriangleMesh::place(std::size_t triangle, const Vec2& square) const {
    // The root makes places as dense near the first corner as elsewhere.
    const double root = std::sqrt(square.x);
    return (1 - root) * corner(triangle, 0) +
           root * ((1 - square.y) * corner(triangle, 1) + square.y * corner(triangle, 2));
}

void turnOver(TriangleMesh& mesh) {
    for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
}

bool isInsideOut(const TriangleMesh& mesh) {
    double volume = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        volume += glm::dot(mesh.corner(t, 0) - mesh.points.front(), mesh.cross(t));
    return volume < 0 && isClosed(mesh);
}

MeshPlaces::MeshPlaces(const TriangleMesh& mesh) : m_mesh(mesh) {
    constexpr double kLift = 1e-4;
    Bounds box;
    for (const Vec3& point : mesh.points) box.include(point);
    m_lift = kLift * largest(box.size());
    double area = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) m_areas.push_back(area += 0.5 * glm::length(mesh.cross(t)));
}

MeshPlaces::Place MeshPlaces::at(const Vec2& square) const {
    const double wanted = square.x * area();
    const auto found = std::upper_bound(m_areas.begin(), m_areas.end() - 1, wanted);
    const auto triangle = static_cast<std::size_t>(found - m_areas.begin());
    const double before = triangle == 0 ? 0 : m_areas[triangle - 1], own = m_areas[triangle] - before;
    const double rest = own > 0 ? std::clamp((wanted - before) / own, 0.0, 1.0) : 0.25;
    const Vec3 normal = glm::normalize(m_mesh.cross(triangle));
    return {m_mesh.place(triangle, {rest, square.y}) + m_lift * normal, normal};
}

}  // namespace scrim
