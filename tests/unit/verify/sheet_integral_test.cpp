// SPDX-License-Identifier: Apache-2.0
#include <scrim/verify/sheet_integral.h>

#include <gtest/gtest.h>

#include <cmath>

namespace scrim::test {
namespace {

// phi by its definition: the integral over x in [0, 1] of e^(-tauLight x) e^(-tauEye y), y = x or 1 - x, by Gauss
// quadrature with two points in each of 20000 steps: an error of (tau / 20000)^4, less than 1e-9 up to tau = 100.
double transmitByQuadrature(double tauEye, double tauLight, bool sameSide) {
    constexpr int kSteps = 20000;
    const double gauss = 0.5 / std::sqrt(3.0);
    double sum = 0;
    for (int i = 0; i < kSteps; ++i)
        for (const double side : {-gauss, gauss}) {
            const double x = (i + 0.5 + side) / kSteps;
            sum += std::exp(-tauLight * x - tauEye * (sameSide ? x : 1 - x));
        }
    return sum / (2 * kSteps);
}

TEST(SheetTransmit, IsTheIntegralOverTheSheet) {
    for (const double eye : {0.0, 1e-9, 1e-3, 0.5, 1.0, 5.0, 50.0})
        for (const double light : {0.0, 1e-9, 1e-3, 0.5, 0.999999, 1.0, 5.0, 50.0})
            for (const bool sameSide : {true, false}) {
                const double expected = transmitByQuadrature(eye, light, sameSide);
                EXPECT_NEAR(sheetTransmit(eye, light, sameSide), expected, 1e-9 * expected)
                    << eye << " " << light << (sameSide ? " same side" : " opposite sides");
            }
}

TEST(SheetTransmit, DoesNotTellEyeFromLight) {
    for (const double a : {1e-12, 0.3, 7.0, 1e4})
        for (const double b : {0.0, 0.2, 8.0, 1e3})
            for (const bool sameSide : {true, false})
                EXPECT_EQ(sheetTransmit(a, b, sameSide), sheetTransmit(b, a, sameSide)) << a << " " << b;
}

// Two sheets are as good as one of their whole thickness: what makes the picture of a slab exact at any thickness.
TEST(SheetTransmit, TelescopesOverSheets) {
    for (const double tau : {1e-6, 0.7, 12.0}) {
        const double front = tau * 0.3, behind = tau * 0.7;
        // Light and eye from the same side: what lies behind is dimmed twice.
        const double same = front * sheetTransmit(front, front, true) +
                            std::exp(-2 * front) * behind * sheetTransmit(behind, behind, true);
        EXPECT_NEAR(same, tau * sheetTransmit(tau, tau, true), 1e-14 * tau);
        // From opposite sides: each is dimmed once, by the other.
        const double opposite = std::exp(-behind) * front * sheetTransmit(front, front, false) +
                                std::exp(-front) * behind * sheetTransmit(behind, behind, false);
        EXPECT_NEAR(opposite, tau * sheetTransmit(tau, tau, false), 1e-14 * tau);
    }
}

TEST(Psi, IsOneAtZeroAndKeepsItsPrecisionNearby) {
    EXPECT_EQ(psi(0), 1);
    EXPECT_EQ(psi(1e-300), 1);
    for (const double t : {1e-12, 1e-8, 1e-4, 1e-2})
        EXPECT_NEAR(psi(t), 1 - t / 2 + t * t / 6 - t * t * t / 24, t * t * t * t / 100 + 1e-15) << t;
    EXPECT_NEAR(psi(1e6), 1e-6, 1e-20);
}

}  // namespace
}  // namespace scrim::test
