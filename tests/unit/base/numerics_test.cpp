// SPDX-License-Identifier: Apache-2.0
// Quadrature, least squares and accelerated iteration against closed forms.
#include <scrim/base/anderson.h>
#include <scrim/base/least_squares.h>
#include <scrim/base/legendre.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

namespace scrim::test {
namespace {

TEST(Numerics, GaussQuadratureIntegratesPolynomialsOfTwiceItsDegreeExactly) {
    for (const int n : {1, 2, 5, 10})
        for (int power = 0; power < 2 * n + 2; ++power) {
            double sum = 0;
            for (const auto& [x, weight] : gaussLegendre(n)) sum += weight * std::pow(x, power);
            const double exact = power % 2 == 0 ? 2.0 / (power + 1) : 0;
            if (power < 2 * n) {
                EXPECT_NEAR(sum, exact, 1e-13) << n << " " << power;
            } else if (power == 2 * n) {
                EXPECT_GT(std::abs(sum - exact), 1e-7) << n;
            }
        }
}

TEST(Numerics, LegendrePolynomialsAreThoseOfTheLibrary) {
    for (const double x : {-1.0, -0.3, 0.0, 0.7, 1.0})
        forLegendre(12, x, [&](std::size_t l, double p) {
            EXPECT_NEAR(p, std::legendre(static_cast<unsigned>(l), x), 1e-14) << l << " " << x;
        });
}

// The line through three points of least squares, and an unknown that no equation determines.
TEST(Numerics, LeastSquaresFitALine) {
    const std::array<double, 3> x{0, 1, 2}, y{1, 2, 4};
    std::vector<std::vector<double>> matrix(3, std::vector<double>(3, 0.0));
    std::vector<double> right(3, 0.0);
    for (std::size_t i = 0; i < 3; ++i) {
        const std::array<double, 3> terms{1, x[i], 0};
        for (std::size_t r = 0; r < 3; ++r) {
            right[r] += terms[r] * y[i];
            for (std::size_t c = 0; c < 3; ++c) matrix[r][c] += terms[r] * terms[c];
        }
    }
    const std::vector<double> line = leastSquares(matrix, right);
    EXPECT_NEAR(line[0], 5.0 / 6, 1e-12);
    EXPECT_NEAR(line[1], 1.5, 1e-12);
    EXPECT_EQ(line[2], 0);
}

// x = A x + b in three dimensions: with three steps kept, the fifth iterate is exact, where plain iteration is still
// far off.
TEST(Numerics, AndersonMixingSolvesLinearEquationsInAsManyStepsAsThereAreUnknowns) {
    const double a[3][3] = {{0.9, 0.05, 0}, {0.1, 0.7, 0.1}, {0, 0.2, 0.75}};
    const std::vector<Real> solution{1, -2, 3};
    const auto next = [&](const std::vector<Real>& x) {
        std::vector<Real> to = solution;
        for (std::size_t r = 0; r < 3; ++r)
            for (std::size_t c = 0; c < 3; ++c) to[r] += static_cast<Real>(a[r][c] * double(x[c] - solution[c]));
        return to;
    };
    const auto off = [&](const std::vector<Real>& x) {
        double sum = 0;
        for (std::size_t i = 0; i < 3; ++i) sum += std::pow(double(x[i] - solution[i]), 2);
        return std::sqrt(sum);
    };
    AndersonMixing mixing(3, [](const auto& u, const auto& v) {
        double sum = 0;
        for (std::size_t i = 0; i < u.size(); ++i) sum += double(u[i]) * double(v[i]);
        return sum;
    });
    std::vector<Real> x(3, Real(0)), plain = x;
    for (int i = 0; i < 5; ++i) {
        mixing.step(x, next(x));
        plain = next(plain);
    }
    EXPECT_LT(off(x), 1e-3);
    EXPECT_GT(off(plain), 0.5);
}

}  // namespace
}  // namespace scrim::test
