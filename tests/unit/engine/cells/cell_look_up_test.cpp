// SPDX-License-Identifier: Apache-2.0
// Look-ups of light on cells at a tile of samples, and the spans of rows that cells are swept by.
#include <scrim/base/simd.h>
#include <scrim/engine/cells/cell_field.h>
#include <scrim/engine/passes/row_spans.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

namespace scrim {
namespace {

// Blocks apart from each other, with different light everywhere.
CellField someLight(int colours) {
    const std::vector<Bounds> boxes{{{0.5, 0.5, 0.5}, {11, 5, 5}}, {{20, 0.5, 9}, {21, 1, 10}}};
    const auto grid = std::make_shared<const CellGrid>(0.75, boxes, Vec3(0.1, 0.2, 0.3));
    CellField field(grid, colours, Rgb(0.5, 1, 0.25));
    field.add([](const Vec3& p) { return Rgb(2 + std::sin(p.x), 3 + p.y * p.z, 1 + p.x); });
    return field;
}

// Samples in and beside these blocks, slanted, in a sheet of this optical depth per unit of extinction.
struct Tile {
    SampleTile samples{};
    SamplePlane plane{{-1, -0.7, 2.2}, {1.6, 0.1, 0.05}, {0.02, 0.5, 0.4}, {0.1, -0.2, 0.7}, 0.8, 1, {}};
    Real extinction[kTileSize] = {};

    Tile() {
        for (int k = 0; k < kTileSize; ++k) {
            samples.u[k] = static_cast<Real>(k % kTileEdge + 0.3);
            samples.v[k] = static_cast<Real>(k / kTileEdge + 0.6);
            samples.eyeA[k] = static_cast<Real>(0.01 * (k % 7) - 0.02);
            samples.eyeB[k] = static_cast<Real>(0.02 * (k % 5) - 0.03);
            // None, thin, and now and then thick.
            extinction[k] = k % 5 == 0 ? Real(0) : static_cast<Real>(k % 11 == 0 ? 2.5 : 0.02 * (k % 13));
        }
    }
};

TEST(CellLookUp, OfATileIsThatOfItsSamplesOnAllInstructionSets) {
    for (const int colours : {1, 3}) {
        const CellField field = someLight(colours);
        for (const std::string& name : simdNames()) {
            Tile tile;
            tile.plane.simd = Simd(name);
            Real rows[3][kTileSize];
            Real* const rgb[3] = {rows[0], rows[1], rows[2]};
            field.lookUp(tile.plane, tile.samples, tile.extinction, rgb);
            int thin = 0, thick = 0, beside = 0;
            for (int k = 0; k < kTileSize; ++k) {
                Real expected[3] = {0, 0, 0};
                if (tile.extinction[k] != 0) {
                    const SheetPath path(tile.plane, tile.samples, k, tile.extinction[k]);
                    field.sample(path.wsNear + path.wsSeen, expected);
                    Real behind[3];
                    field.sample(path.wsFar + path.wsSeenFar, behind);
                    for (int c = 0; path.thick && c < 3; ++c) expected[c] += path.farther * (behind[c] - expected[c]);
                    (expected[0] == 0 ? beside : path.thick ? thick : thin)++;
                }
                for (int c = 0; c < 3; ++c)
                    EXPECT_NEAR(rows[c][k], expected[c], 1e-5 * (1 + expected[c])) << name << " at " << k;
            }
            EXPECT_GT(thin, 40);
            EXPECT_GT(thick, 4);
            EXPECT_GT(beside, 20);
        }
    }
}

TEST(RowSpans, AreAsFewAsVectorsMayWriteBehind) {
    const std::vector<std::vector<CellSpan>> given{{{40, 50}, {0, 8}, {4, 12}, {7, 7}},
                                                   {},
                                                   {{0, 4}, {4 + RowSpans::kApart, 30}},
                                                   {{0, 4}, {3 + RowSpans::kApart, 30}}};
    const RowSpans spans =
        RowSpans::of(given.size(), [&](std::size_t row, std::vector<CellSpan>& out) { out = given[row]; });
    const auto text = [&](std::size_t row) {
        std::string all;
        for (const CellSpan& span : spans.row(row))
            all += std::to_string(span.begin) + "-" + std::to_string(span.end) + " ";
        return all;
    };
    EXPECT_EQ(text(0), "0-12 40-50 ");
    EXPECT_EQ(text(1), "");
    EXPECT_EQ(text(2), "0-4 20-30 ");
    EXPECT_EQ(text(3), "0-30 ");
    EXPECT_EQ(spans.around(0).begin, 0);
    EXPECT_EQ(spans.around(0).end, 50);
    EXPECT_TRUE(spans.around(1).empty());
    EXPECT_EQ(spans.usedRows(2), (std::vector<std::vector<int>>{{0}, {0, 1}}));
}

// More rows than one thread makes at a time.
TEST(RowSpans, OfManyRowsAreTheirOwn) {
    constexpr std::size_t kRows = 20000;
    const RowSpans spans = RowSpans::of(kRows, [](std::size_t row, std::vector<CellSpan>& out) {
        if (row % 3 != 0) out.push_back({static_cast<int>(row), static_cast<int>(row) + 2});
    });
    for (std::size_t row = 0; row < kRows; ++row) {
        ASSERT_EQ(spans.row(row).size(), row % 3 != 0 ? 1u : 0u);
        if (row % 3 != 0) {
            ASSERT_EQ(spans.row(row).front().begin, static_cast<int>(row));
        }
    }
}

}  // namespace
}  // namespace scrim
