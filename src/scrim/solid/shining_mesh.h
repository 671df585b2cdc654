// SPDX-License-Identifier: Apache-2.0
// The triangles of a mesh that shines, in a tree: what they send to a place, how far away they are
// and where a way crosses them is found without a look at each.
#pragma once

#include <scrim/solid/triangle_mesh.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace scrim {

class ShiningMesh {
  public:
    struct Choice {
        std::size_t triangle = 0;  ///< of mesh()
        double chance = 0;         ///< of this triangle, above 0
        double rest = 0;           ///< a number in [0, 1] as even as the one that chose
    };

    /// What shines to a place: nodes of the tree, and running sums of the light that each sends there.
    struct Seen {
        std::vector<std::uint32_t> nodes;
        std::vector<double> sums;
    };

    ShiningMesh() = default;
    /// Sorts the triangles, and leaves out those without an area.
    explicit ShiningMesh(TriangleMesh mesh);

    const TriangleMesh& mesh() const { return m_mesh; }

    Seen seenFrom(const Vec3& ws) const;
    /// Chooses a triangle by a number in [0, 1), nearly in proportion to the light that its middle sends to `ws`: every
    /// triangle with that place in front of it has a chance. Nothing where there is none. `seen`: from `ws`.
    std::optional<Choice> choose(const Seen& seen, const Vec3& ws, double part) const;

    /// Calls ofPart(place, area) for parts of the mesh that are far from `ws` beside their size and
    /// wholly turned towards it, with their middle and the sum of their areas along their normals,
    /// and ofTriangle(number) for all other triangles of which some may be turned towards it.
    template <class OfPart, class OfTriangle>
    void visit(const Vec3& ws, const OfPart& ofPart, const OfTriangle& ofTriangle) const;
    /// To the nearest triangle, within a tenth; infinite where there is none.
    double distance(const Vec3& ws) const;
    /// Where the way from `ws` to `ws` + `way` crosses triangles, as parts of the way in increasing order.
    std::vector<double> crossings(const Vec3& ws, const Vec3& way) const;

  private:
    // Some triangles that follow each other. An inner node has its first child behind it.
    struct Node {
        Vec3 middle{0};     // by area
        double radius = 0;  // all corners are as near to the middle, or nearer
        Vec3 area{0};       // the sum of twice the areas, each along its normal
        Vec3 axis{0};       // unit; the normals are within a cone around it
        double cosine = -1, sine = 0;
        std::uint32_t first = 0, count = 0;
        std::uint32_t second = 0;  // its other child; 0: a leaf
    };

    std::uint32_t build(std::uint32_t first, std::uint32_t count, double size);
    Node around(std::uint32_t first, std::uint32_t count) const;
    void split(const Node& node, double size);
    double weightOf(std::uint32_t triangle, const Vec3& ws) const;
    double weightOf(const Node& node, const Vec3& ws) const;
    enum class Turned { away, towards, unknown };
    Turned turned(const Node& node, const Vec3& ws, double size) const;
    template <class Whole>
    void collect(std::uint32_t index, const Vec3& ws, double size, const Whole& whole) const;
    void nearest(std::uint32_t index, const Vec3& ws, double& distance) const;
    void addCrossings(std::uint32_t index, const Vec3& ws, const Vec3& way, std::vector<double>& at) const;

    TriangleMesh m_mesh;
    std::vector<Vec3> m_middles, m_crosses;  // of each triangle
    std::vector<Node> m_nodes;
};

// Calls whole(node, how it is turned) for the largest nodes that are wholly turned towards `ws` and
// whose radius is smaller than `size` times the distance, and for leaves.
template <class Whole>
void ShiningMesh::collect(std::uint32_t index, const Vec3& ws, double size, const Whole& whole) const {
    const Node& node = m_nodes[index];
    const Turned side = turned(node, ws, size);
    if (side == Turned::away) return;
    if (side == Turned::towards || node.second == 0) {
        whole(index, side);
        return;
    }
    collect(index + 1, ws, size, whole);
    collect(node.second, ws, size, whole);
}

template <class OfPart, class OfTriangle>
void ShiningMesh::visit(const Vec3& ws, const OfPart& ofPart, const OfTriangle& ofTriangle) const {
    constexpr double kSmall = 0.1;
    if (m_nodes.empty()) return;
    collect(0, ws, kSmall, [&](std::uint32_t index, Turned side) {
        const Node& node = m_nodes[index];
        if (side == Turned::towards) {
            ofPart(node.middle, 0.5 * node.area);
            return;
        }
        for (std::uint32_t t = node.first; t < node.first + node.count; ++t) ofTriangle(t);
    });
}

}  // namespace scrim
