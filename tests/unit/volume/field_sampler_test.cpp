// SPDX-License-Identifier: Apache-2.0
#include "support/fields.h"

#include <scrim/volume/field_sampler.h>

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

// A number of its own for every voxel.
double number(const Vec3& is) {
    return 1 + std::sin(12.9 * is.x + 78.2 * is.y + 37.7 * is.z);
}

class Random {
  public:
    double in(double lower, double upper) { return std::uniform_real_distribution<double>(lower, upper)(m_engine); }
    Vec3 vector(double lower, double upper) { return {in(lower, upper), in(lower, upper), in(lower, upper)}; }

  private:
    std::mt19937 m_engine{3};
};

TEST(FieldSampler, KnowsEveryVoxelAndZeroElsewhere) {
    const Int3 lower(-11, -3, 5), upper(9, 12, 20);
    const auto field = makeField(lower, upper, 1, number);
    const FieldSampler probe(*field, Kernel::linear);
    for (int x = lower.x - 9; x <= upper.x + 9; ++x)
        for (int y = lower.y - 9; y <= upper.y + 9; ++y)
            for (int z = lower.z - 9; z <= upper.z + 9; ++z) {
                const Int3 p(x, y, z);
                const bool inside = glm::all(glm::greaterThanEqual(p, lower)) && glm::all(glm::lessThanEqual(p, upper));
                ASSERT_EQ(probe.voxel(p), inside ? double(static_cast<float>(number(Vec3(p)))) : 0);
            }
    EXPECT_EQ(probe.voxel(Int3(1 << 28, -(1 << 28), 0)), 0);
}

TEST(FieldSampler, KnowsTiles) {
    SparseField field;
    field.tiles = {{{-16, 0, 8}, 8, 0.5f}, {{32, 32, 32}, 32, 2.0f}};
    const FieldSampler probe(field, Kernel::linear);
    EXPECT_EQ(probe.voxel({-16, 0, 8}), 0.5);
    EXPECT_EQ(probe.voxel({-9, 7, 15}), 0.5);
    EXPECT_EQ(probe.voxel({-8, 7, 15}), 0);
    EXPECT_EQ(probe.voxel({-17, 7, 15}), 0);
    EXPECT_EQ(probe.voxel({63, 63, 63}), 2);
    EXPECT_EQ(probe.value({40.3, 50.1, 60.9}), 2);
    EXPECT_NEAR(probe.value({63.25, 50, 50}), 1.5, 1e-12);
}

TEST(FieldSampler, WithTheLinearKernelIsTrilinear) {
    const auto field = makeField({-10, -10, -10}, {10, 10, 10}, 1, number);
    const FieldSampler probe(*field, Kernel::linear);
    Random random;
    for (int i = 0; i < 500; ++i) {
        const Vec3 p = random.vector(-11.5, 11.5), base = glm::floor(p), t = p - base;
        const auto lerp = [](double a, double b, double x) { return a + x * (b - a); };
        const auto at = [&](int x, int y, int z) { return probe.voxel(Int3(base) + Int3(x, y, z)); };
        const double expected =
            lerp(lerp(lerp(at(0, 0, 0), at(1, 0, 0), t.x), lerp(at(0, 1, 0), at(1, 1, 0), t.x), t.y),
                 lerp(lerp(at(0, 0, 1), at(1, 0, 1), t.x), lerp(at(0, 1, 1), at(1, 1, 1), t.x), t.y), t.z);
        ASSERT_NEAR(probe.value(p), expected, 1e-12);
    }
}

// The sum of all voxels' kernels, over all voxels there are.
TEST(FieldSampler, IsTheSumOfAllKernels) {
    const auto field = makeField({-4, -4, -4}, {4, 4, 4}, 1, number);
    Random random;
    for (const Kernel kernel : {Kernel::linear, Kernel::gaussian, Kernel::bspline}) {
        const FieldSampler probe(*field, kernel);
        for (int i = 0; i < 40; ++i) {
            // Corners, whole and half positions too: where a kernel's support begins and ends.
            const Vec3 p = i < 10 ? glm::round(2.0 * random.vector(-6.5, 6.5)) / 2.0 : random.vector(-6.5, 6.5);
            double expected = 0;
            for (int x = -4; x <= 4; ++x)
                for (int y = -4; y <= 4; ++y)
                    for (int z = -4; z <= 4; ++z)
                        expected +=
                            double(static_cast<float>(number(Vec3(x, y, z)))) * kernelValue(kernel, p - Vec3(x, y, z));
            ASSERT_NEAR(probe.value(p), expected, 1e-12) << test::nameOf(kernel);
        }
    }
}

// A promise that must never be broken: where it says empty, nothing is.
TEST(FieldSampler, IsZeroWhereItSaysEmpty) {
    SparseField field = *boxField({-3, -3, -3}, {4, 4, 4});
    field.tiles = {{{16, 16, 16}, 8, 1.0f}};
    Random random;
    for (const Kernel kernel : {Kernel::linear, Kernel::bspline}) {
        const FieldSampler probe(field, kernel);
        int empty = 0;
        for (int i = 0; i < 2000; ++i) {
            const Vec3 p = random.vector(-25, 40);
            const double radius = random.in(0.5, 6);
            if (!probe.emptyAround(p, radius)) continue;
            ++empty;
            for (int k = 0; k < 20; ++k) {
                const Vec3 d = random.vector(-1, 1);
                ASSERT_EQ(probe.value(p + radius * d / std::max(1.0, glm::length(d))), 0);
            }
        }
        EXPECT_GT(empty, 500);
        EXPECT_FALSE(probe.emptyAround({0, 0, 0}, 0.1));
        EXPECT_FALSE(probe.emptyAround({20, 20, 20}, 0.1));
        EXPECT_TRUE(probe.emptyAround({100, 0, 0}, 50));
    }
}

TEST(FieldSampler, GivesTheVoxelWhoseCellHoldsAPoint) {
    const auto field = makeField({-10, -10, -10}, {10, 10, 10}, 1, number);
    const FieldSampler sampler(*field);
    Random random;
    for (int i = 0; i < 500; ++i) {
        const Int3 voxel(glm::floor(random.vector(-12, 12)));
        ASSERT_EQ(sampler.nearest(Vec3(voxel) + random.vector(-0.499, 0.499)), sampler.voxel(voxel));
    }
    // However far a point is, it is no whole number that wraps around.
    for (const double far : {1e9, 4294967296.0, -1e300, 1e300}) {
        EXPECT_EQ(sampler.nearest({far, 0, 0}), 0);
        EXPECT_EQ(sampler.value({far, 0, 0}), 0);
    }
}

// As far as it says, the field is what it was at the first point.
TEST(FieldSampler, IsConstantAsFarAsItSays) {
    SparseField field = *boxField({-3, -3, -3}, {4, 4, 4});
    field.tiles = {{{16, 16, 16}, 8, 0.5f}, {{64, 0, 0}, 64, 2.0f}};
    const FieldSampler sampler(field);
    Random random;
    int known = 0, inTiles = 0;
    for (int i = 0; i < 20000; ++i) {
        const Vec3 p = random.vector(-20, 130), way = random.vector(-1, 1);
        const double radius = random.in(0, 3), far = sampler.evenAlong(p, way, radius), here = sampler.value(p);
        if (far < 0) continue;
        ++known;
        inTiles += here > 0;
        for (int k = 0; k < 10; ++k) {
            const Vec3 at = p + std::min(far, 1e3) * random.in(0, 1) * way + random.vector(-radius, radius);
            ASSERT_NEAR(sampler.value(at), here, 1e-12);
        }
    }
    EXPECT_GT(known, 10000);
    EXPECT_GT(inTiles, 500);
    EXPECT_LT(sampler.evenAlong({0.5, 0.5, 0.5}, {1, 0, 0}, 0), 0);  // a block may hold anything
}

// Over borders of blocks, into a tile and beyond the field.
TEST(FieldBrick, IsTheFieldAroundItsBox) {
    auto field = *makeField({-10, -10, -10}, {10, 10, 10}, 1, number);
    field.tiles = {{{16, -8, -8}, 8, 0.5f}};
    const FieldSampler sampler(field, Kernel::linear);
    Random random;
    FieldBrick brick;
    for (int i = 0; i < 200; ++i) {
        Bounds box;
        for (int corner = 0; corner < 2; ++corner) box.include(random.vector(-13, 13) + Vec3(4, 0, 0));
        ASSERT_TRUE(brick.fill(sampler, {box.lower - 1.0, box.upper + 1.0}));
        for (int k = 0; k < 20; ++k) {
            const Vec3 is = box.lower + random.vector(0, 1) * (box.upper - box.lower);
            ASSERT_EQ(brick.value(is), sampler.value(is)) << is.x << " " << is.y << " " << is.z;
            ASSERT_EQ(brick.difference(is), sampler.difference(is));
        }
    }
}

// Sums of eight products in single precision, of values up to 1: their rounding is a few times 1e-7.
TEST(FieldBrick, GivesManyValuesAtOnceInSinglePrecision) {
    const auto field = makeField({-10, -10, -10}, {10, 10, 10}, 1, number);
    const FieldSampler sampler(*field, Kernel::linear);
    Random random;
    FieldBrick brick;
    for (int i = 0; i < 50; ++i) {
        const Int3 lower(random.vector(-14, 8));
        brick.fill(sampler.index(), lower, lower + kBlockEdge);
        const Vec3 f = random.vector(0, 1);
        std::array<float, kBlockVoxels> values{}, x{}, y{}, z{};
        brick.addBlock(f, 2, values.data());
        for (int k = 0; k < kBlockVoxels; ++k) {
            const Vec3 place = Vec3(k / 64, k / 8 % 8, k % 8) + f;
            ASSERT_NEAR(double(values[std::size_t(k)]), 2 * sampler.value(Vec3(lower) + place), 2e-6) << k;
            const Vec3 any = random.vector(0, 7.999);
            x[std::size_t(k)] = float(any.x);
            y[std::size_t(k)] = float(any.y);
            z[std::size_t(k)] = float(any.z);
        }
        brick.values({x.data(), y.data(), z.data()}, kBlockVoxels, values.data());
        for (std::size_t k = 0; k < kBlockVoxels; ++k)
            ASSERT_NEAR(double(values[k]), sampler.value(Vec3(lower) + Vec3(x[k], y[k], z[k])), 2e-6) << k;
    }
}

TEST(FieldBrick, LeavesLargeBoxesAndOtherKernelsToTheSampler) {
    const auto field = makeField({0, 0, 0}, {3, 3, 3}, 1, number);
    FieldBrick brick;
    EXPECT_FALSE(brick.fill(FieldSampler(*field, Kernel::bspline), {Vec3(0), Vec3(2)}));
    EXPECT_FALSE(brick.fill(FieldSampler(*field, Kernel::linear), {Vec3(0), Vec3(100)}));
    EXPECT_FALSE(brick.fill(FieldSampler(*field, Kernel::linear), {Vec3(-1e30), Vec3(1e30)}));
    EXPECT_TRUE(brick.fill(FieldSampler(*field, Kernel::linear), {Vec3(0), Vec3(2)}));
}

}  // namespace
}  // namespace scrim::test
