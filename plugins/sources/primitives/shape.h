// SPDX-License-Identifier: Apache-2.0
// One shape of a list: a solid in its own coordinates (centre at 0, axis along y), and its place in the world. Filling
// needs nothing but the signed distance to a solid, so a new kind is one more case in shape.cpp.
#pragma once

#include <string>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace primitives {

using Vec3 = glm::dvec3;
using Mat3 = glm::dmat3;

enum class Kind { box, sphere, ellipsoid, cylinder, capsule, torus };

struct Shape {
    Kind kind = Kind::sphere;
    Vec3 wsCentre{0};
    Mat3 wsFromLocal{1};  ///< a rotation
    Vec3 half{1};         ///< local half extents, rounding and tube included
    double round = 0;     ///< radius of the edges of a box or cylinder; for a torus, the radius of the tube
    double density = 1;   ///< inside, >= 0
    double soft = 0;      ///< width of the edge, world units; 0: the list's default
    std::string grid;     ///< the grid it belongs to
};

/// Distance from `ws` to the surface, in world units, negative inside. Exact except for ellipsoids, whose distance is
/// of first order near the surface (and has the right sign everywhere).
double distance(const Shape& shape, const Vec3& ws);

/// True if `distance` never changes faster than position does; it then bounds the distances in a whole neighbourhood.
bool isExact(const Shape& shape);

/// Half the extent of the shape's box in the world, without its soft edge.
Vec3 wsHalfExtent(const Shape& shape);

/// The rotation that takes the y axis to `direction`, which must not be 0.
Mat3 rotationFromY(const Vec3& direction);

/// The rotation about x, then y, then z, right-handed, in degrees, as in scenes. Multiples of 90 degrees are exact.
Mat3 rotationFromDegrees(const Vec3& degrees);

}  // namespace primitives
