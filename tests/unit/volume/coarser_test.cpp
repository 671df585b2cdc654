// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/coarser.h>

#include <scrim/base/parallel.h>
#include <scrim/volume/field_builder.h>

#include <cstdint>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
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

Voxels bruteForce(const SparseField& field, const HalvedAxes& halved) {
    Voxels out;
    const double together = (halved[0] ? 2 : 1) * (halved[1] ? 2 : 1) * (halved[2] ? 2 : 1);
    for (const auto& [p, v] : voxels(field)) {
        const auto [x, y, z] = p;
        out[{halved[0] ? half(x) : x, halved[1] ? half(y) : y, halved[2] ? half(z) : z}] += v / together;
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

// Neighbours exchange what interpolation would blur, so single values differ from the means, but not their places and
// their sum. Tiles take no part.
TEST(Coarser, HasTheMeansOfItsVoxelsInSumAlsoAtNegativeIndicesAndAlongSomeAxes) {
    for (const std::uint32_t axes : {7u, 1u, 2u, 3u, 4u, 5u, 6u}) {
        const HalvedAxes halved{(axes & 1) != 0, (axes & 2) != 0, (axes & 4) != 0};
        const SparseField fine = randomField(axes);
        const SparseField coarse = coarser(fine, halved);
        const Voxels expected = bruteForce(fine, halved), found = voxels(coarse);
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_EQ(coarse.wsFromIs[axis][axis], halved[std::size_t(axis)] ? 2 : 1);
            EXPECT_EQ(coarse.wsFromIs[3][axis], halved[std::size_t(axis)] ? 0.5 : 0);
        }
        double sum = 0, means = 0;
        for (const auto& [p, v] : expected) means += v;
        for (const auto& [p, v] : found) {
            EXPECT_TRUE(expected.contains(p));  // a voxel may give away all that it has, but none appears
            sum += v;
        }
        // A dozen additions of floats below 4 for each voxel.
        EXPECT_NEAR(sum, means, double(expected.size()) * 12 * 4 * std::numeric_limits<float>::epsilon());
        EXPECT_EQ(coarse.activeVoxels, found.size());
    }
}

// A wave of 16 voxels in a direction, interpolated between coarse voxels, keeps its amplitude within fourth order: with
// w = pi / 8, means alone would lose 3/8 w^2 = 5.8 % of it, and 0.6 % are left of w^4. A wave along an axis that is not
// halved stays as it is.
TEST(Coarser, KeepsTheAmplitudeOfWaves) {
    for (const auto& [way, halved] : {std::pair{Int3(1, 0, 0), kAllAxes},
                                      {Int3(0, 1, 0), kAllAxes},
                                      {Int3(0, 0, 1), kAllAxes},
                                      {Int3(1, 0, 0), HalvedAxes{true, false, false}},
                                      {Int3(0, 1, 0), HalvedAxes{false, true, false}},
                                      {Int3(0, 0, 1), HalvedAxes{false, true, true}}}) {
        FieldBuilder builder("wave", Mat4(1.0));
        const double w = std::numbers::pi / 8;
        const auto wave = [&](double at) { return 2 + std::sin(w * at); };
        for (int i = 0; i < 8 * 8 * 8; ++i) {
            const Int3 origin(8 * (i & 7), 8 * (i >> 3 & 7), 8 * (i >> 6));
            Block block;
            for (int x = 0; x < 8; ++x)
                for (int y = 0; y < 8; ++y)
                    for (int z = 0; z < 8; ++z) {
                        const Int3 at = (origin + Int3(x, y, z)) * way;
                        block[std::size_t(blockOffset(x, y, z))] = static_cast<float>(wave(at.x + at.y + at.z));
                    }
            builder.addBlock(origin, block.data());
        }
        const Voxels coarse = voxels(coarser(builder.finish(), halved));
        // The first harmonic of what is interpolated: that of the samples times sinc^2 of half a coarse voxel. Two
        // waves from the middle, away from the field's ends.
        double sine = 0, cosine = 0;
        for (int c = 8; c < 24; ++c) {
            const Int3 at = Int3(16) + (c - 16) * way;
            const double v = coarse.at({at.x, at.y, at.z});
            sine += v * std::sin(w * (2 * c + 0.5)) / 8;
            cosine += v * std::cos(w * (2 * c + 0.5)) / 8;
        }
        const double ofTents = std::pow(std::sin(w) / w, 2), ofFine = std::pow(std::sin(w / 2) / (w / 2), 2);
        EXPECT_NEAR(sine * ofTents / ofFine, 1, 0.012);
        EXPECT_NEAR(cosine, 0, 1e-4);
    }
}

TEST(CoarserLevels, AreMadeOnceForAFieldThatIsKept) {
    CoarserLevels levels;
    auto fine = std::make_shared<const SparseField>(randomField(5));
    const auto below = levels.below(fine), again = levels.below(fine);
    EXPECT_EQ(below, again);
    EXPECT_EQ(voxels(*below), voxels(coarser(*fine)));
    fine.reset();
    const auto other = std::make_shared<const SparseField>(randomField(6));
    EXPECT_NE(levels.below(other), below);
    EXPECT_EQ(below.use_count(), 2);  // `again` is the other one: nothing is kept for a field that is gone
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
