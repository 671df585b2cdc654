// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/coarser.h>

#include <scrim/base/parallel.h>
#include <scrim/volume/field_builder.h>

#include <cstdint>
#include <limits>
#include <map>
#include <random>
#include <tuple>

#include <gtest/gtest.h>

namespace scrim {
namespace {

using Block = std::array<float, kBlockVoxels>;
using Voxels = std::map<std::tuple<int, int, int>, double>;

/// Every voxel above 0, tiles written out.
Voxels voxels(const SparseField& field) {
    Voxels out;
    for (std::size_t i = 0; i < field.blockCount(); ++i)
        for (int x = 0; x < 8; ++x)
            for (int y = 0; y < 8; ++y)
                for (int z = 0; z < 8; ++z)
                    if (const float v = field.block(i)[blockOffset(x, y, z)]; v > 0) {
                        const Int3 p = field.blockOrigins[i] + Int3(x, y, z);
                        out[{p.x, p.y, p.z}] += v;
                    }
    for (const ConstantTile& t : field.tiles)
        for (int x = 0; x < t.edge; ++x)
            for (int y = 0; y < t.edge; ++y)
                for (int z = 0; z < t.edge; ++z) out[{t.origin.x + x, t.origin.y + y, t.origin.z + z}] += t.value;
    return out;
}

int half(int v) {
    return v >= 0 ? v / 2 : -((1 - v) / 2);
}

Voxels bruteForce(const SparseField& field) {
    Voxels out;
    for (const auto& [p, v] : voxels(field)) {
        const auto [x, y, z] = p;
        out[{half(x), half(y), half(z)}] += v / 8;
    }
    return out;
}

SparseField randomField(std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> value(-0.5f, 1.0f);
    std::map<std::tuple<int, int, int>, int> taken;
    FieldBuilder builder("random", Mat4(1.0));
    for (int i = 0; i < 60; ++i) {
        const Int3 origin(8 * (int(random() % 9) - 5), 8 * (int(random() % 9) - 4), 8 * (int(random() % 3) - 2));
        if (taken[{origin.x, origin.y, origin.z}]++ > 0) continue;
        if (i % 5 == 0) {
            builder.addTile({origin, 8, 0.25f + 0.01f * static_cast<float>(i)});
            continue;
        }
        Block block;
        for (float& v : block) v = value(random);
        builder.addBlock(origin, block.data());
    }
    builder.addTile({{-64, -64, 64}, 16, 2.0f});
    builder.addTile({{64, 64, -96}, 32, 3.0f});
    return builder.finish();
}

TEST(Coarser, IsTheMeanOfEightVoxelsAlsoAtNegativeIndices) {
    for (const std::uint32_t seed : {1u, 2u, 3u}) {
        const SparseField fine = randomField(seed);
        const SparseField coarse = coarser(fine);
        const Voxels expected = bruteForce(fine);
        const Voxels found = voxels(coarse);
        ASSERT_EQ(found.size(), expected.size());
        for (const auto& [p, v] : expected) {
            const auto at = found.find(p);
            ASSERT_NE(at, found.end());
            // Seven additions of floats below 4.
            EXPECT_NEAR(at->second, v, 8 * 4 * std::numeric_limits<float>::epsilon());
        }
        EXPECT_EQ(coarse.activeVoxels, found.size());
    }
}

TEST(Coarser, KeepsBlocksInAscendingOrder) {
    const SparseField coarse = coarser(randomField(4));
    ASSERT_GT(coarse.blockCount(), 4u);
    for (std::size_t i = 1; i < coarse.blockCount(); ++i)
        EXPECT_TRUE(originLess(coarse.blockOrigins[i - 1], coarse.blockOrigins[i]));
}

TEST(Coarser, PutsTheCoarseCentreBetweenTheFineOnes) {
    FieldBuilder builder("f", Mat4{{2, 0, 1, 0}, {0, 3, 0, 0}, {0, 1, 4, 0}, {10, 20, 30, 1}});
    Block block{};
    block[0] = 1;
    builder.addBlock({-8, 0, 8}, block.data());
    const SparseField fine = builder.finish();
    const SparseField coarse = coarser(fine);
    for (const Int3 c : {Int3(0, 0, 0), Int3(-4, 0, 4), Int3(-1, 7, 3)}) {
        Vec3 mean(0);
        for (int i = 0; i < 8; ++i)
            mean += transformPoint(fine.wsFromIs, Vec3(2 * c.x + (i & 1), 2 * c.y + (i >> 1 & 1), 2 * c.z + (i >> 2))) /
                    8.0;
        const Vec3 centre = transformPoint(coarse.wsFromIs, Vec3(c));
        for (int k = 0; k < 3; ++k) EXPECT_DOUBLE_EQ(centre[k], mean[k]);
    }
    ASSERT_EQ(coarse.blockCount(), 1u);
    EXPECT_EQ(coarse.blockOrigins[0], Int3(-8, 0, 0));
    EXPECT_EQ(coarse.block(0)[blockOffset(4, 0, 4)], 0.125f);
}

TEST(Coarser, HalvesTilesAndTurnsTheSmallestIntoPartsOfBlocks) {
    FieldBuilder builder("f", Mat4(1.0));
    builder.addTile({{-128, 0, 128}, 128, 2.0f});
    builder.addTile({{-8, -8, -8}, 8, 3.0f});
    const SparseField coarse = coarser(builder.finish());
    ASSERT_EQ(coarse.tiles.size(), 1u);
    EXPECT_EQ(coarse.tiles[0].origin, Int3(-64, 0, 64));
    EXPECT_EQ(coarse.tiles[0].edge, 64);
    EXPECT_EQ(coarse.tiles[0].value, 2.0f);
    ASSERT_EQ(coarse.blockCount(), 1u);
    EXPECT_EQ(coarse.blockOrigins[0], Int3(-8, -8, -8));
    EXPECT_EQ(coarse.block(0)[blockOffset(4, 4, 4)], 3.0f);
    EXPECT_EQ(coarse.block(0)[blockOffset(3, 4, 4)], 0.0f);
    EXPECT_EQ(coarse.activeVoxels, 64u * 64 * 64 + 64);
}

TEST(Coarser, SurvivesTheLargestValues) {
    Block block;
    block.fill(std::numeric_limits<float>::max());
    FieldBuilder builder("f", Mat4(1.0));
    builder.addBlock({0, 0, 0}, block.data());
    const SparseField coarse = coarser(builder.finish());
    EXPECT_EQ(coarse.maxValue, std::numeric_limits<float>::max());
}

TEST(Coarser, HandsOnWhatCleaningCounted) {
    Block block;
    block.fill(-1);
    block[0] = std::numeric_limits<float>::quiet_NaN();
    FieldBuilder builder("f", Mat4(1.0));
    builder.addBlock({0, 0, 0}, block.data());
    const SparseField coarse = coarser(builder.finish());
    EXPECT_EQ(coarse.nonFinite, 1u);
    EXPECT_EQ(coarse.negative, 511u);
    EXPECT_TRUE(coarse.empty());
}

}  // namespace
}  // namespace scrim
