// SPDX-License-Identifier: Apache-2.0
// Where slides fall, and which way up.
#include "support/slides.h"

#include <scrim/scene/slide_map.h>

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace scrim::test {
namespace {

Rgb valueAt(const Light& light, const Vec3& ws) {
    return slideValue(light, slideMap(light), ws);
}

// The viewer stands at the light, looks along it, and has `up` above: where the viewer sees the picture's corners.
TEST(Slide, OfADistantLightIsUprightAndNotMirroredForAViewerAtTheLight) {
    // Looking along -z with y up: x is right.
    const Light light = distantSlide({0, 0, -1}, 4, quarters());
    EXPECT_EQ(valueAt(light, {-1, 1, 7}), Rgb(1, 0, 0));   // above, left
    EXPECT_EQ(valueAt(light, {1, 1, -9}), Rgb(0, 1, 0));   // above, right
    EXPECT_EQ(valueAt(light, {-1, -1, 0}), Rgb(0, 0, 1));  // below, left
    EXPECT_EQ(valueAt(light, {1, -1, 0}), Rgb(1));         // below, right
    // Looking along +z with y up: right is -x.
    const Light back = distantSlide({0, 0, 1}, 4, quarters());
    EXPECT_EQ(valueAt(back, {1, 1, 0}), Rgb(1, 0, 0));
    EXPECT_EQ(valueAt(back, {-1, 1, 0}), Rgb(0, 1, 0));
}

TEST(Slide, OfAProjectorIsUprightAndNotMirroredForAViewerAtTheLight) {
    const Light light = projector({0, 0, 10}, 40, quarters());
    EXPECT_EQ(valueAt(light, {-1, 1, 0}), Rgb(1, 0, 0));
    EXPECT_EQ(valueAt(light, {1, 1, 0}), Rgb(0, 1, 0));
    EXPECT_EQ(valueAt(light, {-1, -1, 0}), Rgb(0, 0, 1));
    EXPECT_NEAR(glm::distance(valueAt(light, {1, -1, 0}), Rgb(1)), 0, 1e-12);
    // From the side: looking along -x with y up, right is -z.
    Light side = projector({10, 0, 0}, 40, quarters());
    EXPECT_EQ(valueAt(side, {0, 1, 1}), Rgb(1, 0, 0));
    EXPECT_EQ(valueAt(side, {0, 1, -1}), Rgb(0, 1, 0));
    // With z up, looking along -x: right is y.
    side.wsUp = {0, 0, 3};
    EXPECT_EQ(valueAt(side, {0, -1, 1}), Rgb(1, 0, 0));
    EXPECT_EQ(valueAt(side, {0, 1, 1}), Rgb(0, 1, 0));
}

TEST(Slide, OfAPointLightIsThatOfAProjector) {
    Light light = projector({3, 4, 10}, 40, quarters());
    const Rgb expected = valueAt(light, {0.5, 0.25, 0});
    light.kind = Light::Point{};
    EXPECT_EQ(valueAt(light, {0.5, 0.25, 0}), expected);
}

TEST(Slide, RollsClockwiseForThatViewer) {
    Light light = distantSlide({0, 0, -1}, 4, quarters());
    light.slide->roll = 90;
    // What was above left has gone to above right.
    EXPECT_EQ(valueAt(light, {1, 1, 0}), Rgb(1, 0, 0));
    EXPECT_EQ(valueAt(light, {1, -1, 0}), Rgb(0, 1, 0));
    EXPECT_EQ(valueAt(light, {-1, 1, 0}), Rgb(0, 0, 1));
}

// Straight down with y up: another axis takes its place, and the picture stays a rotation, not a mirror image.
TEST(Slide, WithUpAlongTheLightTakesAnotherAxis) {
    const Light light = distantSlide({0, -1, 0}, 4, quarters());
    const SlideMap map = slideMap(light);
    const auto x = [&](const Vec3& ws) { return map.homogeneous(ws).x; };
    const auto y = [&](const Vec3& ws) { return map.homogeneous(ws).y; };
    // Slide x, slide y and the way of the light are right-handed.
    const Vec3 right(x({1, 0, 0}) - x(Vec3(0)), x({0, 1, 0}) - x(Vec3(0)), x({0, 0, 1}) - x(Vec3(0)));
    const Vec3 down(y({1, 0, 0}) - y(Vec3(0)), y({0, 1, 0}) - y(Vec3(0)), y({0, 0, 1}) - y(Vec3(0)));
    EXPECT_NEAR(glm::distance(glm::cross(glm::normalize(right), glm::normalize(down)), light.wsDirection), 0, 1e-12);
}

TEST(Slide, IsAsWideAsItsWidthOrFovSay) {
    const auto image = makeTexture(100, 50, [](int, int) { return Rgb(1); });
    Light light = distantSlide({0, 0, -1}, 4, image);
    light.wsPosition = {5, 5, 5};
    const auto at = [](const Light& l, const Vec3& ws) {
        const Vec3 h = slideMap(l).homogeneous(ws);
        return Vec2(h) / h.z;
    };
    EXPECT_NEAR(at(light, {3, 5, 0}).x, 0, 1e-12);
    EXPECT_NEAR(at(light, {7, 5, 0}).x, 100, 1e-12);
    EXPECT_NEAR(at(light, {5, 6, 0}).y, 0, 1e-12);  // half as high as wide
    light.slide->height = 8;
    EXPECT_NEAR(at(light, {5, 9, 0}).y, 0, 1e-12);

    const Light thrown = projector({0, 0, 10}, 60, image);
    const double half = 10 * std::tan(glm::radians(30.0));
    EXPECT_NEAR(at(thrown, {-half, 0, 0}).x, 0, 1e-12);
    EXPECT_NEAR(at(thrown, {half, 0, 0}).x, 100, 1e-12);
    EXPECT_NEAR(at(thrown, {0, half / 2, 0}).y, 0, 1e-12);
    EXPECT_NEAR(slideHalfAngle(thrown), std::atan(std::hypot(half, half / 2) / 10), 1e-12);
    EXPECT_NEAR(*slidePixel(thrown, Vec3(0)), 2 * half / 100, 1e-12);
    EXPECT_FALSE(slidePixel(thrown, {0, 0, 11}));
}

TEST(Slide, WithPixelsThatAreNotSquareHasTheAspectOfThePicture) {
    Image image = emptyImage({0, 0, 10, 10});
    Light light = distantSlide({0, 0, -1}, 4, std::make_shared<Texture>(image, 2.0));
    EXPECT_NEAR(slideMap(light).homogeneous({0, 1, 0}).y, 0, 1e-12);  // 4 wide, 2 high
}

TEST(Slide, LeavesDarkWhatIsBehindTheLight) {
    for (const SlideOutside outside : {SlideOutside::black, SlideOutside::clamp, SlideOutside::repeat}) {
        Light light = projector({0, 0, 10}, 40, quarters());
        light.slide->outside = outside;
        EXPECT_EQ(valueAt(light, {0.1, 0.1, 11}), Rgb(0));
        EXPECT_EQ(valueAt(light, {0, 0, 10}), Rgb(0));
    }
}

TEST(Slide, OutsideIsBlackOrTheBorderOrTheNextCopy) {
    const auto image = makeTexture(4, 4, [](int x, int y) { return Rgb(x + 1, y + 1, 1); });
    Light light = distantSlide({0, 0, -1}, 4, image);  // a pixel a unit, from (-2, 2) to (2, -2)
    const Vec3 right(2.5, 1.5, 0), below(-1.5, -7.5, 0);
    EXPECT_EQ(valueAt(light, right), Rgb(0));
    EXPECT_EQ(valueAt(light, {1.999, 1.5, 0}), Rgb(4, 1, 1));  // sharp: not faded towards the border
    light.slide->outside = SlideOutside::clamp;
    EXPECT_EQ(valueAt(light, right), Rgb(4, 1, 1));
    EXPECT_EQ(valueAt(light, below), Rgb(1, 4, 1));
    light.slide->outside = SlideOutside::repeat;
    EXPECT_EQ(valueAt(light, right), Rgb(1, 1, 1));
    EXPECT_EQ(valueAt(light, below), Rgb(1, 2, 1));           // y = 9.5: pixel 1 of the third copy
    EXPECT_EQ(valueAt(light, {-2.5, 1.5, 0}), Rgb(4, 1, 1));  // to the left
}

TEST(Slide, IsBilinearBetweenItsPixels) {
    const auto image = makeTexture(2, 1, [](int x, int) { return Rgb(x, 0, 1); });
    const Light light = distantSlide({0, 0, -1}, 2, image);
    EXPECT_EQ(valueAt(light, {-0.9, 0, 0}), Rgb(0, 0, 1));
    EXPECT_NEAR(valueAt(light, {-0.25, 0, 0}).x, 0.25, 1e-12);
    EXPECT_NEAR(valueAt(light, {0.5, 0, 0}).x, 1, 1e-12);
}

TEST(SlideSheetMap, IsTheMapAtTheSheetsTexels) {
    Sheets sheets;
    sheets.wsAnchor = {1e6, -2e6, 3e6};
    sheets.ssFromWs = sweepRotation(glm::normalize(Vec3(1, -2, -3)), {0, 1, 0});
    sheets.texel = 0.3;
    sheets.thickness = 0.7;
    sheets.ssOrigin = {-5, -6, -7};
    Light light = projector({1, 2, 10}, 50, quarters());
    light.wsPosition += sheets.wsAnchor;
    const SlideMap map = slideMap(light);
    const SlideMap::OnSheet sheet = sheetMap(map, sheets, 4.5);
    for (const Vec3& ts : {Vec3(0, 0, 4.5), Vec3(20, 3, 5), Vec3(7, 31, 4)}) {
        const Vec3 expected = map.homogeneous(sheets.wsPoint(ts));
        const Vec3 found = sheet.atOrigin + ts.x * sheet.perU + ts.y * sheet.perV + (ts.z - 4.5) * sheet.perN;
        EXPECT_NEAR(glm::distance(found, expected), 0, 1e-6);  // doubles at 3e6 end at 5e-10, times 64 pixels
    }
}

TEST(SlideCorners, AreTheEdgesOfTheBeam) {
    Light light = projector({3, 2, 10}, 50, quarters());
    light.slide->roll = 33;
    const SlideMap map = slideMap(light);
    ASSERT_EQ(slideCorners(light).size(), 4u);
    for (const Vec3& direction : slideCorners(light)) {
        const Vec3 h = map.homogeneous(light.wsPosition + 7.0 * direction);
        EXPECT_NEAR(std::abs(h.x / h.z - 32), 32, 1e-9);
        EXPECT_NEAR(std::abs(h.y / h.z - 32), 32, 1e-9);
        EXPECT_NEAR(std::acos(glm::dot(direction, light.wsDirection)), slideHalfAngle(light), 1e-9);
    }
    const Light distant = distantSlide({1, -1, 0.5}, 6, quarters());
    for (const Vec3& corner : distantSlideCorners(distant)) {
        const Vec3 h = slideMap(distant).homogeneous(corner);
        EXPECT_NEAR(std::abs(h.x - 32), 32, 1e-9);
        EXPECT_NEAR(std::abs(h.y - 32), 32, 1e-9);
    }
}

}  // namespace
}  // namespace scrim::test
