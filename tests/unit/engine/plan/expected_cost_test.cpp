// SPDX-License-Identifier: Apache-2.0
// What is told of pictures that take long or much memory.
#include "support/fields.h"

#include <scrim/engine/model/sub_lights.h>
#include <scrim/engine/plan/expected_cost.h>
#include <scrim/engine/plan/make_plan.h>

#include <glm/ext/matrix_transform.hpp>
#include <gtest/gtest.h>

namespace scrim::test {
namespace {

constexpr double kStart = 5e-3;  // of expectedSeconds
constexpr std::size_t kGigabyte = std::size_t{1} << 30;

ViewScene smallScene() {
    ViewScene scene = orthographicScene(boxField({-8, -8, -8}, {7, 7, 7}), Medium(), 40, 64);
    scene.lights = {distantLight({1, -0.5, -0.6})};
    return scene;
}

bool says(const std::string& text, const std::string& part) {
    return text.find(part) != text.npos;
}

TEST(ExpectedCost, OfASmallPictureIsNotTold) {
    const ViewScene scene = smallScene();
    const Plan plan = makePlan(scene, 2);
    EXPECT_GT(roughPictureSeconds(scene, plan, 2), 0);
    EXPECT_LT(roughPictureSeconds(scene, plan, 2), 1);
    EXPECT_EQ(costWarning(scene, plan, 0, 2), "");
}

// The empty space between two volumes is not counted, and neither is each volume in the sheets of the other. Shading
// at pixels, which unlike voxels need, counts three times.
TEST(ExpectedCost, OfTwoVolumesIsTheSumHoweverFarApart) {
    const auto work = [](const ViewScene& scene) { return expectedSeconds(scene, makePlan(scene, 2), 1) - kStart; };
    const ViewScene near = smallScene();
    for (const double larger : {1.0, 8.0}) {
        ViewScene far = near, both = near;
        Mat4& place = far.volumes.front().wsFromIs;
        place = glm::translate(Mat4(1), Vec3(0, 0, -2000)) * glm::scale(Mat4(1), Vec3(larger)) * place;
        both.volumes.push_back(far.volumes.front());
        const double sum = work(near) + work(far), together = work(both);
        EXPECT_GT(together, 0.7 * sum) << larger;
        EXPECT_LT(together, (larger > 1 ? 3 : 1.4) * sum) << larger;
    }
}

// Ten million cells, 256 directions, ten sweeps of 10 ns.
TEST(ExpectedCost, OfScatteredLightGrowsWithItsCells) {
    const ViewScene scene = smallScene();
    Plan plan = makePlan(scene, 2);
    plan.transport.targets.emplace_back();
    plan.transport.cells = 1e7;
    plan.transport.ordinates = 256;
    EXPECT_NEAR(roughPictureSeconds(scene, plan, 2), 128, 2);
    EXPECT_NEAR(roughPictureSeconds(scene, plan, 1), 256, 2);
    EXPECT_EQ(costWarning(scene, plan, 0, 2), "");
    plan.transport.cells = 2e8;
    const std::string text = costWarning(scene, plan, 0, 2);
    EXPECT_TRUE(says(text, "expected to take about 43 minutes")) << text;
    EXPECT_TRUE(says(text, "2e+02 million cells of scattered light")) << text;
    EXPECT_TRUE(says(text, "a larger scatter_cell or a smaller density needs fewer")) << text;
}

// A gigabyte: 4 ns a byte, and 0.05 ns for each of the dome's directions.
TEST(ExpectedCost, OfLightsOnCellsGrowsWithTheirMemoryAndDirections) {
    ViewScene scene = smallScene();
    const Plan sun = makePlan(scene, 2);
    Light dome;
    dome.kind = Light::Dome();
    dome.intensity = Rgb(1);
    dome.samples = 100;
    scene.lights.push_back(dome);
    Plan plan = sun;
    plan.cellLights.lights = {1};
    plan.cellLights.bytes = kGigabyte;
    const double more = roughPictureSeconds(scene, plan, 1) - roughPictureSeconds(scene, sun, 1);
    EXPECT_NEAR(more, double(kGigabyte) * (4e-9 + 5e-11 * subLightCount(scene, dome)), 0.01);
    EXPECT_GT(more, 8);
}

TEST(ExpectedCost, IsThatOfAllRendersThatMotionBlurAverages) {
    ViewScene scene = smallScene();
    const Plan plan = makePlan(scene, 2);
    const double one = roughPictureSeconds(scene, plan, 2);
    scene.shutter.emplace();
    scene.shutter->samples = 32;
    EXPECT_DOUBLE_EQ(roughPictureSeconds(scene, plan, 2), 32 * one);
}

TEST(ExpectedCost, TellsOfMemoryUnlessALimitIsStated) {
    ViewScene scene = smallScene();
    Plan plan = makePlan(scene, 2);
    EXPECT_EQ(costWarning(scene, plan, 3 * kGigabyte, 2), "");
    plan.bytes = 2 * kGigabyte;
    const std::string text = costWarning(scene, plan, 3 * kGigabyte, 2);
    EXPECT_TRUE(says(text, "and 5.0 GB") || says(text, "and 5 GB")) << text;
    EXPECT_TRUE(says(text, "; a coarser preset or a smaller picture takes less")) << text;
    scene.memoryLimit = 8 * kGigabyte;
    EXPECT_EQ(costWarning(scene, plan, 3 * kGigabyte, 2), "");
}

}  // namespace
}  // namespace scrim::test
