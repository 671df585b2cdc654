// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/split_phase.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace scrim::test {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(SplitPhase, LosesNothingAndKeepsAllMomentsThatOrdinatesResolve) {
    const Phase two{0.9, PhaseType::twoLobe, -0.3, 0.25}, rayleigh{0, PhaseType::rayleigh};
    for (const Phase& phase : {Phase{0.75}, Phase{0.9}, Phase{0.2}, Phase{-0.8}, two, rayleigh, drainePhase(0.7, 5),
                               drainePhase(-0.4, 250), dropletPhase(3), dropletPhase(12)}) {
        const SplitPhase split(phase, 6);
        const double f = split.straight();
        EXPECT_EQ(f > 0, std::max(phase.g, phase.g2) > 0.5);
        for (std::size_t l = 0; l < split.spread().size(); ++l) {
            // The moments of the phase function, by the midpoint rule over angles, since lobes are narrow.
            double exact = 0;
            constexpr int kSteps = 20000;
            for (int i = 0; i < kSteps; ++i) {
                const double angle = kPi * (i + 0.5) / kSteps, cosine = std::cos(angle);
                exact += 2 * kPi * phaseValue(phase, cosine) * std::legendre(static_cast<unsigned>(l), cosine) *
                         std::sin(angle) * kPi / kSteps;
            }
            EXPECT_NEAR(f + (1 - f) * split.spread()[l], exact, 1e-4) << phase.g << " " << l;
            EXPECT_NEAR(split.whole()[l], exact, 1e-4) << phase.g << " " << l;
        }
        // Of light that comes a long way all but e^-depth has been scattered.
        for (const double depth : {0.3, 2.0, 20.0}) {
            double sum = 0;
            constexpr int kSteps = 20000;
            for (int i = 0; i < kSteps; ++i)
                sum += 2 * kPi * split.scatteredAgain(depth, (i + 0.5) / kSteps * 2 - 1) * 2 / kSteps;
            EXPECT_NEAR(sum, f > 0 ? 1 - std::exp(-depth) : 0, 0.01) << phase.g << " " << depth;
        }
    }
}

// Repeated scattering multiplies moments, so light that was scattered n times is a binomial sum: of the phase
// function's own powers, and of the series of the lobe that is taken away.
TEST(SplitPhase, SpreadsABeamAsRepeatedScatteringDoes) {
    const Phase phase{0.85};
    constexpr std::size_t kTerms = 200;
    for (const int moments : {6, 8, 10}) {
        const SplitPhase split(phase, moments);
        const double f = split.straight();
        for (const double depth : {0.2, 1.0, 3.0})
            for (const double cosine : {0.98, 0.8, 0.3, -0.5}) {
                double sum = 0;
                for (std::size_t l = 0; l < kTerms; ++l) {
                    const double all = std::pow(phase.g, double(l));
                    const double rest = l < split.first().size() ? split.first()[l] : 0;
                    double narrow = 1, times = 0, poisson = std::exp(-depth);
                    for (int n = 1; n < 40; ++n) {
                        poisson *= depth / n;
                        narrow *= (all - (1 - f) * rest) / f;
                        times += poisson * narrow;
                    }
                    sum +=
                        (2 * double(l) + 1) / (4 * kPi) * all * times * std::legendre(static_cast<unsigned>(l), cosine);
                }
                EXPECT_NEAR(split.scatteredAgain(depth, cosine), sum, 0.01 * std::abs(sum) + 2e-3)
                    << depth << " " << cosine;
            }
    }
}

// With most ordinates, light is scattered for the first time as the phase function says, but for its lobe. The series
// of its own moments is far from it, and below zero.
TEST(SplitPhase, ScattersFirstAsThePhaseFunctionBesideItsLobe) {
    for (const double g : {0.75, 0.85, 0.9, 0.95}) {
        const Phase phase{g};
        const SplitPhase split(phase, 10);
        const double f = split.straight();
        for (std::size_t l = 0; l < 2; ++l) EXPECT_DOUBLE_EQ(split.first()[l], split.spread()[l]);
        double own = 0, first = 0, all = 0, least = 1;
        for (double angle = 0.5; angle < kPi; angle += 0.01) {
            double series[2] = {0, 0};
            for (std::size_t l = 0; l < split.first().size(); ++l) {
                const double term = (1 - f) * (2 * double(l) + 1) / (4 * kPi) *
                                    std::legendre(static_cast<unsigned>(l), std::cos(angle));
                series[0] += term * split.spread()[l];
                series[1] += term * split.first()[l];
            }
            const double exact = phaseValue(phase, std::cos(angle));
            own += std::pow(series[0] / exact - 1, 2);
            first += std::pow(series[1] / exact - 1, 2);
            least = std::min(least, series[1] / exact);
            ++all;
        }
        EXPECT_LT(std::sqrt(first / all), 0.4) << g;  // 0.06 for g = 0.75
        EXPECT_GT(std::sqrt(own / all), 4 * std::sqrt(first / all)) << g;
        EXPECT_GT(least, 0) << g;
    }
}

}  // namespace
}  // namespace scrim::test
