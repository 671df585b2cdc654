// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/field_builder.h>

#include "support/expect_error.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <sys/mman.h>
#include <unistd.h>

namespace scrim {
namespace {

using test::errorOf;
using Block = std::array<float, kBlockVoxels>;

Block filled(float value) {
    Block block;
    block.fill(value);
    return block;
}

TEST(FieldBuilder, SortsBlocksByXThenYThenZ) {
    FieldBuilder builder("f", Mat4(1.0));
    const std::vector<Int3> sorted{{-16, 8, 0}, {-8, 0, 0}, {-8, 0, 8}, {-8, 8, -8}, {0, -8, 0}};
    for (const std::size_t i : {3u, 0u, 4u, 2u, 1u})
        builder.addBlock(sorted[i], filled(static_cast<float>(i + 1)).data());
    const SparseField field = builder.finish();
    EXPECT_EQ(field.blockOrigins, sorted);
    for (std::size_t i = 0; i < sorted.size(); ++i) EXPECT_EQ(field.block(i)[511], static_cast<float>(i + 1));
    EXPECT_EQ(field.activeVoxels, 5u * 512);
    EXPECT_EQ(field.maxValue, 5.0f);
}

TEST(FieldBuilder, CleansAndCountsValues) {
    Block block = filled(0);
    block[0] = std::numeric_limits<float>::quiet_NaN();
    block[1] = -std::numeric_limits<float>::infinity();
    block[2] = -0.5f;
    block[3] = -0.0f;
    block[4] = std::numeric_limits<float>::denorm_min();
    block[5] = -std::numeric_limits<float>::denorm_min();
    block[6] = std::numeric_limits<float>::min();
    FieldBuilder builder("f", Mat4(1.0));
    builder.addBlock({0, 0, 0}, block.data());
    const SparseField field = builder.finish();
    EXPECT_EQ(field.nonFinite, 2u);
    EXPECT_EQ(field.negative, 1u);
    EXPECT_EQ(field.activeVoxels, 1u);
    for (int i = 0; i < 6; ++i) {
        EXPECT_EQ(field.block(0)[i], 0.0f) << i;
        EXPECT_FALSE(std::signbit(field.block(0)[i])) << i;
    }
}

TEST(FieldBuilder, DropsEmptyBlocksBetweenOthers) {
    FieldBuilder builder("f", Mat4(1.0));
    for (int i = 0; i < 200; ++i) builder.addBlock({8 * i, 0, 0}, filled(i % 3 == 0 ? 1.0f + float(i) : 0).data());
    const SparseField field = builder.finish();
    ASSERT_EQ(field.blockCount(), 67u);
    for (int i = 0; i < 67; ++i) {
        EXPECT_EQ(field.blockOrigins[static_cast<std::size_t>(i)].x, 24 * i);
        EXPECT_EQ(field.block(static_cast<std::size_t>(i))[7], 1.0f + float(3 * i));
    }
}

/// Counts in pages what is in memory of the values of `count` blocks.
std::size_t residentPages(const float* values, std::size_t count) {
    const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
    const auto begin = reinterpret_cast<std::uintptr_t>(values) / page * page;
    const auto end = reinterpret_cast<std::uintptr_t>(values + count * kBlockVoxels) / page * page;
    std::vector<unsigned char> pages((end - begin) / page);
    EXPECT_EQ(::mincore(reinterpret_cast<void*>(begin), end - begin, pages.data()), 0);
    return static_cast<std::size_t>(std::count_if(pages.begin(), pages.end(), [](auto p) { return (p & 1) != 0; }));
}

TEST(FieldBuilder, TakesNoMemoryForEmptyBlocks) {
    constexpr int kBlocks = 40000, kPages = kBlocks / 2;
    FieldPieces pieces;
    pieces.name = "f";
    pieces.fill = [](std::size_t i, float* values) { std::fill_n(values, 512, i < 3 ? 1.0f : -1.0f); };
    for (int i = 0; i < kBlocks; ++i) pieces.blockOrigins.push_back({8 * i, 0, 0});
    const SparseField field = buildField(std::move(pieces));
    ASSERT_EQ(field.blockCount(), 3u);
    EXPECT_EQ(field.block(2)[511], 1.0f);
    EXPECT_LT(residentPages(field.block(0), kBlocks), 0.1 * kPages);
}

/// Memory of this process in bytes: "VmRSS" now, "VmHWM" at most since the file clear_refs was written to.
double memoryBytes(const std::string& key) {
    std::ifstream status("/proc/self/status");
    for (std::string word; status >> word;)
        if (word == key + ":") {
            double kilobytes = 0;
            status >> kilobytes;
            return 1024 * kilobytes;
        }
    return 0;
}

TEST(FieldBuilder, GivesItsMemoryBackWhileItFillsTheField) {
    constexpr int kBlocks = 40000;  // 82 MB
    FieldBuilder builder("f", Mat4(1.0));
    for (int i = 0; i < kBlocks; ++i) builder.addBlock({8 * i, 0, 0}, filled(1.0f + float(i)).data());
    std::ofstream("/proc/self/clear_refs") << 5;
    const double before = memoryBytes("VmRSS");
    const SparseField field = builder.finish();
    EXPECT_EQ(field.block(7)[511], 8.0f);
    EXPECT_LT(memoryBytes("VmHWM") - before, 0.3 * double(field.bytes()));
}

TEST(FieldBuilder, IsEmptyAfterFinish) {
    FieldBuilder builder("f", Mat4(2.0));
    builder.addBlock({0, 0, 0}, filled(1).data());
    builder.addTile({{8, 0, 0}, 8, 1});
    // Mat4(2) has 2 in its last corner: not affine.
    EXPECT_EQ(errorOf(ErrorKind::input, [&] { builder.finish(); }), "grid 'f': its transform is not affine");
    FieldBuilder good("f", Mat4(1.0));
    good.addBlock({0, 0, 0}, filled(1).data());
    EXPECT_FALSE(good.finish().empty());
    EXPECT_TRUE(good.finish().empty());
}

TEST(FieldBuilder, RefusesBlocksAndTilesOffTheirLattice) {
    const auto reason = [](const Int3& origin, int edge) {
        FieldBuilder builder("f", Mat4(1.0));
        if (edge == 0)
            builder.addBlock(origin, filled(1).data());
        else
            builder.addTile({origin, edge, 1.0f});
        return errorOf(ErrorKind::input, [&] { builder.finish(); });
    };
    EXPECT_EQ(reason({0, -4, 0}, 0), "grid 'f': a block at 0, -4, 0: origins must be multiples of 8");
    const std::string rule = ": the edge must be 8 times a power of two and the origin a multiple of it";
    EXPECT_EQ(reason({0, 0, 0}, 24), "grid 'f': a tile of edge 24 at 0, 0, 0" + rule);
    EXPECT_EQ(reason({0, 0, 0}, -8), "grid 'f': a tile of edge -8 at 0, 0, 0" + rule);
    EXPECT_EQ(reason({8, 0, 0}, 16), "grid 'f': a tile of edge 16 at 8, 0, 0" + rule);
}

TEST(FieldBuilder, RefusesOverlaps) {
    const auto reason = [](const std::vector<Int3>& blocks, const std::vector<ConstantTile>& tiles) {
        FieldBuilder builder("f", Mat4(1.0));
        for (const Int3& origin : blocks) builder.addBlock(origin, filled(1).data());
        for (const ConstantTile& tile : tiles) builder.addTile(tile);
        return errorOf(ErrorKind::input, [&] { builder.finish(); });
    };
    EXPECT_EQ(reason({{0, 8, 0}, {8, 8, 0}, {0, 8, 0}}, {}), "grid 'f': two blocks at 0, 8, 0");
    EXPECT_EQ(reason({}, {{{0, 8, 0}, 8, 1}, {{0, 8, 0}, 8, 2}}), "grid 'f': two tiles at 0, 8, 0");
    EXPECT_EQ(reason({{0, 8, 0}}, {{{0, 8, 0}, 8, 1}}), "grid 'f': values at 0, 8, 0 lie inside the tile at 0, 8, 0");
    EXPECT_EQ(reason({{-8, -16, -120}}, {{{-128, -128, -128}, 128, 1}}),
              "grid 'f': values at -8, -16, -120 lie inside the tile at -128, -128, -128");
    EXPECT_EQ(reason({}, {{{-16, -16, -16}, 16, 1}, {{-128, -128, -128}, 128, 1}}),
              "grid 'f': values at -16, -16, -16 lie inside the tile at -128, -128, -128");
}

TEST(FieldBuilder, RefusesTransformsWithoutInverse) {
    Mat4 flat(1.0);
    flat[1] = flat[0];
    EXPECT_EQ(errorOf(ErrorKind::input, [&] { FieldBuilder("f", flat).finish(); }),
              "grid 'f': its transform cannot be inverted");
    Mat4 broken(1.0);
    broken[3][0] = std::numeric_limits<double>::infinity();
    EXPECT_EQ(errorOf(ErrorKind::input, [&] { FieldBuilder("f", broken).finish(); }),
              "grid 'f': its transform is not finite");
    Mat4 tiny(1e-9);
    tiny[3][3] = 1;
    EXPECT_NO_THROW(FieldBuilder("f", tiny).finish());
}

}  // namespace
}  // namespace scrim
