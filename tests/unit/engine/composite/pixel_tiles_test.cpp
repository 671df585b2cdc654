// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/composite/pixel_tiles.h>

#include <gtest/gtest.h>

#include <set>

namespace scrim::test {
namespace {

const PixelWindow kRegion{-5, 10, 40, 43};  // touches four by three tiles

// Tiles begin at multiples of 16, wherever the region does: those of a crop are those of the whole picture.
TEST(PixelTiles, CoverTheRegionFromMultiplesOfTheirEdge) {
    const PixelTiles tiles(kRegion);
    EXPECT_EQ(tiles.tilesX(), 4);
    EXPECT_EQ(tiles.tilesY(), 3);
    EXPECT_EQ(tiles.count(), 12);
    EXPECT_EQ(tiles.cornerX(0), -16);
    EXPECT_EQ(tiles.cornerY(0), 0);
    EXPECT_EQ(tiles.cornerX(6), -16 + 32);
    EXPECT_EQ(tiles.cornerY(6), 16);
}

TEST(PixelTiles, GiveEveryPixelItsOwnState) {
    PixelTiles tiles(kRegion);
    std::set<const float*> states;
    for (int y = kRegion.y0; y < kRegion.y1; ++y)
        for (int x = kRegion.x0; x < kRegion.x1; ++x) {
            states.insert(tiles.state(x, y));
            EXPECT_EQ(*tiles.state(x, y), 0);
        }
    EXPECT_EQ(states.size(), 45u * 33);
    // Pixel (x, y) of tile t is number 16 (y - corner) + (x - corner) of it.
    EXPECT_EQ(tiles.state(1, 32), tiles.states(9) + 4 * 1);
    tiles.states(5)[4 * 18 + 3] = -0.5f;
    EXPECT_EQ(tiles.state(2, 17)[3], -0.5f);
    tiles.reset();
    EXPECT_EQ(tiles.state(2, 17)[3], 0);
}

// What a pixel receives of a block of sheets is decided where the block begins, not where a batch does.
TEST(PixelTiles, ClosePixelsWhereABlockBegins) {
    PixelTiles tiles(kRegion);
    tiles.states(3)[4 * 7 + 3] = -0.9995f;
    EXPECT_EQ(tiles.closed(3, 0, 1e-3f)[7], 1);
    EXPECT_EQ(tiles.closed(3, 0, 1e-3f)[8], 0);
    tiles.states(3)[4 * 8 + 3] = -1;
    EXPECT_EQ(tiles.closed(3, 0, 1e-3f)[8], 0);
    EXPECT_EQ(tiles.closed(3, 1, 1e-3f)[8], 1);
}

TEST(PixelTiles, AreOpenUntilTheyAreOpaque) {
    PixelTiles tiles(kRegion);
    for (int t = 0; t < tiles.count(); ++t)
        if (t != 5) tiles.setOpaque(t);
    EXPECT_FALSE(tiles.opaque(5));
    EXPECT_TRUE(tiles.anyOpen(Box2<double>{-5, 10, 40, 43}));
    EXPECT_TRUE(tiles.anyOpen(Box2<double>{12, 27, 12, 27}));   // inside the open one
    EXPECT_FALSE(tiles.anyOpen(Box2<double>{-5, 10, -1, 43}));  // the left column
    EXPECT_TRUE(tiles.anyOpen(Box2<double>{-1e30, -1e30, 1e30, 1e30}));
    EXPECT_FALSE(tiles.anyOpen(Box2<double>{100, 20, 200, 30}));  // beside the picture
    EXPECT_FALSE(tiles.anyOpen(Box2<double>{-200, 20, -100, 30}));
    EXPECT_FALSE(tiles.anyOpen(Box2<double>{12, -50, 14, -40}));
    tiles.setOpaque(5);
    EXPECT_FALSE(tiles.anyOpen(Box2<double>{-1e30, -1e30, 1e30, 1e30}));
    tiles.reset();
    EXPECT_TRUE(tiles.anyOpen(Box2<double>{0, 20, 0, 20}));
}

}  // namespace
}  // namespace scrim::test
