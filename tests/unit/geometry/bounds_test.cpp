// SPDX-License-Identifier: Apache-2.0
#include <scrim/geometry/bounds.h>

#include <gtest/gtest.h>

#include <random>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace scrim::test {
namespace {

TEST(Bounds, StartEmptyAndHoldWhatTheyInclude) {
    Bounds b;
    EXPECT_TRUE(b.empty());
    EXPECT_FALSE(b.contains(Vec3(0)));
    b.include(Vec3(1, 2, 3));
    EXPECT_FALSE(b.empty());
    EXPECT_TRUE(b.contains({1, 2, 3}));
    EXPECT_EQ(b.size(), Vec3(0));
    b.include(Vec3(-1, 5, 3));
    EXPECT_EQ(b.lower, Vec3(-1, 2, 3));
    EXPECT_EQ(b.upper, Vec3(1, 5, 3));
    EXPECT_EQ(b.center(), Vec3(0, 3.5, 3));
    EXPECT_TRUE(b.contains({0, 4, 3}));
    EXPECT_FALSE(b.contains({0, 4, 3.001}));
}

TEST(Bounds, IncludingAnEmptyBoxChangesNothing) {
    Bounds b{Vec3(0), Vec3(1)};
    b.include(Bounds{});
    EXPECT_EQ(b.lower, Vec3(0));
    EXPECT_EQ(b.upper, Vec3(1));
    Bounds none;
    none.include(Bounds{});
    EXPECT_TRUE(none.empty());
}

TEST(Bounds, CentreDoesNotOverflow) {
    const Bounds b{Vec3(1.6e308), Vec3(1.7e308)};
    EXPECT_LE(b.center().x, 1.7e308);
}

TEST(Bounds, CornersAreTheEightOfTheBox) {
    const Bounds b{{1, 2, 3}, {4, 6, 8}};
    Bounds of;
    for (const Vec3& c : b.corners()) {
        of.include(c);
        for (int axis = 0; axis < 3; ++axis) EXPECT_TRUE(c[axis] == b.lower[axis] || c[axis] == b.upper[axis]);
        int same = 0;
        for (const Vec3& other : b.corners()) same += other == c ? 1 : 0;
        EXPECT_EQ(same, 1);
    }
    EXPECT_EQ(of.lower, b.lower);
    EXPECT_EQ(of.upper, b.upper);
}

TEST(TransformedBounds, HoldTheImageOfEveryPoint) {
    const Bounds b{{-1, 0, 2}, {3, 1, 5}};
    std::mt19937 random(1);
    std::uniform_real_distribution<double> unit(0, 1);
    const Mat4 m = glm::translate(glm::rotate(Mat4(1.0), 1.1, glm::normalize(Vec3(1, -2, 3))), Vec3(5, 6, 7)) *
                   glm::scale(Mat4(1.0), Vec3(2, -1, 0.5));
    const Bounds image = transformed(m, b);
    for (int i = 0; i < 500; ++i)
        EXPECT_TRUE(
            image.contains(transformPoint(m, b.lower + b.size() * Vec3(unit(random), unit(random), unit(random)))));
    EXPECT_TRUE(transformed(m, Bounds{}).empty());
}

TEST(Bounds, ClipRaysToWhatLiesWithin) {
    const Bounds box{{-1, 0, 2}, {3, 1, 5}};
    std::mt19937 random(2);
    std::uniform_real_distribution<double> unit(-1, 1);
    int met = 0;
    for (int i = 0; i < 400; ++i) {
        const Vec3 origin = box.center() + 2.5 * Vec3(unit(random), unit(random), unit(random));
        Vec3 direction(unit(random), unit(random), unit(random));
        for (int axis = 0; axis < 3; ++axis)
            if (i >> axis & 1) direction[axis] = 0;
        const auto [first, last] = box.clip(origin, direction, 0, 9);
        met += first <= last;
        for (int k = 0; k <= 300; ++k) {
            const double t = 9 * k / 300.0;
            EXPECT_EQ(box.contains(origin + t * direction), t >= first && t <= last) << i << " " << t;
        }
    }
    EXPECT_GT(met, 50);
    EXPECT_LT(met, 350);
}

TEST(TransformVector, LeavesTheTranslationOut) {
    const Mat4 m = glm::translate(Mat4(2.0), Vec3(5, 6, 7));
    EXPECT_EQ(transformVector(m, {1, 2, 3}), Vec3(2, 4, 6));
    EXPECT_EQ(transformPoint(m, {1, 2, 3}), Vec3(12, 16, 20));
}

}  // namespace
}  // namespace scrim::test
