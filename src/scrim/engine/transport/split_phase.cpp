// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/transport/split_phase.h>

#include <scrim/base/parallel.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace scrim {
namespace {

// The table over depth / (1 + depth) and the sine of half the angle, both in [0, 1]; linear between entries.
constexpr int kDepths = 64, kAngles = 256;
constexpr double kLeastMoment = 1e-4;
constexpr int kMostMoments = 400;

// The mean cosine of the narrowest lobe that the ordinates must resolve. Measured on smoke lit from behind and from the
// side, g = 0.75 and 0.9: with narrower lobes, smoke is too bright where the eye looks near the light; with wider ones,
// which send more light straight on, light is carried too far.
double narrowestLobe(int ordinates) {
    return ordinates <= 64 ? 0.6 : ordinates <= 128 ? 0.7 : 0.85;
}

// The Legendre moments of a phase function: g^l for Henyey and Greenstein's.
struct Moments {
    const Phase& phase;
    double first = 1, second = 1;

    double value() const {
        return phase.type == PhaseType::twoLobe ? (1 - phase.blend) * first + phase.blend * second : first;
    }
    void next() {
        first *= phase.g;
        second *= phase.g2;
    }
};

// The phase function with its narrowest lobes widened. Narrower ones are like a line here, forwards and backwards, and
// would only cause divisions by zero.
Phase heldLobes(Phase phase) {
    constexpr double kNarrowest = 0.9999;
    phase.g = std::clamp(phase.g, -kNarrowest, kNarrowest);
    phase.g2 = std::clamp(phase.g2, -kNarrowest, kNarrowest);
    return phase;
}

}  // namespace

SplitPhase::SplitPhase(const Phase& given, int ordinates) : m_spread(heldLobes(given)) {
    const Phase phase = m_spread;
    if (phase.type == PhaseType::rayleigh) return;
    // For a lobe with mean cosine g, the fraction f goes straight on and the rest has w: f + (1 - f) w = g.
    const double w = narrowestLobe(ordinates);
    const auto straightOf = [&](double g) { return g > w ? (g - w) / (1 - w) : 0.0; };
    m_straight = straightOf(phase.g);
    m_spread.g = std::min(phase.g, w);
    if (phase.type == PhaseType::twoLobe) {
        const double second = straightOf(phase.g2);
        m_straight += phase.blend * (second - m_straight);
        m_spread.g2 = std::min(phase.g2, w);
        m_spread.blend = phase.blend * (1 - second) / (1 - m_straight);
    }
    if (m_straight == 0) return;
    m_table.resize(std::size_t(kDepths) * kAngles);
    parallelFor(kDepths, [&](std::size_t i) {
        const double part = double(i) / (kDepths - 1);
        const double depth = i + 1 < kDepths ? part / (1 - part) : 1e6;
        std::vector<double> weights;
        for (Moments all{phase}, wide{m_spread}; weights.size() < kMostMoments; all.next(), wide.next()) {
            const double narrow = (all.value() - (1 - m_straight) * wide.value()) / m_straight;
            const auto l = static_cast<double>(weights.size());
            weights.push_back((2 * l + 1) / (4 * std::numbers::pi) * all.value() *
                              (std::exp(depth * (narrow - 1)) - std::exp(-depth)));
            if (std::abs(all.value()) * (2 * l + 1) < kLeastMoment) break;
        }
        for (int a = 0; a < kAngles; ++a) {
            const double sine = double(a) / (kAngles - 1), cosine = 1 - 2 * sine * sine;
            double sum = 0, before = 0, polynomial = 1;
            for (std::size_t l = 0; l < weights.size(); ++l) {
                sum += weights[l] * polynomial;
                const auto n = static_cast<double>(l);
                const double next = ((2 * n + 1) * cosine * polynomial - n * before) / (n + 1);
                before = polynomial;
                polynomial = next;
            }
            m_table[i * kAngles + std::size_t(a)] = static_cast<float>(sum);
        }
    });
}

double SplitPhase::scatteredAgain(double depth, double cosTheta) const {
    if (m_table.empty()) return 0;
    const double i = depth / (1 + depth) * (kDepths - 1);
    const double a = std::sqrt(std::clamp(0.5 * (1 - cosTheta), 0.0, 1.0)) * (kAngles - 1);
    const auto row = std::min(static_cast<std::size_t>(i), std::size_t(kDepths - 2));
    const auto column = std::min(static_cast<std::size_t>(a), std::size_t(kAngles - 2));
    const double t = i - double(row), s = a - double(column);
    const float* p = m_table.data() + row * kAngles + column;
    const auto along = [&](const float* v) { return double(v[0]) + s * double(v[1] - v[0]); };
    return along(p) + t * (along(p + kAngles) - along(p));
}

}  // namespace scrim
