// SPDX-License-Identifier: Apache-2.0
// Points that fill a square evenly, however many are taken of them.
#pragma once

#include <scrim/geometry/spaces.h>

#include <glm/common.hpp>

namespace scrim {

/// Point `i` in the unit square of an endless set without gaps or clusters (M. Roberts' R2), shifted by `offset` and
/// wrapped.
inline Vec2 evenPoint(int i, const Vec2& offset = Vec2(0.5)) {
    return glm::fract(offset + double(i) * Vec2(0.7548776662466927, 0.5698402909980532));
}

}  // namespace scrim
