// SPDX-License-Identifier: Apache-2.0
// Falloff, cones and phase functions, on media so thin that nothing is attenuated.
#include "support/fields.h"
#include "support/luminaires.h"

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

// The file's intensity is the cosine of the angle to the axis, to 0.1 %.
TEST(Luminaire, OfTheCosineLawLightsAsItsCosine) {
    ViewScene scene = thinLayer();
    Light light;
    light.kind = Light::Point{};
    light.wsPosition = {12, -4, 25};
    light.wsDirection = glm::normalize(Vec3(-0.4, 0.1, -1));
    light.intensity = Rgb(1e6);
    light.luminaire = luminaireOf("downlight");
    scene.lights.push_back(light);
    const Frame frame = renderScene(scene);
    double most = 0;
    const auto expected = [&](int x, int y) {
        return layerBrightness(x, y, [&](const Vec3& p) {
            const Vec3 way = p - light.wsPosition;
            const double r2 = glm::dot(way, way);
            return 1e6 * std::max(glm::dot(way, light.wsDirection), 0.0) / (r2 * std::sqrt(r2));
        });
    };
    for (int i = 0; i < 3600; ++i) most = std::max(most, expected(i % 60, i / 60));
    for (int y = 2; y < 60; y += 7)
        for (int x = 1; x < 60; x += 7)
            EXPECT_NEAR(pixelOf(frame, x, y)[0], expected(x, y), 5e-3 * most) << x << "," << y;
}

// The profile itself, around the axis as `up` turns it. The file's angles are 10 and 30 degrees apart, so that straight
// lines between them are up to 4 % of the largest value from the law.
TEST(Luminaire, TurnsWithTheUpOfItsLight) {
    ViewScene scene = thinLayer();
    Light light;
    light.kind = Light::Spot{};
    std::get<Light::Spot>(light.kind).coneAngle = 120;
    std::get<Light::Spot>(light.kind).blend = 0;
    light.wsPosition = {0, 0, 35.5};
    light.wsDirection = {0, 0, -1};
    light.point().decay = false;
    light.luminaire = luminaireOf("wall");
    for (const Vec3& up : {Vec3(0, 1, 0), Vec3(1, 0, 0), Vec3(-1, -1, 0)}) {
        light.wsUp = up;
        scene.lights = {light};
        const Frame frame = renderScene(scene);
        // A viewer at the layer who looks at the lamp, along +z, has `up` x (-z) on his right.
        const Vec3 right = glm::normalize(glm::cross(up, Vec3(0, 0, -1)));
        const double full = layerBrightness(30, 30, [](const Vec3&) { return 1.0; });
        for (int y = 4; y < 60; y += 13)
            for (int x = 4; x < 60; x += 13) {
                const double expected = layerBrightness(x, y, [&](const Vec3& p) {
                    const Vec3 way = glm::normalize(p - light.wsPosition);
                    const double t = 40 * kPi / 180;
                    const double along = glm::dot(way, right) * std::sin(t) - way.z * std::cos(t);
                    return std::pow(std::max(along, 0.0), 3);
                });
                EXPECT_NEAR(pixelOf(frame, x, y)[0], expected, 0.05 * full) << x << "," << y;
            }
    }
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
