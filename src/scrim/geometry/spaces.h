// SPDX-License-Identifier: Apache-2.0
// The spaces of Scrim and the few types in which all geometry is written.
//
// Names carry their space as a prefix: `ws` world, `is` a grid's index space (voxel centres at integers), `ss` sweep
// space (u, v, w; world units, w along the sweep's axis), `rs` a view's raster (pixel (0,0) covers [0,1) x [0,1), y
// down). A transform's name says what it maps: `wsFromIs` takes index space to world space. Everything here is double;
// float begins only where coordinates are local to a sheet or a leaf.
#pragma once

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace scrim {

using Vec2 = glm::dvec2;
using Vec3 = glm::dvec3;
using Int2 = glm::ivec2;
using Int3 = glm::ivec3;
using Mat3 = glm::dmat3;  ///< column-major, as GLM
using Mat4 = glm::dmat4;  ///< column-major; the last column is the translation
using Rgb = glm::dvec3;   ///< scene-linear colour in the working space

inline bool isGrey(const Rgb& colour) {
    return colour.x == colour.y && colour.x == colour.z;
}

/// The largest and the smallest component of a vector, and the axis of the largest.
template <class T>
T largest(const glm::vec<3, T>& v) {
    return std::max(std::max(v.x, v.y), v.z);
}
template <class T>
T smallest(const glm::vec<3, T>& v) {
    return std::min(std::min(v.x, v.y), v.z);
}
inline int axisOfLargest(const Vec3& v) {
    return v.x >= v.y && v.x >= v.z ? 0 : v.y >= v.z ? 1 : 2;
}

/// The floor of a vector, which fits integers. A library's floor takes as long as a third of a look-up.
inline Int3 wholeBelow(const Vec3& v) {
    const Int3 whole(v);
    return {whole.x - (v.x < whole.x ? 1 : 0), whole.y - (v.y < whole.y ? 1 : 0), whole.z - (v.z < whole.z ? 1 : 0)};
}

/// The image of the position `p` under the affine map `m`.
inline Vec3 transformPoint(const Mat4& m, const Vec3& p) {
    return Vec3(m[0]) * p.x + Vec3(m[1]) * p.y + Vec3(m[2]) * p.z + Vec3(m[3]);
}

/// The image of the vector `v` (no translation) under the affine map `m`.
inline Vec3 transformVector(const Mat4& m, const Vec3& v) {
    return Vec3(m[0]) * v.x + Vec3(m[1]) * v.y + Vec3(m[2]) * v.z;
}

/// A coordinate axis far from the unit vector `axis`.
inline Vec3 apartFrom(const Vec3& axis) {
    return std::abs(axis.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
}

/// An orthonormal frame whose third column is the unit vector `axis`.
inline Mat3 frameAround(const Vec3& axis) {
    const Vec3 x = glm::normalize(glm::cross(axis, apartFrom(axis)));
    return {x, glm::cross(axis, x), axis};
}

}  // namespace scrim
