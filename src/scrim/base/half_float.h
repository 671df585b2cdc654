// SPDX-License-Identifier: Apache-2.0
// Numbers of 16 bits (IEEE 754 binary16), as files and arrays hold them.
#pragma once

#include <bit>
#include <cstdint>

namespace scrim {

/// The number that 16 bits stand for. Written so that compilers vectorise it, and without denormal
/// floats, which count as 0 in parallel loops.
inline float fromHalf(std::uint16_t half) {
    constexpr std::uint32_t kBias = (127 - 15) << 23, kInfinity = 0x7F800000;
    const std::uint32_t magnitude = half & 0x7FFFU;
    const std::uint32_t normal = magnitude >= 0x7C00U ? kInfinity | magnitude << 13 : (magnitude << 13) + kBias;
    const auto small =
        std::bit_cast<std::uint32_t>(static_cast<float>(static_cast<std::int32_t>(magnitude)) * 0x1p-24f);
    return std::bit_cast<float>((magnitude < 0x400U ? small : normal) | std::uint32_t{half & 0x8000U} << 16);
}

}  // namespace scrim
