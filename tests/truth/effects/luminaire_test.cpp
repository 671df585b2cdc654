// SPDX-License-Identifier: Apache-2.0
// Luminaires in smoke, in shadow buffers, on cells and as sources of light that scatters often, against brute force.
#include "scenes.h"
#include "support/luminaires.h"
#include "support/meshes.h"
#include "support/verified.h"

#include <scrim/engine/plan/make_plan.h>
#include <scrim/engine/plan/transport_plan.h>

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

ViewScene smokeWith(const std::string& luminaire, const Vec3& place, ShadowMethod method) {
    ViewScene scene = orthographicScene(smokeField(16), {0.15, Rgb(0.9), {0.3}}, 36, 36);
    scene.dials.texel = 0.5;
    scene.dials.sheetThickness = 0.5;
    Light light = lamp(place, 200);
    light.luminaire = luminaireOf(luminaire);
    light.wsDirection = glm::normalize(Vec3(0.3, -1, 0.2));
    light.shadow = method;
    scene.lights = {light};
    return scene;
}

// Most of the error is that of pixels beside the lamp, where it is as for a lamp without a luminaire. The picture of
// that one differs by far more.
TEST(Luminaire, InSmokeAgreesWithBruteForce) {
    for (const std::string name : {"downlight", "batwing", "wall"}) {
        ViewScene scene = smokeWith(name, {3.3, 5.2, 1.7}, ShadowMethod::automatic);
        EXPECT_EQ(planCellLights(scene).lights.size(), 1u);
        PixelSample sample = samplePixels(scene, renderScene(scene).image, 120, 7);
        const double error = summarise(sample).error;
        EXPECT_LT(error, 0.03) << name;
        scene.lights[0].luminaire.reset();
        setRendered(sample.pixels, renderScene(scene).image);
        EXPECT_GT(summarise(sample).error, 5 * error) << name;
    }
}

TEST(Luminaire, BesideSmokeAgreesWithBruteForce) {
    for (const std::string name : {"batwing", "wall"}) {
        ViewScene scene = smokeWith(name, {6, 40, 9}, ShadowMethod::automatic);
        scene.lights[0].intensity = Rgb(5000);
        EXPECT_TRUE(planCellLights(scene).lights.empty());
        EXPECT_LT(errorOf(scene, 120), 0.01) << name;
        scene.lights[0].kind = Light::Spot{{}, 30, 0.5};
        EXPECT_LT(errorOf(scene, 120), 0.015) << name << " in a spot";
    }
}

// Many lamps share cells, and each has its own only near it.
TEST(Luminaire, OfLampsThatShareCellsAgreesWithBruteForce) {
    ViewScene scene = smokeWith("wall", {3.3, 5.2, 1.7}, ShadowMethod::automatic);
    for (int i = 0; i < 5; ++i) {
        Light light = scene.lights[0];
        light.wsPosition = {2.0 * i - 4, 3.0 - i, 1.5 * i - 3};
        light.wsDirection = glm::normalize(Vec3(i - 2, -1, 1));
        scene.lights.push_back(light);
    }
    EXPECT_EQ(planCellLights(scene).lights.size(), 6u);
    EXPECT_LT(errorOf(scene, 120), 0.03);
}

// Edges of such shadows are as wide as a texel, with or without a luminaire.
TEST(Luminaire, ThrowsTheShadowsOfSolids) {
    ViewScene scene = smokeWith("batwing", {6, 40, 9}, ShadowMethod::automatic);
    scene.lights[0].intensity = Rgb(5000);
    const Frame open = renderScene(scene);
    scene.solids = oneSolid(squareMesh({4.2, 28, 6.3}, {0, 1, 0}, 2), false);
    PixelSample sample = samplePixels(scene, renderScene(scene).image, 120, 7);
    const double error = summarise(sample).error;
    setRendered(sample.pixels, open.image);
    EXPECT_GT(summarise(sample).error, 5 * error);
    scene.lights[0].luminaire.reset();
    EXPECT_LT(error, 1.2 * errorOf(scene, 120));
}

TEST(Luminaire, LightsWhatScattersOften) {
    ViewScene scene = haze(0.05);
    scene.camera.resolution = {24, 24};
    scene.region = {0, 0, 24, 24};
    scene.volumes.front().medium.scattering = Scattering::full;
    scene.volumes.front().medium.albedo = Rgb(0.9);
    Light light = lamp({0, 0, 25}, 400);
    light.luminaire = luminaireOf("wall");
    light.wsDirection = {0, 0, -1};
    light.shadow = ShadowMethod::buffers;
    scene.lights = {light};
    const BlockError e = blockError(scene, 64);
    EXPECT_LT(e.error, 0.02 + e.noise);
    EXPECT_GT(e.share, 0.1);
}

// Nothing of a downlight goes up: what hangs below the smoke needs no sweep.
TEST(Luminaire, ThatShinesPastEverythingIsCulled) {
    ViewScene scene = smokeWith("downlight", {0, -40, 0}, ShadowMethod::automatic);
    scene.lights[0].wsDirection = {0, -1, 0};
    EXPECT_NE(makePlan(scene, 1).culledLights.at(0), "");
    scene.lights[0].wsDirection = {0, 1, 0};
    EXPECT_EQ(makePlan(scene, 1).culledLights.at(0), "");
}

}  // namespace
}  // namespace scrim::test
