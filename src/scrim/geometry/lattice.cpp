// SPDX-License-Identifier: Apache-2.0
#include <scrim/geometry/lattice.h>

#include <glm/geometric.hpp>

namespace scrim {

Vec3 Lattice::place(const Vec3& ts) const {
    const glm::dvec4 p = rsFromTs * glm::dvec4(ts, 1.0);
    return {p.x / p.w, p.y / p.w, p.w};
}

Mat4 Lattice::linearised(const Vec3& ts) const {
    if (parallel()) return rsFromTs;
    const Vec3 at = place(ts);
    Mat4 map(1.0);
    for (int axis = 0; axis < 3; ++axis) {
        const glm::dvec4& column = rsFromTs[axis];
        map[axis] = {(column.x - at.x * column.w) / at.z, (column.y - at.y * column.w) / at.z, column.z, 0.0};
    }
    const Vec3 moved = transformVector(map, ts);
    map[3] = {at.x - moved.x, at.y - moved.y, ts.z - moved.z, 1.0};
    return map;
}

Vec3 Lattice::rayThrough(double x, double y) const {
    // Along the ray, X - x W and Y - y W stay 0, so the ray is perpendicular to both of their gradients.
    const auto gradient = [&](int row, double place) {
        const auto part = [&](int axis) { return rsFromTs[axis][row] - place * rsFromTs[axis][3]; };
        return Vec3(part(0), part(1), part(2));
    };
    return glm::cross(gradient(0, x), gradient(1, y));
}

Mat3 Lattice::fromPlane(double n) const {
    const auto part = [](const glm::dvec4& column) { return Vec3(column.x, column.y, column.w); };
    return {part(rsFromTs[0]), part(rsFromTs[1]), part(rsFromTs[2]) * n + part(rsFromTs[3])};
}

}  // namespace scrim
