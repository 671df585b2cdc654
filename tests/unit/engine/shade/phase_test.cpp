// SPDX-License-Identifier: Apache-2.0
// Closed-form properties of Henyey-Greenstein. (That it integrates to one is in truth/analytic/light_test.cpp.)
#include <scrim/scene/medium.h>

#include <gtest/gtest.h>

#include <cmath>

namespace scrim::test {
namespace {

const double kPi = std::acos(-1.0);

TEST(Phase, WithoutAnisotropyIsOneOverTheSphere) {
    EXPECT_TRUE(Phase{0}.isotropic());
    EXPECT_FALSE(Phase{-0.1}.isotropic());
    for (const double cosine : {-1.0, -0.2, 0.0, 0.9, 1.0}) EXPECT_NEAR(phaseValue({0}, cosine), 1 / (4 * kPi), 1e-16);
}

// (1 - g^2) / (4 pi) / (1 -+ g)^3 straight on and straight back.
TEST(Phase, HasItsClosedFormsAtBothEnds) {
    for (const double g : {-0.8, 0.3, 0.9}) {
        EXPECT_NEAR(phaseValue({g}, 1), (1 + g) / ((1 - g) * (1 - g)) / (4 * kPi), 1e-12);
        EXPECT_NEAR(phaseValue({g}, -1), (1 - g) / ((1 + g) * (1 + g)) / (4 * kPi), 1e-12);
    }
}

TEST(Phase, HasTheMeanCosineG) {
    for (const double g : {-0.9, -0.3, 0.0, 0.5, 0.95}) {
        double mean = 0;
        constexpr int kSteps = 100000;
        for (int i = 0; i < kSteps; ++i) {
            const double cosine = -1 + 2 * (i + 0.5) / kSteps;
            mean += cosine * phaseValue({g}, cosine) * 4 * kPi / kSteps;
        }
        EXPECT_NEAR(mean, g, 1e-4) << "g = " << g;  // the midpoint rule at the peak of g = 0.95
    }
}

TEST(Phase, WithGReversedScattersTheOtherWay) {
    for (const double g : {0.2, 0.7})
        for (const double cosine : {-1.0, -0.4, 0.0, 0.8})
            EXPECT_NEAR(phaseValue({g}, cosine), phaseValue({-g}, -cosine), 1e-14);
    EXPECT_GT(phaseValue({0.5}, 1), phaseValue({0.5}, -1));
}

double meanCosine(const Phase& phase) {
    double mean = 0;
    constexpr int kSteps = 200000;  // in angle, because lobes are narrow
    for (int i = 0; i < kSteps; ++i) {
        const double angle = kPi * (i + 0.5) / kSteps;
        mean += 2 * kPi * std::sin(angle) * std::cos(angle) * phaseValue(phase, std::cos(angle)) * kPi / kSteps;
    }
    return mean;
}

// Mie's theory has mean cosines of 0.8 to 0.89 for droplets of fog and clouds in visible light (large ones lose half of
// the light to diffraction, straight on, and refract the rest with 0.77), a peak straight on, and more light straight
// back than aside. The fits of the four ranges of sizes meet.
TEST(Phase, OfDropletsIsAsMiesTheoryHasIt) {
    for (const double size : {5.0, 8.0, 20.0, 50.0}) {
        const Phase phase = dropletPhase(size);
        EXPECT_GT(meanCosine(phase), 0.79) << size;
        EXPECT_LT(meanCosine(phase), 0.895) << size;
        EXPECT_GT(phaseValue(phase, 1), 20) << size;
        EXPECT_GT(phaseValue(phase, -1), 2 * phaseValue(phase, -0.2)) << size;
    }
    EXPECT_NEAR(meanCosine(dropletPhase(0.01)), 0, 0.01);  // as small as Rayleigh's
    for (const double size : {0.1, 1.5, 5.0})
        for (const double cosine : {-1.0, -0.5, 0.2, 0.8})
            EXPECT_NEAR(
                phaseValue(dropletPhase(size * 0.9999), cosine) / phaseValue(dropletPhase(size * 1.0001), cosine), 1,
                0.25)
                << size << " " << cosine;
}

}  // namespace
}  // namespace scrim::test
