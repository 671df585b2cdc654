// SPDX-License-Identifier: Apache-2.0
// Triangles in memory.
#pragma once

#include <scrim/geometry/spaces.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace scrim {

struct TriangleMesh {
    std::vector<Vec3> points;                             ///< finite, in the file's own space
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices of points

    /// The corner `i` of a triangle.
    const Vec3& corner(std::size_t triangle, std::size_t i) const { return points[triangles[triangle][i]]; }
    /// Twice the area of a triangle, along its normal.
    Vec3 cross(std::size_t triangle) const;
    Vec3 middle(std::size_t triangle) const;
    /// Maps the unit square to a triangle, evenly by area.
    Vec3 place(std::size_t triangle, const Vec2& square) const;
    std::size_t bytes() const { return points.size() * sizeof(Vec3) + triangles.size() * sizeof(triangles[0]); }
};

/// Turns every triangle over.
void turnOver(TriangleMesh& mesh);

/// True if the mesh is closed, all its triangles are turned alike, and their corners are clockwise
/// as seen from outside. Points at the same place count as one.
bool isInsideOut(const TriangleMesh& mesh);

/// Draws places on a mesh, evenly by area. Keeps a reference to the mesh.
class MeshPlaces {
  public:
    struct Place {
        Vec3 at{0};            ///< in front of the triangle by 1e-4 of the mesh's size, so that it is not in the way
        Vec3 normal{0, 0, 1};  ///< unit; seen from its side, the corners of the triangle are counterclockwise
    };

    explicit MeshPlaces(const TriangleMesh& mesh);
    double area() const { return m_areas.empty() ? 0 : m_areas.back(); }
    /// Maps the unit square to the mesh. Only where area() > 0.
    Place at(const Vec2& square) const;

  private:
    const TriangleMesh& m_mesh;
    double m_lift = 0;
    std::vector<double> m_areas;  // of each triangle and all before it
};

}  // namespace scrim
