// SPDX-License-Identifier: Apache-2.0
#include "support/fields.h"

#include <scrim/scene/light_at.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace scrim::test {
namespace {

Vec3 offAxis(double degrees) {
    return {std::sin(glm::radians(degrees)), 0, -std::cos(glm::radians(degrees))};
}

TEST(LightAt, OfADistantLightIsTheSameEverywhere) {
    const Light sun = distantLight({1, -2, 2}, 3);
    const LightAt at(sun);
    for (const Vec3& ws : {Vec3(0), Vec3(1e6, -5, 7)}) {
        const Arriving in = at.at(ws);
        EXPECT_EQ(in.irradiance, Rgb(3));
        EXPECT_NEAR(glm::distance(in.travel, Vec3(1, -2, 2) / 3.0), 0, 1e-15);
        EXPECT_EQ(in.distance, std::numeric_limits<double>::infinity());
    }
}

// intensity / max(r^2, radius^2), whichever radius is the larger; without decay the intensity itself.
TEST(LightAt, OfAPointFallsOffAsItsRadiusSays) {
    Light light = lamp({1, 2, 3}, 8, 0.5);
    const Vec3 far(1, 2, 7), near(1, 2.25, 3);
    EXPECT_NEAR(LightAt(light).at(far).irradiance.x, 8.0 / 16, 1e-15);
    EXPECT_NEAR(LightAt(light).at(near).irradiance.x, 8 / 0.25, 1e-12);
    EXPECT_NEAR(LightAt(light, 2).at(near).irradiance.x, 8.0 / 4, 1e-15);
    EXPECT_EQ(LightAt(light).at(far).travel, Vec3(0, 0, 1));
    EXPECT_EQ(LightAt(light).at(far).distance, 4);
    light.point().decay = false;
    EXPECT_EQ(LightAt(light).at(far).irradiance.x, 8);
}

// Where a point without a radius stands no irradiance can be named.
TEST(LightAt, OfAPointIsFiniteWhereItStands) {
    const Light point = lamp({1, 2, 3}, 8), ball = lamp({1, 2, 3}, 8, 0.5);
    EXPECT_EQ(LightAt(point).at({1, 2, 3}).irradiance, Rgb(0));
    EXPECT_NEAR(LightAt(ball).at({1, 2, 3}).irradiance.x, 8 / 0.25, 1e-12);
}

TEST(LightAt, OfASpotFadesFromItsBlendToItsCone) {
    Light light = lamp(Vec3(0), 1);
    light.kind = Light::Spot{{}, 60, 0.5};  // dark at 30 degrees, fading from 15
    light.wsDirection = {0, 0, -1};
    const LightAt at(light);
    const double outer = std::cos(glm::radians(30.0)), inner = std::cos(glm::radians(15.0));
    for (const double degrees : {0.0, 14.9, 16.0, 22.0, 29.0, 30.1, 90.0, 180.0}) {
        const double t = (std::cos(glm::radians(degrees)) - outer) / (inner - outer);
        const double expected = t <= 0 ? 0 : t >= 1 ? 1 : t * t * (3 - 2 * t);
        EXPECT_NEAR(at.at(offAxis(degrees)).irradiance.x, expected, 1e-12) << degrees;
    }
}

// A cone without a blend is as good as sharp, and no number divided by zero.
TEST(LightAt, OfASpotWithoutABlendHasASharpEdge) {
    Light light = lamp(Vec3(0), 1);
    light.kind = Light::Spot{{}, 60, 0};
    const LightAt at(light);
    EXPECT_NEAR(at.at(offAxis(29.99)).irradiance.x, 1, 1e-12);
    EXPECT_EQ(at.at(offAxis(30.01)).irradiance.x, 0);
}

TEST(LightAt, OfAnElementFollowsTheCosineToItsFront) {
    Light light = lamp(Vec3(0), 1);
    light.kind = Light::Element{};
    const LightAt at(light);
    for (const double degrees : {0.0, 40.0, 80.0})
        EXPECT_NEAR(at.at(offAxis(degrees)).irradiance.x, std::cos(glm::radians(degrees)), 1e-12);
    EXPECT_EQ(at.at(offAxis(120)).irradiance.x, 0);
}

}  // namespace
}  // namespace scrim::test
