// SPDX-License-Identifier: Apache-2.0
// The life of a plane: whatever was written in one batch must not be seen in the next.
#include <scrim/engine/splat/plane_stack.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

namespace scrim::test {
namespace {

constexpr int kWidth = 48, kHeight = 32;

// Writes `value` into all of a tile.
void fill(PlaneStack& planes, int p, int tx, int ty, float value) {
    for (int y = 0; y < kTileEdge; ++y)
        std::fill_n(planes.plane(p) + std::ptrdiff_t(ty * kTileEdge + y) * planes.rowStride() +
                        tx * kTileEdge * planes.channels(),
                    kTileEdge * planes.channels(), value);
}

// True where every float of the tile is `value`.
bool holds(const PlaneStack& planes, int p, int tx, int ty, float value) {
    for (int y = 0; y < kTileEdge; ++y) {
        const float* row = planes.plane(p) + std::ptrdiff_t(ty * kTileEdge + y) * planes.rowStride() +
                           tx * kTileEdge * planes.channels();
        if (std::any_of(row, row + kTileEdge * planes.channels(), [&](float v) { return v != value; })) return false;
    }
    return true;
}

TEST(PlaneStack, StartsEmptyAndInactive) {
    const PlaneStack planes(3, kWidth, kHeight, 4);
    EXPECT_EQ(planes.tilesX(), 3);
    EXPECT_EQ(planes.tilesY(), 2);
    EXPECT_EQ(planes.rowStride(), kWidth * 4);
    for (int p = 0; p < 3; ++p)
        for (int ty = 0; ty < 2; ++ty)
            for (int tx = 0; tx < 3; ++tx) {
                EXPECT_FALSE(planes.active(p, tx, ty));
                EXPECT_TRUE(holds(planes, p, tx, ty, 0));
            }
}

TEST(PlaneStack, PlanesBeginOnVectorBoundaries) {
    const PlaneStack planes(3, kWidth, kHeight, 1);
    for (int p = 0; p < 3; ++p) EXPECT_EQ(reinterpret_cast<std::uintptr_t>(planes.plane(p)) % 64, 0u);
}

TEST(PlaneStack, CountsFromAnyPlane) {
    PlaneStack planes(3, kWidth, kHeight, 1);
    for (int p = 0; p < 3; ++p) {
        planes.begin(p);
        planes.activate(p, p, 0);
        fill(planes, p, p, 0, static_cast<float>(p + 1));
        planes.finish(p);
    }
    planes.countFrom(1);
    EXPECT_TRUE(planes.active(0, 1, 0));
    EXPECT_FALSE(planes.active(0, 0, 0));
    EXPECT_TRUE(holds(planes, 0, 1, 0, 2));
    EXPECT_TRUE(holds(planes, 1, 2, 0, 3));
    planes.countFrom(0);
    EXPECT_TRUE(holds(planes, 0, 0, 0, 1));
}

TEST(PlaneStack, PlanesDoNotOverlapAndMayBeReadABitBehindTheirEnd) {
    PlaneStack planes(2, kWidth, kHeight, 1);
    EXPECT_GE(planes.planeStride(), kWidth * kHeight + 32);
    EXPECT_GE(PlaneStack::bytes(2, kWidth, kHeight, 1), static_cast<std::size_t>(2 * kWidth * kHeight) * sizeof(float));
    fill(planes, 0, 2, 1, 5);
    EXPECT_TRUE(holds(planes, 1, 0, 0, 0));
}

TEST(PlaneStack, ActivatingClearsWhatTheLastBatchLeft) {
    PlaneStack planes(1, kWidth, kHeight, 2);
    planes.begin(0);
    planes.activate(0, 1, 1);
    fill(planes, 0, 1, 1, 7);
    planes.finish(0);
    EXPECT_TRUE(planes.active(0, 1, 1));
    EXPECT_TRUE(holds(planes, 0, 1, 1, 7));

    planes.begin(0);
    EXPECT_FALSE(planes.active(0, 1, 1));
    planes.activate(0, 1, 1);
    EXPECT_TRUE(planes.active(0, 1, 1));
    EXPECT_TRUE(holds(planes, 0, 1, 1, 0));
}

TEST(PlaneStack, ActivatingTwiceKeepsWhatWasAddedInBetween) {
    PlaneStack planes(1, kWidth, kHeight, 1);
    planes.begin(0);
    planes.activate(0, 0, 0);
    fill(planes, 0, 0, 0, 3);
    planes.activate(0, 0, 0);
    EXPECT_TRUE(holds(planes, 0, 0, 0, 3));
}

TEST(PlaneStack, FinishingClearsTilesThatAreNoLongerUsed) {
    PlaneStack planes(2, kWidth, kHeight, 1);
    for (int p = 0; p < 2; ++p) {
        planes.begin(p);
        planes.replace(p, 2, 0);
        fill(planes, p, 2, 0, 9);
        planes.finish(p);
    }
    planes.begin(0);
    planes.finish(0);
    EXPECT_FALSE(planes.active(0, 2, 0));
    EXPECT_TRUE(holds(planes, 0, 2, 0, 0));
    // The other plane still holds its content.
    EXPECT_TRUE(planes.active(1, 2, 0));
    EXPECT_TRUE(holds(planes, 1, 2, 0, 9));
}

TEST(PlaneStack, FinishRowClearsItsRowOnly) {
    PlaneStack planes(1, kWidth, kHeight, 1);
    planes.begin(0);
    for (int ty = 0; ty < 2; ++ty) {
        planes.replace(0, 0, ty);
        fill(planes, 0, 0, ty, 4);
    }
    planes.begin(0);
    planes.finishRow(0, 1);
    EXPECT_TRUE(holds(planes, 0, 0, 1, 0));
    EXPECT_TRUE(holds(planes, 0, 0, 0, 4));
    planes.finishRow(0, 0);
    EXPECT_TRUE(holds(planes, 0, 0, 0, 0));
}

// A thousand random batches: after finish a tile holds what this batch wrote, or zeros.
TEST(PlaneStack, NeverShowsATexelOfAnEarlierBatch) {
    PlaneStack planes(2, kWidth, kHeight, 1);
    std::mt19937 random(17);
    for (int batch = 1; batch <= 1000; ++batch) {
        const int p = batch % 2;
        planes.begin(p);
        std::vector<float> expected(6, 0.0f);
        for (int i = 0; i < 3; ++i) {
            const int tile = static_cast<int>(random() % 6);
            const auto value = static_cast<float>(batch);
            switch (random() % 3) {
                case 0:
                    break;
                case 1:
                    planes.activate(p, tile % 3, tile / 3);
                    ASSERT_TRUE(holds(planes, p, tile % 3, tile / 3, expected[static_cast<std::size_t>(tile)]));
                    break;
                default:
                    planes.replace(p, tile % 3, tile / 3);
                    fill(planes, p, tile % 3, tile / 3, value);
                    expected[static_cast<std::size_t>(tile)] = value;
            }
        }
        planes.finish(p);
        for (int tile = 0; tile < 6; ++tile)
            ASSERT_TRUE(holds(planes, p, tile % 3, tile / 3, expected[static_cast<std::size_t>(tile)])) << batch;
    }
}

TEST(PlaneStack, AnyActiveLooksAtAClippedClosedRange) {
    PlaneStack planes(1, kWidth, kHeight, 1);
    planes.begin(0);
    planes.activate(0, 2, 1);
    EXPECT_TRUE(planes.anyActive(0, {2, 1, 3, 2}));
    EXPECT_TRUE(planes.anyActive(0, {-5, -5, 51, 51}));
    EXPECT_FALSE(planes.anyActive(0, {0, 0, 2, 2}));
    EXPECT_FALSE(planes.anyActive(0, {2, 0, 3, 1}));
    EXPECT_FALSE(planes.anyActive(0, {3, 1, 10, 2}));
    EXPECT_FALSE(planes.anyActive(0, {-4, 0, 0, 2}));
}

}  // namespace
}  // namespace scrim::test
