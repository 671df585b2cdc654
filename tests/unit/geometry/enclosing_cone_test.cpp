// SPDX-License-Identifier: Apache-2.0
#include <scrim/geometry/enclosing_cone.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

class Random {
  public:
    explicit Random(unsigned seed) : m_engine(seed) {}
    double normal() { return std::normal_distribution<double>()(m_engine); }
    std::mt19937& engine() { return m_engine; }
    /// Directions within about `spread` of a random axis; in [0, pi] by eye.
    std::vector<Vec3> directions(int count, double spread) {
        const Vec3 axis = glm::normalize(Vec3(normal(), normal(), normal()));
        std::vector<Vec3> out;
        for (int i = 0; i < count; ++i)
            out.push_back(glm::normalize(axis + spread * Vec3(normal(), normal(), normal())));
        return out;
    }

  private:
    std::mt19937 m_engine;
};

double narrowestCosine(const std::vector<Vec3>& directions, const Vec3& axis) {
    double least = 1;
    for (const Vec3& d : directions) least = std::min(least, glm::dot(axis, d));
    return least;
}

// The best cone that two or three of the directions fix: one of them is the smallest.
double bruteForceCosine(const std::vector<Vec3>& d) {
    double best = -1;
    const auto offer = [&](const Vec3& axis) {
        if (const double length = glm::length(axis); length > 1e-12)
            for (const double side : {1.0, -1.0}) best = std::max(best, narrowestCosine(d, side / length * axis));
    };
    for (std::size_t i = 0; i < d.size(); ++i) {
        offer(d[i]);
        for (std::size_t j = 0; j < i; ++j) {
            offer(d[i] + d[j]);
            for (std::size_t k = 0; k < j; ++k) offer(glm::cross(d[j] - d[i], d[k] - d[i]));
        }
    }
    return best;
}

TEST(EnclosingCone, OfOneDirectionIsThatDirection) {
    const Cone cone = enclosingCone({Vec3(0, 0.6, 0.8)});
    EXPECT_EQ(cone.axis, Vec3(0, 0.6, 0.8));
    EXPECT_EQ(cone.cosAngle, 1);
}

// ZC02 section 6: between two directions lies the half-way vector.
TEST(EnclosingCone, OfTwoDirectionsIsTheHalfWayVector) {
    Random random(1);
    for (int i = 0; i < 200; ++i) {
        const std::vector<Vec3> two = random.directions(2, 2);
        const Cone cone = enclosingCone(two);
        const Vec3 halfWay = glm::normalize(two[0] + two[1]);
        EXPECT_LT(glm::distance(cone.axis, halfWay), 1e-9);
        EXPECT_NEAR(cone.cosAngle, glm::dot(halfWay, two[0]), 1e-9);
    }
}

TEST(EnclosingCone, HoldsAllDirectionsAndIsTheNarrowest) {
    Random random(2);
    int wide = 0;
    for (int i = 0; i < 400; ++i) {
        const std::vector<Vec3> d = random.directions(3 + i % 9, 0.02 + 0.004 * i);
        const Cone cone = enclosingCone(d);
        const double best = bruteForceCosine(d);
        if (best <= 0) {
            ++wide;
            EXPECT_LE(cone.cosAngle, 1e-9) << "set " << i;
            continue;
        }
        EXPECT_NEAR(glm::length(cone.axis), 1, 1e-12);
        EXPECT_NEAR(narrowestCosine(d, cone.axis), cone.cosAngle, 1e-9) << "set " << i;
        EXPECT_NEAR(cone.cosAngle, best, 1e-9) << "set " << i;
    }
    EXPECT_GT(wide, 20);  // the draw met both kinds
    EXPECT_LT(wide, 200);
}

TEST(EnclosingCone, DoesNotHangOnTheOrder) {
    Random random(3);
    for (int i = 0; i < 50; ++i) {
        std::vector<Vec3> d = random.directions(12, 0.4);
        const Cone expected = enclosingCone(d);
        for (int k = 0; k < 10; ++k) {
            std::shuffle(d.begin(), d.end(), random.engine());
            const Cone cone = enclosingCone(d);
            EXPECT_EQ(cone.axis, expected.axis);  // sorted inside: the very same bits
            EXPECT_EQ(cone.cosAngle, expected.cosAngle);
        }
    }
}

TEST(EnclosingCone, IsNotMovedByDirectionsInsideOrTwice) {
    Random random(4);
    for (int i = 0; i < 50; ++i) {
        std::vector<Vec3> d = random.directions(5, 0.3);
        const Cone expected = enclosingCone(d);
        d.push_back(expected.axis);
        d.push_back(d[2]);
        d.push_back(glm::normalize(d[2] + Vec3(1e-15, 0, 0)));
        const Cone cone = enclosingCone(d);
        EXPECT_LT(glm::distance(cone.axis, expected.axis), 1e-7);
        EXPECT_NEAR(cone.cosAngle, expected.cosAngle, 1e-9);
    }
}

TEST(EnclosingCone, OfMoreThanAHemisphereIsNone) {
    EXPECT_LE(enclosingCone({Vec3(1, 0, 0), Vec3(-1, 0, 0)}).cosAngle, 0);
    EXPECT_LE(enclosingCone({Vec3(1, 0, 0), Vec3(-0.6, 0.8, 0), Vec3(-0.6, -0.8, 0)}).cosAngle, 1e-12);
    EXPECT_LE(enclosingCone({Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(-1, 0, 0), Vec3(0, -1, 0)}).cosAngle, 0);
}

// Grown by some directions at a time: as if all had been there at once, and what is too wide is told to be.
TEST(GrowingCone, IsTheConeOfAll) {
    Random random(5);
    int wider = 0;
    for (int i = 0; i < 100; ++i) {
        std::vector<Vec3> all = random.directions(3, 0.02 + 0.005 * i);
        GrowingCone growing(all);
        for (int step = 0; step < 20; ++step) {
            const std::vector<Vec3> more = random.directions(1 + step % 5, 0.1);
            std::vector<Vec3> together = all;
            together.insert(together.end(), more.begin(), more.end());
            const Cone expected = enclosingCone(together);
            const Cone with = growing.with(more, 0.3);
            if (expected.cosAngle < 0.3) {
                EXPECT_LT(with.cosAngle, 0.3);
                ++wider;
                continue;
            }
            EXPECT_NEAR(with.cosAngle, expected.cosAngle, 1e-9);
            EXPECT_LT(glm::distance(with.axis, expected.axis), 1e-6);
            growing.add(more);
            all = together;
            EXPECT_NEAR(growing.cone().cosAngle, expected.cosAngle, 1e-9);
        }
    }
    EXPECT_GT(wider, 100);
}

// Rims of cones, as lights and eyes of known opening give them; near 0 and near 90 degrees.
TEST(EnclosingCone, OfARimIsItsCone) {
    for (const double angle : {1e-6, 0.01, 0.5, 1.0, 1.5, 1.57}) {
        std::vector<Vec3> rim;
        for (int i = 0; i < 24; ++i) {
            const double t = i * 0.2618;
            rim.push_back({std::sin(angle) * std::cos(t), std::sin(angle) * std::sin(t), std::cos(angle)});
        }
        const Cone cone = enclosingCone(rim);
        EXPECT_NEAR(cone.cosAngle, std::cos(angle), 1e-9) << angle;
        EXPECT_LT(glm::distance(cone.axis, Vec3(0, 0, 1)), 1e-6) << angle;
    }
}

// Of thousands of directions the corners of their hull alone are looked at. The smallest cone is fixed by directions
// that it touches: brute force over those that are next to its rim finds none that is narrower.
TEST(EnclosingCone, OfThousandsHoldsAllAndIsTheSmallest) {
    Random random(7);
    for (const double spread : {1e-4, 0.1, 0.25}) {
        std::vector<Vec3> all = random.directions(6000, spread);
        for (int i = 0; i < 500; ++i) all.push_back(all[std::size_t(i)]);
        const Cone cone = enclosingCone(all);
        GrowingCone growing({all.front()});
        for (std::size_t i = 1; i < all.size(); i += 8)
            growing.add({all.begin() + static_cast<std::ptrdiff_t>(i),
                         all.begin() + static_cast<std::ptrdiff_t>(std::min(i + 8, all.size()))});
        EXPECT_GE(narrowestCosine(all, cone.axis), cone.cosAngle - 1e-12);
        EXPECT_NEAR(growing.cone().cosAngle, cone.cosAngle, 1e-12);
        std::sort(all.begin(), all.end(),
                  [&](const Vec3& a, const Vec3& b) { return glm::dot(cone.axis, a) < glm::dot(cone.axis, b); });
        all.resize(40);
        EXPECT_NEAR(cone.cosAngle, bruteForceCosine(all), 1e-12);
    }
}

}  // namespace
}  // namespace scrim::test
