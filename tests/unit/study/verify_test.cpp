// SPDX-License-Identifier: Apache-2.0
#include "support/expect_error.h"
#include "support/fields.h"

#include <scrim/study/reference.h>
#include <scrim/study/verify.h>

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>
#include <utility>
#include <vector>

namespace scrim::test {
namespace {

VerifiedPixel pixelWith(double reference, double error, int x = 0, int y = 0) {
    return {x, y, {reference + error, reference + error, reference + error, 1}, {reference, reference, reference, 1}};
}

TEST(Summary, OfKnownErrorsIsKnown) {
    // Means of 1 and 3, errors of 0.1 and -0.3: RMS sqrt((0.01 + 0.09) / 2) over a mean of 2.
    const Verification v = summarise({pixelWith(1, 0.1, 4, 5), pixelWith(3, -0.3, 6, 7)});
    EXPECT_EQ(v.pixels, 2);
    EXPECT_NEAR(v.error, std::sqrt(0.05) / 2, 1e-12);
    EXPECT_NEAR(v.bias, -0.2 / 4, 1e-12);
    EXPECT_NEAR(v.worst, 0.3 / 2, 1e-12);
    EXPECT_EQ(v.worstX, 6);
    EXPECT_EQ(v.worstY, 7);
}

// One channel off by 0.3 is a third of all three being so, in the square.
TEST(Summary, TakesTheMeanOverTheChannels) {
    VerifiedPixel p = pixelWith(1, 0);
    p.rendered[1] += 0.3;
    const Verification v = summarise({p});
    EXPECT_NEAR(v.error, 0.3 / std::sqrt(3.0), 1e-12);
    EXPECT_NEAR(v.bias, 0.1, 1e-12);
}

TEST(Summary, CountsNoPixelWhoseReferenceIsAllButEmpty) {
    VerifiedPixel thin = pixelWith(1, 5);
    thin.reference[3] = 1e-3;
    VerifiedPixel lost = pixelWith(1, -1);  // rendered as nothing, although there is something: that counts
    lost.rendered[3] = 0;
    const Verification v = summarise({thin, lost});
    EXPECT_EQ(v.pixels, 1);
    EXPECT_NEAR(v.error, 1, 1e-12);
}

TEST(Summary, OfNothingIsZero) {
    for (const std::vector<VerifiedPixel>& none :
         {std::vector<VerifiedPixel>{}, {VerifiedPixel{}}, {pixelWith(0, 0)}}) {
        const Verification v = summarise(none);
        EXPECT_EQ(v.error, 0);
        EXPECT_EQ(v.worst, 0);
        EXPECT_EQ(v.upper, 0);
    }
}

TEST(Interval, OfEqualErrorsIsAPoint) {
    const Verification v = summarise(std::vector<VerifiedPixel>(50, pixelWith(2, 0.02)));
    EXPECT_NEAR(v.error, 0.01, 1e-12);
    EXPECT_NEAR(v.lower, 0.01, 1e-12);
    EXPECT_NEAR(v.upper, 0.01, 1e-12);
}

// 300 times 80 pixels with errors of deviation 0.02 around a mean of 1, whose true relative RMSE is 0.02: 95 %
// intervals should hold it in 285 of them; bootstraps of few samples are known to fall somewhat short. A broken one
// (of a third of the width, say) would hold it in about 150.
TEST(Interval, HoldsTheTrueErrorAsOftenAsItSays) {
    std::mt19937 random(1);
    std::normal_distribution<double> error(0, 0.02);
    std::uniform_real_distribution<double> brightness(0.5, 1.5);
    int held = 0;
    double width = 0;
    for (int i = 0; i < 300; ++i) {
        std::vector<VerifiedPixel> pixels;
        for (int k = 0; k < 80; ++k) pixels.push_back(pixelWith(brightness(random), error(random)));
        const Verification v = summarise(pixels);
        EXPECT_LE(v.lower, v.error);
        EXPECT_GE(v.upper, v.error);
        held += v.lower <= 0.02 && v.upper >= 0.02 ? 1 : 0;
        width += (v.upper - v.lower) / 300;
    }
    EXPECT_GE(held, 265);
    EXPECT_LE(held, 297);
    // RMSE of n normal errors deviates by 1 / sqrt(2 n), two deviations to each side.
    EXPECT_NEAR(width, 0.02 * 4 / std::sqrt(160.0), 0.002);
}

ViewScene ballScene() {
    ViewScene scene = orthographicScene(smokeField(8), {0.3, Rgb(0.9), {}}, 26, 24);
    scene.lights.push_back(distantLight({1, -1, -1}));
    return scene;
}

TEST(SamplePixels, PicksDifferentPixelsOfWhatIsThere) {
    const ViewScene scene = ballScene();
    const Image image = renderScene(scene).image;
    const auto places = [&](unsigned seed, int count) {
        std::set<std::pair<int, int>> out;
        for (const VerifiedPixel& p : samplePixels(scene, image, count, seed)) {
            EXPECT_TRUE(image.window.contains(p.x, p.y));
            const float* rgba = image.rgba.data() + image.indexOf(p.x, p.y);
            EXPECT_GT(rgba[3], 4e-4f);
            for (std::size_t c = 0; c < 4; ++c) EXPECT_EQ(p.rendered[c], rgba[c]);
            EXPECT_TRUE(out.insert({p.x, p.y}).second) << "twice: " << p.x << "," << p.y;
        }
        return out;
    };
    EXPECT_EQ(places(1, 12).size(), 12u);
    EXPECT_EQ(places(1, 12), places(1, 12));
    EXPECT_NE(places(1, 12), places(2, 12));
    EXPECT_TRUE(places(1, 0).empty());
    EXPECT_TRUE(places(1, -3).empty());
    // More than there are: all there are.
    std::size_t filled = 0;
    for (std::size_t i = 3; i < image.rgba.size(); i += 4) filled += image.rgba[i] > 5e-4f ? 1 : 0;
    EXPECT_EQ(places(1, 100000).size(), filled);
}

TEST(SamplePixels, ComparesWithTheReference) {
    const ViewScene scene = ballScene();
    const std::vector<VerifiedPixel> pixels = samplePixels(scene, renderScene(scene).image, 20, 5);
    const Reference reference(scene);
    for (const VerifiedPixel& p : pixels) EXPECT_EQ(p.reference, reference.pixel(p.x, p.y));
    const Verification v = summarise(pixels);
    EXPECT_GT(v.pixels, 15);  // some of a few wisps at the edge may not count
    EXPECT_GT(v.error, 0);
    EXPECT_LT(v.error, 0.1);  // one voxel a texel, in a ball of eight
}

TEST(SamplePixels, StopsWhenAskedTo) {
    const ViewScene scene = ballScene();
    const Image image = renderScene(scene).image;
    std::vector<double> parts;
    EXPECT_EQ(errorOf(ErrorKind::interrupted,
                      [&] {
                          samplePixels(scene, image, 60, 1, [&](double part) {
                              parts.push_back(part);
                              return parts.size() < 2;
                          });
                      }),
              "the verification was interrupted");
    ASSERT_EQ(parts.size(), 2u);
    EXPECT_LT(parts[0], parts[1]);
}

}  // namespace
}  // namespace scrim::test
