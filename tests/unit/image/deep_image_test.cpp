// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/deep_image.h>

#include <scrim/image/exr_deep.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace scrim {
namespace {

// Fog of constant extinction from `begin` on, cut into pieces: alpha 1 - e^-tau, colour half of that.
DeepCurve fog(double begin, double length, double extinction, int pieces) {
    DeepCurve curve;
    for (int i = 0; i < pieces; ++i) {
        const double a = begin + length * i / pieces, b = begin + length * (i + 1) / pieces;
        const auto alpha = static_cast<float>(-std::expm1(-extinction * (b - begin)));
        curve.push_back({static_cast<float>(a), static_cast<float>(b), {alpha / 2, alpha / 4, alpha / 8, alpha}});
    }
    return curve;
}

// Pieces of random lengths, gaps, opacities and colours.
DeepCurve someCurve(unsigned seed, int pieces) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    DeepCurve curve;
    double depth = 1, left = 1;
    std::array<double, 3> colour{};
    for (int i = 0; i < pieces; ++i) {
        if (unit(random) < 0.2) depth += unit(random);
        const double begin = depth, a = 0.15 * unit(random);
        depth += 0.1 + unit(random);
        for (double& c : colour) c += left * a * unit(random);
        left *= 1 - a;
        curve.push_back({static_cast<float>(begin),
                         static_cast<float>(depth),
                         {static_cast<float>(colour[0]), static_cast<float>(colour[1]), static_cast<float>(colour[2]),
                          static_cast<float>(1 - left)}});
    }
    return curve;
}

std::array<double, 4> overed(const std::vector<DeepSample>& samples) {
    std::array<double, 4> sum{};
    for (const DeepSample& sample : samples)
        for (const double left = 1 - sum[3]; const std::size_t c : {0u, 1u, 2u, 3u}) sum[c] += left * sample.rgba[c];
    return sum;
}

TEST(DeepCurve, OfConstantFogIsBeersLawAtAnyDepth) {
    const DeepCurve curve = fog(2, 3, 0.7, 1);
    for (const double depth : {0.0, 2.0, 2.1, 3.3, 4.9, 5.0, 9.0}) {
        const double alpha = -std::expm1(-0.7 * std::clamp(depth - 2, 0.0, 3.0));
        EXPECT_NEAR(shownBefore(curve, depth)[3], alpha, 1e-6) << depth;
        EXPECT_NEAR(shownBefore(curve, depth)[0], alpha / 2, 1e-6) << depth;
    }
}

TEST(DeepCurve, OfLightWithoutOpacityGrowsEvenly) {
    const DeepCurve glow{{1, 3, {4, 2, 1, 0}}};
    EXPECT_EQ(shownBefore(glow, 1.5), (std::array<double, 4>{1, 0.5, 0.25, 0}));
}

TEST(DeepCurve, OfConstantFogMergesIntoOnePiece) {
    const DeepCurve merging = merged(fog(2, 3, 0.7, 40), 1e-5);
    ASSERT_EQ(merging.size(), 1u);
    EXPECT_EQ(merging[0].begin, 2);
    EXPECT_EQ(merging[0].end, 5);
}

TEST(DeepCurve, MergesWithinItsToleranceAndKeepsItsEnd) {
    for (unsigned seed = 0; seed < 50; ++seed) {
        const DeepCurve curve = someCurve(seed, 60);
        for (const double tolerance : {0.002, 0.01, 0.1}) {
            const DeepCurve merging = merged(curve, tolerance);
            EXPECT_LT(merging.size(), curve.size());
            EXPECT_EQ(merging.back().shown, curve.back().shown);
            const double peak =
                std::max({curve.back().shown[0], curve.back().shown[1], curve.back().shown[2]}) * tolerance;
            for (const DeepPiece& piece : curve)
                for (const float depth : {piece.begin, piece.end}) {
                    const auto a = shownBefore(curve, depth), b = shownBefore(merging, depth);
                    for (std::size_t c = 0; c < 3; ++c) EXPECT_LE(std::abs(a[c] - b[c]), peak + 1e-7);
                    EXPECT_LE(std::abs(a[3] - b[3]), tolerance + 1e-7);
                }
        }
        EXPECT_EQ(merged(curve, 0).size(), curve.size());
    }
}

TEST(DeepCurve, SumsAreExactWhereAnyOfThemEnds) {
    const DeepCurve a = someCurve(1, 20), b = someCurve(2, 30);
    const DeepCurve sum = sumOf({{a, 0.5, 1}, {b, 2, 0}});
    for (const DeepCurve& curve : {a, b})
        for (const DeepPiece& piece : curve) {
            const auto ofA = shownBefore(a, piece.end), ofB = shownBefore(b, piece.end),
                       found = shownBefore(sum, piece.end);
            EXPECT_NEAR(found[0], 0.5 * ofA[0] + 2 * ofB[0], 1e-6);
            EXPECT_NEAR(found[3], ofA[3], 1e-6);
        }
    for (std::size_t i = 1; i < sum.size(); ++i) EXPECT_GE(sum[i].begin, sum[i - 1].end);
}

TEST(DeepCurve, TidiedLosesNothing) {
    // The second piece has collapsed, and the last lies behind what is opaque.
    const DeepCurve curve{{1, 2, {0.1f, 0, 0, 0.2f}},
                          {2, 2, {0.2f, 0, 0, 0.3f}},
                          {2, 3, {0.5f, 0, 0, 0.99999f}},
                          {3, 4, {0.6f, 0, 0, 1}}};
    const DeepCurve tidy = tidied(curve);
    ASSERT_EQ(tidy.size(), 2u);
    EXPECT_EQ(tidy[0].shown, curve[1].shown);
    EXPECT_EQ(tidy[1].shown, curve[3].shown);
    EXPECT_EQ(tidy[1].end, 3);
    const DeepCurve alone = tidied({{5, 5, {0.1f, 0, 0, 0.2f}}});
    ASSERT_EQ(alone.size(), 1u);
    EXPECT_GT(alone[0].end, alone[0].begin);
}

// A half float's last bit is 2^-11 of it; the last sample makes up for what rounding did before it, and its own is at
// most 2^-12 of what it adds. Colours a thousandth, alphas half a step of halves below 1.
TEST(DeepSamples, CompositeToTheEndOfTheCurveHoweverTheyAreRounded) {
    std::size_t clamped = 0;
    for (unsigned seed = 0; seed < 100; ++seed)
        for (const int pieces : {1, 7, 60, 300}) {
            const DeepCurve curve = someCurve(seed, pieces);
            const auto& end = curve.back().shown;
            const auto single = overed(deepSamples(curve, false, clamped)),
                       half = overed(deepSamples(curve, true, clamped));
            for (std::size_t c = 0; c < 4; ++c) {
                EXPECT_NEAR(single[c], end[c], 1e-6);
                EXPECT_NEAR(half[c], end[c], 5e-4 * std::max(end[c], 0.01f));
            }
        }
    EXPECT_EQ(clamped, 0u);
}

TEST(DeepSamples, AreFiniteBehindOpaqueThingsAndSayWhatIsClamped) {
    std::size_t clamped = 0;
    const DeepCurve curve{{1, 2, {0.5f, 0.5f, 0.5f, 1}}, {3, 4, {0.75f, 0.5f, 0.5f, 1}}};
    for (const bool half : {true, false}) {
        const auto samples = deepSamples(curve, half, clamped);
        ASSERT_EQ(samples.size(), 1u);
        EXPECT_EQ(samples[0].rgba, (std::array<float, 4>{0.75f, 0.5f, 0.5f, 1}));
    }
    EXPECT_EQ(clamped, 0u);
    EXPECT_EQ(deepSamples(DeepCurve{{1, 2, {1e6f, 0, 0, 0.5f}}}, true, clamped)[0].rgba[0], 65504.0f);
    EXPECT_EQ(clamped, 1u);
}

}  // namespace
}  // namespace scrim
