// SPDX-License-Identifier: Apache-2.0
// Axis-aligned boxes.
#pragma once

#include <scrim/geometry/spaces.h>

#include <array>
#include <limits>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace scrim {

/// A closed box. It starts empty and grows by `include`.
struct Bounds {
    Vec3 lower{std::numeric_limits<double>::infinity()};
    Vec3 upper{-std::numeric_limits<double>::infinity()};

    bool operator==(const Bounds&) const = default;
    bool empty() const { return lower.x > upper.x || lower.y > upper.y || lower.z > upper.z; }
    Vec3 center() const { return 0.5 * lower + 0.5 * upper; }
    Vec3 size() const { return upper - lower; }
    void include(const Vec3& p) {
        lower = glm::min(lower, p);
        upper = glm::max(upper, p);
    }
    void include(const Bounds& b) {
        lower = glm::min(lower, b.lower);
        upper = glm::max(upper, b.upper);
    }
    bool contains(const Vec3& p) const {
        return p.x >= lower.x && p.y >= lower.y && p.z >= lower.z && p.x <= upper.x && p.y <= upper.y && p.z <= upper.z;
    }
    /// Of a point to the nearest one of the box; 0 within it.
    double distance(const Vec3& p) const { return glm::distance(p, glm::clamp(p, lower, upper)); }
    /// The part of [begin, end] in which origin + t direction is inside of the box; empty where first > second.
    std::pair<double, double> clip(const Vec3& origin, const Vec3& direction, double begin, double end) const {
        for (int axis = 0; axis < 3; ++axis) {
            if (direction[axis] == 0) {
                if (origin[axis] < lower[axis] || origin[axis] > upper[axis])
                    end = -std::numeric_limits<double>::infinity();
                continue;
            }
            const double a = (lower[axis] - origin[axis]) / direction[axis];
            const double b = (upper[axis] - origin[axis]) / direction[axis];
            begin = glm::max(begin, glm::min(a, b));
            end = glm::min(end, glm::max(a, b));
        }
        return {begin, end};
    }
    std::array<Vec3, 8> corners() const {
        std::array<Vec3, 8> c;
        for (int i = 0; i < 8; ++i)
            c[i] = {i & 1 ? upper.x : lower.x, i & 2 ? upper.y : lower.y, i & 4 ? upper.z : lower.z};
        return c;
    }
};

/// The box around the image of `b` under the affine map `m`.
inline Bounds transformed(const Mat4& m, const Bounds& b) {
    Bounds out;
    if (b.empty()) return out;
    for (const Vec3& c : b.corners()) out.include(transformPoint(m, c));
    return out;
}

}  // namespace scrim
