// SPDX-License-Identifier: Apache-2.0
#include "support/fields.h"

#include <scrim/engine/plan/levels.h>
#include <scrim/engine/plan/make_plan.h>

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace scrim::test {
namespace {

ViewScene withVoxels(const std::vector<double>& voxels) {
    ViewScene scene = orthographicScene(boxField({0, 0, 0}, {7, 7, 7}, voxels.front()), Medium(), 20, 16);
    for (std::size_t i = 1; i < voxels.size(); ++i) {
        ViewVolume& volume = scene.volumes.emplace_back(scene.volumes.front());
        volume.field = boxField({0, 0, 0}, {7, 7, 7}, voxels[i]);
        volume.wsFromIs = volume.field->wsFromIs;
    }
    return scene;
}

TEST(VolumeLevels, ShareSheetsAmongLikeVoxels) {
    EXPECT_EQ(volumeLevels(withVoxels({1, 1.9, 1})).size(), 1u);
    EXPECT_EQ(volumeLevels(withVoxels({0.7})).size(), 1u);
}

TEST(VolumeLevels, HaveStepsOfPowersOfTwoCoarsestFirst) {
    const ViewScene scene = withVoxels({0.1, 0.5, 20, 0.15});
    const std::vector<VolumeLevel> levels = volumeLevels(scene);
    ASSERT_GE(levels.size(), 3u);
    std::vector<int> found(scene.volumes.size());
    for (std::size_t i = 0; i < levels.size(); ++i) {
        if (i > 0) {
            const double step = levels[i - 1].voxel / levels[i].voxel;
            EXPECT_EQ(step, std::exp2(std::round(std::log2(step))));
            EXPECT_GE(step, 2);
            EXPECT_LE(step, 8);
        }
        for (std::size_t v = 0; v < found.size(); ++v) found[v] += levels[i].volumes[v] ? 1 : 0;
    }
    EXPECT_EQ(found, std::vector<int>(found.size(), 1));  // each volume in one level
    EXPECT_EQ(levels.back().voxel, 0.1);
    EXPECT_EQ(levels.back().volumes, (std::vector<bool>{true, false, false, true}));
    EXPECT_EQ(levels.front().volumes, (std::vector<bool>{false, false, true, false}));
    EXPECT_LE(levels.front().voxel, 20);
    EXPECT_GT(levels.front().voxel, 10);
}

TEST(VolumeLevels, AreOneWhereALatticeMustBe) {
    ViewScene scene = withVoxels({0.1, 10});
    EXPECT_GT(volumeLevels(scene).size(), 1u);
    scene.deep = ViewDeep{0.001};
    EXPECT_GT(volumeLevels(scene).size(), 1u);
    scene.dials.splat = SplatMode::perView;
    EXPECT_EQ(volumeLevels(scene).size(), 1u);
}

// Surfaces are found along rays from sheet to sheet, so nothing has finer sheets than they have.
TEST(VolumeLevels, HaveAllSurfacesInTheFinest) {
    ViewScene scene = withVoxels({0.1, 1, 10});
    scene.volumes[1].classified = std::make_shared<const Classified>();
    const std::vector<VolumeLevel> levels = volumeLevels(scene);
    EXPECT_EQ(levels.back().volumes, (std::vector<bool>{true, true, false}));
    EXPECT_EQ(levels.back().voxel, 0.1);
    scene.volumes[2].classified = scene.volumes[1].classified;
    EXPECT_EQ(volumeLevels(scene).size(), 1u);
}

// A sheet of one level consists of whole sheets of the next.
TEST(VolumeLevels, HaveSheetsThatEndTogether) {
    ViewScene scene = withVoxels({0.1, 0.5, 20});
    scene.lights.push_back(distantLight({-1, -0.5, -0.3}));
    const Plan plan = makePlan(scene, 1);
    for (const GroupPlan& group : plan.groups) {
        ASSERT_FALSE(group.finer.empty());
        for (const GroupPlan& level : group.finer) {
            const double step = group.sheets.thickness / level.sheets.thickness;
            EXPECT_NEAR(step, std::round(step), 1e-9);
            const double first = (group.sheets.ssOrigin.z - level.sheets.ssOrigin.z) / level.sheets.thickness;
            EXPECT_NEAR(first, std::round(first), 1e-6);
            EXPECT_EQ(group.sheets.wsAnchor, level.sheets.wsAnchor);
            EXPECT_EQ(group.lights.size(), level.lights.size());
        }
    }
}

}  // namespace
}  // namespace scrim::test
