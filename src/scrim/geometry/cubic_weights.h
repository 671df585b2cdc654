// SPDX-License-Identifier: Apache-2.0
// The cubic that passes through values at whole places and keeps what is as fine as their distance.
#pragma once

#include <array>

namespace scrim {

/// The weights of four values in a row for a point that is `f`, 0 to 1, beyond the second (E. Catmull and R. Rom, "A
/// Class of Local Interpolating Splines", 1974). Their sum is 1; the outer two are at most 0.
inline std::array<double, 4> cubicWeights(double f) {
    const double f2 = f * f, f3 = f2 * f;
    return {-0.5 * f + f2 - 0.5 * f3, 1 - 2.5 * f2 + 1.5 * f3, 0.5 * f + 2 * f2 - 1.5 * f3, -0.5 * f2 + 0.5 * f3};
}

}  // namespace scrim
