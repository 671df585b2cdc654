// SPDX-License-Identifier: Apache-2.0
#include <scrim/solid/shining_mesh.h>

#include <scrim/base/running_sums.h>
#include <scrim/geometry/bounds.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

#include <glm/geometric.hpp>

namespace scrim {
namespace {

constexpr std::uint32_t kLeaf = 4;  // most triangles of a leaf

// Light that twice an area along a normal sends along `way`, times some constant.
double sent(const Vec3& cross, const Vec3& way) {
    const double r2 = std::max(glm::dot(way, way), 1e-300);
    return std::max(glm::dot(cross, way), 0.0) / (r2 * std::sqrt(r2));
}

// The place of a triangle that is nearest to `ws`.
Vec3 nearestOf(const TriangleMesh& mesh, std::size_t triangle, const Vec3& ws) {
    const Vec3 normal = mesh.cross(triangle);
    Vec3 nearest(0);
    double least = std::numeric_limits<double>::infinity();
    bool inside = true;
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 &from = mesh.corner(triangle, i), edge = mesh.corner(triangle, (i + 1) % 3) - from;
        inside = inside && glm::dot(glm::cross(edge, ws - from), normal) >= 0;
        const double s = std::clamp(glm::dot(ws - from, edge) / std::max(glm::dot(edge, edge), 1e-300), 0.0, 1.0);
        const Vec3 at = from + s * edge;
        if (const double d = glm::distance(ws, at); d < least) least = d, nearest = at;
    }
    if (!inside) return nearest;
    return ws - glm::dot(ws - mesh.corner(triangle, 0), normal) / glm::dot(normal, normal) * normal;
}

// Where a way crosses a triangle, as a part of it.
std::optional<double> crossingOf(const TriangleMesh& mesh, std::size_t triangle, const Vec3& ws, const Vec3& way) {
    const Vec3 normal = mesh.cross(triangle);
    const double down = glm::dot(normal, way);
    if (down == 0) return std::nullopt;
    const double s = glm::dot(normal, mesh.corner(triangle, 0) - ws) / down;
    if (!(s > 0 && s < 1)) return std::nullopt;
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3& from = mesh.corner(triangle, i);
        const Vec3 edge = mesh.corner(triangle, (i + 1) % 3) - from;
        if (glm::dot(glm::cross(edge, ws + s * way - from), normal) < 0) return std::nullopt;
    }
    return s;
}

}  // namespace

ShiningMesh::ShiningMesh(TriangleMesh mesh) : m_mesh(std::move(mesh)) {
    // What is so small that its area is rounded to 0 has no normal.
    std::erase_if(m_mesh.triangles, [&](const std::array<std::uint32_t, 3>& triangle) {
        const Vec3& a = m_mesh.points[triangle[0]];
        return !(glm::length(glm::cross(m_mesh.points[triangle[1]] - a, m_mesh.points[triangle[2]] - a)) > 0);
    });
    const auto count = static_cast<std::uint32_t>(m_mesh.triangles.size());
    if (count == 0) return;
    Bounds box;
    for (const Vec3& point : m_mesh.points) box.include(point);
    build(0, count, largest(box.size()));
    for (std::uint32_t t = 0; t < count; ++t) {
        m_middles.push_back(m_mesh.middle(t));
        m_crosses.push_back(m_mesh.cross(t));
    }
}

ShiningMesh::Node ShiningMesh::around(std::uint32_t first, std::uint32_t count) const {
    Node node;
    node.first = first;
    node.count = count;
    double all = 0;
    for (std::uint32_t t = first; t < first + count; ++t) {
        const Vec3 cross = m_mesh.cross(t);
        all += glm::length(cross);
        node.area += cross;
        node.middle += glm::length(cross) * m_mesh.middle(t);
    }
    node.middle /= all;
    const double length = glm::length(node.area);
    if (length > 0) node.axis = node.area / length;
    node.cosine = length > 0 ? 1 : -1;
    for (std::uint32_t t = first; t < first + count; ++t) {
        for (std::size_t i = 0; i < 3; ++i)
            node.radius = std::max(node.radius, glm::distance(m_mesh.corner(t, i), node.middle));
        node.cosine = std::min(node.cosine, glm::dot(glm::normalize(m_mesh.cross(t)), node.axis));
    }
    node.sine = std::sqrt(std::max(1 - node.cosine * node.cosine, 0.0));
    return node;
}

// Puts the half of the triangles in front whose places are lower along the axis along which they
// differ most, or whose normals are, if those differ more.
void ShiningMesh::split(const Node& node, double size) {
    Bounds places, normals;
    for (std::uint32_t t = node.first; t < node.first + node.count; ++t) {
        places.include(m_mesh.middle(t));
        normals.include(glm::normalize(m_mesh.cross(t)));
    }
    const bool byNormal = largest(places.size()) / size < 0.5 * largest(normals.size());
    const int axis = axisOfLargest(byNormal ? normals.size() : places.size());
    const auto key = [&](std::uint32_t t) {
        return byNormal ? glm::normalize(m_mesh.cross(t))[axis] : m_mesh.middle(t)[axis];
    };
    std::vector<std::pair<double, std::array<std::uint32_t, 3>>> keyed;
    for (std::uint32_t t = node.first; t < node.first + node.count; ++t)
        keyed.emplace_back(key(t), m_mesh.triangles[t]);
    std::nth_element(keyed.begin(), keyed.begin() + node.count / 2, keyed.end());
    for (std::uint32_t i = 0; i < node.count; ++i) m_mesh.triangles[node.first + i] = keyed[i].second;
}

std::uint32_t ShiningMesh::build(std::uint32_t first, std::uint32_t count, double size) {
    const auto index = static_cast<std::uint32_t>(m_nodes.size());
    m_nodes.push_back(around(first, count));
    if (count <= kLeaf) return index;
    split(m_nodes[index], size);
    build(first, count / 2, size);
    const std::uint32_t second = build(first + count / 2, count - count / 2, size);
    m_nodes[index].second = second;
    return index;
}

double ShiningMesh::weightOf(std::uint32_t triangle, const Vec3& ws) const {
    return sent(m_crosses[triangle], ws - m_middles[triangle]);
}

double ShiningMesh::weightOf(const Node& node, const Vec3& ws) const {
    if (node.second != 0) return sent(node.area, ws - node.middle);
    double sum = 0;
    for (std::uint32_t t = node.first; t < node.first + node.count; ++t) sum += weightOf(t, ws);
    return sum;
}

// A node within an angle a as seen from `ws`, whose normals are within b of an axis, is turned
// towards it where the axis is within 90 - a - b degrees of the way to the place, and away from it
// where that is beyond 90 + a + b. Towards it are only nodes that are small beside their distance.
ShiningMesh::Turned ShiningMesh::turned(const Node& node, const Vec3& ws, double size) const {
    constexpr double kRounding = 1e-9;
    const Vec3 way = ws - node.middle;
    const double distance = glm::length(way), sine = node.radius / std::max(distance, 1e-300);
    if (sine >= 1) return Turned::unknown;
    const double cosine = std::sqrt(1 - sine * sine), along = glm::dot(node.axis, way) / distance;
    const double least = node.sine * cosine + node.cosine * sine + kRounding;
    if (!(node.cosine * cosine - node.sine * sine > 0)) return Turned::unknown;
    if (along < -least) return Turned::away;
    return along > least && sine < size ? Turned::towards : Turned::unknown;
}

ShiningMesh::Seen ShiningMesh::seenFrom(const Vec3& ws) const {
    constexpr double kSmall = 0.2;
    Seen seen;
    if (m_nodes.empty()) return seen;
    collect(0, ws, kSmall, [&](std::uint32_t index, Turned) {
        const double weight = weightOf(m_nodes[index], ws);
        if (!(weight > 0)) return;
        seen.nodes.push_back(index);
        seen.sums.push_back(weight + (seen.sums.empty() ? 0 : seen.sums.back()));
    });
    return seen;
}

// What is small beside its distance counts as its middle.
void ShiningMesh::nearest(std::uint32_t index, const Vec3& ws, double& distance) const {
    constexpr double kSmall = 0.05, kNearer = 0.95;
    const Node& node = m_nodes[index];
    if (const double away = glm::distance(ws, node.middle); node.radius < kSmall * away) {
        distance = std::min(distance, away);
        return;
    }
    if (node.second == 0) {
        for (std::uint32_t t = node.first; t < node.first + node.count; ++t)
            distance = std::min(distance, glm::distance(ws, nearestOf(m_mesh, t, ws)));
        return;
    }
    std::pair<double, std::uint32_t> children[] = {{0, index + 1}, {0, node.second}};
    for (auto& [least, child] : children) least = glm::distance(ws, m_nodes[child].middle) - m_nodes[child].radius;
    if (children[1] < children[0]) std::swap(children[0], children[1]);
    for (const auto& [least, child] : children)
        if (least < kNearer * distance) nearest(child, ws, distance);
}

double ShiningMesh::distance(const Vec3& ws) const {
    double distance = std::numeric_limits<double>::infinity();
    if (!m_nodes.empty()) nearest(0, ws, distance);
    return distance;
}

void ShiningMesh::addCrossings(std::uint32_t index, const Vec3& ws, const Vec3& way, std::vector<double>& at) const {
    const Node& node = m_nodes[index];
    const Vec3 beside = node.middle - ws;
    const double s = std::clamp(glm::dot(beside, way) / std::max(glm::dot(way, way), 1e-300), 0.0, 1.0);
    if (glm::distance(beside, s * way) > node.radius) return;
    if (node.second != 0) {
        addCrossings(index + 1, ws, way, at);
        addCrossings(node.second, ws, way, at);
        return;
    }
    for (std::uint32_t t = node.first; t < node.first + node.count; ++t)
        if (const std::optional<double> crossing = crossingOf(m_mesh, t, ws, way)) at.push_back(*crossing);
}

std::vector<double> ShiningMesh::crossings(const Vec3& ws, const Vec3& way) const {
    std::vector<double> at;
    if (!m_nodes.empty()) addCrossings(0, ws, way, at);
    std::ranges::sort(at);
    return at;
}

std::optional<ShiningMesh::Choice> ShiningMesh::choose(const Seen& seen, const Vec3& ws, double part) const {
    if (seen.nodes.empty()) return std::nullopt;
    Choice choice{0, 1, part};
    const auto step = [&](std::span<const double> sums) {
        const auto [i, rest] = findInSums(sums, choice.rest);
        choice.chance *= (sums[i] - (i > 0 ? sums[i - 1] : 0)) / sums.back();
        choice.rest = rest;
        return i;
    };
    std::uint32_t index = seen.nodes[step(seen.sums)];
    while (m_nodes[index].second != 0) {
        const std::uint32_t children[] = {index + 1, m_nodes[index].second};
        const double first = weightOf(m_nodes[children[0]], ws);
        index = children[step(std::array{first, first + weightOf(m_nodes[children[1]], ws)})];
    }
    const Node& leaf = m_nodes[index];
    std::array<double, kLeaf> ofLeaf{};
    double sum = 0;
    for (std::uint32_t i = 0; i < leaf.count; ++i) ofLeaf[i] = sum += weightOf(leaf.first + i, ws);
    choice.triangle = leaf.first + step({ofLeaf.data(), leaf.count});
    if (!(choice.chance > 0)) return std::nullopt;
    return choice;
}

}  // namespace scrim
