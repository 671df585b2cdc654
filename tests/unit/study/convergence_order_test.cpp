// SPDX-License-Identifier: Apache-2.0
#include <scrim/study/convergence_order.h>

#include <gtest/gtest.h>

#include <cmath>

namespace scrim::test {
namespace {

// Signed errors C h^p, seen from the finest of them.
std::vector<DialDistance> distances(double order, double finest) {
    std::vector<DialDistance> all;
    for (const double h : {0.25, 0.5, 1.0, 2.0, 4.0})
        all.push_back({h, 3 * (std::pow(h, order) - std::pow(finest, order))});
    return all;
}

TEST(ConvergenceOrder, OfAPowerIsItsExponent) {
    for (const double order : {0.5, 1.0, 1.7, 2.0, 3.0})
        EXPECT_NEAR(convergenceOrder(distances(order, 0.25), 0.25).value(), order, 0.011) << order;
}

TEST(ConvergenceOrder, IsTheBestFitOfWhatIsNoPower) {
    std::vector<DialDistance> noisy = distances(2, 0.25);
    for (std::size_t i = 0; i < noisy.size(); ++i) noisy[i].distance *= i % 2 == 0 ? 1.1 : 0.9;
    EXPECT_NEAR(convergenceOrder(noisy, 0.25).value(), 2, 0.15);
}

TEST(ConvergenceOrder, IsUnknownOfFewerThanTwoDistances) {
    EXPECT_EQ(convergenceOrder({}, 1), std::nullopt);
    EXPECT_EQ(convergenceOrder({{1, 0}, {2, 0.1}}, 1), std::nullopt);
    EXPECT_EQ(convergenceOrder({{1, 0}, {2, 0}, {4, 0}}, 1), std::nullopt);
}

}  // namespace
}  // namespace scrim::test
