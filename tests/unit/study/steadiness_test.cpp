// SPDX-License-Identifier: Apache-2.0
// Second differences of frames that were made by a formula, so that the true values are known.
#include "support/expect_error.h"

#include <scrim/scene/quality.h>
#include <scrim/study/shot_steadiness.h>
#include <scrim/study/steadiness_data.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <functional>

namespace scrim::test {
namespace {

constexpr int kWidth = 4, kHeight = 3, kPixels = kWidth * kHeight;

/// A grey value for pixel (x, y) of frame t.
using Value = std::function<double(int x, int y, int t)>;

SteadyLayer layerOf(const std::string& name, int t, const Value& value) {
    SteadyLayer layer{name, {}};
    for (int p = 0; p < kPixels; ++p) layer.rgb.insert(layer.rgb.end(), 3, float(value(p % kWidth, p / kWidth, t)));
    return layer;
}

LayerSteadiness measured(int frames, const Value& shown, const Value& converged) {
    SteadinessMeter meter(kWidth);
    for (int t = 1; t <= frames; ++t) meter.add(t, {layerOf("beauty", t, shown)}, {layerOf("beauty", t, converged)});
    return meter.layers().front();
}

double one(int, int, int) {
    return 1;
}

double black(int, int, int) {
    return 0;
}

TEST(Steadiness, OfLightThatChangesEvenlyIsPerfect) {
    const auto even = [](int x, int y, int t) { return 1 + 0.25 * x + 0.5 * y + 0.125 * t * (x - y); };
    const LayerSteadiness layer = measured(6, even, even);
    EXPECT_EQ(layer.all.shown, 0);
    EXPECT_EQ(layer.all.excess, 0);
    EXPECT_EQ(layer.worst, 0);
    EXPECT_EQ(layer.pixels, 4u * kPixels);
    EXPECT_EQ(layer.frames.size(), 4u);
}

// An error that stays where it is, or that grows evenly, is no flicker.
TEST(Steadiness, DoesNotSeeAnErrorThatStands) {
    const auto wrong = [](int x, int, int t) { return 1 + 0.5 * x + 0.25 * t; };
    const LayerSteadiness layer = measured(5, wrong, one);
    EXPECT_EQ(layer.all.excess, 0);
    // Frame 2, 3 and 4; columns 0 to 3.
    double squares = 0;
    for (int t = 2; t <= 4; ++t)
        for (int x = 0; x < kWidth; ++x) squares += std::pow(0.5 * x + 0.25 * t, 2) / (3 * kWidth);
    EXPECT_NEAR(layer.all.error, std::sqrt(squares), 1e-6);
}

// What is true may accelerate: with t^2 second differences are 2, in both, and nothing exceeds them.
TEST(Steadiness, DoesNotBlameTheTruth) {
    const auto faster = [](int, int, int t) { return double(t * t); };
    const LayerSteadiness layer = measured(3, faster, faster);
    const double mean = (1 + 4 + 9) / 3.0;
    EXPECT_NEAR(layer.mean, mean, 1e-6);
    EXPECT_NEAR(layer.all.shown, 2 / mean, 1e-6);
    EXPECT_NEAR(layer.all.converged, 2 / mean, 1e-6);
    EXPECT_EQ(layer.all.excess, 0);
}

// An error of +e, -e, +e, ... has second differences of 4 e; one that hides true acceleration exceeds it, too.
TEST(Steadiness, IsTheSecondDifferenceOfTheError) {
    const auto flickers = [](int, int, int t) { return 1 + (t % 2 ? 0.0625 : -0.0625); };
    LayerSteadiness layer = measured(6, flickers, one);
    EXPECT_NEAR(layer.all.shown, 0.25, 1e-6);
    EXPECT_EQ(layer.all.converged, 0);
    EXPECT_NEAR(layer.all.excess, 0.25, 1e-6);
    layer = measured(6, one, flickers);
    EXPECT_EQ(layer.all.shown, 0);
    EXPECT_NEAR(layer.all.converged, 0.25, 1e-6);
    EXPECT_NEAR(layer.all.excess, 0.25, 1e-6);
}

// One pixel of twelve pops by 1/2 in frame 4 of 6: second differences of 1/2, 1 and 1/2 around it. None are in frame 2.
TEST(Steadiness, FindsTheFrameAndThePixel) {
    const auto pops = [](int x, int y, int t) { return 1 + (x == 3 && y == 1 && t == 4 ? 0.5 : 0.0); };
    const LayerSteadiness layer = measured(6, pops, one);
    EXPECT_EQ(layer.worstFrame, 4);
    EXPECT_EQ(layer.worstX, 3);
    EXPECT_EQ(layer.worstY, 1);
    EXPECT_NEAR(layer.worst, 1, 1e-6);
    ASSERT_EQ(layer.frames.size(), 4u);
    const double expected[] = {0, 0.5, 1, 0.5};
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_EQ(layer.frames[i].first, int(i) + 2);
        EXPECT_NEAR(layer.frames[i].second.excess, expected[i] / std::sqrt(kPixels), 1e-6);
    }
    EXPECT_NEAR(layer.all.excess, std::sqrt(1.5 / (4 * kPixels)), 1e-6);
}

// Flicker of a fiftieth of the largest value counts, and of less does not, unless it pops above that in one frame.
TEST(Steadiness, LeavesOutWhatIsDark) {
    const auto flickers = [](double dark) {
        return [dark](int x, int y, int t) { return x + y == 0 ? 1.0 : dark * (t % 2); };
    };
    const auto dark = [](int x, int y, int) { return x + y == 0 ? 1.0 : 0.0; };
    EXPECT_EQ(measured(5, flickers(0.019), dark).pixels, 3u);
    EXPECT_EQ(measured(5, flickers(0.019), dark).all.excess, 0);
    EXPECT_EQ(measured(5, flickers(0.021), dark).pixels, 3u * kPixels);
    EXPECT_GT(measured(5, flickers(0.021), dark).all.excess, 0.1);
    EXPECT_EQ(measured(5, dark, flickers(0.021)).pixels, 3u * kPixels);
}

TEST(Steadiness, KeepsLayersApart) {
    const auto flickers = [](int, int, int t) { return 2 + (t % 2); };
    SteadinessMeter meter(kWidth);
    for (int t = 1; t <= 4; ++t)
        meter.add(t, {layerOf("beauty", t, one), layerOf("indirect", t, flickers), layerOf("emission", t, black)},
                  {layerOf("beauty", t, one), layerOf("indirect", t, one), layerOf("emission", t, black)});
    const std::vector<LayerSteadiness> layers = meter.layers();
    ASSERT_EQ(layers.size(), 3u);
    EXPECT_EQ(layers[0].all.excess, 0);
    EXPECT_EQ(layers[1].name, "indirect");
    EXPECT_NEAR(layers[1].all.excess, 2, 1e-6);
    EXPECT_EQ(layers[2].pixels, 0u);  // it is black
    EXPECT_EQ(layers[2].mean, 0);

    ShotSteadinessResult result;
    result.promised = 0.02;
    result.layers = layers;
    EXPECT_EQ(result.restless(), std::vector<std::string>{"indirect"});
    const auto json = nlohmann::json::parse(steadinessAsJson(result, "a.toml"));
    EXPECT_FALSE(json.at("kept"));
    EXPECT_TRUE(json.at("layers").at(0).at("kept"));
    EXPECT_NEAR(json.at("layers").at(1).at("excess").get<double>(), 2, 1e-6);
    EXPECT_EQ(json.at("layers").at(1).at("frames").at(1).at("frame"), 3);
    EXPECT_NE(steadinessAsCsv(result).find("\n\"indirect\",3,"), std::string::npos) << steadinessAsCsv(result);
}

TEST(Steadiness, NeedsThreeFramesOfOneKind) {
    EXPECT_EQ(measured(2, one, one).pixels, 0u);
    SteadinessMeter meter(kWidth);
    meter.add(1, {layerOf("beauty", 1, one)}, {layerOf("beauty", 1, one)});
    const std::string reason = "frame 2 has other layers or another size than the frames before it";
    EXPECT_EQ(errorOf(ErrorKind::input,
                      [&] {
                          meter.add(2, {{"beauty", std::vector<float>(3)}}, {layerOf("beauty", 2, one)});
                      }),
              reason);
    EXPECT_EQ(
        errorOf(ErrorKind::input, [&] { meter.add(2, {layerOf("beauty", 2, one)}, {layerOf("direct", 2, one)}); }),
        reason);
}

TEST(ConvergedDials, AreHalfAsLarge) {
    Dials dials;
    dials.scatterCell = 2.37;
    dials.scatterDirections = 64;
    dials.lod = 1.4;
    const Dials finer = convergedDials(dials, 3);
    EXPECT_EQ(finer.texel, dials.texel / 2);
    EXPECT_EQ(finer.sheetThickness, dials.sheetThickness / 2);
    EXPECT_EQ(finer.scatterCell, 2.37 / 2);
    EXPECT_EQ(finer.scatterDirections, 128);
    EXPECT_EQ(finer.lightCell, 1.5);
    EXPECT_EQ(finer.lod, 0);
    EXPECT_FALSE(convergedDials(dials, 0).lightCell);
}

TEST(ConvergedDials, StayWithinTheirLimits) {
    Dials dials;
    for (const DialInfo& dial : dialTable()) {
        if (dial.allowed.find("a number from ") == std::string::npos) continue;
        const std::string least = dial.allowed.substr(dial.allowed.find("a number from ") + 14);
        setDialFromText(dials, dial.name, least.substr(0, least.find(' ')), "");
    }
    dials.scatterDirections = 256;
    dials.footprintSteps = 128;
    EXPECT_NO_THROW(checkDials(convergedDials(dials, 0.25), "converged"));
}

}  // namespace
}  // namespace scrim::test
