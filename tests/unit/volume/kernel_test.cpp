// SPDX-License-Identifier: Apache-2.0
// The kernels by their definition: what a field is made of.
#include <scrim/volume/kernel.h>

#include "support/fields.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

constexpr Kernel kAll[] = {Kernel::linear, Kernel::gaussian, Kernel::bspline};

class Random {
  public:
    double in(double lower, double upper) { return std::uniform_real_distribution<double>(lower, upper)(m_engine); }
    Vec3 vector(double reach) { return {in(-reach, reach), in(-reach, reach), in(-reach, reach)}; }

  private:
    std::mt19937 m_engine{7};
};

double sumOverLattice(Kernel kernel, const Vec3& offset) {
    double sum = 0;
    for (int x = -3; x <= 3; ++x)
        for (int y = -3; y <= 3; ++y)
            for (int z = -3; z <= 3; ++z) sum += kernelValue(kernel, offset + Vec3(x, y, z));
    return sum;
}

// The midpoint rule with n points a voxel takes the mean of n^3 shifted lattice sums: it is exact for partitions
// of unity, and only rounding of some 10^5 terms remains.
TEST(Kernel, OfAPartitionOfUnityIntegratesToOne) {
    for (const Kernel kernel : {Kernel::linear, Kernel::bspline}) {
        constexpr int n = 12;
        double sum = 0;
        for (int x = -2 * n; x < 2 * n; ++x)
            for (int y = -2 * n; y < 2 * n; ++y)
                for (int z = -2 * n; z < 2 * n; ++z) sum += kernelValue(kernel, (Vec3(x, y, z) + 0.5) / double(n));
        EXPECT_NEAR(sum / (n * n * n), 1, 1e-10) << nameOf(kernel);
    }
}

// In spherical shells, by Simpson's rule: an error of h^4 with h = 1/500.
TEST(Kernel, GaussianIntegratesToOne) {
    constexpr int n = 1000;
    const double h = 2.0 / n;
    double sum = 0;
    for (int i = 0; i <= n; ++i) {
        // The last point lies on the cut, where the kernel is already 0: take its limit from inside.
        const double r = i == n ? 2 * (1 - 1e-12) : i * h;
        const double weight = i == 0 || i == n ? 1 : i % 2 ? 4 : 2;
        sum += weight * 4 * std::acos(-1.0) * r * r * kernelValue(Kernel::gaussian, {r, 0, 0});
    }
    EXPECT_NEAR(sum * h / 3, 1, 1e-9);
}

TEST(Kernel, GaussianHangsOnDistanceAlone) {
    Random random;
    for (int i = 0; i < 100; ++i) {
        const Vec3 p = random.vector(1.1);
        const double here = kernelValue(Kernel::gaussian, p);
        EXPECT_NEAR(here, kernelValue(Kernel::gaussian, {0, glm::length(p), 0}), 1e-14);
        EXPECT_NEAR(here / kernelValue(Kernel::gaussian, Vec3(0)), std::exp(-2 * glm::dot(p, p)), 1e-14);
    }
}

TEST(Kernel, LinearAndBsplineSumToOneEverywhere) {
    Random random;
    for (const Kernel kernel : {Kernel::linear, Kernel::bspline})
        for (int i = 0; i < 200; ++i) {
            const Vec3 offset = random.vector(0.5);
            EXPECT_NEAR(sumOverLattice(kernel, offset), 1, 1e-13)
                << nameOf(kernel) << " at " << offset.x << "," << offset.y << "," << offset.z;
        }
}

// "Ripples by about 1 %", kernel.h says: the largest Fourier coefficient of the lattice sum is e^(-pi^2/2) = 0.7 %,
// six directions of it add up to 4.3 % at a voxel's centre; what the cut takes away is within that.
TEST(Kernel, GaussianRipples) {
    Random random;
    double most = 0;
    for (int i = 0; i < 1000; ++i)
        most = std::max(most, std::abs(sumOverLattice(Kernel::gaussian, random.vector(0.5)) - 1));
    EXPECT_GT(most, 0.01);
    EXPECT_LT(most, 0.05);
    EXPECT_NEAR(sumOverLattice(Kernel::gaussian, Vec3(0)) - 1, 6 * std::exp(-std::acos(-1.0) * std::acos(-1.0) / 2),
                3e-3);
}

TEST(Kernel, IsEvenAndNeverNegative) {
    Random random;
    for (const Kernel kernel : kAll)
        for (int i = 0; i < 200; ++i) {
            const Vec3 p = random.vector(2.2);
            EXPECT_EQ(kernelValue(kernel, p), kernelValue(kernel, -p)) << nameOf(kernel);
            EXPECT_GE(kernelValue(kernel, p), 0) << nameOf(kernel);
        }
}

TEST(KernelRadius, IsWhereTheKernelEndsOnEveryAxis) {
    for (const Kernel kernel : kAll)
        for (int axis = 0; axis < 3; ++axis) {
            Vec3 p(0);
            p[axis] = kernelRadius(kernel);
            EXPECT_EQ(kernelValue(kernel, p), 0) << nameOf(kernel);
            EXPECT_EQ(kernelValue(kernel, 1.5 * p), 0) << nameOf(kernel);
            EXPECT_GT(kernelValue(kernel, 0.999 * p), 0) << nameOf(kernel);
        }
}

TEST(KernelExtent, HoldsTheKernelAndIsReached) {
    Random random;
    for (const Kernel kernel : kAll)
        for (int i = 0; i < 50; ++i) {
            const Vec3 row = random.vector(3);
            const double extent = kernelExtent(kernel, row);
            // Nothing beyond it ...
            for (int k = 0; k < 200; ++k) {
                const Vec3 p = random.vector(2.2);
                if (kernelValue(kernel, p) > 0) {
                    EXPECT_LT(std::abs(glm::dot(row, p)), extent);
                }
            }
            // ... and something right before it: towards a corner of the box, or along the row in the ball.
            const Vec3 farthest =
                kernel == Kernel::gaussian ? 2.0 * glm::normalize(row) : kernelRadius(kernel) * glm::sign(row);
            EXPECT_NEAR(glm::dot(row, farthest), extent, 1e-12);
            EXPECT_GT(kernelValue(kernel, 0.999 * farthest), 0) << nameOf(kernel);
        }
}

}  // namespace
}  // namespace scrim::test
