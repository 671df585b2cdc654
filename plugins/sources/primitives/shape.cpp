// SPDX-License-Identifier: Apache-2.0
#include "shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace primitives {
namespace {

/// Distance to a box: outside, to the nearest corner, edge or face; inside, to the nearest face.
double boxDistance(const Vec3& p, const Vec3& half) {
    const Vec3 q = glm::abs(p) - half;
    return glm::length(glm::max(q, Vec3(0))) + std::min(std::max({q.x, q.y, q.z}), 0.0);
}

/// Distance to a cylinder, as for a box in the plane of radius and height.
double cylinderDistance(const Vec3& p, double radius, double halfHeight) {
    const double r = std::hypot(p.x, p.z) - radius, h = std::abs(p.y) - halfHeight;
    return std::hypot(std::max(r, 0.0), std::max(h, 0.0)) + std::min(std::max(r, h), 0.0);
}

/// First-order distance f / |grad f| for f = k (k - 1) with k = |p / half|, which is 0 on the surface.
double ellipsoidDistance(const Vec3& p, const Vec3& half) {
    const double k = glm::length(p / half);
    const double slope = glm::length(p / (half * half));
    // At the centre the slope is 0; no surface point is nearer than the shortest half axis.
    return slope > 0 ? k * (k - 1) / slope : -std::min({half.x, half.y, half.z});
}

double localDistance(const Shape& s, const Vec3& p) {
    switch (s.kind) {
        case Kind::box:
            return boxDistance(p, s.half - s.round) - s.round;
        case Kind::sphere:
            return glm::length(p) - s.half.x;
        case Kind::ellipsoid:
            return ellipsoidDistance(p, s.half);
        case Kind::cylinder:
            return cylinderDistance(p, s.half.x - s.round, s.half.y - s.round) - s.round;
        case Kind::capsule: {
            const double straight = s.half.y - s.half.x;
            return glm::length(Vec3(p.x, p.y - std::clamp(p.y, -straight, straight), p.z)) - s.half.x;
        }
        case Kind::torus:
            break;
    }
    return std::hypot(std::hypot(p.x, p.z) - (s.half.x - s.round), p.y) - s.round;
}

/// Sine and cosine, exact where they are integers.
std::array<double, 2> sinCos(double degrees) {
    const double turn = std::fmod(degrees, 360.0);
    const double quarter = turn / 90;
    if (quarter == std::floor(quarter)) {
        const int q = (static_cast<int>(quarter) + 4) % 4;
        constexpr std::array<double, 4> kSine{0, 1, 0, -1};
        return {kSine[static_cast<std::size_t>(q)], kSine[static_cast<std::size_t>((q + 1) % 4)]};
    }
    const double radians = turn * std::numbers::pi / 180;
    return {std::sin(radians), std::cos(radians)};
}

}  // namespace

double distance(const Shape& shape, const Vec3& ws) {
    return localDistance(shape, (ws - shape.wsCentre) * shape.wsFromLocal);  // v M is the transpose of M times v
}

bool isExact(const Shape& shape) {
    return shape.kind != Kind::ellipsoid;
}

Vec3 wsHalfExtent(const Shape& shape) {
    const Mat3& m = shape.wsFromLocal;
    return glm::abs(m[0]) * shape.half.x + glm::abs(m[1]) * shape.half.y + glm::abs(m[2]) * shape.half.z;
}

Mat3 rotationFromY(const Vec3& direction) {
    const Vec3 y = glm::normalize(direction);
    // Uses whichever of x and z is further from y. For a coordinate axis the result is a permutation without rounding.
    const Vec3 other = std::abs(y.x) <= std::abs(y.z) ? Vec3(1, 0, 0) : Vec3(0, 0, 1);
    const Vec3 a = glm::normalize(other - glm::dot(other, y) * y);
    return std::abs(y.x) <= std::abs(y.z) ? Mat3(a, y, glm::cross(a, y)) : Mat3(glm::cross(y, a), y, a);
}

Mat3 rotationFromDegrees(const Vec3& degrees) {
    const auto [sx, cx] = sinCos(degrees.x);
    const auto [sy, cy] = sinCos(degrees.y);
    const auto [sz, cz] = sinCos(degrees.z);
    const Mat3 x(1, 0, 0, 0, cx, sx, 0, -sx, cx), y(cy, 0, -sy, 0, 1, 0, sy, 0, cy), z(cz, sz, 0, -sz, cz, 0, 0, 0, 1);
    return z * y * x;
}

}  // namespace primitives
