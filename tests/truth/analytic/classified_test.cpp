// SPDX-License-Identifier: Apache-2.0
// Classified shading (ZC02 section 3.1) against closed forms, against itself in the other order, and against brute
// force.
#include "support/verified.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace scrim::test {
namespace {

const double kPi = std::acos(-1.0);

Classified transferOf(std::vector<TransferPoint> points) {
    Classified c;
    c.transfer = std::move(points);
    return c;
}

// Opaque from a value of 1/2 on, as a sharp step.
Classified stepAtHalf(double extinction) {
    return transferOf({{0.5, Rgb(1), 0}, {0.5, Rgb(1), extinction}, {1, Rgb(1), extinction}});
}

ViewScene classifiedScene(std::shared_ptr<const SparseField> field, const Classified& look, double height,
                          int resolution) {
    ViewScene scene = orthographicScene(std::move(field), {}, height, resolution);
    scene.volumes[0].classified = std::make_shared<const Classified>(look);
    return scene;
}

// Optical depth along z of a field that is linear between `values` at whole z and 0 beyond them.
double depthThrough(const Classified& look, const std::vector<double>& values) {
    double depth = 0, before = 0;
    for (std::size_t i = 0; i <= values.size(); ++i) {
        const double after = i < values.size() ? values[i] : 0;
        constexpr int kSteps = 20000;
        for (int k = 0; k < kSteps; ++k)
            depth += classify(look, before + (after - before) * (k + 0.5) / kSteps).extinction / kSteps;
        before = after;
    }
    return depth;
}

TEST(Classified, RampHasTheOpticalDepthOfItsTransferFunctionAtAnyThickness) {
    // Values 0.05, 0.1 ... along z; a band of the transfer function, a step and a slope.
    std::vector<double> values;
    for (int z = 1; z <= 20; ++z) values.push_back(0.05 * z);
    const auto field = makeField({-12, -12, 0}, {12, 12, 19}, 1, [](const Vec3& is) { return 0.05 * (is.z + 1); });
    for (const Classified& look :
         {transferOf({{0.4, Rgb(1), 0}, {0.8, Rgb(1), 0.5}}),
          transferOf({{0.3, Rgb(1), 0}, {0.35, Rgb(1), 2}, {0.4, Rgb(1), 0}}), stepAtHalf(0.2)}) {
        const double expected = -std::expm1(-depthThrough(look, values));
        for (const double thickness : {0.25, 1.0, 2.0}) {
            ViewScene scene = classifiedScene(field, look, 10, 8);
            scene.dials.sheetThickness = thickness;
            const double alpha = pixelOf(renderScene(scene), 4, 4)[3];
            // Values on planes are means over sheets: where the ramp ends they are rounded off.
            EXPECT_NEAR(alpha, expected, (thickness > 1 ? 2e-2 : 5e-3) * expected) << "thickness " << thickness;
        }
    }
}

TEST(Classified, WhiteSurfaceThatFacesTheLightReflectsEOverPi) {
    // Extinct enough to be opaque: half of the light is lost on its way in and out within the surface itself,
    // integral of sigma e^(-2 sigma t) dt = 1/2.
    Classified look = stepAtHalf(20);
    look.ambient = look.specular = 0;
    look.diffuse = 1;
    ViewScene scene = classifiedScene(boxField({-12, -12, -6}, {12, 12, 6}), look, 10, 8);
    scene.lights.push_back(distantLight({0, 0, -1}, 2));
    EXPECT_NEAR(pixelOf(renderScene(scene), 4, 4)[0], 2 / kPi / 2, 0.01);
}

TEST(Classified, DiffuseFollowsTheCosineOfTheLight) {
    Classified look = stepAtHalf(1);
    look.ambient = look.specular = 0;
    look.diffuse = 1;
    for (const double degrees : {0.0, 30.0, 50.0}) {
        const double angle = degrees * kPi / 180;
        ViewScene scene = classifiedScene(boxField({-24, -24, -6}, {24, 24, 6}), look, 10, 8);
        scene.dials.sheetThickness = scene.dials.texel = 0.5;
        scene.lights.push_back(distantLight({std::sin(angle), 0, -std::cos(angle)}, kPi));
        // Within the surface: integral of sigma e^(-sigma t (1 + 1 / cos)) dt.
        const double expected = std::cos(angle) / (1 + 1 / std::cos(angle));
        // Sheets and texels of half a voxel resolve a surface that leans against them to a few per cent.
        EXPECT_NEAR(pixelOf(renderScene(scene), 4, 4)[0], expected, 0.08 * expected) << degrees;
    }
}

TEST(Classified, ASurfaceThinnerThanASheetIsAsBrightAsItsLeanTellsWhereverItLies) {
    // Opaque within a twentieth of a voxel, and so within a part of any sheet. Of the light that comes and goes at
    // these cosines to the normal, 1 / (1 + eye / light) is left. A medium too thin to be seen makes surfaces take the
    // light of texels.
    Classified look = stepAtHalf(20);
    look.ambient = look.specular = 0;
    look.diffuse = 1;
    Medium thin;
    thin.densityScale = 1e-9;
    const auto veil = boxField({-20, -20, -20}, {20, 20, 20});
    double worst = 0, worstOfTexels = 0;
    for (const double degrees : {0.0, 30.0, 50.0})
        for (const double depth : {0.0, 0.15, 0.3, 0.45}) {
            const double angle = degrees * kPi / 180;
            const auto ramp = makeField({-24, -24, -6}, {24, 24, 6}, 1,
                                        [&](const Vec3& is) { return std::clamp(0.5 - (is.z + depth) / 6, 0.0, 1.0); });
            ViewScene scene = classifiedScene(ramp, look, 10, 8);
            scene.lights.push_back(distantLight({std::sin(angle), 0, -std::cos(angle)}, kPi));
            const double expected = std::cos(angle) / (1 + 1 / std::cos(angle));
            const auto error = [&] { return std::abs(pixelOf(renderScene(scene), 4, 4)[0] / expected - 1); };
            worst = std::max(worst, error());
            scene.volumes.push_back({"veil", veil, veil->wsFromIs, thin});
            worstOfTexels = std::max(worstOfTexels, error());
        }
    // Measured: 0.057, and more than twice that where lights are looked up once for a sheet, from texels.
    EXPECT_LT(worst, 0.08);
    EXPECT_LT(worst, 0.5 * worstOfTexels);
}

TEST(Classified, LightFromBehindASurfaceCountsOnlyWhereItIsTwoSided) {
    Classified look = stepAtHalf(0.02);  // so thin that light from behind arrives
    look.ambient = look.specular = 0;
    ViewScene scene = classifiedScene(
        makeField({-12, -12, -6}, {12, 12, 6}, 1, [](const Vec3& is) { return 0.3 + 0.03 * (is.z + 16); }), look, 10,
        8);
    scene.lights.push_back(distantLight({0, 0, 1}, 1));
    scene.lights[0].shadows = false;
    // Density grows towards the eye, so normals point away from it: the far light is in front of the surfaces.
    const double front = pixelOf(renderScene(scene), 4, 4)[0];
    scene.lights[0] = distantLight({0, 0, -1}, 1);
    scene.lights[0].shadows = false;
    const double behind = pixelOf(renderScene(scene), 4, 4)[0];
    look.twoSided = true;
    scene.volumes[0].classified = std::make_shared<const Classified>(look);
    const double twoSided = pixelOf(renderScene(scene), 4, 4)[0];
    EXPECT_LT(behind, 0.3 * front);  // what is left is the box's own face towards the eye
    EXPECT_GT(twoSided, 0.9 * front);
}

TEST(Classified, InteriorsWithoutAGradientAreNotBlack) {
    Classified look = stepAtHalf(0.005);
    look.ambient = look.specular = 0;
    look.diffuse = 1;
    ViewScene scene = classifiedScene(boxField({-12, -12, -48}, {12, 12, 48}), look, 10, 8);
    scene.lights.push_back(distantLight({1, 0, 0}, kPi));
    scene.lights[0].shadows = false;
    // Along z nearly all is interior: radiance = E/pi times opacity, whatever the way to the light.
    const auto pixel = pixelOf(renderScene(scene), 4, 4);
    // The faces at either end have normals, to a depth of about five voxels in all 98.
    EXPECT_NEAR(pixel[0], pixel[3], 0.16 * pixel[3]);
}

TEST(Classified, HighlightIsWhereTheMirrorDirectionMeetsTheEye) {
    Classified look = stepAtHalf(20);
    look.ambient = look.diffuse = 0;
    look.specular = 1;
    look.exponent = 50;
    const auto ball = makeField(Int3(-22), Int3(22), 1,
                                [](const Vec3& is) { return std::clamp(0.5 + (16 - glm::length(is)) / 6, 0.0, 1.0); });
    ViewScene scene = classifiedScene(ball, look, 44, 88);
    // Light and eye 60 degrees apart: the normal half-way leans by 30, at sin(30) of the radius.
    scene.lights.push_back(distantLight({-std::sin(kPi / 3), 0, -std::cos(kPi / 3)}, kPi));
    const Frame frame = renderScene(scene);
    double best = 0;
    int bestX = 0, bestY = 0;
    for (int y = 0; y < 88; ++y)
        for (int x = 0; x < 88; ++x)
            if (pixelOf(frame, x, y)[0] > best) {
                best = pixelOf(frame, x, y)[0];
                bestX = x;
                bestY = y;
            }
    EXPECT_NEAR((bestX + 0.5 - 44) / 2, 16 * 0.5, 1.5);
    EXPECT_NEAR((bestY + 0.5 - 44) / 2, 0, 1.5);
}

// A plan whose sheets are the same ones, swept from the other end.
Plan turnedRound(Plan plan) {
    for (GroupPlan& group : plan.groups) {
        Sheets& s = group.sheets;
        const Vec3 far(s.ssOrigin.x, s.ssOrigin.y + (s.height - 1) * s.texel, s.ssOrigin.z + s.count * s.thickness);
        s.ssFromWs = Mat3(1, 0, 0, 0, -1, 0, 0, 0, -1) * s.ssFromWs;  // u, -v, -w
        s.ssOrigin = {far.x, -far.y, -far.z};
        group.sameSide = !group.sameSide;
    }
    return plan;
}

TEST(Compositing, FrontToBackAndBackToFrontGiveTheSamePicture) {
    // ZC02 eq. 1 and 2, without lights' shadows, which have an order of their own.
    Classified look = transferOf({{0.1, Rgb(0.2, 0.3, 1), 0}, {0.3, Rgb(0.2, 0.3, 1), 0.3}, {0.8, Rgb(1, 0.5, 0), 4}});
    ViewScene scene = classifiedScene(smokeField(20), look, 50, 64);
    scene.ambient = Rgb(1);
    const Plan plan = makePlan(scene, 1);
    const Frame there = render(scene, plan), back = render(scene, turnedRound(plan));
    double most = 0, largest = 0;
    for (std::size_t i = 0; i < there.image.rgba.size(); ++i) {
        most = std::max(most, double(there.image.rgba[i]));
        largest = std::max(largest, std::abs(double(there.image.rgba[i]) - double(back.image.rgba[i])));
    }
    EXPECT_GT(most, 0.1);
    // Rounding, and the cut-off of what lies behind opaque pixels, of which only one order knows.
    EXPECT_LT(largest, 2 * scene.dials.opacityCutoff * most);
    scene.dials.opacityCutoff = 0;
    const Frame exact = render(scene, makePlan(scene, 1)), exactBack = render(scene, turnedRound(makePlan(scene, 1)));
    for (std::size_t i = 0; i < exact.image.rgba.size(); ++i)
        ASSERT_NEAR(exact.image.rgba[i], exactBack.image.rgba[i], 2e-4 * most);
}

// Brightness of a plane that leans against the sheets, where a sharp step of the transfer function cuts a ramp:
// relative deviation from its mean. Slices would show as stripes.
double stripes(double thickness) {
    Classified look = stepAtHalf(4);
    look.ambient = 1;
    look.diffuse = look.specular = 0;
    const Vec3 normal = glm::normalize(Vec3(0.35, 0.2, 1));
    const auto ramp = makeField({-30, -30, -20}, {30, 30, 20}, 1,
                                [&](const Vec3& is) { return std::clamp(0.5 - glm::dot(is, normal) / 8, 0.0, 1.0); });
    ViewScene scene = classifiedScene(ramp, look, 20, 40);
    // So thin a cover that its depth shows: only 40 % opaque.
    Classified thin = look;
    thin.transfer = {{0.5, Rgb(1), 0}, {0.5, Rgb(1), 1.0}, {0.6, Rgb(1), 1.0}, {0.6, Rgb(1), 0}, {1, Rgb(1), 0}};
    scene.volumes[0].classified = std::make_shared<const Classified>(thin);
    scene.ambient = Rgb(1);
    scene.dials.sheetThickness = thickness;
    const Frame frame = renderScene(scene);
    double sum = 0, squares = 0;
    int count = 0;
    for (int y = 10; y < 30; ++y)
        for (int x = 10; x < 30; ++x) {
            const double value = pixelOf(frame, x, y)[0];
            sum += value;
            squares += value * value;
            ++count;
        }
    const double mean = sum / count;
    return std::sqrt(std::max(0.0, squares / count - mean * mean)) / mean;
}

TEST(Classified, SharpStepsShowNoSlicesAtTheDefaultThickness) {
    for (const double thickness : {0.5, 1.0, 2.0, 4.0, 8.0})
        RecordProperty("stripesAt" + std::to_string(thickness), std::to_string(stripes(thickness)));
    EXPECT_LT(stripes(0.5), 0.01);
    EXPECT_LT(stripes(1), 0.01);
    EXPECT_LT(stripes(2), 0.02);
}

TEST(Classified, ShadowsFollowTheTransferFunction) {
    // A block that the transfer function makes transparent casts none; the same block, made extinct, dims what lies
    // below it by e^-tau.
    const auto block = boxField({-20, 10, -20}, {20, 17, 20});
    const auto below = boxField({-16, -8, -16}, {16, -1, 16});
    Medium medium;
    medium.densityScale = 1e-4;
    medium.albedo = Rgb(1);
    const auto brightness = [&](double extinction) {
        ViewScene scene = orthographicScene(below, medium, 16, 16);
        Classified look = transferOf({{0.2, Rgb(0), 0}, {0.3, Rgb(0), extinction}, {1, Rgb(0), extinction}});
        scene.volumes.push_back({"block", block, block->wsFromIs, {}});
        scene.volumes[1].classified = std::make_shared<const Classified>(look);
        scene.lights.push_back(distantLight({0, -1, 0}));
        scene.dials.crossFade = 0;
        return pixelOf(renderScene(scene), 8, 10)[0];
    };
    // From 0.2 / 0.3 on: the tents at top and bottom add 0.7 + 0.8 voxels to the seven between the centres, a little
    // more than half of the tenth in between them.
    const double expected = std::exp(-0.1 * (7 + 0.7 + 0.75));
    EXPECT_NEAR(brightness(0.1) / brightness(0), expected, 0.02 * expected);
}

// A scene of surfaces that shadow themselves, and the same with a medium too thin to be seen, beside which lights meet
// the extinction of texels.
TEST(Classified, LightsThatClassifyAlongTheirOwnRaysLeaveLessErrorThanTexels) {
    Classified look = transferOf({{0.3, Rgb(1), 0}, {0.35, Rgb(1), 3}, {1, Rgb(1), 3}});
    look.specular = 0;
    ViewScene scene = classifiedScene(smokeField(24), look, 60, 96);
    scene.lights.push_back(distantLight({1, -1, -0.6}, 3));
    scene.dials.texel = scene.dials.sheetThickness = 0.5;
    ViewScene mixed = scene;
    Medium thin;
    thin.densityScale = 1e-9;
    const auto veil = boxField({-20, -20, -20}, {20, 20, 20});
    mixed.volumes.push_back({"veil", veil, veil->wsFromIs, thin});
    PixelSample sample = samplePixels(scene, renderScene(scene).image, 60, 7);
    const double along = summarise(sample).error;
    setRendered(sample.pixels, renderScene(mixed).image);
    const double texels = summarise(sample).error;
    // What is left is the shading of the surfaces, which is the same in both: measured, 17.9 instead of 21.5 %.
    EXPECT_LT(along, 0.9 * texels) << along;
}

// Texels of 1.5 voxels know little of a surface between them. What the eye sees of it is still right: what is left
// comes from sheets of a quarter of a voxel.
TEST(Classified, SeenSurfacesDoNotShowTheTexels) {
    Classified look = transferOf({{0.3, Rgb(1), 0}, {0.35, Rgb(1, 0.6, 0.3), 3}, {1, Rgb(0.3, 0.6, 1), 3}});
    ViewScene scene = classifiedScene(smokeField(24), look, 60, 96);
    scene.ambient = Rgb(1);
    scene.lights.push_back(distantLight({1, -1, -0.6}, 3));
    scene.lights[0].shadows = false;
    scene.dials.sheetThickness = 0.25;
    scene.dials.texel = 1.5;
    for (const Kernel kernel : {Kernel::linear, Kernel::bspline}) {
        scene.dials.kernel = kernel;
        const PixelSample sample = samplePixels(scene, renderScene(scene).image, 60, 7);
        EXPECT_LT(summarise(sample).error, 0.01) << nameOf(kernel);
    }
}

TEST(Classified, WhatLiesBehindOpaquePixelsHasNoNormals) {
    // One tile of pixels, half of which see a block. The other half stays open to the end.
    ViewScene scene = classifiedScene(boxField({-24, -24, -12}, {0, 24, 12}), stepAtHalf(20), 10, 8);
    scene.lights.push_back(distantLight({0, 0, -1}, 2));
    const auto normals = [&](double cutoff) {
        scene.dials.opacityCutoff = cutoff;
        return renderScene(scene).work.shade.gradients;
    };
    const auto all = normals(0), seen = normals(0.001);
    EXPECT_GT(seen, 0u);
    EXPECT_LT(seen, all / 2);
}

TEST(Classified, GradientsWhoseSquareNoFloatHoldsAreGradients) {
    ViewScene scene = classifiedScene(makeField({-6, -6, -6}, {6, 6, 6}, 1, [](const Vec3&) { return 1e25; }),
                                      stepAtHalf(20), 20, 16);
    scene.lights.push_back(distantLight({0, 0, -1}, 2));
    for (const float value : renderScene(scene).image.rgba) {
        ASSERT_TRUE(std::isfinite(value)) << value;
        EXPECT_LE(value, 2);
    }
}

TEST(Classified, OpacityByTheGradientIsTheRampAtTheRampsSlope) {
    // Values rise by 0.05 a voxel, and fall from 1 to 0 in one at the end.
    for (const double voxel : {1.0, 2.0}) {
        const auto field =
            makeField({-12, -12, 0}, {12, 12, 19}, voxel, [](const Vec3& is) { return 0.05 * (is.z + 1); });
        for (const auto& [low, high] : {std::pair(0.0, 0.1), {0.03, 0.06}, {0.06, 0.08}, {0.01, 0.02}}) {
            Classified look =
                transferOf({{0.3, Rgb(1), 0}, {0.3, Rgb(1), 0.05}, {0.7, Rgb(1), 0.05}, {0.7, Rgb(1), 0}});
            look.gradientRamp = {{low, 0}, {high, 1}};
            ViewScene scene = classifiedScene(field, look, 10 * voxel, 8);
            scene.dials.texel = scene.dials.sheetThickness = 0.5;
            const double factor = std::clamp((0.05 / voxel - low) / (high - low), 0.0, 1.0);
            // 8 voxels of the ramp have the values, and 0.4 of the fall, where the gradient is large.
            const double expected = 0.05 * voxel * (8 * factor + 0.4);
            const double depth = -std::log(1 - pixelOf(renderScene(scene), 4, 4)[3]);
            // The fall is shorter than the field is sharp on sheets: up to half of it.
            EXPECT_NEAR(depth, expected, 0.05 * voxel * (0.2 + 0.1 * factor)) << voxel << ": " << low << " " << high;
        }
    }
}

TEST(Classified, ShadowsHaveTheOpacityByTheGradientToo) {
    // Light crosses the same ramp on its way: beside the eye, along x.
    const auto field = makeField({0, -12, -12}, {19, 12, 12}, 1, [](const Vec3& is) { return 0.05 * (is.x + 1); });
    Classified look = transferOf({{0.3, Rgb(1), 0}, {0.3, Rgb(1), 0.1}, {0.7, Rgb(1), 0.1}, {0.7, Rgb(1), 0}});
    look.diffuse = 1;
    look.ambient = look.specular = 0;
    look.gradientRamp = {{0, 0}, {0.1, 1}};
    ViewScene scene = classifiedScene(field, look, 40, 40);
    scene.dials.texel = scene.dials.sheetThickness = 0.5;
    scene.lights.push_back(distantLight({1, 0, 0}, kPi));
    scene.lights[0].shadows = true;
    ViewScene open = scene;
    open.lights[0].shadows = false;
    const Frame shadowed = renderScene(scene), lit = renderScene(open);
    for (const int x : {27, 30, 32}) {  // the values begin at x = 5, in pixel 25
        const double way = x + 0.5 - 25;
        EXPECT_NEAR(pixelOf(shadowed, x, 20)[0] / pixelOf(lit, x, 20)[0], std::exp(-0.05 * way), 0.015) << x;
    }
}

TEST(Classified, OpacityByTheGradientAgreesWithBruteForce) {
    Classified look =
        transferOf({{0.15, Rgb(0.3, 0.5, 1), 0}, {0.3, Rgb(0.3, 0.5, 1), 0.4}, {0.6, Rgb(1, 0.6, 0.3), 2}});
    look.gradientRamp = {{0.02, 0}, {0.06, 1}};
    ViewScene scene = classifiedScene(smokeField(24), look, 60, 96);
    scene.ambient = Rgb(0.3);
    scene.lights.push_back(distantLight({1, -1, -0.6}, 3));
    expectConvergence(scene, 40, 1, 0.04);  // as without it
}

TEST(Classified, AgreesWithBruteForce) {
    Classified look =
        transferOf({{0.15, Rgb(0.3, 0.5, 1), 0}, {0.3, Rgb(0.3, 0.5, 1), 0.2}, {0.6, Rgb(1, 0.6, 0.3), 2}});
    look.specular = 0.3;
    ViewScene scene = classifiedScene(smokeField(24), look, 60, 96);
    scene.ambient = Rgb(0.3);
    scene.lights.push_back(distantLight({1, -1, -0.6}, 3));
    expectConvergence(scene, 40, 1, 0.04);  // surfaces, and their highlights
}

// The field leaps from 0 to 1 within a voxel, and shows from its first traces on. Were it as smooth there as the splats
// are, its lit sides would lie in their own shadow.
TEST(Classified, SurfacesThatShowFromTheFirstTraceOnDoNotShadowThemselves) {
    for (const double trace : {0.001, 0.03}) {
        const Classified look = transferOf({{0.2 * trace, Rgb(1), 0}, {trace, Rgb(1), 1.2}});
        ViewScene scene = classifiedScene(boxField({-10, -9, -15}, {10, 9, 15}), look, 42, 32);
        scene.volumes[0].wsFromIs = glm::rotate(scene.volumes[0].wsFromIs, 0.3, Vec3(1, 0.7, 0.2));
        scene.lights.push_back(distantLight({-1, -0.8, -0.5}, 3));
        scene.dials.texel = scene.dials.sheetThickness = 0.28;
        EXPECT_LT(errorOf(scene, 60), 0.025) << trace;
    }
}

}  // namespace
}  // namespace scrim::test
