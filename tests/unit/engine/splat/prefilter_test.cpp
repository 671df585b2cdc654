// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/plane_stack.h>

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace scrim::test {
namespace {

// A plane of 48 x 48 texels, all tiles active, holding f inside of a border of zeros.
PlaneStack planeOf(const std::function<double(int, int)>& f) {
    PlaneStack planes(1, 48, 48, 1);
    planes.begin(0);
    for (int t = 0; t < 9; ++t) planes.activate(0, t % 3, t / 3);
    planes.finish(0);
    for (int y = 1; y < 47; ++y)
        for (int x = 1; x < 47; ++x) planes.plane(0)[y * planes.rowStride() + x] = static_cast<float>(f(x, y));
    return planes;
}

TEST(Prefilter, LeavesLinearFieldsAlone) {
    PlaneStack planes = planeOf([](int x, int y) { return 5 + 0.25 * x + 0.125 * y; });
    planes.prefilter(0);
    for (int y = 2; y < 46; ++y)
        for (int x = 2; x < 46; ++x)
            ASSERT_NEAR(planes.plane(0)[y * planes.rowStride() + x], 5 + 0.25 * x + 0.125 * y, 1e-5) << x << "," << y;
}

// The mean, over all positions between texels, of bilinear look-ups is the field's own mean once more.
TEST(Prefilter, MakesTheMeanOfBilinearLookUpsThatOfTheField) {
    const auto field = [](double x, double y) { return 400 + x * x + 2 * y * y; };
    PlaneStack planes = planeOf([&](int x, int y) { return field(x, y); });
    const auto meanError = [&] {
        double sum = 0;
        const int n = 50;
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i) {
                const double fx = (i + 0.5) / n, fy = (j + 0.5) / n;
                const float* texel = planes.plane(0) + 20 * planes.rowStride() + 20;
                const float* below = texel + planes.rowStride();
                const double value =
                    (texel[0] * (1 - fx) + texel[1] * fx) * (1 - fy) + (below[0] * (1 - fx) + below[1] * fx) * fy;
                sum += (value - field(20 + fx, 20 + fy)) / (n * n);
            }
        return sum;
    };
    // Before: a twelfth of the second differences on each axis, doubled by bilinear interpolation: (2 + 4) / 12.
    EXPECT_NEAR(meanError(), 0.5, 0.01);
    planes.prefilter(0);
    EXPECT_NEAR(meanError(), 0, 0.01);
}

TEST(Prefilter, NeverGoesBelowZero) {
    PlaneStack planes = planeOf([](int x, int y) { return x == 20 && y == 20 ? 1.0 : 0.0; });
    planes.prefilter(0);
    const float* row = planes.plane(0) + 20 * planes.rowStride();
    EXPECT_NEAR(row[20], 1 + 4.0 / 12, 1e-6);
    EXPECT_EQ(row[19], 0);
    EXPECT_EQ(row[21], 0);
}

}  // namespace
}  // namespace scrim::test
