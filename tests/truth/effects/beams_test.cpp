// SPDX-License-Identifier: Apache-2.0
// Lamps that are seen in haze, and their beams close to what they shine from: beside brute force, which follows their
// borders. Sheets are thicker than the beams are wide there, and than the lamps are far away.
#include "support/meshes.h"
#include "support/slides.h"
#include "support/verified.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

// Thin haze of 40 voxels, seen along -z, a lamp in its upper part that shines down and a little towards the eye.
ViewScene haze(double cone, double thickness) {
    Medium medium;
    medium.densityScale = 0.02;
    medium.albedo = Rgb(1);
    ViewScene scene = orthographicScene(boxField(Int3(-20), Int3(20)), medium, 30, 60);
    scene.dials.texel = 1;
    scene.dials.sheetThickness = thickness;
    Light light = lamp({0.3, 12.2, 0.4}, 100, 0.3);
    Light::Spot spot;
    spot.radius = 0.3;
    spot.coneAngle = cone;
    light.kind = spot;
    light.wsDirection = glm::normalize(Vec3(0.1, -1, 0.3));
    scene.lights = {light};
    return scene;
}

// With the value in the middle of each sheet, at texels, 30 to 300 %. Measured: 1.1 to 2.7 %.
TEST(Beams, OfASpotInThePictureAreAsBruteForceFindsThem) {
    for (const double cone : {8.0, 30.0, 70.0})
        for (const double thickness : {1.0, 3.0})
            EXPECT_LT(errorOf(haze(cone, thickness), 60), 0.03) << cone << ", " << thickness;
}

// With the value in the middle of each sheet, 600 %.
TEST(Beams, OfANarrowSpotFromOutsideAreAsBruteForceFindsThem) {
    ViewScene scene = haze(3, 2);
    scene.lights[0].wsPosition = {0, 26, 0};
    scene.lights[0].wsDirection = {0, -1, 0};
    EXPECT_LT(errorOf(scene, 60), 0.025);
}

// A plate across a half of the beam. A sheet's part that is beyond the beam must not count as lit.
TEST(Beams, BesideASolidAreAsBruteForceFindsThem) {
    ViewScene scene = haze(40, 1.5);
    auto plate = std::make_shared<TriangleMesh>();
    plate->points = {{0.3, 9, -8}, {8, 9, -8}, {8, 9, 8}, {0.3, 9, 8}};
    plate->triangles = {{0, 1, 2}, {0, 2, 3}};
    scene.solids = oneSolid(plate, false);
    EXPECT_LT(errorOf(scene, 60), 0.03);
}

// The same haze around a lamp, at rays of a voxel's spacing. Sheets are four voxels thick.
ViewScene hazeAround(const Phase& phase, ShadowMethod shadow) {
    Medium medium{0.03, Rgb(1), phase};
    ViewScene scene = orthographicScene(boxField(Int3(-20), Int3(20)), medium, 14, 14);
    scene.dials.texel = 1;
    scene.dials.sheetThickness = 4;
    scene.lights = {lamp({0.3, 0.2, 0.4}, 100)};
    scene.lights[0].shadow = shadow;
    return scene;
}

constexpr int kAllPixels = 14 * 14;
// What `standard` promises; texels of a voxel leave a third of it.
constexpr double kPromised = 0.01;

// With the phase function in the middle of each sheet 107, 292, 211 and 50 %, but for the first.
TEST(LampInHaze, OfAnyPhaseFunctionIsAsBruteForceFindsIt) {
    for (const double g : {0.0, 0.3, 0.6, 0.9, -0.6})
        EXPECT_LT(errorOf(hazeAround(Phase{g}, ShadowMethod::cells), kAllPixels), kPromised) << g;
}

TEST(LampInHaze, OfTwoLobesIsAsBruteForceFindsIt) {
    Phase phase{0.85};
    phase.type = PhaseType::twoLobe;
    phase.g2 = -0.4;
    phase.blend = 0.3;
    EXPECT_LT(errorOf(hazeAround(phase, ShadowMethod::cells), kAllPixels), kPromised);
}

TEST(LampInHaze, ThatIsASphereIsAsBruteForceFindsIt) {
    ViewScene scene = hazeAround(Phase{0.6}, ShadowMethod::cells);
    Light::Area sphere;
    sphere.shape = AreaShape::sphere;
    sphere.radius = 0.8;
    scene.lights[0].kind = sphere;
    EXPECT_LT(errorOf(scene, 24), 2 * kPromised);  // brute force draws its points at random
}

// Buffers see a spot, and its light begins within a sheet. With the phase function in the middle, and light that is
// dimmed by the whole sheet, 5 to 19 %.
TEST(LampInHaze, ThatIsASpotIsAsBruteForceFindsIt) {
    for (const double g : {0.0, 0.6, 0.9}) {
        ViewScene scene = hazeAround(Phase{g}, ShadowMethod::buffers);
        Light::Spot spot;
        spot.coneAngle = 60;
        scene.lights[0].kind = spot;
        scene.lights[0].wsDirection = glm::normalize(Vec3(0.1, 0.2, 1));
        EXPECT_LT(errorOf(scene, kAllPixels), 1.5 * kPromised) << g;
    }
}

// The same haze, in which the eye is, just behind a lamp: some of the sheet that they share is seen.
ViewScene eyeBehindLamp(const Vec3& place, ShadowMethod shadow, double thickness) {
    ViewScene scene = hazeAround({}, shadow);
    scene.camera.type = CameraType::perspective;
    scene.camera.fov = 40;
    scene.camera.wsPosition = {0.1, 0.2, 12.3};
    scene.lights[0].wsPosition = scene.camera.wsPosition + place;
    scene.dials.sheetThickness = thickness;
    return scene;
}

// With whole sheets in place of that part, 4 to 149 %.
TEST(LampInHaze, JustBeforeAnEyeInTheHazeIsAsBruteForceFindsIt) {
    for (const double thickness : {2.0, 3.0, 4.0}) {
        ViewScene scene = eyeBehindLamp({0.2, -0.1, -0.8}, ShadowMethod::cells, thickness);
        EXPECT_LT(errorOf(scene, kAllPixels), kPromised) << thickness;
        scene.lights[0].shadow = ShadowMethod::buffers;
        Light::Spot spot;
        spot.coneAngle = 40;
        scene.lights[0].kind = spot;
        scene.lights[0].wsDirection = glm::normalize(Vec3(-0.1, 0.1, -1));
        EXPECT_LT(errorOf(scene, kAllPixels), 2 * kPromised) << "spot, " << thickness;
    }
}

// What the lamp's light loses in that sheet before the eye's part of it: without it, 5 %.
TEST(LampInHaze, ThatIsASpotBehindTheEyeIsDimmedOnItsWayPastIt) {
    for (const double thickness : {2.0, 3.0, 4.0}) {
        ViewScene scene = eyeBehindLamp({0.2, -0.1, 1.2}, ShadowMethod::buffers, thickness);
        scene.volumes[0].medium.densityScale = 0.1;
        Light::Spot spot;
        spot.coneAngle = 60;
        scene.lights[0].kind = spot;
        scene.lights[0].wsDirection = {0, 0, -1};
        EXPECT_LT(errorOf(scene, kAllPixels), 2 * kPromised) << thickness;
    }
}

}  // namespace
}  // namespace scrim::test
