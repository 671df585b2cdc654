// SPDX-License-Identifier: Apache-2.0
// Axes and groups against the paper's half-way vector and against brute force.
#include "support/expect_error.h"
#include "support/fields.h"
#include "support/slides.h"

#include <scrim/geometry/camera.h>
#include <scrim/engine/plan/light_groups.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

const double kPi = std::acos(-1.0);

// A small box of fog at the origin, seen from somewhere on +z.
ViewScene fogScene(CameraType type) {
    Medium medium;
    ViewScene scene = orthographicScene(boxField({-8, -8, -8}, {7, 7, 7}), medium, 40, 64);
    scene.camera.type = type;
    scene.camera.fov = 35;
    scene.camera.wsPosition = {0, 0, 60};
    scene.dials.crossFade = 0;
    return scene;
}

std::vector<GroupPlan> groupsOf(const ViewScene& scene) {
    return groupLights(scene, subLights(scene), wsCorners(scene), eyeParts(scene, wsCorners(scene)).front());
}

Light pointLight(const Vec3& position) {
    Light light;
    light.name = "bulb";
    light.kind = Light::Point{};
    light.wsPosition = position;
    return light;
}

double angle(const Vec3& a, const Vec3& b) {
    return std::acos(std::clamp(glm::dot(glm::normalize(a), glm::normalize(b)), -1.0, 1.0));
}

void expectSame(const Vec3& a, const Vec3& b, double tolerance) {
    EXPECT_LT(glm::distance(a, b), tolerance)
        << a.x << "," << a.y << "," << a.z << " and " << b.x << "," << b.y << "," << b.z;
}

// The largest angle between the axis and any ray of the group, the eye's turned where it looks against the lights.
double worstSlant(const ViewScene& scene, const GroupPlan& group) {
    double worst = 0;
    const std::vector<EyePart> eye = eyeParts(scene, wsCorners(scene));
    for (const Vec3& d : eye.front().wsDirections)
        worst = std::max(worst, angle(group.sameSide ? d : -d, group.wsAxis));
    for (const PlannedLight& part : group.lights)
        for (const Vec3& d : part.wsDirections) worst = std::max(worst, angle(d, group.wsAxis));
    return worst;
}

class Random {
  public:
    explicit Random(unsigned seed) : m_engine(seed) {}
    double in(double lower, double upper) { return std::uniform_real_distribution<double>(lower, upper)(m_engine); }
    Vec3 direction() {
        for (;;) {
            const Vec3 p(in(-1, 1), in(-1, 1), in(-1, 1));
            if (const double r = glm::length(p); r > 0.1 && r < 1) return p / r;
        }
    }
    std::mt19937& engine() { return m_engine; }

  private:
    std::mt19937 m_engine;
};

// ZC02 section 6: w = normalize(l + s d).
TEST(Axis, OfOneParallelLightIsTheHalfWayVector) {
    Random random(1);
    for (int i = 0; i < 300; ++i) {
        ViewScene scene = fogScene(CameraType::orthographic);
        const Vec3 l = random.direction(), d(0, 0, -1);
        scene.lights.push_back(distantLight(l));
        const std::vector<GroupPlan> groups = groupsOf(scene);
        ASSERT_EQ(groups.size(), 1u);
        const double s = glm::dot(l, d) >= 0 ? 1 : -1;
        EXPECT_EQ(groups[0].sameSide, s > 0);
        expectSame(groups[0].wsAxis, glm::normalize(l + s * d), 1e-9);
        EXPECT_NEAR(groups[0].slant, angle(l, s * d) / 2, 1e-7);
    }
}

TEST(Axis, OfALightAlongTheViewIsTheView) {
    ViewScene scene = fogScene(CameraType::orthographic);
    scene.lights.push_back(distantLight({0, 0, -1}));
    const GroupPlan group = groupsOf(scene).at(0);
    EXPECT_TRUE(group.sameSide);
    expectSame(group.wsAxis, {0, 0, -1}, 1e-12);
    EXPECT_NEAR(group.slant, 0, 1e-7);
}

// A light behind the volume that faces the eye: s = -1 and w = -d.
TEST(Axis, OfALightThatFacesTheEyeIsTheLights) {
    ViewScene scene = fogScene(CameraType::orthographic);
    scene.lights.push_back(distantLight({0, 0, 1}));
    const GroupPlan group = groupsOf(scene).at(0);
    EXPECT_FALSE(group.sameSide);
    expectSame(group.wsAxis, {0, 0, 1}, 1e-12);
    EXPECT_NEAR(group.slant, 0, 1e-7);
}

// l . d = 0, also where rounding has it fall on either side of 0: the side must not flicker.
TEST(Axis, OfAPerpendicularLightLeansFortyFiveDegrees) {
    for (const double off : {0.0, 1e-16, -1e-16, 1e-12, -1e-12}) {
        ViewScene scene = fogScene(CameraType::orthographic);
        scene.lights.push_back(distantLight({1, 0, off}));
        const GroupPlan group = groupsOf(scene).at(0);
        EXPECT_TRUE(group.sameSide) << off;
        expectSame(group.wsAxis, glm::normalize(Vec3(1, 0, -1)), 1e-9);
        EXPECT_NEAR(group.slant, kPi / 4, 1e-9);
    }
}

TEST(Axis, WithoutLightsIsTheView) {
    const GroupPlan parallel = groupsOf(fogScene(CameraType::orthographic)).at(0);
    EXPECT_TRUE(parallel.lights.empty());
    EXPECT_TRUE(parallel.sameSide);
    expectSame(parallel.wsAxis, {0, 0, -1}, 1e-12);
    // In perspective the middle of the rays that meet the volume.
    ViewScene scene = fogScene(CameraType::perspective);
    const std::vector<GroupPlan> groups = groupsOf(scene);
    ASSERT_EQ(groups.size(), 1u);
    expectSame(groups[0].wsAxis, glm::normalize(Vec3(-0.5, -0.5, -60)), 0.02);
    EXPECT_NEAR(groups[0].slant, worstSlant(scene, groups[0]), 1e-7);
}

TEST(Groups, OfOppositeLightsAreTwo) {
    ViewScene scene = fogScene(CameraType::perspective);
    scene.lights = {distantLight({0.2, 0.1, -1}), distantLight({-0.1, 0.3, 1})};
    const std::vector<GroupPlan> groups = groupsOf(scene);
    ASSERT_EQ(groups.size(), 2u);
    EXPECT_NE(groups[0].sameSide, groups[1].sameSide);
    EXPECT_EQ(groups[0].lights.size() + groups[1].lights.size(), 2u);
}

TEST(Groups, OfLightsThatAgreeAreOne) {
    ViewScene scene = fogScene(CameraType::perspective);
    scene.lights = {distantLight({0.2, 0.1, -1}), distantLight({0.4, 0, -1}), pointLight({10, 40, 90})};
    EXPECT_EQ(groupsOf(scene).size(), 1u);
}

// Whatever stands around: every part is served once, no group of several leans more than the dial allows, and the
// slant that sheets are laid out for is the true one.
TEST(Groups, OfManyLightsKeepToTheLimit) {
    Random random(2);
    for (int i = 0; i < 60; ++i) {
        ViewScene scene = fogScene(i % 2 ? CameraType::perspective : CameraType::orthographic);
        scene.camera.wsPosition = 60.0 * random.direction();
        scene.camera.wsFromCamera = lookAt(scene.camera.wsPosition, Vec3(0), {0, 1, 0});
        scene.dials.maxSlant = random.in(30, 75);
        const int lights = 1 + i % 12;
        for (int k = 0; k < lights; ++k)
            scene.lights.push_back(k % 3 ? distantLight(random.direction())
                                         : pointLight(random.in(50, 200) * random.direction()));
        std::multiset<int> served;
        for (const GroupPlan& group : groupsOf(scene)) {
            EXPECT_NEAR(glm::length(group.wsAxis), 1, 1e-12);
            EXPECT_NEAR(group.slant, worstSlant(scene, group), 1e-6);
            EXPECT_LT(group.slant, kPi / 2);
            if (group.lights.size() > 1) {
                EXPECT_LE(group.slant, scene.dials.maxSlant * kPi / 180 + 1e-9);
            }
            for (const PlannedLight& part : group.lights) served.insert(static_cast<int>(part.light));
        }
        for (int k = 0; k < lights; ++k) EXPECT_EQ(served.count(k), 1u) << "light " << k;
    }
}

TEST(Groups, AreAsManyAsALowerLimitNeeds) {
    Random random(3);
    ViewScene scene = fogScene(CameraType::orthographic);
    for (int k = 0; k < 12; ++k) scene.lights.push_back(distantLight(random.direction()));
    std::size_t before = 100;
    for (const double limit : {10.0, 40.0, 60.0, 80.0}) {
        scene.dials.maxSlant = limit;
        const std::size_t count = groupsOf(scene).size();
        EXPECT_LE(count, before) << limit;
        before = count;
    }
    EXPECT_GE(before, 2u);  // lights on both sides of the eye
}

TEST(Groups, DoNotHangOnTheOrderOfTheLights) {
    Random random(4);
    ViewScene scene = fogScene(CameraType::perspective);
    for (int k = 0; k < 9; ++k) {
        scene.lights.push_back(k % 3 ? distantLight(random.direction()) : pointLight(120.0 * random.direction()));
        scene.lights.back().name = std::string(1, static_cast<char>('a' + k));
    }
    // Names of each group's lights, in order, with its axis.
    const auto described = [](const ViewScene& s) {
        std::vector<std::pair<std::string, Vec3>> out;
        for (const GroupPlan& group : groupsOf(s)) {
            std::string names;
            for (const PlannedLight& part : group.lights) names += s.lights[static_cast<std::size_t>(part.light)].name;
            out.emplace_back(names, group.wsAxis);
        }
        return out;
    };
    const auto expected = described(scene);
    for (int i = 0; i < 20; ++i) {
        std::shuffle(scene.lights.begin(), scene.lights.end(), random.engine());
        const auto actual = described(scene);
        ASSERT_EQ(actual.size(), expected.size());
        for (std::size_t g = 0; g < actual.size(); ++g) {
            EXPECT_EQ(actual[g].first, expected[g].first);
            EXPECT_EQ(actual[g].second, expected[g].second);  // to the bit: sheets lie where they lay
        }
    }
}

TEST(PointLight, FarAwayIsOneViewThatHoldsTheVolume) {
    ViewScene scene = fogScene(CameraType::orthographic);
    scene.lights.push_back(pointLight({50, 0, 0}));
    const std::vector<GroupPlan> groups = groupsOf(scene);
    ASSERT_EQ(groups.size(), 1u);
    ASSERT_EQ(groups[0].lights.size(), 1u);
    EXPECT_TRUE(groups[0].lights[0].wsWindows.empty());
    for (const Vec3& corner : wsCorners(scene)) {
        EXPECT_LE(angle(corner - scene.lights[0].wsPosition, groups[0].wsAxis), groups[0].slant + 1e-9);
    }
}

// A light inside the volume is cut into windows. Every direction lies well within one of them, and each window lists
// all that overlap it, itself included: shares can be made to sum to one (SplitLight in unit/shade).
TEST(PointLight, InsideTheVolumeIsCutIntoWindowsThatCoverTheSphere) {
    ViewScene scene = fogScene(CameraType::orthographic);
    scene.lights.push_back(pointLight({1, 2, -3}));
    std::vector<PlannedLight> parts;
    for (const GroupPlan& group : groupsOf(scene)) {
        EXPECT_LE(group.slant, kSlantLimit);
        parts.insert(parts.end(), group.lights.begin(), group.lights.end());
    }
    EXPECT_EQ(parts.size(), 42u);  // corners and edges of an icosahedron
    for (const PlannedLight& part : parts) {
        const Vec3 axis = part.wsWindows.at(static_cast<std::size_t>(part.window));
        for (const Vec3& d : part.wsDirections) EXPECT_NEAR(angle(d, axis), kWindowAngle, 1e-6);
        for (const PlannedLight& other : parts) {
            const Vec3 otherAxis = other.wsWindows.at(static_cast<std::size_t>(other.window));
            const bool listed =
                std::find(part.wsWindows.begin(), part.wsWindows.end(), otherAxis) != part.wsWindows.end();
            EXPECT_EQ(listed, angle(axis, otherAxis) < 2 * kWindowAngle);
        }
    }
    Random random(5);
    for (int i = 0; i < 2000; ++i) {
        const Vec3 d = random.direction();
        double nearest = kPi;
        for (const PlannedLight& part : parts)
            nearest = std::min(nearest, angle(d, part.wsWindows[static_cast<std::size_t>(part.window)]));
        ASSERT_LT(nearest, 21.2 * kPi / 180);  // the icosahedron's: windows of 32 degrees overlap well
    }
}

TEST(SpotLight, WithANarrowConeInsideTheVolumeIsOneView) {
    ViewScene scene = fogScene(CameraType::orthographic);
    Light spot = pointLight({0, 0, 0});
    spot.kind = Light::Spot{};
    spot.wsDirection = {1, 0, 0};
    std::get<Light::Spot>(spot.kind).coneAngle = 40;
    scene.lights.push_back(spot);
    const std::vector<GroupPlan> groups = groupsOf(scene);
    ASSERT_EQ(groups.size(), 1u);
    ASSERT_EQ(groups[0].lights.size(), 1u);
    // The corners of the polygon of 16 that touches the cone.
    const double corner = std::atan(std::tan(20 * kPi / 180) / std::cos(kPi / 16));
    for (const Vec3& d : groups[0].lights[0].wsDirections) EXPECT_NEAR(angle(d, {1, 0, 0}), corner, 1e-9);
}

TEST(SpotLight, WithAWideConeIsCutIntoTheWindowsItMeets) {
    ViewScene scene = fogScene(CameraType::orthographic);
    Light spot = pointLight({0, 0, 0});
    spot.kind = Light::Spot{};
    spot.wsDirection = {0, -1, 0};
    std::get<Light::Spot>(spot.kind).coneAngle = 130;
    scene.lights.push_back(spot);
    std::size_t parts = 0;
    for (const GroupPlan& group : groupsOf(scene))
        for (const PlannedLight& part : group.lights) {
            const Vec3 axis = part.wsWindows.at(static_cast<std::size_t>(part.window));
            EXPECT_LE(angle(axis, spot.wsDirection), 65 * kPi / 180 + kWindowAngle + 1e-9);
            ++parts;
        }
    EXPECT_GT(parts, 10u);
    EXPECT_LT(parts, 42u);
}

TEST(Projector, InsideTheVolumeIsOneViewOfItsBeam) {
    ViewScene scene = fogScene(CameraType::orthographic);
    scene.lights = {projector({0, 0, 3}, 40, quarters())};
    auto groups = groupsOf(scene);
    ASSERT_EQ(groups.size(), 1u);
    ASSERT_EQ(groups[0].lights.size(), 1u);
    EXPECT_TRUE(groups[0].lights[0].wsWindows.empty());
    for (const Vec3& d : groups[0].lights[0].wsDirections)
        EXPECT_NEAR(angle(d, scene.lights[0].wsDirection), slideHalfAngle(scene.lights[0]), 1e-9);
    // Far away, and narrower than the volume: its beam too.
    scene.lights = {projector({0, 30, 30}, 3, quarters())};
    groups = groupsOf(scene);
    EXPECT_NEAR(angle(groups[0].lights.at(0).wsDirections.at(0), scene.lights[0].wsDirection),
                slideHalfAngle(scene.lights[0]), 1e-9);
}

TEST(Projector, ThatMissesTheVolumeIsNoWork) {
    ViewScene scene = fogScene(CameraType::orthographic);
    scene.lights = {projector({0, 30, 30}, 20, quarters())};
    scene.lights[0].wsDirection = {0, 1, 0};
    const auto groups = groupsOf(scene);
    ASSERT_EQ(groups.size(), 1u);
    EXPECT_TRUE(groups[0].lights.empty());
}

TEST(ImageAligned, SheetsFaceTheCamera) {
    Random random(6);
    for (int i = 0; i < 40; ++i) {
        ViewScene scene = fogScene(CameraType::perspective);
        scene.dials.sheets = SheetAxis::imageAligned;
        // Within 60 degrees of the view, one way or the other.
        const double side = i % 2 ? 1 : -1;
        scene.lights.push_back(distantLight({random.in(-1, 1), random.in(-1, 1), side}));
        const GroupPlan group = groupsOf(scene).at(0);
        expectSame(group.wsAxis, {0, 0, group.sameSide ? -1 : 1}, 1e-12);
        EXPECT_EQ(group.sameSide, side < 0);
        EXPECT_NEAR(group.slant, worstSlant(scene, group), 1e-7);
    }
}

TEST(ImageAligned, SheetsUnderAPerpendicularLightAreAnError) {
    ViewScene scene = fogScene(CameraType::orthographic);
    scene.dials.sheets = SheetAxis::imageAligned;
    scene.lights.push_back(distantLight({0, -1, 0}));
    EXPECT_EQ(errorOf(ErrorKind::render, [&] { groupsOf(scene); }),
              "image-aligned sheets do not suit this scene (sheets = \"half-way\" does): rays lean 90.0 degrees from "
              "the sweep's axis, at most 85 can be rendered");
}

// The camera stands in the fog and sees nearly half of the sphere.
TEST(WideView, BeyondWhatImageAlignedSheetsServeIsAnError) {
    ViewScene scene = fogScene(CameraType::perspective);
    scene.camera.wsPosition = {0, 0, 0};
    scene.camera.fov = 175;
    scene.dials.sheets = SheetAxis::imageAligned;
    const std::string text = errorOf(ErrorKind::render, [&] { groupsOf(scene); });
    EXPECT_TRUE(
        text.starts_with("image-aligned sheets do not suit this scene (sheets = \"half-way\" does): rays lean 8"))
        << text;
    EXPECT_TRUE(text.ends_with(" degrees from the sweep's axis, at most 85 can be rendered")) << text;
}

TEST(EyeDirections, HoldEveryRayThatMeetsTheVolume) {
    ViewScene scene = fogScene(CameraType::perspective);
    scene.camera.wsPosition = {10, -5, 40};
    scene.camera.wsFromCamera = lookAt(scene.camera.wsPosition, {3, 2, 0}, {0, 1, 0});
    const std::vector<Vec3> corners = wsCorners(scene);
    const GroupPlan group = groupsOf(scene).at(0);
    Random random(7);
    const RayFamily rays = wsRays(scene.camera);
    Bounds ws;
    for (const Vec3& corner : corners) ws.include(corner);
    for (int i = 0; i < 500; ++i) {
        // A point of the volume's box that lies in the picture.
        const Vec3 p(random.in(ws.lower.x, ws.upper.x), random.in(ws.lower.y, ws.upper.y),
                     random.in(ws.lower.z, ws.upper.z));
        const glm::dvec4 ndc = worldToNdc(scene.camera) * glm::dvec4(p, 1);
        if (std::abs(ndc.x) > ndc.w || std::abs(ndc.y) > ndc.w) continue;
        EXPECT_LE(angle(p - rays.origin0, group.wsAxis), group.slant + 1e-9);
    }
}

}  // namespace
}  // namespace scrim::test
