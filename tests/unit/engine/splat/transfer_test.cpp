// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/surface.h>

#include <scrim/geometry/sheets.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace scrim::test {
namespace {

Classified bandAndSlope() {
    Classified c;
    c.transfer = {{10, Rgb(1, 0, 0), 0}, {20, Rgb(1, 0.5, 0), 3}, {20, Rgb(0, 0, 1), 0},
                  {60, Rgb(0, 0, 1), 0}, {60, Rgb(0, 1, 1), 8},   {100, Rgb(1, 1, 1), 2}};
    c.densityScale = 0.5;
    return c;
}

// Means over the runs a-b and b-c by plain summation; `part` picks extinction (-1) or a channel of its product.
double meanOverRuns(const Classified& look, double a, double b, double c, int part) {
    constexpr int kSteps = 4000;
    double sum = 0;
    for (int k = 0; k < kSteps; ++k) {
        const double t = (k + 0.5) / kSteps;
        for (const double value : {a + t * (b - a), b + t * (c - b)}) {
            const ClassifiedValue v = classify(look, value);
            sum += v.extinction * (part < 0 ? 1.0 : v.color[part]) / (2 * kSteps);
        }
    }
    return sum;
}

TEST(TransferTable, MeansAreThoseOfLinearRuns) {
    const Classified look = bandAndSlope();
    const TransferTable table(look);
    std::mt19937 random(3);
    std::uniform_real_distribution<float> any(0, 130);
    alignas(64) float a[kTileSize], b[kTileSize], c[kTileSize], sigma[kTileSize], green[kTileSize];
    for (int k = 0; k < kTileSize; ++k) {
        a[k] = any(random);
        // Short runs, too: down to much less than a cell of the table.
        const float reach = std::pow(10.0f, -static_cast<float>(k % 6));
        b[k] = std::max(0.0f, a[k] + reach * (any(random) - 65));
        c[k] = std::max(0.0f, b[k] + reach * (any(random) - 65));
    }
    table.meanExtinction(a, b, c, kTileSize, sigma);
    table.meanEmission(1, a, b, c, kTileSize, green);
    // A cell of the table is a 2048th of 100, so a run of l values near a jump of 4 is off by 4 (100 / 2048) / l at
    // most: where it is shorter than that, steps are a cell wide.
    for (int k = 0; k < kTileSize; ++k) {
        const double shortest = std::max(0.05, double(std::min(std::abs(b[k] - a[k]), std::abs(c[k] - b[k]))));
        const double tolerance = std::min(4.1, 4 * 0.05 / shortest) + 0.01;
        EXPECT_NEAR(sigma[k], meanOverRuns(look, a[k], b[k], c[k], -1), tolerance)
            << a[k] << " " << b[k] << " " << c[k];
        EXPECT_NEAR(green[k], meanOverRuns(look, a[k], b[k], c[k], 1), tolerance) << a[k] << " " << b[k] << " " << c[k];
    }
}

TEST(TransferTable, LongRunsAreExactAcrossSteps) {
    const Classified look = bandAndSlope();
    const TransferTable table(look);
    alignas(64) float a[kTileSize], b[kTileSize], c[kTileSize], sigma[kTileSize];
    for (int k = 0; k < kTileSize; ++k) {
        a[k] = 0.01f * static_cast<float>(k);
        b[k] = 40 + 0.013f * static_cast<float>(k);
        c[k] = 120 - 0.01f * static_cast<float>(k);
    }
    table.meanExtinction(a, b, c, kTileSize, sigma);
    for (int k = 0; k < kTileSize; k += 15)
        EXPECT_NEAR(sigma[k], meanOverRuns(look, a[k], b[k], c[k], -1), 2e-3 * sigma[k]) << k;
}

TEST(TransferTable, KnowsWhereNothingIsExtinct) {
    const TransferTable table(bandAndSlope());
    EXPECT_FALSE(table.anyBetween(0, 9.9f));
    EXPECT_TRUE(table.anyBetween(0, 10.1f));
    EXPECT_FALSE(table.anyBetween(21, 59));
    EXPECT_TRUE(table.anyBetween(21, 61));
    EXPECT_TRUE(table.anyBetween(500, 600)) << "constant beyond the last point";
}

TEST(Classify, IsLinearBetweenPointsAndConstantBeyond) {
    const Classified look = bandAndSlope();
    EXPECT_EQ(classify(look, 5).extinction, 0);
    EXPECT_DOUBLE_EQ(classify(look, 15).extinction, 0.75);
    EXPECT_DOUBLE_EQ(classify(look, 15).color.y, 0.25);
    EXPECT_DOUBLE_EQ(classify(look, 80).extinction, 2.5);
    EXPECT_DOUBLE_EQ(classify(look, 1000).extinction, 1);
}

TEST(NormalWeight, FallsWhereTheGradientVanishes) {
    const Classified look = bandAndSlope();
    EXPECT_EQ(normalWeight(look, 0, 2), 0);
    EXPECT_DOUBLE_EQ(normalWeight(look, vagueGradient(look, 2), 2), 0.5);
    EXPECT_GT(normalWeight(look, 5, 2), 0.99);
}

}  // namespace
}  // namespace scrim::test
