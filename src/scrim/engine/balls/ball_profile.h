// SPDX-License-Identifier: Apache-2.0
// What a ball hides and sends, from its middle to its rim. A ray at distance q radii from the centre passes a chord of
// 2 r s, s = sqrt(1 - q^2). With h = 2 r sigma, the optical depth of the longest chord, it meets the opacity
// 1 - exp(-h s), and of radiance e per world unit sends e 2 r (1 - exp(-h s)) / h. So both are multiples of the profile
// w(q) = (1 - exp(-h s)) / h, of which rings have integrals in closed form: none of a ball is lost, whatever the rings.
#pragma once

#include <algorithm>
#include <cmath>

namespace scrim {

/// The integral of w over the disc of radius 1 beyond the ring where s = `s`, divided by pi: from 0 for s = 0 to that
/// of the whole disc for s = 1, which is 2/3 for a thin ball. Its error is below 1e-6.
inline double ballShareWithin(double h, double s) {
    // 2 times the integral of (1 - exp(-h s)) / h s ds, which loses its digits where h is small: its series.
    constexpr double kSmall = 0.05;
    if (h < kSmall) return 2 * s * s * s * (1.0 / 3 - h * s * (1.0 / 8 - h * s * (1.0 / 30 - h * s / 144)));
    const double x = h * s;
    return 2 * (0.5 * s * s - (1 - (1 + x) * std::exp(-x)) / (h * h)) / h;
}

/// The share of a ball between the distances `from` and `to` (radii) from its centre.
inline double ballShare(double h, double from, double to) {
    const auto at = [](double q) { return std::sqrt(std::max(1 - q * q, 0.0)); };
    return ballShareWithin(h, at(from)) - ballShareWithin(h, at(to));
}

/// That of a disc, which is alike everywhere: w = 1.
inline double discShare(double from, double to) {
    return to * to - from * from;
}

}  // namespace scrim
