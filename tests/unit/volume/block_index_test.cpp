// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/block_index.h>

#include <scrim/volume/field_builder.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <vector>

namespace scrim::test {
namespace {

// Blocks, and tiles of several sizes, on either side of the origin; `far`: one block is so far away that no table holds
// them all.
SparseField mixedField(bool far = true) {
    FieldBuilder builder("mixed", Mat4(1.0));
    std::vector<float> values(kBlockVoxels);
    for (int i = 0; i < kBlockVoxels; ++i) values[std::size_t(i)] = static_cast<float>(i % 7);
    for (const Int3& origin : {Int3(0, 0, 0), Int3(8, 0, 0), Int3(-16, -8, 24), Int3(far ? 1 << 26 : 512, 0, 0)})
        builder.addBlock(origin, values.data());
    builder.addTile({{16, 0, 0}, 8, 2.5f});
    builder.addTile({{64, 0, 0}, 64, 3.5f});
    builder.addTile({{0, -128, 0}, 128, 4.5f});
    builder.addTile({{128, 128, 128}, 8, 5.5f});
    return builder.finish();
}

// As the field's own lists have it.
double scanned(const SparseField& field, const Int3& is) {
    for (std::size_t b = 0; b < field.blockCount(); ++b)
        if (const Int3 p = is - field.blockOrigins[b]; std::min({p.x, p.y, p.z}) >= 0 && std::max({p.x, p.y, p.z}) < 8)
            return field.block(b)[blockOffset(p.x, p.y, p.z)];
    for (const ConstantTile& tile : field.tiles)
        if (const Int3 p = is - tile.origin; std::min({p.x, p.y, p.z}) >= 0 && std::max({p.x, p.y, p.z}) < tile.edge)
            return tile.value;
    return 0;
}

TEST(BlockIndex, FindsWhatAScanOfAllBlocksAndTilesFinds) {
    for (const bool far : {true, false}) {
        const SparseField field = mixedField(far);
        const BlockIndex index(field);
        std::mt19937 random(3);
        const auto near = [&] { return static_cast<int>(random() % 320) - 150; };
        int found = 0;
        for (int i = 0; i < 20000; ++i) {
            const Int3 is(near() + (i % 10 == 0 ? (far ? 1 << 26 : 512) : 0), near(), near());
            const double expected = scanned(field, is);
            ASSERT_EQ(index.voxel(is), expected) << toText(is) << (far ? ", by a hash" : ", by a table");
            found += expected > 0;
        }
        EXPECT_GT(found, 500);
        EXPECT_EQ(index.isBounds().lower, field.isBounds().lower);
        EXPECT_EQ(index.isBounds().upper, field.isBounds().upper);
    }
}

// Places 2^24 voxels apart, and more, are not mistaken for one another.
TEST(BlockIndex, TellsPlacesApartHoweverFarTheyAre) {
    const SparseField field = mixedField();
    const BlockIndex index(field);
    for (const int away : {1 << 21, 1 << 24, 1 << 25, -(1 << 27)}) {
        EXPECT_TRUE(index.at(Int3(away >> 3, 0, 0)).empty()) << away;
        EXPECT_TRUE(index.at(Int3(0, away >> 3, 0)).empty()) << away;
    }
    EXPECT_NE(index.at(Int3((1 << 26) >> 3, 0, 0)).values, nullptr);
}

TEST(BlockIndex, VisitsWhatABoxTouchesOnceWhateverItsSize) {
    const SparseField field = mixedField();
    const BlockIndex index(field);
    const auto visited = [&](const Int3& lower, const Int3& upper) {
        std::vector<std::uint32_t> numbers;
        index.visit(lower, upper, [&](const BlockIndex::Place& place, std::uint32_t number) {
            EXPECT_FALSE(place.empty());
            numbers.push_back(number);
        });
        std::sort(numbers.begin(), numbers.end());
        return numbers;
    };
    const std::vector<std::uint32_t> all = visited(Int3(-(1 << 28)), Int3(1 << 28));
    ASSERT_EQ(all.size(), field.blockCount() + field.tiles.size());
    EXPECT_EQ(std::set<std::uint32_t>(all.begin(), all.end()).size(), all.size());
    EXPECT_EQ(visited(Int3(0), Int3(0)).size(), 1u);              // a block
    EXPECT_EQ(visited(Int3(9, 3, 3), Int3(9, 3, 3)).size(), 1u);  // within a tile of 64
    EXPECT_EQ(visited(Int3(0), Int3(2, 0, 0)).size(), 3u);        // two blocks and a tile
    EXPECT_TRUE(visited(Int3(40), Int3(60)).empty());
    EXPECT_TRUE(visited(Int3(1), Int3(0)).empty());
}

TEST(BlockIndex, KnowsWhereNothingIsEvenOfHugeBoxes) {
    const SparseField field = mixedField();
    const BlockIndex index(field);
    EXPECT_TRUE(index.anyIn({Vec3(-1e12), Vec3(1e12)}));
    EXPECT_FALSE(index.anyIn({Vec3(1e10), Vec3(1e12)}));
    EXPECT_TRUE(index.anyIn({Vec3(127, 63, 63), Vec3(127.5, 63.5, 63.5)}));  // the last voxel of a tile
    EXPECT_FALSE(index.anyIn({Vec3(127.1, 70, 63), Vec3(130, 75, 64)}));
    const SparseField nothing;
    EXPECT_FALSE(BlockIndex(nothing).anyIn({Vec3(-1e12), Vec3(1e12)}));
    EXPECT_EQ(BlockIndex(nothing).voxel(Int3(0)), 0);
}

}  // namespace
}  // namespace scrim::test
