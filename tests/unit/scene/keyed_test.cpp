// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/keyed.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace scrim {
namespace {

Keyed<double> uneven(Interpolation interpolation) {
    return {{{1, 0}, {4, 1}, {5, 10}, {11, 10}, {12, -3}, {20, 2}}, interpolation};
}

TEST(Keyed, PassesThroughItsKeysAndIsConstantOutside) {
    for (const auto interpolation : {Interpolation::linear, Interpolation::smooth}) {
        const Keyed<double> keyed = uneven(interpolation);
        for (const auto& [frame, value] : keyed.keys) EXPECT_DOUBLE_EQ(keyed.at(frame), value);
        EXPECT_EQ(keyed.at(-100), 0);
        EXPECT_EQ(keyed.at(100), 2);
    }
}

TEST(Keyed, LinearIsTheChord) {
    const Keyed<Vec3> keyed{{{1, {0, 0, 9}}, {48, {9, 0, 0}}}, Interpolation::linear};
    EXPECT_DOUBLE_EQ(keyed.at(24.5).x, 4.5);
    EXPECT_DOUBLE_EQ(keyed.at(24.5).z, 4.5);
}

TEST(Keyed, SmoothStaysBetweenNeighbouringKeys) {
    const Keyed<double> keyed = uneven(Interpolation::smooth);
    for (std::size_t i = 0; i + 1 < keyed.keys.size(); ++i)
        for (int k = 0; k <= 1000; ++k) {
            const auto [f0, a] = keyed.keys[i];
            const auto [f1, b] = keyed.keys[i + 1];
            const double v = keyed.at(f0 + (f1 - f0) * k / 1000);
            EXPECT_GE(v, std::min(a, b));
            EXPECT_LE(v, std::max(a, b));
        }
}

TEST(Keyed, SmoothHasAContinuousSlope) {
    const Keyed<double> keyed = uneven(Interpolation::smooth);
    constexpr double h = 1e-6;
    for (const auto& [frame, value] : keyed.keys) {
        const double before = (keyed.at(frame) - keyed.at(frame - h)) / h;
        const double after = (keyed.at(frame + h) - keyed.at(frame)) / h;
        // Curvatures are below 100 a frame squared here: one-sided differences agree to about 100 h.
        EXPECT_NEAR(before, after, 2e-4) << "at frame " << frame;
    }
}

TEST(Keyed, SmoothReproducesAStraightLineBetweenInnerKeys) {
    const Keyed<double> keyed{{{0, 0}, {2, 2}, {5, 5}, {6, 6}, {9, 9}}, Interpolation::smooth};
    for (double f = 2; f <= 6; f += 0.125) EXPECT_NEAR(keyed.at(f), f, 1e-12);
}

TEST(Keyed, OneKeyIsAConstant) {
    const Keyed<double> keyed{{{7, 3}}, Interpolation::smooth};
    for (const double f : {-1.0, 7.0, 8.0}) EXPECT_EQ(keyed.at(f), 3);
}

}  // namespace
}  // namespace scrim
