// SPDX-License-Identifier: Apache-2.0
// One shape of a list: a solid in its own coordinates (centre at 0, axis along y) and where that stands in the world.
// Everything a filler must know of a solid is its signed distance, so that a new kind is one more case in shape.cpp.
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
    double round = 0;     ///< radius of edges of a box or cylinder; of a torus: that of the tube
    double density = 1;   ///< of the inside, >= 0
    double soft = 0;      ///< world units from inside to outside; 0: the list's default
    std::string grid;     ///< the grid it belongs to
};

/// Distance of `ws` to the surface, in world units, negative inside. Exact, but for ellipsoids, whose distance is of
/// first order near the surface (and of the right sign everywhere).
double distance(const Shape& shape, const Vec3& ws);

/// Whether `distance` never changes faster than position does: it then bounds what a whole neighbourhood holds.
bool isExact(const Shape& shape);

/// Half the extents of the shape's box in the world, without its soft edge.
Vec3 wsHalfExtent(const Shape& shape);

/// The rotation that takes the y axis to `direction`, which must not be 0.
Mat3 rotationFromY(const Vec3& direction);

/// About x, then y, then z, right-handed, in degrees, as scenes do it. Multiples of 90 degrees are exact.
Mat3 rotationFromDegrees(const Vec3& degrees);

}  // namespace primitives
