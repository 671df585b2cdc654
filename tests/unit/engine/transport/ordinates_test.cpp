// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/transport/ordinates.h>

#include <scrim/base/error.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(Ordinates, IntegrateLowPolynomialsExactly) {
    for (const int count : kOrdinateCounts) {
        const Ordinates set = ordinates(count);
        ASSERT_EQ(set.count(), count);
        double sum = 0;
        Mat3 moments(0);
        for (int m = 0; m < count; ++m) {
            const Vec3& d = set.directions[std::size_t(m)];
            EXPECT_NEAR(glm::length(d), 1, 1e-12);
            for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(d[axis] < 0, (m / set.perOctant >> axis & 1) != 0);
            sum += set.weights[std::size_t(m)];
            moments += set.weights[std::size_t(m)] * glm::outerProduct(d, d);
        }
        EXPECT_NEAR(sum, 4 * kPi, 1e-12);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) EXPECT_NEAR(moments[i][j], i == j ? 4 * kPi / 3 : 0, 1e-12) << count;
    }
    EXPECT_THROW(ordinates(65), Error);
}

TEST(Ordinates, ScatterWithoutLossAndWithThePhaseFunctionsMeanCosine) {
    for (const double g : {-0.5, 0.0, 0.3, 0.75, 0.9}) {
        const Ordinates set = ordinates(64);
        Phase phase;
        phase.g = g;
        const std::vector<Real> matrix = scatteringMatrix(set, phase);
        for (int n = 0; n < 64; ++n) {
            double row = 0, column = 0, cosine = 0;
            for (int m = 0; m < 64; ++m) {
                const auto weights = set.weights[std::size_t(m)] / set.weights[std::size_t(n)];
                const double into = double(matrix[std::size_t(n * 64 + m)]) * weights;  // of n's light
                EXPECT_GE(into, 0);
                column += into;
                cosine += into * glm::dot(set.directions[std::size_t(n)], set.directions[std::size_t(m)]);
                row += double(matrix[std::size_t(m * 64 + n)]);
            }
            EXPECT_NEAR(row, 1, 1e-5) << g;
            EXPECT_NEAR(column, 1, 1e-5) << g;
            EXPECT_NEAR(cosine, g, 0.03) << g;
        }
    }
}

}  // namespace
}  // namespace scrim::test
