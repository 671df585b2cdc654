// SPDX-License-Identifier: Apache-2.0
// Verification of light that scatters more than once: squares of pixels, the variance of the path tracer, and whether a
// solver that is wrong on purpose is found out.
#include "full_smoke.h"

#include <scrim/scene/quality.h>
#include <scrim/verify/path_tracer.h>
#include <scrim/verify/reference.h>
#include <scrim/verify/verify.h>
#include <scrim/verify/verify_pixels.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

namespace scrim::test {
namespace {

ViewScene smoke(double sigma, double g) {
    ViewScene scene = fullSmoke(12, 26, 40, sigma, g);
    scene.dials.texel = scene.dials.sheetThickness = 0.5;
    return scene;
}

ViewScene onlyOnce(ViewScene scene) {
    for (ViewVolume& volume : scene.volumes) volume.medium.scattering = Scattering::single;
    return scene;
}

TEST(VerifiedSquares, AreMeansOfTheirPixels) {
    ViewScene scene = onlyOnce(smoke(0.3, 0));
    scene.region.x1 -= 2;  // the last squares are cut
    const Image image = renderScene(scene).image;
    std::vector<VerifiedPixel> squares;
    for (const Int2& at : verificationOrder(scene, image, 1, 4)) squares.push_back({at.x, at.y, {}, {}, {}, 4});
    evaluateReferences(scene, squares);
    setRendered(squares, image);
    const Reference reference(scene);
    for (const VerifiedPixel& s : squares) {
        std::array<double, 4> truth{}, shown{};
        int count = 0;
        for (int y = s.y; y < s.y + 4; ++y)
            for (int x = s.x; x < s.x + 4; ++x) {
                if (!scene.region.contains(x, y)) continue;
                ++count;
                const auto pixel = reference.pixel(x, y);
                for (std::size_t c = 0; c < 4; ++c) {
                    truth[c] += pixel[c];
                    shown[c] += image.rgba[image.indexOf(x, y) + c];
                }
            }
        ASSERT_GT(count, 0);
        for (std::size_t c = 0; c < 4; ++c) {
            EXPECT_NEAR(s.reference[c], truth[c] / count, 1e-12) << s.x << "," << s.y;
            EXPECT_NEAR(s.rendered[c], shown[c] / count, 1e-9) << s.x << "," << s.y;
        }
        EXPECT_EQ(s.variance, (std::array<double, 3>{}));
    }
}

// Every pixel that may show something is in one square, and no square comes twice.
TEST(VerifiedSquares, HoldEveryPixelThatMayShowSomething) {
    const ViewScene scene = smoke(0.3, 0);
    const Image image = emptyImage(scene.region);
    std::set<std::pair<int, int>> squares;
    for (const Int2& at : verificationOrder(scene, image, 3, 4)) {
        EXPECT_EQ(at.x % 4, 0);
        EXPECT_EQ(at.y % 4, 0);
        EXPECT_TRUE(squares.emplace(at.x, at.y).second) << at.x << "," << at.y;
    }
    for (const Int2& at : verificationOrder(scene, image, 3))
        EXPECT_TRUE(squares.contains({at.x - at.x % 4, at.y - at.y % 4})) << at.x << "," << at.y;
}

// The square of a noisy mean is too large by its variance. Over 600 estimates of 24 paths each, the mean of the square
// less the variance that each estimate states must be the square of the true mean, within four deviations; with the
// variance left in, it is not.
TEST(PathTracer, StatesTheVarianceThatMakesSquaresUnbiased) {
    const ViewScene scene = smoke(0.4, 0.5);
    const PathTracer tracer(scene);
    constexpr int kTimes = 600, kPaths = 24;
    const double truth = tracer.pixel(20, 20, 200000, 99999).mean.y;
    double sum = 0, squares = 0, biased = 0;
    for (int i = 0; i < kTimes; ++i) {
        const Estimate e = tracer.pixel(20, 20, kPaths, std::uint64_t(i) + 1);
        const double unbiased = e.mean.y * e.mean.y - e.variance.y;
        sum += unbiased / kTimes;
        squares += unbiased * unbiased / kTimes;
        biased += e.mean.y * e.mean.y / kTimes;
    }
    const double deviation = std::sqrt((squares - sum * sum) / kTimes);
    EXPECT_NEAR(sum, truth * truth, 4 * deviation);
    EXPECT_GT(biased, truth * truth + 4 * deviation);
}

// Where the same light comes from everywhere and nothing is absorbed, every pixel is that light times alpha: a picture
// that is exact. A solver that loses a twentieth of the light is found out.
TEST(VerifyScattering, PassesAnExactPictureAndFindsALossOfLight) {
    ViewScene scene = smoke(0.4, 0.6);
    scene.volumes[0].medium.albedo = Rgb(1);
    scene.lights.clear();
    scene.ambient = Rgb(1, 0.5, 0.25);
    Image exact = renderScene(scene).image;
    const Reference reference(scene);
    for (int y = scene.region.y0; y < scene.region.y1; ++y)
        for (int x = scene.region.x0; x < scene.region.x1; ++x) {
            const double alpha = reference.pixel(x, y)[3];
            float* rgba = exact.rgba.data() + exact.indexOf(x, y);
            for (int c = 0; c < 3; ++c) rgba[c] = static_cast<float>(scene.ambient[c] * alpha);
            rgba[3] = static_cast<float>(alpha);
        }
    PixelSample sample = samplePixels(scene, exact, kAllPixels, 1);
    EXPECT_EQ(sample.pixels.front().edge, kScatteringMean);
    EXPECT_LT(summarise(sample).upper, 0.025);
    Image lossy = exact;
    for (std::size_t i = 0; i < lossy.rgba.size(); ++i)
        if (i % 4 != 3) lossy.rgba[i] *= 0.95F;
    setRendered(sample.pixels, lossy);
    EXPECT_GT(summarise(sample).lower, 0.025);
}

// A sound solver keeps what `draft` promises; with cells of four times the edge, with the phase function ignored or
// with a tenth of the scattered light lost it does not, and the whole interval says so.
TEST(VerifyScattering, FindsSolversThatAreWrong) {
    // Cells take voxels for cubes, which is 3 % off where a ball has but 12 of them along its radius.
    ViewScene scene = fullSmoke(24, 52, 40, 0.25, 0.6);
    scene.dials.texel = scene.dials.sheetThickness = 1;
    const double promised = promisedScatteringError("draft");
    PixelSample sample = samplePixels(scene, renderScene(scene).image, kAllPixels, 1);
    const Verification sound = summarise(sample);
    EXPECT_LT(sound.upper, promised) << sound.error;
    const auto lowest = [&](const Image& image) {
        setRendered(sample.pixels, image);
        return summarise(sample).lower;
    };
    ViewScene large = scene, even = scene;
    large.dials.scatterCell = 16;
    even.volumes[0].medium.phase.g = 0;
    EXPECT_GT(lowest(renderScene(large).image), promised) << summarise(sample).error;
    // The first scattering of `scene`, and all further ones without its phase function.
    const Image once = renderScene(onlyOnce(scene)).image, evenOnce = renderScene(onlyOnce(even)).image;
    Image ignored = renderScene(even).image, lost = renderScene(scene).image;
    for (std::size_t i = 0; i < ignored.rgba.size(); ++i) {
        ignored.rgba[i] += once.rgba[i] - evenOnce.rgba[i];
        lost.rgba[i] = once.rgba[i] + 0.67F * (lost.rgba[i] - once.rgba[i]);
    }
    EXPECT_GT(lowest(ignored), promised) << summarise(sample).error;
    EXPECT_GT(lowest(lost), promised) << summarise(sample).error;
}

}  // namespace
}  // namespace scrim::test
