// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/composite/pixel_tiles.h>

#include <gtest/gtest.h>

#include <set>

namespace scrim::test {
namespace {

const PixelWindow kRegion{-5, 10, 40, 43};  // 45 x 33: three by three tiles

TEST(PixelTiles, CoverTheRegionFromItsCorner) {
    const PixelTiles tiles(kRegion);
    EXPECT_EQ(tiles.tilesX(), 3);
    EXPECT_EQ(tiles.tilesY(), 3);
    EXPECT_EQ(tiles.count(), 9);
    EXPECT_EQ(tiles.cornerX(0), -5);
    EXPECT_EQ(tiles.cornerY(0), 10);
    EXPECT_EQ(tiles.cornerX(5), -5 + 32);
    EXPECT_EQ(tiles.cornerY(5), 10 + 16);
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
    EXPECT_EQ(tiles.state(-5 + 17, 10 + 33 - 1), tiles.states(7) + 4 * 1);
    tiles.states(4)[4 * 18 + 3] = -0.5f;
    EXPECT_EQ(tiles.state(-5 + 18, 10 + 17)[3], -0.5f);
    tiles.reset();
    EXPECT_EQ(tiles.state(-5 + 18, 10 + 17)[3], 0);
}

TEST(PixelTiles, AreOpenUntilTheyAreOpaque) {
    PixelTiles tiles(kRegion);
    for (int t = 0; t < tiles.count(); ++t)
        if (t != 4) tiles.setOpaque(t);
    EXPECT_FALSE(tiles.opaque(4));
    EXPECT_TRUE(tiles.anyOpen(Box2<double>{-5, 10, 40, 43}));
    EXPECT_TRUE(tiles.anyOpen(Box2<double>{12, 27, 12, 27}));   // inside the open one
    EXPECT_FALSE(tiles.anyOpen(Box2<double>{-5, 10, 10, 43}));  // the left column
    EXPECT_TRUE(tiles.anyOpen(Box2<double>{-1e30, -1e30, 1e30, 1e30}));
    EXPECT_FALSE(tiles.anyOpen(Box2<double>{100, 20, 200, 30}));  // beside the picture
    EXPECT_FALSE(tiles.anyOpen(Box2<double>{-200, 20, -100, 30}));
    EXPECT_FALSE(tiles.anyOpen(Box2<double>{12, -50, 14, -40}));
    tiles.setOpaque(4);
    EXPECT_FALSE(tiles.anyOpen(Box2<double>{-1e30, -1e30, 1e30, 1e30}));
    tiles.reset();
    EXPECT_TRUE(tiles.anyOpen(Box2<double>{0, 20, 0, 20}));
}

}  // namespace
}  // namespace scrim::test
