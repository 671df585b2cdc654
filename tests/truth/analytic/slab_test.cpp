// SPDX-License-Identifier: Apache-2.0
// Uniform slabs, for which single scattering has a closed form.
#include "support/fields.h"

#include <gtest/gtest.h>

#include <cmath>

namespace scrim::test {
namespace {

const double kPi = std::acos(-1.0);
constexpr double kAlbedo = 0.8, kIrradiance = 2.0;
constexpr int kThickness = 10;  // voxels

// A slab around the origin, seen along -z, 20 voxels of it in the picture; far wider, so that its sides are out of
// reach of the light that its middle sees.
ViewScene slab(double opticalDepth, const Vec3& lightDirection) {
    Medium medium;
    medium.densityScale = opticalDepth / kThickness;
    medium.albedo = Rgb(kAlbedo);
    ViewScene scene = orthographicScene(boxField({-48, -48, -5}, {47, 47, 4}), medium, 20, 32);
    scene.lights.push_back(distantLight(lightDirection, kIrradiance));
    return scene;
}

class SlabLitAlongTheView : public testing::TestWithParam<double> {};

// Light behind the viewer: L = E rho / (8 pi) (1 - e^-2 tau). The sheets tile the slab exactly, so only float
// rounding and the footprints' quantisation remain.
TEST_P(SlabLitAlongTheView, FromTheFrontMatchesTheClosedForm) {
    const double tau = GetParam();
    const Frame frame = renderScene(slab(tau, {0, 0, -1}));
    const double expected = kIrradiance * kAlbedo / (8 * kPi) * (1 - std::exp(-2 * tau));
    EXPECT_NEAR(pixelOf(frame, 16, 16)[0], expected, 2e-3 * expected);
    EXPECT_NEAR(pixelOf(frame, 16, 16)[3], -std::expm1(-tau), 2e-3 * -std::expm1(-tau));
}

// Light that faces the viewer: L = E rho / (4 pi) tau e^-tau.
TEST_P(SlabLitAlongTheView, FromBehindMatchesTheClosedForm) {
    const double tau = GetParam();
    const Frame frame = renderScene(slab(tau, {0, 0, 1}));
    const double expected = kIrradiance * kAlbedo / (4 * kPi) * tau * std::exp(-tau);
    // tau e^-tau turns an error of tau into one that is (tau - 1) times as large.
    EXPECT_NEAR(pixelOf(frame, 16, 16)[0], expected, 1e-3 * (2 + tau) * expected);
}

INSTANTIATE_TEST_SUITE_P(OpticalDepths, SlabLitAlongTheView, testing::Values(1e-6, 0.1, 1.0, 3.0, 10.0, 50.0));

// tau = 5 in every sheet: a source that is constant over a sheet would come out 84 % too dark.
TEST(DenseSlab, WithFiveOpticalDepthsASheetIsStillExact) {
    const Frame frame = renderScene(slab(5.0 * kThickness, {0, 0, -1}));
    const double expected = kIrradiance * kAlbedo / (8 * kPi);
    EXPECT_NEAR(pixelOf(frame, 16, 16)[0], expected, 2e-3 * expected);
}

// From the side: light has passed sigma x when it reaches depth x behind the lit face.
TEST(SlabLitFromTheSide, DarkensAwayFromTheLitFace) {
    Medium medium;
    medium.densityScale = 0.02;
    medium.albedo = Rgb(kAlbedo);
    // Deep along the view, so that the soft voxel at its front and back, where light passes more easily, hardly counts.
    constexpr int kDepth = 120;
    ViewScene scene = orthographicScene(boxField({-16, -16, -kDepth / 2}, {15, 15, kDepth / 2 - 1}), medium, 32, 32);
    scene.lights.push_back(distantLight({1, 0, 0}, kIrradiance));
    const Frame frame = renderScene(scene);
    const double through = 1 - std::exp(-medium.densityScale * kDepth);
    for (int x = 6; x < 26; ++x) {
        // The tent kernel moves the face half a voxel out: to -16.5; pixels are one voxel wide.
        const double depth = (x + 0.5 - 16) + 16.5;
        const double expected = kIrradiance * kAlbedo / (4 * kPi) * through * std::exp(-medium.densityScale * depth);
        EXPECT_NEAR(pixelOf(frame, x, 16)[0], expected, 0.01 * expected) << "pixel " << x;
    }
}

// The upper slab takes e^-tau from what the lower one gets (Beer-Lambert).
TEST(TwoSlabs, TheFirstShadowsTheSecond) {
    const auto scene = [](bool both) {
        Medium medium;
        medium.densityScale = 0.1;
        medium.albedo = Rgb(kAlbedo);
        ViewScene s = orthographicScene(boxField({-12, -20, -12}, {11, -13, 11}), medium, 64, 64);
        if (both) {
            const auto upper = boxField({-20, 6, -20}, {19, 13, 19});
            s.volumes.push_back({"upper", upper, upper->wsFromIs, medium});
        }
        s.lights.push_back(distantLight({0, -1, 0}, kIrradiance));
        return s;
    };
    const double alone = pixelOf(renderScene(scene(false)), 32, 48)[0];
    const double shadowed = pixelOf(renderScene(scene(true)), 32, 48)[0];
    ASSERT_GT(alone, 0);
    EXPECT_NEAR(shadowed / alone, std::exp(-0.1 * 8), 2e-3);
}

TEST(Shadows, SwitchedOffLeaveTheSlabFullyLit) {
    ViewScene scene = slab(2.0, {0, 0, 1});
    scene.lights[0].shadows = false;
    const double expected = kIrradiance * kAlbedo / (4 * kPi) * (1 - std::exp(-2.0));
    EXPECT_NEAR(pixelOf(renderScene(scene), 16, 16)[0], expected, 2e-3 * expected);
}

TEST(Ambient, IsAlbedoTimesOpacityTimesItsRadiance) {
    ViewScene scene = slab(2.0, {0, 0, 1});
    scene.lights.clear();
    scene.ambient = {0.5, 1.0, 2.0};
    const auto pixel = pixelOf(renderScene(scene), 16, 16);
    for (std::size_t c = 0; c < 3; ++c) {
        const double expected = scene.ambient[static_cast<int>(c)] * kAlbedo * (1 - std::exp(-2.0));
        EXPECT_NEAR(pixel[c], expected, 2e-3 * expected);
    }
}

}  // namespace
}  // namespace scrim::test
