// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/transport/ordinates.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace scrim::test {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(SplitPhase, LosesNothingAndKeepsTheMeanCosine) {
    const Phase two{0.9, PhaseType::twoLobe, -0.3, 0.25};
    for (const Phase& phase : {Phase{0.75}, Phase{0.9}, Phase{0.3}, Phase{-0.8}, two}) {
        const SplitPhase split(phase, 64);
        const auto cosineOf = [](const Phase& p) {
            return p.type == PhaseType::twoLobe ? (1 - p.blend) * p.g + p.blend * p.g2 : p.g;
        };
        EXPECT_NEAR(split.straight() + (1 - split.straight()) * cosineOf(split.spread()), cosineOf(phase), 1e-12);
        EXPECT_EQ(split.straight() > 0, phase.g > 0.6);
        // Of light that comes a long way all but e^-depth has been scattered.
        for (const double depth : {0.3, 2.0, 20.0}) {
            double sum = 0;
            constexpr int kSteps = 20000;
            for (int i = 0; i < kSteps; ++i)
                sum += 2 * kPi * split.scatteredAgain(depth, (i + 0.5) / kSteps * 2 - 1) * 2 / kSteps;
            EXPECT_NEAR(sum, split.straight() > 0 ? 1 - std::exp(-depth) : 0, 0.01) << phase.g << " " << depth;
        }
    }
}

// Henyey and Greenstein's functions fold into one another, so light that was scattered n times is a binomial sum of
// them.
TEST(SplitPhase, SpreadsABeamAsRepeatedScatteringDoes) {
    const Phase phase{0.85};
    const SplitPhase split(phase, 64);
    const double f = split.straight(), w = split.spread().g;
    for (const double depth : {0.2, 1.0, 3.0})
        for (const double cosine : {0.98, 0.8, 0.3, -0.5}) {
            double sum = 0, poisson = std::exp(-depth);
            for (int n = 1; n < 25; ++n) {
                poisson *= depth / n;
                double binomial = 1;
                for (int k = 0; k <= n; ++k) {
                    sum += poisson * binomial * std::pow(-(1 - f), k) / std::pow(f, n) *
                           phaseValue({std::pow(phase.g, n - k + 1) * std::pow(w, k)}, cosine);
                    binomial *= double(n - k) / (k + 1);
                }
            }
            EXPECT_NEAR(split.scatteredAgain(depth, cosine), sum, 0.01 * std::abs(sum) + 1e-4)
                << depth << " " << cosine;
        }
}

}  // namespace
}  // namespace scrim::test
