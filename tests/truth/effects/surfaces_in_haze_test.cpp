// SPDX-License-Identifier: Apache-2.0
// Rectangles, disks and cylinders that shine among the volumes, in the picture: beside brute force, which takes small
// steps near them. Their light rises towards them within a cell and within a sheet.
#include "soft_lights.h"
#include "support/meshes.h"
#include "support/verified.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

// Thin haze of 24 voxels, seen along -z.
ViewScene haze(const Light& light, const Medium& medium) {
    ViewScene scene = orthographicScene(boxField(Int3(-12), Int3(12)), medium, 18, 48);
    scene.dials.texel = 1;
    scene.dials.sheetThickness = 1.5;
    scene.dials.lightCell = 1;
    scene.dials.lightError = 0.02;
    scene.lights = {light};
    return scene;
}

Medium thin() {
    Medium medium;
    medium.densityScale = 0.03;
    medium.albedo = Rgb(1);
    return medium;
}

Light shape(AreaShape shape, double width, double radius) {
    Light light = areaLight(shape, {0.3, 1.2, 0.4}, 0.5 * width, 0, Rgb(10));
    auto& area = std::get<Light::Area>(light.kind);
    area.width = width;
    area.radius = radius;
    light.wsDirection = glm::normalize(Vec3(0.3, -1, 0.5));
    return light;
}

double errorNear(const Light& light, const Medium& medium = thin(), double cell = 1) {
    ViewScene scene = haze(light, medium);
    scene.dials.lightCell = cell;
    return errorOf(scene, 60);
}

// With what cells keep of their sub-lights: 7.4, 11, 4.8 and 12 %; 5.0 % at a border, and 17 % beside a solid.
TEST(SurfacesInHaze, AreAsBruteForceFindsThem) {
    EXPECT_LT(errorNear(shape(AreaShape::rectangle, 1.6, 0)), 0.04);
    EXPECT_LT(errorNear(shape(AreaShape::rectangle, 5, 0)), 0.03);
    EXPECT_LT(errorNear(shape(AreaShape::disk, 0, 1.5)), 0.03);
    EXPECT_LT(errorNear(shape(AreaShape::cylinder, 9, 0.3)), 0.03);
}

// Cells that keep what phase functions make of the light, and not what holds it back alone, leave 12 and 14 %.
TEST(SurfacesInHaze, ThatScattersForwardsAreAsBruteForceFindsThem) {
    Medium medium = thin();
    medium.phase.g = 0.6;
    EXPECT_LT(errorNear(shape(AreaShape::rectangle, 4, 0), medium), 0.03);
    EXPECT_LT(errorNear(shape(AreaShape::disk, 0, 2), medium), 0.03);
    EXPECT_LT(errorNear(shape(AreaShape::cylinder, 9, 0.3), medium), 0.03);
}

// A ball of flat faces that is a mesh, as it is, and where it hides its own light: 15 and 138 % where its light is that
// of its sub-lights, of which cells put some behind its faces.
TEST(SurfacesInHaze, ThatAreMeshesAreAsBruteForceFindsThem) {
    Light light = shape(AreaShape::mesh, 0, 0);
    auto ball = std::make_shared<TriangleMesh>(*ballMesh({0.3, 1.2, 0.4}, 1.3, 8));
    turnOver(*ball);
    shineFrom(light, *ball, Mat4(1.0));
    for (const bool hides : {false, true}) {
        ViewScene scene = haze(light, thin());
        if (hides) scene.solids = oneSolid(ball, false);
        EXPECT_LT(errorOf(scene, 60), 0.03) << hides;
    }
}

// Points send light through the slices along three axes. Each part of it ends where the next one begins, and what
// sharpens each by itself leaves 2 % and more along these borders, through all of the haze.
TEST(SurfacesInHaze, HaveNoSeamsWhereTheirLightChangesItsAxis) {
    const auto found = [](double cell) {
        ViewScene scene = haze(shape(AreaShape::rectangle, 4, 0), thin());
        scene.lights[0].wsDirection = {0, 0, 1};
        scene.dials.lightCell = cell;
        return renderScene(scene).image;
    };
    const Image coarse = found(1), fine = found(0.5);
    double most = 0;
    for (std::size_t i = 0; i < fine.rgba.size(); i += 4)
        if (fine.rgba[i] > 0) most = std::max(most, std::abs(double(coarse.rgba[i]) / double(fine.rgba[i]) - 1));
    EXPECT_LT(most, 0.015);
}

// Where no volume holds the light back, cells near it leave the rest to others all the same.
TEST(SurfacesInHaze, ThatHoldsNothingBackAreAsBruteForceFindsThem) {
    ViewScene scene = haze(shape(AreaShape::rectangle, 4, 0), thin());
    scene.volumes[0].shadows = {false};
    EXPECT_LT(errorOf(scene, 60), 0.03);
}

// A plate hides a half of the light from a part of the haze.
TEST(SurfacesInHaze, BesideASolidAreAsBruteForceFindsThem) {
    ViewScene scene = haze(shape(AreaShape::rectangle, 4, 0), thin());
    auto plate = std::make_shared<TriangleMesh>();
    plate->points = {{1.3, -6, -5}, {7.3, -5, -5}, {7.3, -5, 6}, {1.3, -6, 6}};
    plate->triangles = {{0, 1, 2}, {0, 2, 3}};
    scene.solids = oneSolid(plate, false);
    EXPECT_LT(errorOf(scene, 60), 0.05);
}

// A half of the light is outside of the haze.
TEST(SurfacesInHaze, AtItsBorderAreAsBruteForceFindsThem) {
    Light light = shape(AreaShape::rectangle, 4, 0);
    light.wsPosition = {0.3, 12, 0.4};
    ViewScene scene = haze(light, thin());
    scene.camera.wsPosition.y += 6;
    EXPECT_LT(errorOf(scene, 60), 0.04);
}

// What is kept close to a light belongs to its layer.
TEST(SurfacesInHaze, HaveLayersThatAddUp) {
    ViewScene scene = haze(shape(AreaShape::rectangle, 4, 0), thin());
    scene.lights.push_back(shape(AreaShape::disk, 0, 1.5));
    scene.lights[0].name = "one";
    scene.lights[1].name = "two";
    scene.lights[1].wsPosition = {-3, -2, 1};
    scene.layers = {Layer::light};
    const Frame frame = renderScene(scene);
    ASSERT_EQ(frame.layers.size(), 2u);
    for (std::size_t i = 0; i < frame.layers[0].data.size(); ++i) {
        const double both = double(frame.layers[0].data[i]) + double(frame.layers[1].data[i]);
        EXPECT_NEAR(both, double(frame.image.rgba[i / 3 * 4 + i % 3]), 1e-5 * both + 1e-7);
    }
}

}  // namespace
}  // namespace scrim::test
