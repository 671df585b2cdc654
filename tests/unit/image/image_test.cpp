// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/image.h>

#include "support/print_window.h"

#include <gtest/gtest.h>

#include <limits>

namespace scrim {
namespace {

TEST(PixelWindow, IsHalfOpen) {
    const PixelWindow window{-2, -1, 3, 4};
    EXPECT_EQ(window.width(), 5);
    EXPECT_EQ(window.height(), 5);
    EXPECT_TRUE(window.contains(-2, -1));
    EXPECT_FALSE(window.contains(3, 0));
    EXPECT_TRUE(window.contains(window));
    EXPECT_FALSE(window.contains(PixelWindow{0, 0, 4, 1}));
    EXPECT_TRUE((PixelWindow{4, 4, 2, 8}).empty());
    EXPECT_EQ((PixelWindow{4, 4, 2, 8}).pixelCount(), 0u);
}

TEST(NonEmptyWindow, IsTheTightBoxAroundAnyChannel) {
    Image image = emptyImage({-3, -2, 5, 6});
    image.rgba[image.indexOf(-1, 3) + 2] = 0.5f;
    image.rgba[image.indexOf(2, 0) + 3] = -1.0f;
    EXPECT_EQ(nonEmptyWindow(image), (PixelWindow{-1, 0, 3, 4}));
}

TEST(NonEmptyWindow, CountsNaNAsContent) {
    Image image = emptyImage({0, 0, 4, 4});
    image.rgba[image.indexOf(3, 3)] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(nonEmptyWindow(image), (PixelWindow{3, 3, 4, 4}));
}

TEST(NonEmptyWindow, IsOnePixelOfAnEmptyImage) {
    EXPECT_EQ(nonEmptyWindow(emptyImage({-3, 7, 5, 9})), (PixelWindow{-3, 7, -2, 8}));
}

TEST(Reframed, CropsAndPads) {
    Image image = emptyImage({-1, -1, 2, 2});
    for (std::size_t i = 0; i < image.rgba.size(); ++i) image.rgba[i] = static_cast<float>(i + 1);
    const Image out = reframed(image, {0, 0, 4, 3});
    EXPECT_EQ(out.rgba[out.indexOf(0, 0)], image.rgba[image.indexOf(0, 0)]);
    EXPECT_EQ(out.rgba[out.indexOf(1, 1) + 3], image.rgba[image.indexOf(1, 1) + 3]);
    EXPECT_EQ(out.rgba[out.indexOf(2, 1)], 0.0f);
    EXPECT_EQ(out.rgba[out.indexOf(0, 2)], 0.0f);
}

}  // namespace
}  // namespace scrim
