// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/medium.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace scrim {
namespace {

constexpr double kFourPi = 4 * std::numbers::pi;

double henyeyGreenstein(double g, double cosTheta) {
    // The clamp keeps rounding from taking the peak of a narrow lobe to zero.
    const double x = std::max(1 + g * g - 2 * g * cosTheta, (1 - std::abs(g)) * (1 - std::abs(g)));
    return (1 - g * g) / (kFourPi * std::pow(x, 1.5));
}

}  // namespace

double phaseValue(const Phase& phase, double cosTheta) {
    switch (phase.type) {
        case PhaseType::twoLobe:
            return (1 - phase.blend) * henyeyGreenstein(phase.g, cosTheta) +
                   phase.blend * henyeyGreenstein(phase.g2, cosTheta);
        case PhaseType::rayleigh:
            return (1 + phase.strength * (0.75 * (1 + cosTheta * cosTheta) - 1)) / kFourPi;
        default:
            return henyeyGreenstein(phase.g, cosTheta);
    }
}

Phase flattened(const Phase& phase, double part) {
    Phase flat = phase;
    flat.g *= part;
    flat.g2 *= part;
    flat.strength *= part;
    return flat;
}

}  // namespace scrim
