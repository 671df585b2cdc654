// SPDX-License-Identifier: Apache-2.0
// Whether floats are finite, many at a time: a pass over memory that costs next to nothing beside what made them.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

namespace scrim {

/// Of infinities, and of what is no number, all bits of the exponent are set.
inline bool isFinite(float value) {
    constexpr std::uint32_t kExponent = 0x7f800000;
    return (std::bit_cast<std::uint32_t>(value) & kExponent) != kExponent;
}

inline bool allFinite(const std::vector<float>& values) {
    bool all = true;
    for (const float value : values) all &= isFinite(value);
    return all;
}

}  // namespace scrim
