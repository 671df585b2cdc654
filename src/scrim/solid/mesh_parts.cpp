// SPDX-License-Identifier: Apache-2.0
#include <scrim/solid/mesh_parts.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <span>

#include <glm/geometric.hpp>

namespace scrim {
namespace {

constexpr std::size_t kMostPieces = 64;  // triangles of a part

bool faces(const MeshPiece& piece, const Bounds& box) {
    const Vec3& n = piece.area;
    const Vec3 farthest(n.x > 0 ? box.upper.x : box.lower.x, n.y > 0 ? box.upper.y : box.lower.y,
                        n.z > 0 ? box.upper.z : box.lower.z);
    return glm::dot(farthest - piece.at, n) > 0;
}

// Adds a triangle in quarters of quarters that are no larger than `most`.
void addCut(const std::array<Vec3, 3>& corners, double most, TriangleMesh& out) {
    const auto& [a, b, c] = corners;
    if (0.5 * glm::length(glm::cross(b - a, c - a)) <= most) {
        const auto first = static_cast<std::uint32_t>(out.points.size());
        out.points.insert(out.points.end(), {a, b, c});
        out.triangles.push_back({first, first + 1, first + 2});
        return;
    }
    const Vec3 ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
    addCut({a, ab, ca}, most, out);
    addCut({ab, b, bc}, most, out);
    addCut({ca, bc, c}, most, out);
    addCut({ab, bc, ca}, most, out);
}

double areaOf(std::span<const MeshPiece> pieces) {
    return std::accumulate(pieces.begin(), pieces.end(), 0.0,
                           [](double sum, const MeshPiece& piece) { return sum + glm::length(piece.area); });
}

// Divides pieces across the longest axis, so that the area on either side is in proportion to the parts there.
void divide(std::span<MeshPiece> pieces, int parts, std::vector<MeshPart>& out) {
    if (parts <= 1 || pieces.size() <= 1) {
        if (!pieces.empty()) out.emplace_back(pieces.begin(), pieces.end());
        return;
    }
    Bounds box;
    for (const MeshPiece& piece : pieces) box.include(piece.at);
    const int axis = axisOfLargest(box.size()), lower = parts / 2;
    std::sort(pieces.begin(), pieces.end(), [&](const auto& a, const auto& b) { return a.at[axis] < b.at[axis]; });
    const double wanted = areaOf(pieces) * lower / parts;
    std::size_t first = 0;
    for (double sum = 0; first < pieces.size() - 1 && sum < wanted; ++first) sum += glm::length(pieces[first].area);
    first = std::max<std::size_t>(first, 1);
    divide(pieces.first(first), lower, out);
    divide(pieces.subspan(first), parts - lower, out);
}

// The pieces by the direction they face, if there are few: the sides of a box, or both sides of a
// sheet, which lie where they would be taken for one part. Otherwise all of them are one facet.
std::vector<MeshPart> facetsOf(const MeshPart& pieces) {
    constexpr double kAlike = 0.95;
    constexpr std::size_t kMostFacets = 12;
    std::vector<MeshPart> facets;
    for (const MeshPiece& piece : pieces) {
        const auto facet = std::ranges::find_if(facets, [&](const MeshPart& other) {
            const Vec3& a = other.front().area;
            return glm::dot(a, piece.area) > kAlike * glm::length(a) * glm::length(piece.area);
        });
        if (facet != facets.end())
            facet->push_back(piece);
        else if (facets.size() < kMostFacets)
            facets.push_back({piece});
        else
            return {pieces};
    }
    return facets;
}

}  // namespace

TriangleMesh cutTriangles(const TriangleMesh& mesh, double most) {
    TriangleMesh out;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const std::array<Vec3, 3> corners{mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)};
        if (mesh.cross(t) != Vec3(0)) addCut(corners, most, out);
    }
    return out;
}

PartShape shapeOf(const MeshPart& part) {
    PartShape shape;
    for (const MeshPiece& piece : part) {
        const double area = glm::length(piece.area);
        shape.middle += area * piece.at;
        shape.facing += piece.area;
        shape.area += area;
    }
    shape.middle /= shape.area;
    for (const MeshPiece& piece : part)
        shape.reach = std::max(shape.reach, glm::distance(piece.at, shape.middle) + std::sqrt(glm::length(piece.area)));
    return shape;
}

std::vector<MeshPart> meshParts(const TriangleMesh& mesh, const Bounds& box, int count) {
    const MeshPlaces places(mesh);
    std::vector<MeshPart> parts;
    if (!(places.area() > 0)) return parts;
    MeshPart pieces;
    if (const std::size_t most = kMostPieces * std::size_t(count); mesh.triangles.size() <= most) {
        const TriangleMesh cut = cutTriangles(mesh, places.area() / (4.0 * count));
        for (std::size_t t = 0; t < cut.triangles.size(); ++t) pieces.push_back({cut.middle(t), 0.5 * cut.cross(t)});
    } else {
        for (std::size_t i = 0; i < most; ++i) {
            const double across = double(i) / std::numbers::phi;
            const auto [at, normal] = places.at({(double(i) + 0.5) / double(most), across - std::floor(across)});
            pieces.push_back({at, places.area() / double(most) * normal});
        }
    }
    const auto leaveUnseen = [&](std::vector<MeshPart>& some) {
        std::erase_if(some, [&](const MeshPart& part) {
            return std::ranges::none_of(part, [&](const MeshPiece& piece) { return faces(piece, box); });
        });
    };
    std::vector<MeshPart> facets = facetsOf(pieces);
    leaveUnseen(facets);
    double area = 0;
    for (const MeshPart& facet : facets) area += areaOf(facet);
    for (MeshPart& facet : facets)
        divide(facet, std::max(static_cast<int>(std::lround(count * areaOf(facet) / area)), 1), parts);
    leaveUnseen(parts);
    return parts;
}

}  // namespace scrim
