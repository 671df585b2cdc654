// SPDX-License-Identifier: Apache-2.0
// Falloff, cones and phase functions, on media so thin that nothing is attenuated.
#include "support/fields.h"

#include <scrim/geometry/camera.h>
#include <scrim/scene/medium.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

const double kPi = std::acos(-1.0);

constexpr double kExtinction = 1e-6;

// A layer of smoke, 16 voxels thick around z = -1/2, seen along -z: brightness is irradiance, summed over depth.
ViewScene thinLayer() {
    Medium medium;
    medium.densityScale = kExtinction;
    medium.albedo = Rgb(1);
    return orthographicScene(boxField({-48, -48, -8}, {47, 47, 7}), medium, 60, 60);
}

// Brightness of pixel (x, y) where irradiance depends on position.
template <class Irradiance>
double layerBrightness(int x, int y, const Irradiance& irradiance) {
    double sum = 0;
    for (int i = 0; i < 160; ++i) {
        const Vec3 p(x + 0.5 - 30, 30 - y - 0.5, -8.5 + (i + 0.5) / 10);
        sum += 0.1 * kExtinction * irradiance(p) / (4 * kPi);
    }
    return sum;
}

TEST(PointLight, FallsOffWithTheSquareOfDistance) {
    ViewScene scene = thinLayer();
    Light light;
    light.name = "bulb";
    light.kind = Light::Point{};
    light.wsPosition = {5, -3, 80};
    light.intensity = Rgb(1e6);
    scene.lights.push_back(light);
    const Frame frame = renderScene(scene);
    for (const auto& [x, y] : {std::pair{30, 30}, {5, 5}, {50, 12}, {35, 33}}) {
        const double expected = layerBrightness(
            x, y, [&](const Vec3& p) { return 1e6 / glm::dot(p - light.wsPosition, p - light.wsPosition); });
        EXPECT_NEAR(pixelOf(frame, x, y)[0], expected, 5e-3 * expected) << x << "," << y;
    }
}

TEST(PointLight, WithoutDecayIsAsBrightEverywhere) {
    ViewScene scene = thinLayer();
    Light light;
    light.kind = Light::Point{};
    light.wsPosition = {5, -3, 80};
    light.intensity = Rgb(1e6);
    light.point().decay = false;
    scene.lights.push_back(light);
    const Frame frame = renderScene(scene);
    EXPECT_NEAR(pixelOf(frame, 5, 5)[0], pixelOf(frame, 50, 40)[0], 5e-3 * pixelOf(frame, 5, 5)[0]);
}

TEST(PointLight, IsNoBrighterThanAtItsRadius) {
    ViewScene scene = thinLayer();
    Light light;
    light.kind = Light::Point{};
    light.wsPosition = {0, 0, 120};
    light.point().radius = 200;
    light.intensity = Rgb(1e6);
    scene.lights.push_back(light);
    const double expected = 1e6 / (200 * 200) * 16 * kExtinction / (4 * kPi);
    EXPECT_NEAR(pixelOf(renderScene(scene), 30, 30)[0], expected, 5e-3 * expected);
}

TEST(SpotLight, LightsItsConeOnlyAndFadesOverItsBlend) {
    ViewScene scene = thinLayer();
    Light light;
    light.kind = Light::Spot{};
    light.wsPosition = {0, 0, 99.5};
    light.wsDirection = {0, 0, -1};
    std::get<Light::Spot>(light.kind).coneAngle = 24;
    std::get<Light::Spot>(light.kind).blend = 0.5;
    light.point().decay = false;
    light.intensity = Rgb(1);
    scene.lights.push_back(light);
    const Frame frame = renderScene(scene);
    // Smooth in the cosine between the inner angle of 6 degrees and the outer of 12.
    const double outer = std::cos(12 * kPi / 180), inner = std::cos(6 * kPi / 180);
    const double full = layerBrightness(30, 30, [](const Vec3&) { return 1.0; });
    for (int x = 30; x < 60; ++x) {
        const double expected = layerBrightness(x, 30, [&](const Vec3& p) {
            const double cosine = glm::normalize(p - light.wsPosition).z * -1;
            const double t = std::clamp((cosine - outer) / (inner - outer), 0.0, 1.0);
            return t * t * (3 - 2 * t);
        });
        EXPECT_NEAR(pixelOf(frame, x, 30)[0], expected, 5e-3 * full) << "pixel " << x;
    }
    EXPECT_EQ(pixelOf(frame, 58, 30)[0], 0);
}

TEST(HenyeyGreenstein, IntegratesToOneOverTheSphere) {
    for (const double g : {-0.9, -0.3, 0.0, 0.5, 0.95}) {
        double sum = 0;
        const int steps = 200000;
        for (int i = 0; i < steps; ++i) {
            const double cosine = -1 + 2 * (i + 0.5) / steps;
            sum += 2 * kPi * phaseValue({g}, cosine) * 2 / steps;
        }
        EXPECT_NEAR(sum, 1, 1e-4) << "g = " << g;
    }
}

TEST(HenyeyGreenstein, ScattersForwardIntoAnEyeThatFacesTheLight) {
    for (const Vec3& direction : {Vec3(0, 0, 1), Vec3(0, 0, -1), Vec3(1, 0, 0), Vec3(1, 2, 0.5)}) {
        ViewScene scene = thinLayer();
        scene.volumes[0].medium.phase.g = 0.6;
        scene.lights.push_back(distantLight(direction, 1e6));
        scene.lights[0].shadows = false;
        // Light leaves towards the eye along +z.
        const double expected = 1e6 * 16 * kExtinction * phaseValue({0.6}, glm::normalize(direction).z);
        // The faces of the layer are sharp and cross the sheets at up to 50 degrees: 1 % of resampling.
        EXPECT_NEAR(pixelOf(renderScene(scene), 30, 30)[0], expected, 1e-2 * expected);
    }
}

}  // namespace
}  // namespace scrim::test
