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

Phase dropletPhase(double size) {
    const double log = std::log(size);
    const auto lobes = [](double g, double g2, double alpha, double blend) {
        return Phase{g, PhaseType::twoLobe, g2, blend, 1, alpha};
    };
    if (size <= 0.1)
        return lobes(13.8 * size * size, 1.1456 * size * std::sin(9.29044 * size), 250,
                     0.252977 - 312.983 * std::pow(size, 4.3));
    if (size < 1.5) {
        const double wave = std::cos((log - 0.238604) * (log + 1.00667) / (0.507522 - 0.15677 * log));
        return lobes(0.862 - 0.143 * log * log,
                     0.344213 + 0.379685 * std::cos(1.19692 * wave + 1.37932 * log + 0.0625835), 250,
                     0.316072 + 0.0778917 * log + 0.146209 * std::cos(3.38707 * log + 2.11193));
    }
    if (size < 5)
        return lobes(0.940256 + 0.0604931 * std::log(log), 0.500411 - 0.081287 / (1.27551 + std::tan(log) - 2 * log),
                     6.31675 + 7.30354 * log,
                     0.376475 + 0.026914 * (log - std::cos(5.68947 * (std::log(log) - 0.0292149))));
    return lobes(std::exp(-0.0990567 / (size - 1.67154)), std::exp(-2.20679 / (size + 3.91029) - 0.428934),
                 std::exp(3.62489 - 8.29288 / (size + 5.52825)), std::exp(-0.599085 / (size - 0.641583) - 0.665888));
}

double phaseValue(const Phase& phase, double cosTheta) {
    switch (phase.type) {
        case PhaseType::twoLobe:
            return (1 - phase.blend) * henyeyGreenstein(phase.g, cosTheta) +
                   phase.blend * henyeyGreenstein(phase.g2, cosTheta) * (1 + phase.alpha * cosTheta * cosTheta) /
                       (1 + phase.alpha * (1 + 2 * phase.g2 * phase.g2) / 3);
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
    flat.alpha *= part;
    return flat;
}

std::vector<Octave> octavesOf(const Medium& medium) {
    std::vector<Octave> all{{medium.phase}};
    const Octaves& o = medium.octaves;
    for (int n = 1; n < o.count; ++n)
        all.push_back(
            {flattened(medium.phase, std::pow(o.phase, n)), std::pow(o.extinction, n), std::pow(o.contribution, n)});
    return all;
}

}  // namespace scrim
