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

double phaseOver(const Phase& phase, double cosine, double toEye) {
    constexpr double kNarrow = 0.9995;
    if (cosine > kNarrow) return phaseValue(phase, toEye);
    const double aside = std::sqrt(std::max(1 - toEye * toEye, 0.0));
    double sum = 0;
    for (const double node : {0.21132486540518713, 0.78867513459481287}) {
        const double z = 1 - node * (1 - cosine), across = aside * std::sqrt(std::max(1 - z * z, 0.0));
        for (const auto& [turn, count] : {std::pair(1.0, 1), {0.5, 2}, {-0.5, 2}, {-1.0, 1}})
            sum += count * phaseValue(phase, std::clamp(z * toEye + across * turn, -1.0, 1.0));
    }
    return sum / 12;
}

Phase flattened(const Phase& phase, double part) {
    Phase flat = phase;
    flat.g *= part;
    flat.g2 *= part;
    flat.strength *= part;
    return flat;
}

}  // namespace scrim
