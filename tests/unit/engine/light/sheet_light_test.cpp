// SPDX-License-Identifier: Apache-2.0
// The filtered slide of a tile against averages taken by brute force.
#include "support/slides.h"

#include <scrim/engine/light/sheet_light.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

namespace scrim::test {
namespace {

// A tile of texels, its eye's slopes, and what the slide makes of it.
struct TintedTile {
    SampleTile samples;
    alignas(64) float tint[3 * kTileSize] = {};
    bool lit = false;

    TintedTile(const SheetSlide& slide, int u0, int v0, float slopeA, float slopeB, const SampleSpacing& spacing = {}) {
        for (int k = 0; k < kTileSize; ++k) {
            samples.u[k] = static_cast<float>(u0 + k % kTileEdge);
            samples.v[k] = static_cast<float>(v0 + k / kTileEdge);
            samples.eyeA[k] = slopeA;
            samples.eyeB[k] = slopeB;
        }
        samples.spacing = spacing;
        lit = tintTile(slide, samples, 1, tint);
    }
};

constexpr float kNoSpacing = 1e-6f;
SampleSpacing points() {
    SampleSpacing spacing;
    spacing.x[0] = kNoSpacing;
    spacing.y[1] = kNoSpacing;
    return spacing;
}

// Sheets of unit texels and thickness, across a light along their axis; `turn` tilts the light.
struct Setting {
    Sheets sheets;
    Light light;
    SheetSlide slide;

    explicit Setting(Light l) : light(std::move(l)) {
        sheets.ssFromWs = sweepRotation({0, 0, -1}, {0, 1, 0});
        sheets.ssOrigin = {-40, -40, -10};
        const SlideMap map = slideMap(light);
        slide = {light.slide->image.get(), light.slide->outside, sheetMap(map, sheets, 9.5)};
    }
    Rgb exact(double u, double v, double n) const {
        return slideValue(light, slideMap(light), sheets.wsPoint({u, v, n}));
    }
    // The mean along the eye's ray through the sheet.
    Rgb along(double u, double v, double slopeA, double slopeB) const {
        constexpr int kSteps = 400;
        Rgb sum(0);
        for (int i = 0; i < kSteps; ++i) {
            const double n = (i + 0.5) / kSteps - 0.5;
            sum += exact(u + n * slopeA, v + n * slopeB, 9.5 + n) / double(kSteps);
        }
        return sum;
    }
};

std::shared_ptr<const Texture> waves(int edge, double pixels) {
    return makeTexture(edge, edge, [pixels](int x, int y) {
        return Rgb(0.5 + 0.5 * std::sin(x * 6.283185 / pixels), 0.5 + 0.5 * std::cos(y * 6.283185 / pixels), 0.25);
    });
}

// Float positions relative to the tile's corner: a hundredth of a thousandth of a pixel.
TEST(SlideTile, OfPointsIsTheExactValue) {
    for (const bool perspective : {false, true})
        for (const SlideOutside outside : {SlideOutside::clamp, SlideOutside::repeat}) {
            Light light =
                perspective ? projector({3, -2, 50}, 70, waves(512, 40)) : distantSlide({0, 0, -1}, 70, waves(512, 40));
            light.slide->outside = outside;
            light.slide->roll = 20;
            const Setting s(light);
            const TintedTile tile(s.slide, 16, 48, 0, 0, points());
            ASSERT_TRUE(tile.lit);
            for (int k = 0; k < kTileSize; k += 7) {
                // Along a ray that follows the light nothing changes; this one does not, under perspective.
                const Rgb expected = s.along(tile.samples.u[k], tile.samples.v[k], 0, 0);
                for (int c = 0; c < 3; ++c)
                    EXPECT_NEAR(tile.tint[c * kTileSize + k], expected[c], perspective ? 2e-3 : 1e-5) << k;
            }
        }
}

// A slide four times as fine as the texels, swept along a ray at 45 degrees: the taps' average is the ray's.
TEST(SlideTile, AveragesAlongTheEyesRayThroughTheSheet) {
    const auto image = waves(512, 9);
    const Setting s(distantSlide({0, 0, -1}, 128, image));  // 4 pixels a texel
    for (const auto& [a, b] : {std::pair{1.0, 0.0}, {0.0, -1.0}, {0.7, 0.7}, {1.7, -0.4}}) {
        const TintedTile tile(s.slide, 16, 48, static_cast<float>(a), static_cast<float>(b), points());
        double worst = 0, range = 0;
        for (int k = 0; k < kTileSize; ++k) {
            const Rgb expected = s.along(tile.samples.u[k], tile.samples.v[k], a, b);
            for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(tile.tint[c * kTileSize + k] - expected[c]));
            range = std::max(range, std::abs(expected.x - 0.5));
        }
        // Taps half a pixel apart: the midpoint rule on a wave of 9 pixels is good to (pi / 18)^2 / 6.
        EXPECT_LT(worst, 6e-3) << a << " " << b;
        EXPECT_GT(range, 0.1);
    }
}

TEST(SlideTile, MinifiedIsTheMeanOfWhatATexelCovers) {
    // One pixel wide checks, 7.3 pixels a texel.
    const auto checks = makeTexture(1000, 1000, [](int x, int y) { return Rgb((x + y) % 2, 0, 1); });
    const Setting s(distantSlide({0, 0, -1}, 1000 / 7.3, checks));
    const TintedTile tile(s.slide, 32, 32, 0, 0);
    for (int k = 0; k < kTileSize; ++k) EXPECT_NEAR(tile.tint[k], 0.5, 1e-5);
    for (int k = 0; k < kTileSize; ++k) EXPECT_NEAR(tile.tint[2 * kTileSize + k], 1, 1e-5);
}

// 11 pixels a texel: half a box is 5.5 of them, and pixels of 4 and 8 reach one and a half of their edges.
TEST(SlideTile, MinifiedEdgeIsHardlyWiderThanATexel) {
    const auto image = makeTexture(1024, 1024, [](int x, int) { return Rgb(x < 517 ? 0 : 1); });
    const Setting s(distantSlide({0, 0, -1}, 1024 / 11.0, image));
    const double step = s.exact(40, 40, 9.5).x == s.exact(30, 40, 9.5).x ? 40 + 5 / 11.0 : 40 - 5 / 11.0;
    const TintedTile tile(s.slide, 32, 32, 0, 0);
    for (int k = 0; k < kTileSize; ++k) {
        const double u = tile.samples.u[k] - step;
        const double exact = s.exact(tile.samples.u[k], tile.samples.v[k], 9.5).x;
        const bool beyond = std::abs(u) > 1.5 * 8 / 11;
        EXPECT_NEAR(tile.tint[k], exact, beyond ? 1e-5 : 0.6) << u;
    }
}

TEST(SlideTile, MinifiedBeyondItsSmallestLevelIsItsMean) {
    const auto image = makeTexture(37, 5, [](int x, int) { return Rgb(x, 1, 0); });
    Light light = distantSlide({0, 0, -1}, 0.01, image);
    light.slide->outside = SlideOutside::repeat;
    const Setting s(light);
    const TintedTile tile(s.slide, 32, 32, 0.3f, 0);
    for (int k = 0; k < kTileSize; ++k) EXPECT_NEAR(tile.tint[k], 18, 1e-3);
}

// A step between two wide pixels rises over one pixel of the slide, not more.
TEST(SlideTile, MagnifiedIsAsSharpAsTheSlide) {
    const auto image = makeTexture(8, 8, [](int x, int) { return Rgb(x < 4 ? 0 : 1); });
    const Setting s(distantSlide({0, 0, -1}, 80, image));  // a pixel is 10 texels; the step is at u = 40
    const TintedTile tile(s.slide, 32, 32, 0, 0);
    for (int k = 0; k < kTileSize; ++k)
        EXPECT_NEAR(tile.tint[k], s.exact(tile.samples.u[k], tile.samples.v[k], 9.5).x, 1e-5) << k;
}

// The picture's border is as sharp as the samples, even where its pixels are large.
TEST(SlideTile, BorderIsSharpAndCountsByCoverage) {
    const auto white = makeTexture(2, 2, [](int, int) { return Rgb(1); });
    const Setting s(distantSlide({0, 0, -1}, 20.5, white));  // from u = 29.75 to 50.25
    const TintedTile tile(s.slide, 16, 32, 0, 0);
    for (int i = 0; i < kTileEdge; ++i) {
        const double u = tile.samples.u[i];
        EXPECT_NEAR(tile.tint[8 * kTileEdge + i], std::clamp(u + 0.5 - 29.75, 0.0, 1.0), 1e-4) << u;
    }
    // Behind the border nothing is written.
    EXPECT_FALSE(TintedTile(s.slide, 0, 0, 0, 0).lit);
    // A picture smaller than a texel still gives all its light.
    const Setting small(distantSlide({0, 0, -1}, 0.25, white));
    const TintedTile speck(small.slide, 32, 32, 0, 0);
    double sum = 0;
    for (int k = 0; k < kTileSize; ++k) sum += speck.tint[k];
    EXPECT_NEAR(sum, 0.25 * 0.25, 1e-4);
}

TEST(SlideTile, BehindTheLightIsDark) {
    Light light = projector({0, 0, 5}, 60, waves(64, 8));  // the sheet lies at z = 0.5
    light.wsDirection = {0, 0, 1};
    for (const SlideOutside outside : {SlideOutside::black, SlideOutside::clamp, SlideOutside::repeat}) {
        light.slide->outside = outside;
        const Setting s(light);
        EXPECT_FALSE(TintedTile(s.slide, 32, 32, 0.5f, 0.5f).lit);
    }
}

// In the plane of a wide light, partly behind it: finite numbers everywhere.
TEST(SlideTile, StaysFiniteWhereTheLightSkimsTheSheet) {
    for (const SlideOutside outside : {SlideOutside::black, SlideOutside::clamp, SlideOutside::repeat})
        for (const double z : {0.5, 0.5 + 1e-9, 3.0}) {
            Light light = projector({0, 0, z}, 120, waves(64, 8));
            light.wsDirection = {1, 0, 0};
            light.slide->outside = outside;
            const Setting s(light);
            for (const float slope : {0.0f, 1e3f, -1e6f}) {
                const TintedTile tile(s.slide, 32, 32, slope, 0.5f);
                for (const float value : tile.tint) {
                    ASSERT_TRUE(std::isfinite(value));
                    ASSERT_GE(value, 0);
                    ASSERT_LE(value, 1.0001f);
                }
            }
        }
}

// 1e6 world units away, with voxels of a thousandth: only doubles can tell where the slide is.
TEST(SlideTile, KeepsItsPlaceFarFromTheOrigin) {
    Light light = distantSlide({0, 0, -1}, 0.07, waves(512, 40));
    light.wsPosition = {1e6, -1e6, 1e6};
    Setting s(light);
    s.sheets.wsAnchor = light.wsPosition;
    s.sheets.texel = s.sheets.thickness = 1e-3;
    s.sheets.ssOrigin *= 1e-3;
    s.slide.map = sheetMap(slideMap(light), s.sheets, 9.5);
    const TintedTile tile(s.slide, 32, 48, 0, 0, points());
    for (int k = 0; k < kTileSize; k += 5) {
        const Vec3 h = s.slide.map.atOrigin + double(tile.samples.u[k]) * s.slide.map.perU +
                       double(tile.samples.v[k]) * s.slide.map.perV;
        EXPECT_NEAR(tile.tint[k], 0.5 + 0.5 * std::sin((h.x - 0.5) * 6.283185 / 40), 4e-3);
    }
}

}  // namespace
}  // namespace scrim::test
