// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/split_phase.h>

#include <scrim/base/least_squares.h>
#include <scrim/base/legendre.h>
#include <scrim/base/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

namespace scrim {
namespace {

constexpr double kPi = std::numbers::pi;

// The table over depth / (1 + depth) and the sine of half the angle, both in [0, 1]; linear between entries.
constexpr int kDepths = 64, kAngles = 256;
constexpr double kLeastTerm = 1e-4;  // relative to an even distribution over all directions
constexpr int kMostMoments = 5000;   // the lobe of droplets of 50 micrometres has 3,000

// The phase function with its narrowest lobes widened. Narrower ones are like a line here, forwards
// and backwards, and would only cause divisions by zero.
Phase heldLobes(Phase phase) {
    constexpr double kNarrowest = 0.9999;
    phase.g = std::clamp(phase.g, -kNarrowest, kNarrowest);
    phase.g2 = std::clamp(phase.g2, -kNarrowest, kNarrowest);
    return phase;
}

// Moments of which the first two are `moments`. The series of all of them, times 1 - straight, is
// as close as can be to the phase function at angles beyond kLobe, relative to it.
std::vector<double> besideLobe(const Phase& phase, std::vector<double> moments, double straight) {
    constexpr std::size_t kKept = 2;
    constexpr double kLobe = 0.35;
    constexpr int kSteps = 720;
    const std::size_t free = moments.size() - kKept;
    std::vector<std::vector<double>> matrix(free, std::vector<double>(free, 0.0));
    std::vector<double> right(free, 0.0), terms(free);
    for (int i = static_cast<int>(kLobe / kPi * kSteps); i < kSteps; ++i) {
        const double angle = kPi * (i + 0.5) / kSteps, value = phaseValue(phase, std::cos(angle));
        double left = 1;  // relative to the value, as all terms
        forLegendre(moments.size(), std::cos(angle), [&](std::size_t l, double p) {
            const double term = (2 * double(l) + 1) * p * (1 - straight) / (4 * kPi * value);
            if (l < kKept)
                left -= term * moments[l];
            else
                terms[l - kKept] = term;
        });
        for (std::size_t r = 0; r < free; ++r) {
            right[r] += std::sin(angle) * terms[r] * left;
            for (std::size_t c = 0; c < free; ++c) matrix[r][c] += std::sin(angle) * terms[r] * terms[c];
        }
    }
    const std::vector<double> found = leastSquares(std::move(matrix), std::move(right));
    std::copy(found.begin(), found.end(), moments.begin() + std::ptrdiff_t(kKept));
    return moments;
}

}  // namespace

std::vector<double> legendreMoments(const Phase& phase, int count) {
    std::vector<double> moments(std::size_t(count), 0.0);
    // Draine's: cos^2 P_l is a sum of P_{l-2}, P_l and P_{l+2}.
    const auto draine = [&](double n) {
        const double beside = (n + 1) * (n + 1) / ((2 * n + 1) * (2 * n + 3)) + n * n / ((2 * n + 1) * (2 * n - 1));
        const double after = (n + 1) * (n + 2) / ((2 * n + 1) * (2 * n + 3));
        double sum = after * std::pow(phase.g2, n + 2) + beside * std::pow(phase.g2, n);
        if (n >= 2) sum += n * (n - 1) / ((2 * n + 1) * (2 * n - 1)) * std::pow(phase.g2, n - 2);
        return (std::pow(phase.g2, n) + phase.alpha * sum) / (1 + phase.alpha * (1 + 2 * phase.g2 * phase.g2) / 3);
    };
    for (std::size_t l = 0; l < moments.size(); ++l) {
        const auto n = static_cast<double>(l);
        moments[l] = phase.type == PhaseType::rayleigh ? (l == 0   ? 1
                                                          : l == 2 ? 0.1 * phase.strength
                                                                   : 0)
                     : phase.type == PhaseType::twoLobe
                         ? (1 - phase.blend) * std::pow(phase.g, n) + phase.blend * draine(n)
                         : std::pow(phase.g, n);
    }
    return moments;
}

SplitPhase::SplitPhase(const Phase& given, int moments) {
    constexpr int kMany = 10;         // moments
    constexpr double kLittle = 1e-3;  // what goes straight on below this is not worth a table
    const Phase phase = heldLobes(given);
    m_spread = m_first = m_whole = legendreMoments(phase, moments);
    if (phase.type == PhaseType::rayleigh) return;
    // Light goes straight on forwards only: what is left of backward lobes is cut off.
    Phase forwards = phase;
    forwards.g = std::max(phase.g, 0.0);
    forwards.g2 = std::max(phase.g2, 0.0);
    m_straight = legendreMoments(forwards, moments + 1).back();
    if (m_straight < kLittle) m_straight = 0;
    if (m_straight == 0) return;
    for (double& moment : m_spread) moment = (moment - m_straight) / (1 - m_straight);
    m_first = moments >= kMany ? besideLobe(phase, m_spread, m_straight) : m_spread;
    const std::vector<double> all = legendreMoments(phase, kMostMoments);
    // A weight is at most the term's here, since exp(depth narrow) - 1 times exp(-depth) is less than about narrow.
    std::size_t terms = m_spread.size() + 1;
    while (terms < all.size() && all[terms] * all[terms] * double(2 * terms + 1) > kLeastTerm * m_straight) ++terms;
    std::vector<std::array<double, kDepths>> weights(terms);
    parallelFor(terms, [&](std::size_t l) {
        const double rest = l < m_first.size() ? (1 - m_straight) * m_first[l] : 0;
        const double narrow = (all[l] - rest) / m_straight;
        for (std::size_t i = 0; i < kDepths; ++i) {
            const double part = double(i) / (kDepths - 1), depth = i + 1 < kDepths ? part / (1 - part) : 1e6;
            weights[l][i] =
                double(2 * l + 1) / (4 * kPi) * all[l] * (std::exp(depth * (narrow - 1)) - std::exp(-depth));
        }
    });
    m_table.resize(std::size_t(kDepths) * kAngles);
    parallelFor(kAngles, [&](std::size_t a) {
        const double sine = double(a) / (kAngles - 1);
        std::array<double, kDepths> sums{};
        forLegendre(terms, 1 - 2 * sine * sine, [&](std::size_t l, double p) {
            for (std::size_t i = 0; i < kDepths; ++i) sums[i] += weights[l][i] * p;
        });
        for (std::size_t i = 0; i < kDepths; ++i) m_table[i * kAngles + a] = static_cast<float>(sums[i]);
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
