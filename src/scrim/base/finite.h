// SPDX-License-Identifier: Apache-2.0
// Tests whether floats are finite, many at a time. A pass over memory costs next to nothing
// compared with computing the values.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

namespace scrim {

/// The exponent bits of infinities and NaNs are all set.
inline bool isFinite(float value) {
    constexpr std::uint32_t kExponent = 0x7f800000;
    return (std::bit_cast<std::uint32_t>(value) & kExponent) != kExponent;
}

inline bool allFinite(const std::vector<float>& values) {
    // Where all exponent bits are set, adding one carries into the sign bit. Sums and ORs vectorise.
    constexpr std::uint32_t kExponent = 0x7f800000, kOne = 0x00800000, kSign = 0x80000000;
    std::uint32_t flown = 0;
    for (const float value : values) flown |= (std::bit_cast<std::uint32_t>(value) & kExponent) + kOne;
    return (flown & kSign) == 0;
}

}  // namespace scrim
