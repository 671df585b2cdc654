// SPDX-License-Identifier: Apache-2.0
// Points that fill a square evenly, however many are taken of them, and directions.
#pragma once

#include <scrim/geometry/spaces.h>

#include <cmath>
#include <numbers>

#include <glm/common.hpp>

namespace scrim {

/// Point `i` in the unit square of an endless set without gaps or clusters (M. Roberts' R2),
/// shifted by `offset` and wrapped.
inline Vec2 evenPoint(int i, const Vec2& offset = Vec2(0.5)) {
    return glm::fract(offset + double(i) * Vec2(0.7548776662466927, 0.5698402909980532));
}

/// Direction `i`, unit, of `count` that lie evenly around a point.
inline Vec3 evenDirection(int i, int count) {
    const double z = 1 - (2.0 * i + 1) / count, turn = 2 * std::numbers::pi * evenPoint(i).x;
    return {std::sqrt(1 - z * z) * std::cos(turn), std::sqrt(1 - z * z) * std::sin(turn), z};
}

}  // namespace scrim
