// SPDX-License-Identifier: Apache-2.0
#include "support/expect_error.h"
#include "support/fields.h"

#include <scrim/verify/moments_reference.h>
#include <scrim/verify/reference.h>
#include <scrim/verify/verify.h>
#include <scrim/verify/verify_pixels.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <utility>
#include <vector>

namespace scrim::test {
namespace {

VerifiedPixel pixelWith(double reference, double error, int x = 0, int y = 0) {
    return {x, y, {reference + error, reference + error, reference + error, 1}, {reference, reference, reference, 1}};
}

Verification summaryOf(const std::vector<VerifiedPixel>& pixels) {
    return summarise(pixels);
}

TEST(Summary, OfKnownErrorsIsKnown) {
    // Means of 1 and 3, errors of 0.1 and -0.3: RMS sqrt((0.01 + 0.09) / 2) over a mean of 2.
    const Verification v = summaryOf({pixelWith(1, 0.1, 4, 5), pixelWith(3, -0.3, 6, 7)});
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
    const Verification v = summaryOf({p});
    EXPECT_NEAR(v.error, 0.3 / std::sqrt(3.0), 1e-12);
    EXPECT_NEAR(v.bias, 0.1, 1e-12);
}

VerifiedPixel pixelOfAlpha(double reference, double rendered) {
    return {0, 0, {0, 0, 0, rendered}, {0, 0, 0, reference}};
}

// What shows nothing, in the picture as in truth, does not count; what shows in one of the two does.
TEST(Summary, CountsWhatShowsInThePictureOrInTruth) {
    const VerifiedPixel lit = pixelWith(1, 0);
    VerifiedPixel lost = lit, ghost = lit;
    lost.rendered = {};
    ghost.reference = {};
    EXPECT_EQ(summaryOf({lit, VerifiedPixel{}, pixelOfAlpha(1e-3, 1e-3)}).pixels, 1);
    EXPECT_NEAR(summaryOf({lit, lost}).error, std::sqrt(0.5), 1e-12);
    EXPECT_NEAR(summaryOf({lit, ghost}).error, std::sqrt(0.5) / 0.5, 1e-12);
    EXPECT_EQ(summaryOf({lit, ghost}).pixels, 2);
    PixelSample sample;
    sample.pixels = {VerifiedPixel{}, lit, pixelOfAlpha(1e-3, 1e-3), ghost, lost};
    const std::vector<VerifiedPixel> counted = countedPixels(sample);
    ASSERT_EQ(counted.size(), 3u);
    EXPECT_EQ(counted[0].reference, lit.reference);
    EXPECT_EQ(counted[1].reference, ghost.reference);
    EXPECT_EQ(counted[2].rendered, lost.rendered);
}

// What only emits has no alpha; what is fainter than a thousandth of the brightest does not count.
TEST(Summary, CountsWhatShinesWithoutCovering) {
    const auto flame = [](double reference, double error) {
        VerifiedPixel p = pixelWith(reference, error);
        p.reference[3] = p.rendered[3] = 0;
        return p;
    };
    const Verification v = summaryOf({flame(4, 0), flame(2, -0.6), flame(0.003, 0.0005)});
    EXPECT_EQ(v.pixels, 2);
    EXPECT_NEAR(v.error, 0.6 / std::sqrt(2.0) / 3, 1e-12);
}

TEST(Summary, TellsTheErrorOfAlphaApart) {
    VerifiedPixel p = pixelWith(1, 0.01);
    p.reference[3] = 0.5;
    p.rendered[3] = 0.4;
    const Verification v = summaryOf({p, p});
    EXPECT_NEAR(v.error, 0.01, 1e-12);
    EXPECT_NEAR(v.alphaError, 0.2, 1e-12);
    EXPECT_EQ(v.alphaUpper, v.alphaError);
}

TEST(Summary, OfABlackPictureIsThatOfAlpha) {
    EXPECT_NEAR(summaryOf({pixelOfAlpha(0.5, 0.5), pixelOfAlpha(0.5, 0.4)}).error, 0.1 / std::sqrt(2.0) / 0.5, 1e-12);
    // Light where there is none is measured by what covers.
    VerifiedPixel shines = pixelOfAlpha(0.5, 0.5);
    shines.rendered[0] = shines.rendered[1] = shines.rendered[2] = 0.05;
    EXPECT_NEAR(summaryOf({shines, shines}).error, 0.1, 1e-12);
}

TEST(Summary, OfAPictureOfAnythingWhereNothingIsIsInfinite) {
    EXPECT_EQ(summaryOf({pixelOfAlpha(0, 0.5)}).error, std::numeric_limits<double>::infinity());
}

TEST(Summary, OfValuesThatAreNotFiniteIsInfinite) {
    for (const double wrong : {std::nan(""), std::numeric_limits<double>::infinity()})
        for (std::size_t channel = 0; channel < 4; ++channel) {
            VerifiedPixel p = pixelWith(1, 0, 3, 4);
            p.rendered[channel] = wrong;
            const Verification v = summaryOf({pixelWith(1, 0), p});
            EXPECT_EQ(v.error, std::numeric_limits<double>::infinity());
            EXPECT_EQ(v.upper, v.error);
            EXPECT_EQ(v.worstX, 3);
        }
}

TEST(Summary, OfNothingIsZero) {
    for (const std::vector<VerifiedPixel>& none : {std::vector<VerifiedPixel>{}, {VerifiedPixel{}}}) {
        const Verification v = summaryOf(none);
        EXPECT_EQ(v.pixels, 0);
        EXPECT_EQ(v.error, 0);
        EXPECT_EQ(v.worst, 0);
        EXPECT_EQ(v.upper, 0);
    }
}

// Of a picture that was looked at as a whole there is nothing left to guess; of half of it, less than of a small part.
TEST(Interval, NarrowsAsThePictureIsUsedUp) {
    std::mt19937 random(1);
    std::normal_distribution<double> error(0, 0.02);
    PixelSample sample;
    for (int i = 0; i < 100; ++i) sample.pixels.push_back(pixelWith(1, error(random)));
    const auto width = [&](std::size_t candidates) {
        sample.candidates = candidates;
        const Verification v = summarise(sample);
        EXPECT_EQ(v.complete, candidates == 100);
        return std::log(v.upper / v.lower);
    };
    EXPECT_EQ(width(100), 0);
    EXPECT_NEAR(width(200) / width(0), std::sqrt(0.5), 1e-9);
    EXPECT_LT(width(1000), width(0));
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

TEST(SamplePixels, PicksAsManyDifferentPixelsAsCount) {
    const ViewScene scene = ballScene();
    const Image image = renderScene(scene).image;
    const auto places = [&](unsigned seed, int count) {
        const PixelSample sample = samplePixels(scene, image, count, seed);
        EXPECT_EQ(summarise(sample).pixels, std::max(count, 0));
        std::vector<std::pair<int, int>> out;
        for (const VerifiedPixel& p : sample.pixels) {
            EXPECT_TRUE(image.window.contains(p.x, p.y));
            const float* rgba = image.rgba.data() + image.indexOf(p.x, p.y);
            for (std::size_t c = 0; c < 4; ++c) EXPECT_EQ(p.rendered[c], rgba[c]);
            out.emplace_back(p.x, p.y);
        }
        EXPECT_EQ(std::set(out.begin(), out.end()).size(), out.size());
        return out;
    };
    const auto twelve = places(1, 12), forty = places(1, 40);
    EXPECT_EQ(places(1, 12), twelve);
    EXPECT_NE(places(2, 12), twelve);
    // More of the same: so that runs with other counts can be compared.
    ASSERT_GT(forty.size(), twelve.size());
    EXPECT_TRUE(std::equal(twelve.begin(), twelve.end(), forty.begin()));
    EXPECT_TRUE(places(1, 0).empty());
    EXPECT_TRUE(places(1, -3).empty());
}

TEST(SamplePixels, OfAllLooksAtEveryPixelThatShowsSomething) {
    const ViewScene scene = ballScene();
    const Image image = renderScene(scene).image;
    const PixelSample sample = samplePixels(scene, image, kAllPixels, 1);
    EXPECT_EQ(sample.candidates, sample.pixels.size());
    EXPECT_TRUE(summarise(sample).complete);
    std::set<std::pair<int, int>> looked;
    for (const VerifiedPixel& p : sample.pixels) looked.emplace(p.x, p.y);
    const Reference reference(scene);
    for (int y = scene.region.y0; y < scene.region.y1; ++y)
        for (int x = scene.region.x0; x < scene.region.x1; ++x) {
            if (looked.contains({x, y})) continue;
            EXPECT_EQ(reference.pixel(x, y)[3], 0) << x << "," << y;
            EXPECT_EQ(image.rgba[image.indexOf(x, y) + 3], 0) << x << "," << y;
        }
    // More than there are is all there are.
    EXPECT_EQ(samplePixels(scene, image, 100000, 1).pixels.size(), sample.pixels.size());
}

TEST(SamplePixels, FindsWhatThePictureLost) {
    const ViewScene scene = ballScene();
    const PixelSample sample = samplePixels(scene, emptyImage(scene.region), 30, 1);
    const Verification v = summarise(sample);
    EXPECT_EQ(v.pixels, 30);
    EXPECT_GE(v.error, 1);
}

TEST(SamplePixels, FindsGhostsWhereNoVolumeIs) {
    const ViewScene scene = ballScene();
    Image image = emptyImage(scene.region);
    const int corner = scene.region.x0;
    image.rgba[image.indexOf(corner, scene.region.y0)] = 1;
    const auto order = verificationOrder(scene, image, 1);
    EXPECT_NE(std::find(order.begin(), order.end(), Int2(corner, scene.region.y0)), order.end());
}

TEST(SamplePixels, ComparesWithTheReference) {
    const ViewScene scene = ballScene();
    const PixelSample sample = samplePixels(scene, renderScene(scene).image, 20, 5);
    const Reference reference(scene);
    for (const VerifiedPixel& p : sample.pixels) EXPECT_EQ(p.reference, reference.pixel(p.x, p.y));
    const Verification v = summarise(sample);
    EXPECT_EQ(v.pixels, 20);
    EXPECT_GT(v.error, 0);
    EXPECT_LT(v.error, 0.1);  // one voxel a texel, in a ball of eight
}

// Every beginning of the order is spread evenly: each quarter of the picture (of a scene that fills it) has its share
// of the first 4 n pixels to within a few. Independent draws would be off by more than this in most of the seeds.
TEST(VerificationOrder, IsStratified) {
    ViewScene scene = orthographicScene(boxField({-20, -20, -2}, {19, 19, 1}), {0.3, Rgb(0.9), {}}, 32, 32);
    const Image image = emptyImage(scene.region);
    const PixelWindow& r = scene.region;
    for (unsigned seed = 1; seed <= 20; ++seed) {
        const std::vector<Int2> order = verificationOrder(scene, image, seed);
        ASSERT_EQ(order.size(), r.pixelCount());
        for (const std::size_t n : {4, 16, 64}) {
            std::array<int, 4> counts{};
            for (std::size_t i = 0; i < 4 * n; ++i)
                ++counts[(order[i].x >= (r.x0 + r.x1) / 2 ? 1u : 0u) + (order[i].y >= (r.y0 + r.y1) / 2 ? 2u : 0u)];
            for (const int count : counts) EXPECT_EQ(count, static_cast<int>(n)) << "seed " << seed;
        }
    }
}

// Every pixel is as likely as any other to be the first: over 4000 seeds each of 64 regions gets 62 (deviation 8).
TEST(VerificationOrder, IsFair) {
    ViewScene scene = orthographicScene(boxField({-20, -20, -2}, {19, 19, 1}), {0.3, Rgb(0.9), {}}, 32, 24);
    const Image image = emptyImage(scene.region);
    std::array<int, 64> counts{};
    for (unsigned seed = 0; seed < 4000; ++seed) {
        const Int2 first = verificationOrder(scene, image, seed).front() - Int2(scene.region.x0, scene.region.y0);
        ++counts[static_cast<std::size_t>(first.x / 3 + first.y / 3 * 8)];
    }
    for (const int count : counts) EXPECT_NEAR(count, 62.5, 5 * 7.9);
}

// Between the pixels of a step, and with what was done until then: none, if not one was.
TEST(SamplePixels, EndsWhenTimeIsOver) {
    const ViewScene scene = ballScene();
    const Image image = renderScene(scene).image;
    SampleOptions options;
    options.count = kAllPixels;
    options.seconds = 1e-9;
    const PixelSample none = samplePixels(scene, image, options);
    EXPECT_TRUE(none.outOfTime);
    EXPECT_TRUE(none.pixels.empty());
    const Verification v = summarise(none);
    EXPECT_EQ(v.pixels, 0);
    EXPECT_FALSE(v.complete);
}

TEST(MomentsReference, IsLeftBetweenPixels) {
    const ViewScene scene = ballScene();
    MomentsReference reference(scene);
    std::vector<VerifiedPixel> pixels = samplePixels(scene, renderScene(scene).image, 20, 5).pixels;
    std::atomic<int> asked = 0;
    EXPECT_FALSE(reference.evaluate(pixels, [&] { return ++asked > 5; }));
    EXPECT_TRUE(reference.evaluate(pixels, [] { return false; }));
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

// Noise of the reference, as that of a path tracer, is no error of the picture; but it hides one.
TEST(Verify, IntervalHoldsTheErrorBehindANoisyReference) {
    constexpr double kError = 0.02;
    for (const double noise : {0.005, 0.02, 0.3}) {
        int inside = 0;
        double widest = 0;
        constexpr int kTimes = 200;
        for (unsigned seed = 0; seed < kTimes; ++seed) {
            std::mt19937 random(seed);
            std::normal_distribution<double> normal;
            std::vector<VerifiedPixel> pixels(150, pixelWith(1, 0));
            for (VerifiedPixel& p : pixels)
                for (std::size_t c = 0; c < 3; ++c) {
                    p.rendered[c] += kError * normal(random);
                    p.reference[c] += noise * normal(random);
                    p.variance[c] = noise * noise;
                }
            const Verification v = summarise(pixels);
            inside += v.lower <= kError && kError <= v.upper ? 1 : 0;
            EXPECT_LE(v.lower, v.error);
            EXPECT_GE(v.upper, v.error);
            widest = std::max(widest, v.upper);
        }
        EXPECT_GE(inside, kTimes * 85 / 100) << noise;  // of 95 that are claimed: few pixels, long tails
        EXPECT_LT(widest, kError + noise) << noise;
    }
}

}  // namespace
}  // namespace scrim::test
