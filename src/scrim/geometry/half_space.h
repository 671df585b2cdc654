// SPDX-License-Identifier: Apache-2.0
// Half-spaces, whose intersection is what cuts leave of a volume.
#pragma once

#include <scrim/geometry/spaces.h>

#include <algorithm>
#include <limits>
#include <vector>

#include <glm/vec4.hpp>

namespace scrim {

/// The points p with dot(normal, p) + offset >= 0. `normal` is a unit vector, which points inwards.
struct HalfSpace {
    Vec3 normal{0, 0, 1};
    double offset = 0;

    /// The distance of `p` from the face; below 0 outside.
    double depth(const Vec3& p) const { return glm::dot(normal, p) + offset; }
    /// The plane as a row vector, whose product with a point (x, y, z, 1) is the depth.
    glm::dvec4 row() const { return {normal, offset}; }
    bool operator==(const HalfSpace&) const = default;
};

/// The image of a half-space under the inverse of the affine map `from`: `from` maps the new space to the old one.
inline HalfSpace transformed(const HalfSpace& space, const Mat4& from) {
    const glm::dvec4 row = space.row() * from;
    const double length = glm::length(Vec3(row));
    return {Vec3(row) / length, row.w / length};
}

/// The depth of `p` in the intersection of `spaces`: below 0 outside of it, infinity where there are none.
inline double depthIn(const std::vector<HalfSpace>& spaces, const Vec3& p) {
    double depth = std::numeric_limits<double>::infinity();
    for (const HalfSpace& space : spaces) depth = std::min(depth, space.depth(p));
    return depth;
}

/// The fraction of a cell that lies in the intersection of `spaces`. `edges`: the cell's edges as
/// columns. It is exact for one face that is parallel to a face of the cell.
inline double partIn(const std::vector<HalfSpace>& spaces, const Vec3& centre, const Mat3& edges) {
    double part = 1;
    for (const HalfSpace& space : spaces) {
        const Vec3 across = glm::abs(space.normal * edges);
        part *= std::clamp(space.depth(centre) / (across.x + across.y + across.z) + 0.5, 0.0, 1.0);
    }
    return part;
}

/// What points at a depth below `reach` of each face add to a gradient, so that a cut shows a
/// surface: the inward normal times a factor that falls from 1 on the face to 0.
inline Vec3 facing(const std::vector<HalfSpace>& spaces, const Vec3& p, double reach) {
    Vec3 sum(0);
    for (const HalfSpace& space : spaces) sum += std::clamp(1 - space.depth(p) / reach, 0.0, 1.0) * space.normal;
    return sum;
}

}  // namespace scrim
