// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/preview_marks.h>

#include <gtest/gtest.h>

#include <algorithm>

namespace scrim::test {
namespace {

constexpr int kWidth = 480, kHeight = 360;

DisplayImage greyPicture() {
    return {{0, 0, kWidth, kHeight}, std::vector<std::uint8_t>(std::size_t(4 * kWidth * kHeight), 100)};
}

const std::uint8_t* pixelOf(const DisplayImage& picture, int x, int y) {
    return picture.rgba.data() + 4 * (std::size_t(y) * kWidth + std::size_t(x));
}

TEST(PreviewMarks, RoundALengthDownToOneTwoOrFive) {
    EXPECT_DOUBLE_EQ(roundLength(1), 1);
    EXPECT_DOUBLE_EQ(roundLength(1.99), 1);
    EXPECT_DOUBLE_EQ(roundLength(4.99), 2);
    EXPECT_DOUBLE_EQ(roundLength(730), 500);
    EXPECT_DOUBLE_EQ(roundLength(0.0211), 0.02);
    EXPECT_DOUBLE_EQ(roundLength(1e-7), 1e-7);
    EXPECT_DOUBLE_EQ(roundLength(1000), 1000);
}

// Two metres at a distance of 10, where a pixel is 10 / 480 wide; a third of that at 30.
TEST(PreviewMarks, HaveABarThatIsTrueAtTheMiddle) {
    PreviewMarks marks;
    marks.camera.resolution = {kWidth, kHeight};
    marks.camera.fov = 2 * 26.565051177077990;  // as wide as it is deep
    marks.camera.wsPosition = {0, 0, 0};
    for (const double distance : {10.0, 30.0}) {
        marks.wsMiddle = {0, 0, -distance};
        DisplayImage picture = greyPicture();
        drawMarks(picture, marks);
        const double length = distance == 10 ? 2 : 5, pixels = length * kWidth / distance;
        int white = 0;
        for (int x = 0; x < kWidth / 2; ++x) white += pixelOf(picture, x, kHeight - 14)[1] > 130 ? 1 : 0;
        EXPECT_NEAR(white, pixels, 3) << distance;
    }
}

TEST(PreviewMarks, PointAlongTheAxesAsTheCameraSeesThem) {
    PreviewMarks marks;
    marks.camera.resolution = {kWidth, kHeight};
    marks.camera.wsPosition = {0, -10, 0};
    marks.camera.wsFromCamera = lookAt({0, -10, 0}, {0, 0, 0}, {0, 0, 1});  // x to the right, z up, y away
    marks.wsMiddle = {0, 0, 0};
    DisplayImage picture = greyPicture();
    drawMarks(picture, marks);
    // The mean place of pixels in which a colour stands out.
    const auto placeOf = [&](int channel) {
        Vec2 sum(0);
        int count = 0;
        for (int y = kHeight / 2; y < kHeight; ++y)
            for (int x = kWidth / 2; x < kWidth; ++x) {
                const std::uint8_t* p = pixelOf(picture, x, y);
                if (p[channel] < 180 || p[(channel + 1) % 3] > 150 || p[(channel + 2) % 3] > 150) continue;
                sum += Vec2(x, y);
                ++count;
            }
        EXPECT_GT(count, 5) << channel;
        return sum / double(std::max(count, 1));
    };
    const Vec2 red = placeOf(0), blue = placeOf(2);
    EXPECT_GT(red.x, blue.x + 8);
    EXPECT_LT(blue.y, red.y - 8);
}

TEST(PreviewMarks, LeaveTheRestOfThePictureAlone) {
    PreviewMarks marks;
    marks.camera.resolution = {kWidth, kHeight};
    marks.wsMiddle = {0, 0, -10};
    DisplayImage picture = greyPicture();
    drawMarks(picture, marks);
    for (int y = 0; y < kHeight / 2; ++y)
        for (int x = 0; x < kWidth; ++x) ASSERT_EQ(pixelOf(picture, x, y)[0], 100) << x << ", " << y;
    marks.wsMiddle = {0, 0, 10};  // behind the eye: no bar
    picture = greyPicture();
    drawMarks(picture, marks);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth / 2; ++x) ASSERT_EQ(pixelOf(picture, x, y)[0], 100) << x << ", " << y;
}

}  // namespace
}  // namespace scrim::test
