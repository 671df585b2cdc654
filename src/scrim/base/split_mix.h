// SPDX-License-Identifier: Apache-2.0
// Random numbers that are the same in every run (G. Steele, D. Lea and C. Flood, Fast Splittable
// Pseudorandom Number Generators, 2014: SplitMix64).
#pragma once

#include <cstdint>

namespace scrim {

inline constexpr std::uint64_t kSplitMixStep = 0x9e3779b97f4a7c15;

/// The number that follows state `v`.
constexpr std::uint64_t splitMix(std::uint64_t v) {
    v += kSplitMixStep;
    v = (v ^ v >> 30) * 0xbf58476d1ce4e5b9;
    v = (v ^ v >> 27) * 0x94d049bb133111eb;
    return v ^ v >> 31;
}

}  // namespace scrim
