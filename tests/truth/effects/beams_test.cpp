// SPDX-License-Identifier: Apache-2.0
// Lamps whose beams are seen in haze, close to what they shine from: beside brute force, which follows their borders.
// Sheets are thicker than the beams are wide there.
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

}  // namespace
}  // namespace scrim::test
