// SPDX-License-Identifier: Apache-2.0
// What is seen besides volumes: matte solids and skies. Closed forms in a slab of haze, and the reference.
#include "scenes.h"
#include "support/meshes.h"

#include <scrim/image/clear_sky.h>
#include <scrim/scene/light_surface.h>
#include <scrim/verify/reference.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kSigma = 0.03;  // of the haze, which is 20 units thick

Solid matte(std::shared_ptr<const TriangleMesh> mesh, const Rgb& color) {
    return {"matte", std::move(mesh), Mat4(1.0), true, true, false, Rgb(0), color};
}

Light sky(const Rgb& radiance) {
    Light light;
    light.name = "sky";
    light.kind = Light::Dome{};
    light.intensity = radiance;
    light.visible = true;
    return light;
}

ViewScene behindHaze() {
    ViewScene scene = haze(kSigma);
    scene.volumes[0].medium.albedo = Rgb(0);  // it takes light, and sends none
    scene.layers = {Layer::backdrop};
    return scene;
}

void expectPixel(const Frame& frame, const Rgb& rgb, double alpha, double tolerance) {
    const auto seen = pixelOf(frame, 10, 10);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(seen[std::size_t(c)], rgb[c], tolerance) << c;
    EXPECT_NEAR(seen[3], alpha, tolerance);
}

TEST(Backdrop, IsASkyThroughWhatTheVolumesLetThrough) {
    ViewScene scene = behindHaze();
    const Rgb blue(0.2, 0.4, 1);
    scene.lights = {sky(blue)};
    expectPixel(renderScene(scene), std::exp(-20 * kSigma) * blue, 1, 3e-4);
    scene.volumes[0].medium.extinctionTint = {1, 0.5, 0.25};
    expectPixel(renderScene(scene), glm::exp(-20 * kSigma * Rgb(1, 0.5, 0.25)) * blue, 1, 3e-4);
    scene.volumes[0].holdout = true;  // it hides the sky, and has no alpha
    expectPixel(renderScene(scene), glm::exp(-20 * kSigma * Rgb(1, 0.5, 0.25)) * blue,
                (std::exp(-20 * kSigma) + std::exp(-10 * kSigma) + std::exp(-5 * kSigma)) / 3, 3e-4);
    scene.lights.front().visible = false;
    expectPixel(renderScene(scene), Rgb(0), 0, 0);
}

// A clear sky around the eye of `scene`, whose sun stands where it looks, over the middle of the picture (-z).
Light clearSky(const ClearSky& sky) {
    Light light;
    light.name = "sky";
    light.kind = Light::Dome{180};
    light.visible = true;
    const SkyPicture picture = skyPicture(sky, ColourConfig::open(""));
    light.slide.emplace();
    light.slide->image = picture.image;
    light.slide->parts = picture.parts;
    return light;
}

// The sum of the sun's pixels is its irradiance, whether it fills many of them or a part of one; haze dims it as all.
TEST(Backdrop, IsAClearSkyWithItsSunThroughHaze) {
    ViewScene scene = behindHaze();
    scene.camera = {};
    scene.camera.wsPosition = {0, 0, 100};
    scene.camera.resolution = {40, 40};
    ClearSky sky;
    sky.sunElevation = 0.15;
    sky.airDensity = sky.dustDensity = sky.ozoneDensity = sky.groundAlbedo = 0;  // a black sky
    for (const double fov : {2.0, 8.0, 40.0}) {
        scene.camera.fov = fov;
        scene.region = {0, 0, 40, 40};
        scene.lights = {clearSky(sky)};
        const Rgb light = scene.lights.front().slide->parts->suns.front().light;
        const Frame frame = renderScene(scene);
        const double pixel = 2 * std::tan(fov * kPi / 360) / 40;
        Rgb sum(0);
        for (int y = 0; y < 40; ++y)
            for (int x = 0; x < 40; ++x)
                for (int c = 0; c < 3; ++c) sum[c] += pixelOf(frame, x, y)[std::size_t(c)] * pixel * pixel;
        const double left = std::exp(-20 * kSigma);
        // With few pixels in it, it counts which of them have their middle in its border.
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c] / (left * light[c]), 1, fov < 5 ? 0.02 : 0.08) << fov;
        EXPECT_EQ(pixelOf(frame, 0, 0)[3], 1);
        EXPECT_EQ(pixelOf(frame, 0, 0)[0], 0);
    }
}

// What the sky lights, before the sky that is seen: by the reference, which chooses its rays by the sky and the sun.
TEST(Backdrop, LightsTheHazeBeforeAClearSky) {
    ViewScene scene = haze(kSigma);
    ClearSky sky;
    sky.sunElevation = 25;
    scene.lights = {clearSky(sky)};
    scene.lights.front().shadow = ShadowMethod::buffers;
    scene.layers = {Layer::light, Layer::backdrop};
    const Frame frame = renderScene(scene);
    const Reference reference(scene);
    for (int i = 3; i < 18; i += 3) {
        const auto truth = reference.pixel(i, 9), seen = pixelOf(frame, i, 9);
        for (std::size_t c = 0; c < 4; ++c) EXPECT_NEAR(seen[c] / truth[c], 1, 0.02) << i << " " << c;
    }
    scene.lights.front().slide->parts = nullptr;  // without its sun
    EXPECT_LT(pixelOf(renderScene(scene), 9, 9)[0], 0.8 * pixelOf(frame, 9, 9)[0]);
}

// A surface in the middle of the haze, half-way through: light and eye pass 9.5 units of it each, the light on a slant.
TEST(Backdrop, IsAMatteSurfaceUnderLightThatPassedTheHaze) {
    ViewScene scene = behindHaze();
    const Vec3 travel = glm::normalize(Vec3(0.6, 0.2, -1));
    scene.lights = {distantLight(travel, 3)};
    const Rgb red(0.8, 0.3, 0.1);
    scene.solids = std::make_shared<Solids>(std::vector{matte(squareMesh(Vec3(0), {0, 0, 1}, 300), red)});
    const double cosine = -travel.z, lit = 3 * cosine / kPi * std::exp(-9.5 * kSigma / cosine);
    expectPixel(renderScene(scene), std::exp(-9.5 * kSigma) * lit * red, 1, 5e-4);
    scene.lights.front().wsDirection.z *= -1;  // its other side
    expectPixel(renderScene(scene), Rgb(0), 1, 1e-6);
    scene.ambient = {0.5, 1, 2};
    expectPixel(renderScene(scene), std::exp(-9.5 * kSigma) * red * scene.ambient, 1, 5e-4);
}

// A lamp of intensity I at a height h over a surface, and a sky over it: I / h^2, and pi L.
TEST(Backdrop, IsLitByLampsAndSkies) {
    ViewScene scene = behindHaze();
    scene.volumes[0].medium.densityScale = 0;
    scene.solids = std::make_shared<Solids>(std::vector{matte(squareMesh({0.5, -0.5, -8}, {0, 0, 1}, 300), Rgb(1))});
    scene.lights = {lamp({0.5, -0.5, -3}, 10)};
    expectPixel(renderScene(scene), Rgb(10 / (25 * kPi)), 1, 1e-4);
    scene.lights = {sky(Rgb(0.7))};
    expectPixel(renderScene(scene), Rgb(0.7), 1, 0.01);  // its sub-lights: light_error
}

TEST(Backdrop, IsDarkInTheShadowOfASolidAndHiddenByOneWithoutColour) {
    ViewScene scene = behindHaze();
    scene.volumes[0].medium.densityScale = 0;
    scene.lights = {distantLight(glm::normalize(Vec3(0.6, 0.2, -1)), 3)};
    Solid shade = matte(squareMesh({-6, -2, 10}, {0, 0, 1}, 1.5), Rgb(0));  // on the way from the light to the middle
    shade.holdout = false;
    shade.color.reset();
    const Solid floor = matte(squareMesh(Vec3(0), {0, 0, 1}, 300), Rgb(1));
    scene.solids = std::make_shared<Solids>(std::vector{floor, shade});
    const Frame frame = renderScene(scene);
    expectPixel(frame, Rgb(0), 1, 1e-6);
    EXPECT_GT(pixelOf(frame, 3, 3)[0], 0.5);
    Solid hides = matte(squareMesh({0, 0, 5}, {0, 0, 1}, 2), Rgb(0));
    hides.color.reset();
    scene.solids = std::make_shared<Solids>(std::vector{floor, hides});
    expectPixel(renderScene(scene), Rgb(0), 0, 0);
}

// A lamp that the camera sees, whose surface is at z = 5 on the axis of the view, 4.5 units below the top of the haze.
ViewScene lampInHaze(AreaShape shape, double spread = 180) {
    constexpr double kRadius = 3, kSurface = 5;
    ViewScene scene = behindHaze();
    Light lamp;
    lamp.name = "lamp";
    lamp.kind = Light::Area{.shape = shape, .width = 6, .height = 6, .radius = kRadius, .spread = spread};
    const bool round = shape == AreaShape::sphere || shape == AreaShape::cylinder;
    lamp.wsPosition = {0, 0, round ? kSurface - kRadius : kSurface};
    lamp.wsDirection = {0, 0, 1};
    lamp.intensity = {3, 2, 1};
    lamp.visible = true;
    scene.lights = {lamp};
    return scene;
}

void showSurface(ViewScene& scene) {
    Solid solid{"lamp", std::make_shared<TriangleMesh>(surfaceOf(scene.lights.front())), Mat4(1.0), true, false};
    solid.light = 0;
    scene.solids = std::make_shared<Solids>(std::vector{solid});
}

TEST(Backdrop, IsTheSurfaceOfALampThroughTheHazeBeforeIt) {
    for (const AreaShape shape : {AreaShape::rectangle, AreaShape::disk, AreaShape::sphere, AreaShape::cylinder}) {
        SCOPED_TRACE(static_cast<int>(shape));
        ViewScene scene = lampInHaze(shape);
        showSurface(scene);
        const Frame frame = renderScene(scene);
        // A pixel lies beside the axis, so the surface of a ball is a little farther away there.
        expectPixel(frame, std::exp(-4.5 * kSigma) * Rgb(3, 2, 1), 1, 0.02);
        const auto truth = Reference(scene).pixel(10, 10), seen = pixelOf(frame, 10, 10);
        for (std::size_t c = 0; c < 4; ++c) EXPECT_NEAR(seen[c], truth[c], 1e-3) << c;
        const auto beside = pixelOf(frame, 0, 0);
        EXPECT_EQ(beside[0], 0);
        EXPECT_NEAR(beside[3], 1 - std::exp(-20 * kSigma), 1e-3) << "beside it, the haze alone";
    }
}

TEST(Backdrop, IsDarkBehindALampThatShinesToOneSideAndNarrowerWithASpread) {
    for (const AreaShape shape : {AreaShape::rectangle, AreaShape::disk}) {
        ViewScene scene = lampInHaze(shape);
        scene.lights.front().wsDirection = {0, 0, -1};
        showSurface(scene);
        expectPixel(renderScene(scene), Rgb(0), 1, 1e-6);
        scene = lampInHaze(shape, 60);
        showSurface(scene);
        const double half = kPi / 6, along = std::tan(half) / (std::tan(half) - half);
        expectPixel(renderScene(scene), along * std::exp(-4.5 * kSigma) * Rgb(3, 2, 1), 1, 0.02);
    }
}

// In haze that scatters, the lamp hides what is behind it; a crop is the same as its part of the whole.
TEST(Backdrop, OfALampInSmokeAgreesWithBruteForceAndWithItsCrops) {
    ViewScene scene = lampInHaze(AreaShape::sphere);
    scene.volumes[0].medium.albedo = Rgb(0.8);
    scene.lights.push_back(distantLight(glm::normalize(Vec3(0.6, 0.2, -1)), 3));
    scene.dials.texel = scene.dials.sheetThickness = 0.5;
    showSurface(scene);
    const Frame frame = renderScene(scene);
    const Reference reference(scene);
    for (int i = 4; i < 16; ++i) {
        const auto truth = reference.pixel(i, 9), seen = pixelOf(frame, i, 9);
        for (std::size_t c = 0; c < 4; ++c) EXPECT_NEAR(seen[c], truth[c], 0.02 * truth[c] + 2e-3) << i << " " << c;
    }
    scene.region = {6, 7, 13, 12};
    const Frame crop = renderScene(scene);
    for (int y = 7; y < 12; ++y)
        for (int x = 6; x < 13; ++x) EXPECT_EQ(pixelOf(crop, x, y), pixelOf(frame, x, y)) << x << " " << y;
}

// The left half of the picture is red, the lower right quarter green. The eye is on the side that the lamp shines to.
TEST(Backdrop, IsThePictureOfARectangle) {
    ViewScene scene = lampInHaze(AreaShape::rectangle);
    scene.volumes[0].medium.densityScale = 0;
    scene.lights.front().intensity = Rgb(1);
    Image picture = emptyImage({0, 0, 2, 2});
    for (const int red : {0, 2}) picture.rgba[std::size_t(4 * red)] = 1;
    picture.rgba[4 * 3 + 1] = 1;
    scene.lights.front().slide.emplace().image = std::make_shared<const Texture>(picture);
    showSurface(scene);
    const Frame frame = renderScene(scene);
    const auto at = [&](int x, int y) { return pixelOf(frame, 10 + x, 10 + y); };  // the middles of the quarters
    EXPECT_NEAR(at(-2, -2)[0], 1, 1e-6);
    EXPECT_NEAR(at(-2, 1)[0], 1, 1e-6);
    EXPECT_NEAR(at(1, -2)[1], 0, 1e-6);
    EXPECT_NEAR(at(1, 1)[1], 1, 1e-6);
}

TEST(SurfaceOfALight, HasItsAreaAndShinesOutwards) {
    for (const AreaShape shape : {AreaShape::rectangle, AreaShape::disk, AreaShape::sphere, AreaShape::cylinder}) {
        ViewScene scene = lampInHaze(shape);
        Light& light = scene.lights.front();
        light.wsDirection = glm::normalize(Vec3(1, 2, 3));
        const TriangleMesh mesh = surfaceOf(light);
        double area = 0;
        const bool round = shape == AreaShape::sphere || shape == AreaShape::cylinder;
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
            const Vec3 cross = mesh.cross(t);
            area += 0.5 * glm::length(cross);
            const Vec3 out = round ? mesh.middle(t) - light.wsPosition : light.wsDirection;
            EXPECT_GE(glm::dot(cross, out), 0) << static_cast<int>(shape) << " " << t;  // a disk's middle has no area
        }
        EXPECT_NEAR(area / light.area()->area(), 1, 2e-3) << static_cast<int>(shape);
    }
}

// A ball before a sky in haze that reaches behind it: at its silhouette each ray has its own part of both.
ViewScene ballBeforeSky() {
    ViewScene scene = behindHaze();
    scene.volumes[0].medium = {0.2, Rgb(0.8), Phase{0.3}, {1, 0.7, 0.5}};
    scene.lights = {sky({0.2, 0.4, 1}), distantLight(glm::normalize(Vec3(0.6, 0.2, -1)), 3)};
    scene.ambient = Rgb(0.05);
    scene.solids = std::make_shared<Solids>(std::vector{matte(ballMesh({0.3, 0.2, 4}, 5), {0.9, 0.5, 0.3})});
    scene.layers = {Layer::light, Layer::ambient, Layer::emission, Layer::transmittance, Layer::backdrop};
    scene.dials.antialias = 2;
    scene.dials.lightError = 0.03;
    scene.dials.texel = scene.dials.sheetThickness = 0.5;
    return scene;
}

TEST(Backdrop, AgreesWithBruteForceAtSilhouettes) {
    const ViewScene scene = ballBeforeSky();
    const Frame frame = renderScene(scene);
    const Reference reference(scene);
    for (int i = 0; i < 20; ++i) {
        const auto truth = reference.pixel(i, 7), seen = pixelOf(frame, i, 7);
        for (std::size_t c = 0; c < 4; ++c) EXPECT_NEAR(seen[c], truth[c], 0.012 * truth[c] + 1e-3) << i << " " << c;
    }
}

TEST(Backdrop, AddsUpToTheBeautyWithTheOtherLayers) {
    const Frame frame = renderScene(ballBeforeSky());
    std::vector<double> sum(frame.image.rgba.size() / 4 * 3, 0);
    for (const FrameLayer& layer : frame.layers)
        for (std::size_t i = 0; i < sum.size() && layer.layer != Layer::transmittance; ++i) sum[i] += layer.data[i];
    for (std::size_t i = 0; i < sum.size(); ++i) ASSERT_NEAR(sum[i], frame.image.rgba[i / 3 * 4 + i % 3], 1e-6) << i;
}

TEST(Backdrop, IsTheSameInACrop) {
    ViewScene scene = ballBeforeSky();
    const Frame whole = renderScene(scene);
    scene.picture = scene.region;
    scene.region = {5, 4, 13, 12};
    const Frame crop = renderScene(scene);
    for (int y = 4; y < 12; ++y)
        for (int x = 5; x < 13; ++x) ASSERT_EQ(pixelOf(crop, x, y), pixelOf(whole, x, y)) << x << " " << y;
}

// Nothing is splatted where no volume is seen, and yet there is a sky.
TEST(Backdrop, IsThereWithoutAnyVolume) {
    ViewScene scene = behindHaze();
    scene.volumes.clear();
    scene.lights = {sky({0.2, 0.4, 1})};
    expectPixel(renderScene(scene), {0.2, 0.4, 1}, 1, 1e-6);
}

}  // namespace
}  // namespace scrim::test
