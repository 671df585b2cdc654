// SPDX-License-Identifier: Apache-2.0
// The paper's own splatting: n + 1 splats, each into its view's sheets (ZC02 section 3.2, 4 and 6).
#include "support/verified.h"

#include <scrim/geometry/camera.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

ViewScene smokeScene(const Light& light) {
    Medium medium;
    medium.densityScale = 0.12;
    ViewScene scene = orthographicScene(smokeField(22), medium, 54, 64);
    scene.lights.push_back(light);
    scene.dials.splat = SplatMode::perView;
    scene.dials.crossFade = 0;
    return scene;
}

void makePerspective(ViewScene& scene) {
    scene.camera.type = CameraType::perspective;
    scene.camera.wsPosition = {10, 20, 70};
    scene.camera.wsFromCamera = lookAt(scene.camera.wsPosition, Vec3(0), {0, 1, 0});
    scene.camera.fov = 40;
}

Light pointLight(const Vec3& wsPosition) {
    Light light;
    light.name = "lamp";
    light.kind = Light::Point{};
    light.wsPosition = wsPosition;
    light.intensity = Rgb(3000);
    return light;
}

struct Views {
    const char* name;
    bool perspective;
    Light light;
    SheetAxis sheets;
    ShadowPlane plane;
    ShadowFilter filter;
};
void PrintTo(const Views& v, std::ostream* out) {
    *out << v.name;
}

class PerView : public testing::TestWithParam<Views> {};

TEST_P(PerView, AgreesWithBruteForce) {
    const Views& v = GetParam();
    ViewScene scene = smokeScene(v.light);
    if (v.perspective) makePerspective(scene);
    scene.dials.sheets = v.sheets;
    scene.dials.shadowPlane = v.plane;
    scene.dials.shadowFilter = v.filter;
    expectConvergence(scene, 60, 1, 0.003);
}

const Light kSide = distantLight({-1, -0.7, -0.9}, 3), kFront = distantLight({0.3, 0.2, -1}, 3),
            kBack = distantLight({0.3, -0.5, 0.8}, 3);
constexpr auto kHalf = SheetAxis::halfWay, kAligned = SheetAxis::imageAligned;
constexpr auto kLight = ShadowPlane::light, kImage = ShadowPlane::image;
constexpr auto kBilinear = ShadowFilter::bilinear, kNearest = ShadowFilter::nearest;
INSTANTIATE_TEST_SUITE_P(Views, PerView,
                         testing::Values(Views{"parallelHalfWay", false, kSide, kHalf, kLight, kBilinear},
                                         Views{"parallelImageAligned", false, kFront, kAligned, kImage, kBilinear},
                                         Views{"parallelNearest", false, kFront, kAligned, kImage, kNearest},
                                         Views{"backToFront", false, kBack, kHalf, kLight, kBilinear},
                                         Views{"perspectiveHalfWay", true, kSide, kHalf, kLight, kBilinear},
                                         Views{"perspectiveImageAligned", true, kFront, kAligned, kImage, kNearest},
                                         Views{"perspectiveBackToFront", true, kBack, kHalf, kImage, kBilinear},
                                         Views{"pointLight", true, pointLight({50, 40, 30}), kHalf, kLight, kBilinear},
                                         Views{"pointLightOnImagePlane", true, pointLight({20, 40, 60}), kAligned,
                                               kImage, kBilinear}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(PerViewSlab, HasItsClosedFormFromBothKindsOfCamera) {
    Medium medium;
    medium.densityScale = 0.1;
    for (const bool perspective : {false, true}) {
        ViewScene scene = orthographicScene(boxField({-40, -40, -8}, {39, 39, 7}), medium, 40, 32);
        scene.dials.splat = SplatMode::perView;
        scene.dials.footprintSteps = 32;
        if (perspective) {
            scene.camera.type = CameraType::perspective;
            scene.camera.wsPosition = {0, 0, 60};
            scene.camera.fov = 30;
        }
        const Frame frame = renderScene(scene);
        for (const auto& [x, y] : {std::pair{16, 16}, {3, 5}, {28, 20}}) {
            // The ray's slant lengthens its way.
            const RayFamily rays = wsRays(scene.camera);
            const double slant = glm::length(rays.direction(x + 0.5, y + 0.5));
            const double expected = -std::expm1(-0.1 * 16 * slant);
            EXPECT_NEAR(pixelOf(frame, x, y)[3], expected, 3e-3) << perspective << " " << x << "," << y;
        }
    }
}

TEST(PerView, SharesTheLaterStagesWithTheDefault) {
    ViewScene scene = smokeScene(kSide);
    const Frame own = renderScene(scene);
    scene.dials.splat = SplatMode::shared;
    scene.dials.shade = ShadeMode::pixel;
    const Frame shared = renderScene(scene);
    double squares = 0, sum = 0;
    for (std::size_t i = 0; i < own.image.rgba.size(); ++i) {
        squares += std::pow(own.image.rgba[i] - shared.image.rgba[i], 2);
        sum += shared.image.rgba[i];
    }
    const auto count = static_cast<double>(own.image.rgba.size());
    EXPECT_LT(std::sqrt(squares / count) / (sum / count), 0.06);
}

TEST(PerView, SplatsOnceMoreForEveryShadow) {
    ViewScene scene = smokeScene(kSide);
    const auto footprints = [&] { return static_cast<double>(renderScene(scene).work.footprints); };
    scene.lights[0].shadows = false;
    const double none = footprints();
    scene.lights[0].shadows = true;
    const double one = footprints();
    scene.lights.push_back(distantLight({-0.9, -0.8, -0.9}, 3));
    const double two = footprints();
    // A voxel's footprints differ in number with the slant of the view.
    EXPECT_NEAR(one / none, 2, 0.4);
    EXPECT_NEAR(two / none, 3, 0.7);
    scene.dials.splat = SplatMode::shared;
    const double shared = footprints();
    scene.lights.resize(1);
    EXPECT_EQ(footprints(), shared) << "shared sheets are splatted once, whatever the number of lights";
}

// ZC02 Fig. 5, line 3.
TEST(OcclusionMap, SavesFootprintsOfTheEyeAndChangesNothing) {
    Medium medium;
    medium.densityScale = 2;
    ViewScene scene = orthographicScene(boxField({-40, -40, -40}, {39, 39, 39}), medium, 64, 64);
    scene.dials.splat = SplatMode::perView;
    scene.ambient = Rgb(1);
    const Frame culled = renderScene(scene);
    scene.dials.opacityCutoff = 0;
    const Frame all = renderScene(scene);
    EXPECT_LT(double(culled.work.footprints), 0.6 * double(all.work.footprints));
    for (std::size_t i = 0; i < all.image.rgba.size(); ++i) ASSERT_NEAR(culled.image.rgba[i], all.image.rgba[i], 1e-3);
}

TEST(OcclusionMap, LeavesTheShadowsOfHiddenVoxels) {
    // A wall that hides most of a long bar from the eye; the bar's shadow falls on a floor beside the wall.
    Medium medium;
    medium.densityScale = 0.5;
    const auto field = makeField({-40, -30, -30}, {40, 30, 30}, 1, [](const Vec3& p) {
        const bool wall = p.z > 20 && p.z < 26 && p.x < 0;
        const bool bar = p.x < -4 && std::abs(p.y - 15) < 4 && p.z < 14 && p.z > -10;
        const bool floor = p.y < -20 && p.y > -26;
        return wall || bar || floor ? 1.0 : 0.0;
    });
    ViewScene scene = orthographicScene(field, medium, 64, 64);
    scene.dials.splat = SplatMode::perView;
    scene.dials.crossFade = 0;
    scene.lights.push_back(distantLight({0.8, -0.75, -0.2}, 5));
    const Frame with = renderScene(scene);
    scene.lights[0].shadows = false;
    const Frame without = renderScene(scene);
    // To the right of the wall, on the floor's edge: the shadow of the bar that nobody sees.
    const auto brightness = [](const Frame& frame) {
        double sum = 0;
        for (int x = 46; x < 60; ++x)
            for (int y = 54; y < 58; ++y) sum += pixelOf(frame, x, y)[0];
        return sum;
    };
    EXPECT_LT(brightness(with), 0.95 * brightness(without));
    scene.lights[0].shadows = true;
    expectConvergence(scene, 60, 0.5, 0.04);  // hard edges: a band as wide as a texel is off
}

// ZC02 section 6: "the image-aligned splatting makes it difficult to keep track of accurate opacities as seen from the
// perpendicular light source".
TEST(Perpendicular, ImageAlignedSheetsShowThePapersProblemAndHalfWaySheetsDoNot) {
    ViewScene scene = smokeScene(distantLight({0, -1, 0}, 3));
    expectConvergence(scene, 60, 1, 0.003);
    const double halfWay = errorOf(scene, 60);
    scene.dials.splat = SplatMode::shared;
    const double shared = errorOf(scene, 60);
    scene.dials.splat = SplatMode::perView;
    scene.dials.sheets = SheetAxis::imageAligned;
    const double aligned = errorOf(scene, 60);
    RecordProperty("halfWayPerView", std::to_string(halfWay));
    RecordProperty("halfWayShared", std::to_string(shared));
    RecordProperty("imageAligned", std::to_string(aligned));
    EXPECT_GT(aligned, 5 * std::max(halfWay, shared));
}

}  // namespace
}  // namespace scrim::test
