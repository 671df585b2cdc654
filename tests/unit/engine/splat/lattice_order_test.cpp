// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/splatter.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

std::vector<Mat4> someMaps() {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> unit(-1, 1);
    std::vector<Mat4> maps{Mat4(1.0)};
    maps.push_back(Mat4(1.0));
    maps.back()[2][2] = -0.7;  // mirrored along the sweep
    for (int i = 0; i < 10; ++i) {
        Mat4 m(1.0);
        for (int column = 0; column < 4; ++column)
            for (int row = 0; row < 3; ++row) m[column][row] = 2 * unit(random);
        maps.push_back(m);
    }
    return maps;
}

TEST(LatticeOrder, HoldsEveryVoxelOnceAtItsOffset) {
    for (const Mat4& map : someMaps()) {
        const LatticeOrder order(map);
        std::vector<int> seen(kBlockVoxels);
        for (std::size_t k = 0; k < kBlockVoxels; ++k) {
            const int i = order.index[k];
            ++seen.at(static_cast<std::size_t>(i));
            const Vec3 expected = transformVector(map, Vec3(i / 64, i / 8 % 8, i % 8));
            EXPECT_EQ(order.offsetU[k], static_cast<float>(expected.x));
            EXPECT_EQ(order.offsetV[k], static_cast<float>(expected.y));
            EXPECT_EQ(order.offsetN[k], static_cast<float>(expected.z));
        }
        EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), kBlockVoxels);
    }
}

TEST(LatticeOrder, AscendsInWholeSheets) {
    for (const Mat4& map : someMaps()) {
        const LatticeOrder order(map);
        const auto depth = [&](std::size_t k) {
            const int i = order.index[k];
            return std::floor(transformVector(map, Vec3(i / 64, i / 8 % 8, i % 8)).z);
        };
        for (std::size_t k = 1; k < kBlockVoxels; ++k) ASSERT_LE(depth(k - 1), depth(k)) << k;
    }
}

TEST(LatticeOrder, BetweenFindsAllVoxelsOfARangeAndNoSheetTooMany) {
    std::mt19937 random(13);
    std::uniform_real_distribution<double> place(-30, 30), length(0, 8);
    for (const Mat4& map : someMaps()) {
        const LatticeOrder order(map);
        for (int i = 0; i < 100; ++i) {
            const double lower = place(random), upper = lower + length(random);
            const auto [first, second] = order.between(lower, upper);
            ASSERT_LE(0, first);
            ASSERT_LE(first, second);
            ASSERT_LE(second, kBlockVoxels);
            for (int k = 0; k < kBlockVoxels; ++k) {
                const double n = order.offsetN[static_cast<std::size_t>(k)];
                const bool listed = k >= first && k < second;
                if (n > lower && n < upper) {
                    EXPECT_TRUE(listed) << n << " of (" << lower << ", " << upper << ")";
                }
                if (std::floor(n) < std::floor(lower) || std::floor(n) > std::floor(upper + 1)) {
                    EXPECT_FALSE(listed) << n << " of (" << lower << ", " << upper << ")";
                }
            }
        }
    }
}

// A footprint of the linear kernel is two texels wide where a voxel is one: neighbours three apart do not meet.
TEST(LatticeOrder, NeighboursInASheetDoNotShareTexels) {
    const LatticeOrder order(Mat4(1.0));
    for (std::size_t k = 1; k < kBlockVoxels; ++k) {
        if (k % 64 == 0) continue;  // the first voxel of the next sheet
        const double apart = std::max(std::abs(order.offsetU[k] - order.offsetU[k - 1]),
                                      std::abs(order.offsetV[k] - order.offsetV[k - 1]));
        ASSERT_GE(apart, 3) << "voxels " << k - 1 << " and " << k;
    }
}

}  // namespace
}  // namespace scrim::test
