// SPDX-License-Identifier: Apache-2.0
// A surface that shines, divided into parts that are each seen as one from afar.
#pragma once

#include <scrim/geometry/bounds.h>
#include <scrim/solid/triangle_mesh.h>

#include <vector>

namespace scrim {

/// The triangles of a mesh, cut so that none is larger than `most`. Those without an area are left out.
TriangleMesh cutTriangles(const TriangleMesh& mesh, double most);

/// A flat piece of a surface.
struct MeshPiece {
    Vec3 at{0};    ///< its middle
    Vec3 area{0};  ///< its area, along its normal
};

using MeshPart = std::vector<MeshPiece>;

/// What a part is as a whole.
struct PartShape {
    Vec3 middle{0};
    Vec3 facing{0};   ///< the sum of MeshPiece::area
    double area = 0;  ///< the sum of the areas of its pieces
    /// The largest of |piece.at - middle| + sqrt(area of the piece): about the radius of the part around its middle.
    double reach = 0;
};
PartShape shapeOf(const MeshPart& part);

/// Divides the mesh into about `count` compact parts of about the same area, fewer if there are
/// fewer pieces, and leaves out those that have nothing of `box` in front of them. No part reaches
/// over the edges of a mesh with few facets. Large triangles are cut. Where there are more than 64
/// triangles a part, pieces are drawn at places spread evenly over the mesh.
std::vector<MeshPart> meshParts(const TriangleMesh& mesh, const Bounds& box, int count);

}  // namespace scrim
