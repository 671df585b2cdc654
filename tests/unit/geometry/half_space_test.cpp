// SPDX-License-Identifier: Apache-2.0
#include <scrim/geometry/half_space.h>

#include <gtest/gtest.h>

#include <random>

#include <glm/gtc/matrix_transform.hpp>

namespace scrim::test {
namespace {

TEST(HalfSpace, GoesWithThePointsItHolds) {
    const HalfSpace space{glm::normalize(Vec3(1, 2, -3)), 0.7};
    Mat4 m = glm::rotate(Mat4(1.0), 0.6, Vec3(3, 1, 2));
    m = glm::translate(m, Vec3(4, 5, 6)) * glm::scale(Mat4(1.0), Vec3(2));
    const HalfSpace moved = transformed(space, glm::inverse(m));
    EXPECT_NEAR(glm::length(moved.normal), 1, 1e-12);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> any(-9, 9);
    for (int i = 0; i < 50; ++i) {
        const Vec3 p(any(random), any(random), any(random));
        EXPECT_NEAR(moved.depth(transformPoint(m, p)), 2 * space.depth(p), 1e-9);
    }
}

TEST(HalfSpace, DepthInSeveralIsThatOfTheNearestFace) {
    const std::vector<HalfSpace> spaces{{{1, 0, 0}, 0}, {{0, 1, 0}, 2}};
    EXPECT_EQ(depthIn(spaces, {1, 5, 0}), 1);
    EXPECT_EQ(depthIn(spaces, {1, -5, 0}), -3);
    EXPECT_GT(depthIn({}, {0, 0, 0}), 1e300);
}

TEST(HalfSpace, PartOfACellIsExactAlongItsAxes) {
    const Mat3 edges(2, 0, 0, 0, 3, 0, 0, 0, 4);
    const std::vector<HalfSpace> space{{{0, 0, 1}, 0}};  // z >= 0
    EXPECT_EQ(partIn(space, {0, 0, 9}, edges), 1);
    EXPECT_EQ(partIn(space, {0, 0, -2}, edges), 0);
    EXPECT_EQ(partIn(space, {0, 0, 1}, edges), 0.75);
    EXPECT_EQ(partIn({}, {0, 0, -2}, edges), 1);
}

TEST(HalfSpace, FacesAddTheirNormalWithinReach) {
    const std::vector<HalfSpace> spaces{{{1, 0, 0}, 0}, {{0, 1, 0}, 0}};
    EXPECT_EQ(facing(spaces, {0.25, 0.5, 7}, 1), Vec3(0.75, 0.5, 0));
    EXPECT_EQ(facing(spaces, {3, 0, 7}, 2), Vec3(0, 1, 0));
}

}  // namespace
}  // namespace scrim::test
