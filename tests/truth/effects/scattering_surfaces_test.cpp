// SPDX-License-Identifier: Apache-2.0
// Classified volumes that scatter: light that has scattered before, against closed forms, against a medium that does
// the same, and against the path tracer.
#include "scenes.h"
#include "support/verified.h"

#include <scrim/engine/plan/transport_plan.h>
#include <scrim/engine/solve/scattered_light.h>
#include <scrim/verify/path_tracer.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

// Of one colour, and linear in density; Phong's model reflects nothing.
Classified likeAMedium(double sigma, double albedo, const Rgb& color = Rgb(1)) {
    Classified look;
    look.transfer = {{0, color, 0}, {1, color, sigma}};
    look.diffuse = look.specular = 0;
    look.scatters = true;
    look.albedo = Rgb(albedo);
    return look;
}

// Flesh around bone: thin and red, then dense and white from a value on.
Classified fleshAndBone() {
    Classified look;
    look.transfer = {{0.1, {0.9, 0.4, 0.2}, 0},
                     {0.3, {0.9, 0.4, 0.2}, 0.1},
                     {0.55, {0.9, 0.4, 0.2}, 0.15},
                     {0.65, {0.9, 0.9, 0.8}, 0.6},
                     {1, {0.9, 0.9, 0.8}, 0.6}};
    look.scatters = true;
    look.albedo = Rgb(1);
    return look;
}

void give(ViewVolume& volume, const Classified& look) {
    volume.classified = std::make_shared<const Classified>(look);
}

ViewScene shaped(const Classified& look, const Vec3& direction) {
    ViewScene scene = orthographicScene(smokeField(20), {}, 44, 48);
    give(scene.volumes[0], look);
    scene.lights = {distantLight(glm::normalize(direction))};
    scene.dials.texel = 0.5;
    scene.dials.sheetThickness = 0.5;
    return scene;
}

// Light is the same everywhere where nothing is absorbed, whatever the transfer function does to the extinction.
TEST(ScatteringSurfaces, OfAnEvenGlowThatAbsorbNothingAreAlphaTimesTheGlow) {
    for (const ShadeMode shade : {ShadeMode::texel, ShadeMode::pixel}) {
        Classified look = fleshAndBone();
        for (TransferPoint& point : look.transfer) point.color = Rgb(1);
        ViewScene scene = shaped(look, {0, 0, -1});
        scene.lights.clear();
        scene.ambient = {1, 0.5, 0.25};
        scene.dials.scatterError = 1e-5;
        scene.dials.shade = shade;
        const Frame frame = renderScene(scene);
        EXPECT_TRUE(frame.scatterConverged);
        for (int y = 4; y < 48; y += 8)
            for (int x = 4; x < 48; x += 8) {
                const auto pixel = pixelOf(frame, x, y);
                for (std::size_t c = 0; c < 3; ++c)
                    EXPECT_NEAR(pixel[c], scene.ambient[int(c)] * pixel[3], 1e-3) << x << " " << y;
            }
        const Estimate truth = PathTracer(scene).pixel(24, 24, 4000);
        EXPECT_NEAR(truth.mean.x, pixelOf(frame, 24, 24)[3], 5 * std::sqrt(truth.variance.x) + 0.004);
    }
}

// Within a volume that takes next to no light, what is around is there undiminished: radiance is the depth times albedo
// times colour, and Phong's factor on ambient light does not count.
TEST(ScatteringSurfaces, OfAThinSlabShowWhatIsAroundByAlbedoAndColour) {
    const Rgb color(0.9, 0.5, 0.1);
    const double sigma = 1e-4;
    for (const double ambient : {0.0, 3.0}) {
        ViewScene scene = orthographicScene(boxField({-20, -20, -5}, {20, 20, 4}), {}, 10, 8);
        Classified look = likeAMedium(sigma, 0.8, color);
        look.ambient = ambient;
        give(scene.volumes[0], look);
        scene.ambient = {2, 2, 4};
        const auto pixel = pixelOf(renderScene(scene), 4, 4);
        for (std::size_t c = 0; c < 3; ++c) {
            const double expected = scene.ambient[int(c)] * 0.8 * color[int(c)] * -std::expm1(-10 * sigma);
            EXPECT_NEAR(pixel[c], expected, 0.01 * expected) << c;
        }
    }
}

// All that has scattered before, of lights, of what is around, and of a fire beside it, is that of an isotropic medium
// of the same extinction, whose albedo is the albedo times the colour.
TEST(ScatteringSurfaces, ShowTheIndirectLightOfAMediumThatDoesTheSame) {
    const Rgb color(1, 0.8, 0.5);
    ViewScene scene = shaped(likeAMedium(0.3, 0.95, color), {1, -0.5, -0.3});
    scene.lights[0].intensity = {3, 2, 3};
    scene.ambient = {0.1, 0.1, 0.2};
    scene.layers = {Layer::indirect};
    ViewScene medium = scene;
    medium.volumes[0].classified = nullptr;
    medium.volumes[0].medium.densityScale = 0.3;
    medium.volumes[0].medium.albedo = 0.95 * color;
    medium.volumes[0].medium.scattering = Scattering::full;
    EXPECT_EQ(solvesOf(scene, planTransport(scene)), 3);
    const Frame a = renderScene(scene), b = renderScene(medium);
    double difference = 0, squares = 0, most = 0;
    for (std::size_t i = 0; i < a.layers[0].data.size(); ++i) {
        const double own = double(b.layers[0].data[i]), off = double(a.layers[0].data[i]) - own;
        difference += off * off;
        squares += own * own;
        most = std::max(most, std::abs(off));
    }
    EXPECT_GT(squares, 1);
    // Measured: 0.0042. A cell of eight voxels takes the transfer function at eight places by lot.
    EXPECT_LT(std::sqrt(difference / squares), 0.006) << most;
}

TEST(ScatteringSurfaces, TakeOneSolveWhereAllIsGrey) {
    ViewScene scene = shaped(likeAMedium(0.3, 0.95), {1, 0, 0});
    EXPECT_EQ(solvesOf(scene, planTransport(scene)), 1);
    Classified look = *scene.volumes[0].classified;
    look.transfer[1].color = {1, 0.9, 1};
    give(scene.volumes[0], look);
    EXPECT_EQ(solvesOf(scene, planTransport(scene)), 3);
    look.scatters = false;
    give(scene.volumes[0], look);
    EXPECT_FALSE(planTransport(scene).any());
}

TEST(ScatteringSurfaces, AgreeWithThePathTracer) {
    struct Case {
        Vec3 light;
        bool around;
    };
    for (const Case& c : {Case{{0.3, -0.2, -1}, false}, Case{{1, -1, 0}, false}, Case{{0, 0, 1}, true}}) {
        ViewScene scene = shaped(fleshAndBone(), c.light);
        scene.dials.scatterCell = 1;  // a cell of two voxels is 1.2 mean free paths thick in bone
        if (c.around) {
            scene.lights.clear();
            scene.ambient = Rgb(1);
        }
        const BlockError e = blockError(scene, 256);
        // Measured: 1.2, 0.0 and 0.2 % with noise of 0.8 to 1.4 %.
        EXPECT_LT(e.error, 0.015 + e.noise) << c.light.x << " noise " << e.noise;
        EXPECT_GT(e.share, 0.1);
    }
}

// Smoke and a surface that scatter into each other, and a fire that lights both.
TEST(ScatteringSurfaces, ExchangeLightWithMediaAndFire) {
    ViewScene scene = shaped(fleshAndBone(), {1, -0.5, -0.3});
    Medium smoke;
    smoke.densityScale = 0.2;
    smoke.albedo = Rgb(0.95);
    smoke.scattering = Scattering::full;
    const auto field = smokeField(12);
    scene.volumes.push_back({"smoke", field, field->wsFromIs, smoke});
    scene.volumes.back().wsFromIs[3] = {24, 3, 0, 1};
    scene.volumes.back().emission = {{flameField(), {0.02, 0.01, 0.004}}};
    scene.camera.height = 80;
    const BlockError e = blockError(scene, 256);
    EXPECT_LT(e.error, 0.03 + e.noise) << e.noise;
    ViewScene apart = scene;
    apart.layers = {Layer::light, Layer::ambient, Layer::emission, Layer::indirect};
    const Frame whole = renderScene(scene), parts = renderScene(apart);
    for (std::size_t i = 0; i < whole.image.rgba.size(); ++i) {
        if (i % 4 == 3) continue;
        double sum = 0;
        for (const FrameLayer& layer : parts.layers)
            if (layer.layer != Layer::indirect) sum += double(layer.data[i / 4 * 3 + i % 4]);
        // Solves of layers and of the whole end where a sweep changes less than 2e-3.
        ASSERT_NEAR(sum, whole.image.rgba[i], 4e-3 * whole.image.rgba[i] + 1e-5) << i;
    }
}

// What a dome sends straight to a surface is scattered like all that is around it, in the picture and in the reference;
// where nothing scatters twice, that is all of its light.
TEST(ScatteringSurfaces, TakeTheLightOfADomeFromAllAround) {
    ViewScene scene = orthographicScene(smokeField(8), {}, 18, 8);
    give(scene.volumes[0], likeAMedium(0.6, 1e-3));
    scene.dials.texel = 0.5;
    scene.dials.sheetThickness = 0.5;
    Light dome;
    dome.kind = Light::Dome{};
    dome.intensity = Rgb(1);
    scene.lights = {dome};
    scene.dials.scatterCell = 1;
    const Frame frame = renderScene(scene);
    EXPECT_EQ(frame.work.lightSamples, 0u);
    std::vector<VerifiedPixel> pixels;
    for (int i = 0; i < 4; ++i) pixels.push_back({3 + i % 2, 3 + i / 2, {}, {}, {}});
    EXPECT_LT(std::abs(greenBias(scene, frame, pixels)), 0.03);
}

// A surface that does not scatter is what it was beside one that does: black to light that has scattered before.
TEST(ScatteringSurfaces, LeaveOthersAsTheyAre) {
    Classified look = likeAMedium(0.3, 0.9);
    look.scatters = false;
    ViewScene scene = shaped(look, {1, -0.5, -0.3});
    const Frame alone = renderScene(scene);
    const auto far = smokeField(4);
    scene.volumes.push_back({"far", far, far->wsFromIs, {}});
    give(scene.volumes.back(), likeAMedium(0.3, 0.9));
    scene.volumes.back().wsFromIs[3] = {0, 40, 0, 1};  // out of the picture, and out of the light's way
    const Frame beside = renderScene(scene);
    for (std::size_t i = 0; i < alone.image.rgba.size(); ++i)
        ASSERT_NEAR(alone.image.rgba[i], beside.image.rgba[i], 1e-3) << i;
}

}  // namespace
}  // namespace scrim::test
