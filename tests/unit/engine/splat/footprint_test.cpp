// SPDX-License-Identifier: Apache-2.0
// Tabulated footprints against direct integrals of the kernel.
//
// Tolerance. The table integrates in steps of h = 1 / sheetSteps with two-point Gauss quadrature. Within a smooth
// piece that is exact for `linear`; a step with a kink of slope jump j is off by at most 0.0223 j h^2 (the largest
// error for (x - c)+ over all c). A line meets the tent's nine planes of kinks at most once each, with jumps of at
// most 2 |d|, d = voxels a sheet along w: 0.4 |d| h^2 in all. The smooth kernels stay below that; the gaussian's cut
// is a jump of 1.8e-4, at most twice, and at most a step is misjudged.
#include "support/fields.h"

#include <scrim/engine/splat/footprint.h>

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>
#include <ostream>
#include <random>
#include <string>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>

namespace scrim::test {
namespace {

struct Case {
    std::string name;
    Mat3 tsFromIs;
};
void PrintTo(const Case& c, std::ostream* out) {
    *out << c.name;
}

Mat3 scaled(double u, double v, double n) {
    return Mat3(u, 0, 0, 0, v, 0, 0, 0, n);
}

Mat3 rotated(double angle, const Vec3& axis) {
    return Mat3(glm::rotate(Mat4(1.0), angle, glm::normalize(axis)));
}

Mat3 sheared() {
    return Mat3(1, 0.3, -0.2, 0, 0.9, 0.5, 0.4, 0, 1.1);
}

// Integral of the kernel along N over [from, to], through (x, y) in texels from the voxel's centre.
double integral(Kernel kernel, const Mat3& isFromTs, double x, double y, double from, double to) {
    constexpr int kSteps = 2000;
    const double step = (to - from) / kSteps;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) sum += step * kernelValue(kernel, isFromTs * Vec3(x, y, from + (i + 0.5) * step));
    return sum;
}

double tolerance(const FootprintTable& table, const Mat3& isFromTs) {
    const double h = 1.0 / table.sheetSteps();
    return 0.4 * glm::length(isFromTs[2]) * h * h + 2 * 1.8e-4 * h + 1e-6;
}

class Footprints : public testing::TestWithParam<std::tuple<Kernel, Case>> {
  protected:
    Kernel kernel() const { return std::get<0>(GetParam()); }
    Mat3 tsFromIs() const { return std::get<1>(GetParam()).tsFromIs; }
};

TEST_P(Footprints, OfATexelSumOverTheSheetsToTheLineIntegral) {
    const FootprintTable table(kernel(), Mat4(tsFromIs()), {4, 16});
    const Mat3 isFromTs = glm::inverse(tsFromIs());
    const double extent = table.extent().z;
    for (int stepV = 0; stepV < 4; stepV += 3)
        for (int stepU = 0; stepU < 4; ++stepU)
            for (int row = 0; row < table.rows(); ++row)
                for (int column = 0; column < table.columns(); ++column) {
                    const double expected = integral(kernel(), isFromTs, table.firstColumn() + column - stepU / 4.0,
                                                     table.firstRow() + row - stepV / 4.0, -extent, extent);
                    for (const int stepN : {0, 5, 15}) {
                        double sum = 0;
                        for (int sheet = 0; sheet < table.sheets(); ++sheet)
                            sum += table.weights()[table.offset(stepU, stepV, stepN) +
                                                   static_cast<std::size_t>(sheet * table.sheetStride() +
                                                                            row * table.rowStride() + column)];
                        ASSERT_NEAR(sum, expected, tolerance(table, isFromTs))
                            << "texel " << column << "," << row << " of fraction " << stepU << "," << stepV << ","
                            << stepN;
                    }
                }
}

TEST_P(Footprints, AreMeansOverTheirSlab) {
    const FootprintTable table(kernel(), Mat4(tsFromIs()), {8, 8});
    const Mat3 isFromTs = glm::inverse(tsFromIs());
    std::mt19937 random(3);
    const auto below = [&](int count) { return static_cast<int>(random() % static_cast<unsigned>(count)); };
    double largest = 0;
    for (int i = 0; i < 400; ++i) {
        const int u = below(8), v = below(8), n = below(8);
        const int column = below(table.columns()), row = below(table.rows()), sheet = below(table.sheets());
        const double nearN = table.firstSheet() + sheet - n / 8.0;
        const double expected = integral(kernel(), isFromTs, table.firstColumn() + column - u / 8.0,
                                         table.firstRow() + row - v / 8.0, nearN, nearN + 1);
        const double weight =
            table.weights()[table.offset(u, v, n) +
                            static_cast<std::size_t>(sheet * table.sheetStride() + row * table.rowStride() + column)];
        largest = std::max(largest, weight);
        ASSERT_NEAR(weight, expected, tolerance(table, isFromTs)) << column << "," << row << "," << sheet;
    }
    EXPECT_GT(largest, 0.01);  // the draw met more than empty corners
}

// The kernel is 0 at every texel and in every sheet that the footprint leaves out.
TEST_P(Footprints, MissNothingOfTheKernel) {
    const FootprintTable table(kernel(), Mat4(tsFromIs()), {8, 8});
    const Mat3 isFromTs = glm::inverse(tsFromIs());
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int i = 0; i < 20000; ++i) {
        // A point of the kernel, seen from a voxel whose fractions are those of some entry.
        const Vec3 is = kernelRadius(kernel()) * Vec3(unit(random), unit(random), unit(random));
        if (kernelValue(kernel(), is) == 0) continue;
        const Vec3 ts = tsFromIs() * is;
        const Vec3 fraction(double(random() % 8) / 8, double(random() % 8) / 8, double(random() % 8) / 8);
        // The line of texels next to it counts only where it passes through the kernel itself.
        const double column = std::round(ts.x + fraction.x), row = std::round(ts.y + fraction.y);
        const Vec3 onLine(column - fraction.x, row - fraction.y, ts.z);
        if (kernelValue(kernel(), isFromTs * onLine) == 0) continue;
        EXPECT_GE(column, table.firstColumn());
        EXPECT_LT(column, table.firstColumn() + table.columns());
        EXPECT_GE(row, table.firstRow());
        EXPECT_LT(row, table.firstRow() + table.rows());
        const double sheet = std::floor(ts.z + fraction.z);
        EXPECT_GE(sheet, table.firstSheet());
        EXPECT_LT(sheet, table.firstSheet() + table.sheets());
    }
}

TEST_P(Footprints, AreZeroInThePaddingOfTheirRows) {
    const FootprintTable table(kernel(), Mat4(tsFromIs()), {4, 4});
    ASSERT_EQ(table.rowStride() % 4, 0);
    ASSERT_GE(table.rowStride(), table.columns());
    const std::size_t rows = table.bytes() / sizeof(float) / static_cast<std::size_t>(table.rowStride());
    for (std::size_t row = 0; row < rows; ++row)
        for (int i = table.columns(); i < table.rowStride(); ++i)
            ASSERT_EQ(table.weights()[row * static_cast<std::size_t>(table.rowStride()) + static_cast<std::size_t>(i)],
                      0);
}

TEST_P(Footprints, TakeTheBytesTheyAnnounce) {
    const Mat4 map(tsFromIs());
    EXPECT_EQ(FootprintTable(kernel(), map, {8, 4}).bytes(), FootprintTable::bytes(kernel(), map, {8, 4}));
}

INSTANTIATE_TEST_SUITE_P(
    EveryShape, Footprints,
    testing::Combine(testing::Values(Kernel::linear, Kernel::gaussian, Kernel::bspline),
                     testing::Values(Case{"aligned", Mat3(1.0)}, Case{"thinSheets", scaled(1, 1, 4)},
                                     Case{"thickSheets", scaled(1, 1, 0.4)}, Case{"fineTexels", scaled(2, 2, 1)},
                                     Case{"rotated", rotated(0.7, {1, 2, 3})},
                                     Case{"rotatedThin", scaled(1, 1, 2) * rotated(-2.1, {3, -1, 0.5})},
                                     Case{"sheared", sheared()},
                                     Case{"anisotropic", rotated(0.4, {0, 1, 1}) * scaled(1.5, 0.6, 0.9)},
                                     Case{"mirrored", rotated(1.2, {1, 0, 1}) * scaled(-1, 1, 1)})),
    [](const auto& test) { return test::nameOf(std::get<0>(test.param)) + "_" + std::get<1>(test.param).name; });

// Sums over texels as well: linear and bspline footprints on a lattice of one texel a voxel fill every sheet evenly.
TEST(FootprintSums, OfAnAlignedLatticeAreOneInEveryTexel) {
    for (const Kernel kernel : {Kernel::linear, Kernel::bspline}) {
        const FootprintTable table(kernel, Mat4(1.0), {8, 8});
        for (int step = 0; step < 8; ++step) {
            double sum = 0;
            for (int i = 0; i < table.sheets() * table.sheetStride(); ++i)
                sum += table.weights()[table.offset(step, 3, 8 - 1 - step) + static_cast<std::size_t>(i)];
            EXPECT_NEAR(sum, 1, 1e-5) << test::nameOf(kernel);  // the table's kinks fall on its steps
        }
    }
}

TEST(FootprintSteps, ArePowersOfTwoThatResolveAVoxel) {
    for (const int wanted : {2, 8, 16, 32, 64})
        for (const double size : {0.1, 0.3, 0.9, 1.0, 2.5, 7.0, 500.0}) {
            const FootprintTable::Steps steps = footprintSteps(Mat4(scaled(size, 2 * size, 1 / size)), wanted);
            for (const auto& [n, voxel, enough] :
                 {std::tuple{steps.texel, size, 0.95}, {steps.sheet, 1 / size, 0.75}}) {
                EXPECT_EQ(n & (n - 1), 0);
                EXPECT_GE(n, enough == 0.95 && voxel < 8 ? 4 : 2);
                EXPECT_LE(n, 128);
                if (n < 128) {
                    // A little less is near enough: the next power would be twice as large a table an axis.
                    EXPECT_GE(n * voxel, enough * wanted);
                }
                if (n > (enough == 0.95 && voxel < 8 ? 4 : 2)) {
                    EXPECT_LT(n * voxel / 2, enough * wanted);
                }
            }
        }
}

// Linear footprints have kinks in rows and columns there.
TEST(FootprintSteps, AreFinerForLinearKernelsWhoseGridLiesAlongTexels) {
    const Mat4 along(scaled(2.2, 2.2, 1));
    const FootprintTable::Steps usual = footprintSteps(along, 8);
    EXPECT_GE(slopedSteps(Kernel::linear, along, 8).texel, 2 * usual.texel);
    EXPECT_EQ(slopedSteps(Kernel::bspline, along, 8).texel, usual.texel);
    EXPECT_EQ(slopedSteps(Kernel::linear, along, 8).sheet, usual.sheet);
    const Mat4 turned = along * glm::rotate(Mat4(1), 0.4, Vec3(1, 1, 0));
    EXPECT_EQ(slopedSteps(Kernel::linear, turned, 8).texel, footprintSteps(turned, 8).texel);
    const Mat4 large(scaled(40, 40, 20));  // whose tables are
    EXPECT_EQ(slopedSteps(Kernel::linear, large, 8).texel, footprintSteps(large, 8).texel);
}

}  // namespace
}  // namespace scrim::test
