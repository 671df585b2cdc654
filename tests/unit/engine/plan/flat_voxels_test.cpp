// SPDX-License-Identifier: Apache-2.0
// Sheets along flat voxels: which rays they serve, and what texels they take.
#include "support/fields.h"

#include <scrim/engine/plan/flat_voxels.h>
#include <scrim/engine/plan/make_plan.h>

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

// A box of 32^3 voxels with edges `edges`, turned about x by `turn` degrees, and a sun.
ViewScene boxOf(const Vec3& edges, double turn, const Vec3& sun) {
    Medium medium;
    medium.densityScale = 0.1;
    ViewScene scene = orthographicScene(boxField({-16, -16, -16}, {15, 15, 15}), medium, 40, 64);
    ViewVolume& volume = scene.volumes.front();
    volume.wsFromIs =
        glm::rotate(Mat4(1), glm::radians(turn), Vec3(1, 0, 0)) * glm::scale(Mat4(1), edges) * volume.wsFromIs;
    scene.lights = {distantLight(sun)};
    return scene;
}

const Vec3 kDown{0, 0, -1};

std::optional<FlatSheets> sheetsOf(const ViewScene& scene, const Vec3& eye, const Vec3& light) {
    return FlatVoxels(scene).sheets({glm::normalize(eye)}, {glm::normalize(light)});
}

TEST(FlatVoxels, HaveSheetsAlongThemWhereEyeAndLightCrossThem) {
    const ViewScene flat = boxOf({1, 1, 0.02}, 0, kDown);
    const auto sheets = sheetsOf(flat, {0.8, 0, -0.6}, {-0.5, 0.5, -0.5});
    ASSERT_TRUE(sheets);
    EXPECT_LT(glm::distance(sheets->wsAxis, kDown), 1e-12);
    EXPECT_TRUE(sheets->sameSide);
    EXPECT_NEAR(sheets->slant, std::acos(1 / std::sqrt(3)), 1e-9);  // the light's; the eye's is smaller

    // Their own side counts: eye and light run in opposite ways across the sheets, though not against each other.
    const auto behind = sheetsOf(flat, {0.8, 0, -0.6}, {0.9, 0, 0.4});
    ASSERT_TRUE(behind);
    EXPECT_FALSE(behind->sameSide);
    EXPECT_LT(glm::distance(behind->wsAxis, -kDown), 1e-12);

    EXPECT_FALSE(sheetsOf(flat, {1, 0, 0}, kDown)) << "an eye within the sheets";
    EXPECT_FALSE(sheetsOf(flat, kDown, {1, 0, -0.02})) << "a light within the sheets";
    EXPECT_TRUE(sheetsOf(flat, kDown, {1, 0, -0.15}));
    EXPECT_FALSE(sheetsOf(boxOf({1, 1, 0.3}, 0, kDown), kDown, {1, 0, -0.15})) << "voxels that are hardly flat";
    EXPECT_FALSE(sheetsOf(boxOf({1, 1, 1}, 0, kDown), kDown, {0, 0.3, -1}));
    EXPECT_FALSE(sheetsOf(boxOf({1, 0.02, 0.02}, 0, kDown), kDown, {0, 0.3, -1})) << "needles";
}

TEST(FlatVoxels, TakeNoMoreTexelsThanCubesWhateverTheirRatio) {
    const auto texels = [](double ratio, double turn) {
        ViewScene scene = boxOf({1, 1, 1 / ratio}, turn, {0.5, -0.4, -0.7});
        return double(makePlan(scene, 2).work.texelsShaded);
    };
    const double cubes = texels(1, 0);
    for (const double ratio : {10.0, 100.0, 1e4})
        for (const double turn : {0.0, 25.0})
            EXPECT_LT(texels(ratio, turn), 2 * cubes) << ratio << " turned by " << turn;
}

TEST(FlatVoxels, ShareOneSweepOfAllLightsOnOneSide) {
    ViewScene scene = boxOf({1, 1, 0.01}, 20, {0.9, 0, -0.6});
    for (const Vec3& sun : {Vec3(-0.9, 0, -0.6), Vec3(0, 0.9, -0.3), Vec3(0.2, -0.6, -0.6)})
        scene.lights.push_back(distantLight(sun));
    const Plan plan = makePlan(scene, 2);
    ASSERT_EQ(plan.groups.size(), 1u);
    EXPECT_EQ(plan.groups.front().lights.size(), 4u);
    EXPECT_EQ(plan.groups.front().primary, 1);
    scene.lights.push_back(distantLight({0.2, 0.3, 1}));
    EXPECT_EQ(makePlan(scene, 2).groups.size(), 2u);
}

// Cubes beside flat voxels of the same short edge need texels of that edge.
TEST(FlatVoxels, LeaveFineTexelsToCubesOfTheirLevel) {
    ViewScene scene = boxOf({1, 1, 0.1}, 0, kDown);
    const VolumeLevel alone = volumeLevels(scene).back();
    EXPECT_NEAR(edgeAcross(scene, alone, kDown), 1, 1e-12);
    EXPECT_NEAR(edgeAcross(scene, alone, glm::normalize(Vec3(0.3, 0, -1))), 0.1 * std::sqrt(1.09) / 0.3, 1e-9);
    EXPECT_NEAR(edgeAcross(scene, alone, {1, 0, 0}), 0.1, 1e-12);
    ViewVolume cubes = scene.volumes.front();
    cubes.wsFromIs = glm::scale(Mat4(1), Vec3(0.1)) * scene.volumes.front().field->wsFromIs;
    scene.volumes.push_back(cubes);
    EXPECT_NEAR(edgeAcross(scene, volumeLevels(scene).back(), kDown), 0.1, 1e-12);
}

}  // namespace
}  // namespace scrim::test
