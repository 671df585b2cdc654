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
    // Where all bits of the exponent are set, one more flows over into the sign's: sums and ORs go many at a time.
    constexpr std::uint32_t kExponent = 0x7f800000, kOne = 0x00800000, kSign = 0x80000000;
    std::uint32_t flown = 0;
    for (const float value : values) flown |= (std::bit_cast<std::uint32_t>(value) & kExponent) + kOne;
    return (flown & kSign) == 0;
}

}  // namespace scrim
