// SPDX-License-Identifier: Apache-2.0
// Phase functions beside light from a solid angle, in closed form and by quadrature.
#include <scrim/scene/phase_over_caps.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace scrim::test {
namespace {

constexpr double kPi = std::numbers::pi;

// By many directions: rings of equal width, weighted by their areas.
double byQuadrature(const Phase& phase, double cosine, double half) {
    constexpr int kRings = 1000, kAround = 200;
    const double sine = std::sqrt(1 - cosine * cosine);
    double sum = 0, weights = 0;
    for (int i = 0; i < kRings; ++i) {
        const double a = (i + 0.5) / kRings * half, z = std::cos(a), r = std::sin(a);
        for (int j = 0; j < kAround; ++j)
            sum += r * phaseValue(phase, cosine * z + sine * r * std::cos(2 * kPi * (j + 0.5) / kAround));
        weights += r * kAround;
    }
    return sum / weights;
}

double wholeOf(const PhaseRow& row) {
    constexpr int kSteps = 200000;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) sum += phaseIn(row, -1 + 2 * (i + 0.5) / kSteps) * 4 * kPi / kSteps;
    return sum;
}

TEST(PhaseOverCaps, AreTheMeansOfThePhaseFunctionOverThem) {
    for (const Phase& phase : {Phase{0.9}, Phase{-0.7}, Phase{0.98}, drainePhase(0.5, 4), dropletPhase(8)}) {
        const PhaseOverCaps caps(phase, 0.4);
        for (const double half : {0.03, 0.17, 0.4})
            for (const double angle : {0.0, 0.1, 0.35, 1.2, 2.9}) {
                const double expected = byQuadrature(phase, std::cos(angle), half);
                // Linear between the entries of the table.
                EXPECT_NEAR(caps.at(std::cos(angle), half), expected, 0.02 * expected + 1e-4)
                    << "g " << phase.g << " " << phase.g2 << ", cap " << half << ", angle " << angle;
            }
    }
}

TEST(PhaseOverCaps, OfNoWidthAreThePhaseFunction) {
    const Phase phase{0.8};
    const PhaseOverCaps caps(phase, 0.3);
    for (const double cosine : {1.0, 0.99, 0.5, -0.2, -1.0})
        EXPECT_NEAR(caps.at(cosine, 0), phaseValue(phase, cosine), 2e-3 * phaseValue(phase, cosine));
}

// What is cut off and what is left make a whole, and away from peaks nothing changes.
TEST(CutPhase, LosesNoLight) {
    for (const Phase& phase : {Phase{0.6}, Phase{0.9}, Phase{0.99}, Phase{-0.9}, dropletPhase(1), dropletPhase(20)}) {
        const CutPhase cut(phase, 0.3);
        EXPECT_NEAR(wholeOf(cut.row) + cut.onwards.part + cut.backwards.part, 1, 2e-3) << phase.g << " " << phase.g2;
        EXPECT_NEAR(phaseIn(cut.row, 0), phaseValue(phase, 0), 0.01 * phaseValue(phase, 0));
        EXPECT_GE(cut.onwards.part, 0);
        for (const CutPhase::Peak& peak : {cut.onwards, cut.backwards}) {
            double all = 0, depth = -1;
            for (const PeakRing& ring : peak.rings) {
                all += ring.part;
                EXPECT_GT(ring.depth, depth);
                depth = ring.depth;
            }
            if (peak.part > 1e-3) {
                EXPECT_NEAR(all, 1, 1e-9);
            }
        }
        EXPECT_LT(phaseIn(cut.row, 1), 20 * phaseValue(phase, std::cos(0.45)));
    }
}

TEST(LobeWidth, IsThatOfTheNarrowestLobe) {
    EXPECT_GT(lobeWidth(Phase{0.0}), 3);
    EXPECT_DOUBLE_EQ(lobeWidth(Phase{-0.75}), 0.25);
    EXPECT_TRUE(needsCaps(Phase{0.9}, 0.17));
    EXPECT_FALSE(needsCaps(Phase{0.3}, 0.17));
}

}  // namespace
}  // namespace scrim::test
