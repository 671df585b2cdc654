// SPDX-License-Identifier: Apache-2.0
// Plans against the scene they are made from: sheets and rasters must hold everything that will be asked of them.
#include "support/expect_error.h"
#include "support/fields.h"
#include "support/slides.h"

#include <scrim/geometry/camera.h>
#include <scrim/engine/plan/make_plan.h>
#include <scrim/engine/plan/report.h>

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>

namespace scrim::test {
namespace {

const double kPi = std::acos(-1.0);

// A rotated box of fog under a few lights, seen in perspective.
ViewScene someScene() {
    ViewScene scene = orthographicScene(boxField({-12, -20, -8}, {11, 19, 7}, 0.5), {0.4, Rgb(0.9), {}}, 30, 64);
    scene.volumes[0].wsFromIs = glm::rotate(Mat4(1.0), 0.6, glm::normalize(Vec3(1, 2, 3))) * scene.volumes[0].wsFromIs;
    scene.camera.type = CameraType::perspective;
    scene.camera.wsPosition = {5, 8, 50};
    scene.camera.wsFromCamera = lookAt(scene.camera.wsPosition, {0, 0, 0}, {0, 1, 0});
    scene.lights = {distantLight({1, -1, -0.4}), distantLight({0.1, 0.2, 1})};
    Light bulb;
    bulb.kind = Light::Point{};
    bulb.wsPosition = {20, 30, 25};
    scene.lights.push_back(bulb);
    return scene;
}

TEST(Plan, OfAnEmptySceneHasNoGroups) {
    ViewScene scene = someScene();
    scene.volumes.clear();
    EXPECT_TRUE(makePlan(scene, 2).groups.empty());
    scene.volumes.push_back({"empty", std::make_shared<SparseField>(), Mat4(1.0), {}});
    EXPECT_TRUE(makePlan(scene, 2).groups.empty());
}

TEST(Plan, HasOnePrimaryGroupAndItIsTheFirst) {
    const Plan plan = makePlan(someScene(), 2);
    ASSERT_EQ(plan.groups.size(), 2u);
    EXPECT_EQ(plan.groups[0].primary, 1);
    EXPECT_EQ(plan.groups[1].primary, 0);
    std::size_t lights = 0;
    for (const GroupPlan& group : plan.groups) lights += group.lights.size();
    EXPECT_EQ(lights, 3u);
}

// Texels blur a border that is as narrow as they are: one of two texels left 17 % at `high`.
TEST(Plan, ShadesAtPixelsWhereTheBorderOfAConeIsNarrowerThanFourTexels) {
    ViewScene scene = orthographicScene(boxField(Int3(-8), Int3(7)), {0.01, Rgb(0.9), {}}, 20, 8);
    Light spot;
    Light::Spot cone;
    cone.coneAngle = 10;
    spot.name = "spot";
    spot.kind = cone;
    spot.wsPosition = {0, 0, 48};
    spot.wsDirection = {0, 0, -1};
    scene.lights = {spot};
    const double border = 0.5 * cone.blend * cone.coneAngle * kPi / 180 * (48 - 8);  // where it meets the box
    for (const double texels : {0.3, 2.0, 3.5, 6.0}) {
        scene.dials.texel = border / texels;
        EXPECT_EQ(makePlan(scene, 2).shadeReason.find("so near") != std::string::npos, texels < 4) << texels;
    }
}

// Of three tints and two sets of lights, volumes have four pairs. More pairs than channels are an error.
TEST(ExtinctionChannels, AreThoseOfVolumesAlone) {
    ViewScene scene = someScene();
    const ViewVolume first = scene.volumes[0];
    const auto setVolumes = [&](const std::vector<std::pair<Rgb, std::vector<bool>>>& all) {
        scene.volumes.clear();
        for (const auto& [tint, shadows] : all) {
            scene.volumes.push_back(first);
            scene.volumes.back().medium.extinctionTint = tint;
            scene.volumes.back().shadows = shadows;
        }
    };
    const std::vector<bool> one{true, false, false};
    setVolumes({{Rgb(1), {}}, {{1, 0.5, 0.5}, {}}, {{0.5, 1, 0.5}, {}}, {{0.5, 1, 0.5}, one}, {{0.5, 1, 0.5}, one}});
    const ExtinctionChannels channels = extinctionChannels(scene);
    ASSERT_EQ(channels.count(), 4);
    ASSERT_EQ(channels.shadows.size(), 4u);
    for (std::size_t v = 0; v < scene.volumes.size(); ++v) {
        const std::vector<Real>& weights = channels.weights[v];
        for (std::size_t i = 0; i < weights.size(); ++i)
            EXPECT_EQ(weights[i], i == std::min<std::size_t>(v, 3) ? 1 : 0) << v << " " << i;
    }
    EXPECT_EQ(channels.castIn(0), (std::vector<int>{0, 1, 2, 3}));
    EXPECT_EQ(channels.castIn(1), (std::vector<int>{0, 1, 2}));

    std::vector<std::pair<Rgb, std::vector<bool>>> many;
    const Rgb tints[] = {Rgb(1), {1, 0.5, 0.5}, {0.5, 1, 0.5}};
    for (int i = 0; i < 8; ++i) many.push_back({tints[i % 3], {(i & 1) != 0, (i & 2) != 0, (i & 4) != 0}});
    setVolumes(many);
    EXPECT_EQ(extinctionChannels(scene).count(), 8);
    for (int i = 0; i < 2; ++i) many.push_back({tints[(i + 1) % 3], {(i & 1) != 0, false, false}});
    setVolumes(many);
    EXPECT_EQ(errorOf(ErrorKind::usage, [&] { extinctionChannels(scene); }),
              "the volumes have 3 tints of extinction and cast shadows in 8 sets of lights, which takes 10 channels; "
              "expected at most 9");
}

TEST(PlannedSheets, CoverTheVolumeWithTwoTexelsOfZerosAround) {
    const ViewScene scene = someScene();
    for (const GroupPlan& group : makePlan(scene, 2).groups) {
        const Sheets& sheets = group.sheets;
        EXPECT_EQ(sheets.width % kTileEdge, 0);
        EXPECT_EQ(sheets.height % kTileEdge, 0);
        for (const Vec3& corner : wsCorners(scene)) {
            const Vec3 ts = sheets.tsPoint(corner);
            EXPECT_GE(ts.x, 2);
            EXPECT_LE(ts.x, sheets.width - 3);
            EXPECT_GE(ts.y, 2);
            EXPECT_LE(ts.y, sheets.height - 3);
            EXPECT_GE(ts.z, 0);
            EXPECT_LE(ts.z, sheets.count);
        }
    }
}

TEST(PlannedSheets, HaveTheDialsSizesAndThinnerOnesWhereRaysLean) {
    ViewScene scene = someScene();
    scene.dials.texel = 0.75;
    scene.dials.sheetThickness = 1.5;
    const Plan plan = makePlan(scene, 2);
    EXPECT_NEAR(plan.voxel, 0.5, 1e-12);
    for (const GroupPlan& group : plan.groups) {
        EXPECT_NEAR(group.sheets.texel, 0.75 * 0.5, 1e-12);
        EXPECT_NEAR(group.sheets.thickness, 1.5 * 0.5 * std::cos(group.slant), 1e-12);
        EXPECT_GT(group.slant, 0.01);
        EXPECT_LT(group.slant, 80 * kPi / 180);
    }
}

// Neither a step of the camera along its view nor another crop moves texels or sheets.
TEST(PlannedSheets, AreAnchoredToTheScene) {
    ViewScene scene = someScene();
    scene.camera.type = CameraType::orthographic;
    const Plan before = makePlan(scene, 2);
    scene.camera.wsPosition += 3.3 * viewingAxis(scene.camera) + 1.7 * scene.camera.wsFromCamera[0];
    scene.region = {10, 10, 30, 30};
    const Plan after = makePlan(scene, 2);
    ASSERT_EQ(before.groups.size(), after.groups.size());
    for (std::size_t g = 0; g < before.groups.size(); ++g) {
        EXPECT_EQ(before.groups[g].sheets.wsAnchor, after.groups[g].sheets.wsAnchor);
        EXPECT_EQ(before.groups[g].sheets.ssOrigin, after.groups[g].sheets.ssOrigin);
        EXPECT_EQ(before.groups[g].sheets.ssFromWs, after.groups[g].sheets.ssFromWs);
    }
    // And texels lie at whole multiples of their size from the anchor.
    for (const GroupPlan& group : before.groups) {
        const Vec3 steps = group.sheets.ssOrigin * group.sheets.tsStep();
        for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(steps[axis], std::round(steps[axis]), 1e-9);
    }
}

// Every point of the volume finds the cells of its light ray on the shadow raster.
TEST(LightRaster, HoldsTheRaysToEveryPointOfTheVolume) {
    ViewScene scene = someScene();
    for (const double shadowTexel : {0.5, 1.0, 2.0}) {
        scene.dials.shadowTexel = shadowTexel;
        for (const GroupPlan& group : makePlan(scene, 2).groups)
            for (const PlannedLight& light : group.lights) {
                EXPECT_EQ(light.view.width % kTileEdge, 0);
                EXPECT_EQ(light.view.height % kTileEdge, 0);
                // The corners, kernels included, and points in between.
                std::vector<Vec3> points = wsCorners(scene);
                std::mt19937 random(1);
                std::uniform_real_distribution<double> unit(0, 1);
                const Bounds is = scene.volumes[0].field->isBounds();
                for (int i = 0; i < 300; ++i)
                    points.push_back(
                        transformPoint(scene.volumes[0].wsFromIs,
                                       is.lower + is.size() * Vec3(unit(random), unit(random), unit(random))));
                for (const Vec3& ws : points) {
                    const Vec3 ts = group.sheets.tsPoint(ws);
                    const int sheet = static_cast<int>(std::floor(ts.z));
                    ASSERT_TRUE(light.view.reaches(sheet));
                    const LightView::Cells map = light.view.at(sheet);
                    const double x = (ts.x - map.offsetU) / map.scale, y = (ts.y - map.offsetV) / map.scale;
                    EXPECT_GE(x, 0);
                    EXPECT_LE(x, light.view.width - 1);
                    EXPECT_GE(y, 0);
                    EXPECT_LE(y, light.view.height - 1);
                    // Cells are as fine as the dial says wherever the light meets the volume.
                    EXPECT_LE(map.scale, shadowTexel * 1.05);
                }
            }
    }
}

TEST(LightRaster, FollowsTheLightsOwnRays) {
    const ViewScene scene = someScene();
    for (const GroupPlan& group : makePlan(scene, 2).groups)
        for (const PlannedLight& plan : group.lights) {
            const Light& light = scene.lights[static_cast<std::size_t>(plan.light)];
            if (light.distant()) {
                const Vec3 ts = group.sheets.tsVector(light.wsDirection);
                EXPECT_GT(ts.z, 0);  // lights travel with the sweep
                EXPECT_NEAR(plan.view.tsSource.x, ts.x / ts.z, 1e-12);
                EXPECT_NEAR(plan.view.tsSource.y, ts.y / ts.z, 1e-12);
            } else {
                EXPECT_LT(glm::distance(plan.view.tsSource, group.sheets.tsPoint(light.wsPosition)), 1e-9);
            }
            EXPECT_NEAR(plan.view.slopeScale, group.sheets.texel / group.sheets.thickness, 1e-12);
        }
}

TEST(Plan, GivesLightsWithoutShadowsNoBuffer) {
    ViewScene scene = someScene();
    const std::size_t with = makePlan(scene, 2).bytes;
    for (Light& light : scene.lights) light.shadows = false;
    const Plan plan = makePlan(scene, 2);
    EXPECT_LT(plan.bytes, with);
    EXPECT_EQ(plan.work.lightSamples, 0u);
    for (const GroupPlan& group : plan.groups)
        for (const PlannedLight& light : group.lights) EXPECT_FALSE(light.shadowed);
}

TEST(Plan, CutsPixelsForAntialiasing) {
    ViewScene scene = someScene();
    scene.region = {-3, 5, 20, 40};
    scene.dials.antialias = 3;
    EXPECT_EQ(makePlan(scene, 2).region, (PixelWindow{-9, 15, 60, 120}));
}

TEST(Shading, IsWhereItIsLessWorkUnlessTheSceneSaysSo) {
    ViewScene scene = someScene();
    scene.camera.resolution = Int2(512);
    scene.region = {0, 0, 512, 512};
    EXPECT_FALSE(makePlan(scene, 2).shadeAtPixels);  // some 80 x 80 texels
    // A crop is shaded as the picture it is a part of; a small picture is not.
    scene.region = {250, 250, 254, 254};
    EXPECT_FALSE(makePlan(scene, 2).shadeAtPixels);
    scene.camera.resolution = Int2(16);
    scene.region = {0, 0, 16, 16};
    const Plan few = makePlan(scene, 2);
    EXPECT_TRUE(few.shadeAtPixels);
    EXPECT_NE(few.shadeReason.find("pixels wide"), std::string::npos) << few.shadeReason;
    scene.dials.shade = ShadeMode::texel;
    EXPECT_FALSE(makePlan(scene, 2).shadeAtPixels);
    EXPECT_EQ(makePlan(scene, 2).shadeReason, "the scene sets it");
    scene.dials.shade = ShadeMode::pixel;
    EXPECT_TRUE(makePlan(scene, 2).shadeAtPixels);
}

// A pixel of the slide needs two texels at least; else pixels.
TEST(PlannedShading, IsAtPixelsWhereASheetIsDense) {
    ViewScene scene = someScene();
    scene.camera.resolution = {1024, 1024};  // texels of many pixels: a thin medium is shaded at those
    EXPECT_FALSE(makePlan(scene, 2).shadeAtPixels);
    scene.volumes[0].medium.densityScale = 4;
    const Plan plan = makePlan(scene, 2);
    EXPECT_TRUE(plan.shadeAtPixels);
    EXPECT_NE(plan.shadeReason.find("an optical depth of"), std::string::npos) << plan.shadeReason;
    scene.dials.sheetThickness = 0.1;
    EXPECT_FALSE(makePlan(scene, 2).shadeAtPixels);
}

TEST(Shading, IsAtPixelsWhereASlideIsFinerThanTwoTexels) {
    ViewScene scene = someScene();
    scene.camera.resolution = Int2(512);                                     // texels of many pixels
    scene.lights = {distantSlide({0.1, 0.2, -1}, 64 * 1.01, quarters(64))};  // texels of 0.5
    EXPECT_FALSE(makePlan(scene, 2).shadeAtPixels);
    scene.lights[0].slide->width = 64 * 0.99;
    const Plan plan = makePlan(scene, 2);
    EXPECT_TRUE(plan.shadeAtPixels);
    EXPECT_EQ(plan.shadeReason,
              "a pixel of the slide of 'slide' covers 0.99 at the volume, less than two texels of 0.5");
    scene.dials.shade = ShadeMode::texel;
    EXPECT_FALSE(makePlan(scene, 2).shadeAtPixels);
}

// The raster of a spot among the volumes is laid over its cone, round as it is: over directions on its rim, 15 of these
// rays were up to 2.4 cells outside of a raster of 656 x 576.
TEST(LightRaster, HoldsTheConeOfASpotInTheVolume) {
    Light::Spot cone;
    cone.coneAngle = 60;
    cone.blend = 0;
    ViewScene scene = orthographicScene(boxField(Int3(-24), Int3(23)), {0.1, Rgb(0.9), {}}, 106, 64);
    scene.dials.texel = scene.dials.sheetThickness = 0.125;
    scene.lights = {lamp({-21.6, 1.2, 0.7}, 1)};
    scene.lights[0].kind = cone;
    for (const double roll : {0.13, 0.02, 0.3}) {
        const Vec3 axis = scene.lights[0].wsDirection = glm::normalize(Vec3(1, roll, -0.21));
        const GroupPlan group = makePlan(scene, 2).groups.at(0);
        const LightView& view = group.lights.at(0).view;
        const Mat3 frame = frameAround(axis);
        for (int i = 0; i < 360; ++i) {
            const double turn = i * kPi / 180, angle = 29.99 * kPi / 180;
            const Vec3 across = std::cos(turn) * frame[0] + std::sin(turn) * frame[1];
            const Vec3 ts = group.sheets.tsVector(std::cos(angle) * axis + std::sin(angle) * across);
            const double x = (ts.x / ts.z - view.first.x) / view.cell, y = (ts.y / ts.z - view.first.y) / view.cell;
            EXPECT_TRUE(x >= 1 && y >= 1 && x <= view.width - 2 && y <= view.height - 2) << i << ": " << x << ", " << y;
        }
    }
}

// A raster of too many cells has fewer and larger ones, and says so.
TEST(LightRaster, SaysWhereItsCellsAreLargerThanTheDial) {
    for (const SplatMode splat : {SplatMode::shared, SplatMode::perView}) {
        ViewScene scene = orthographicScene(boxField(Int3(-24), Int3(23)), {0.1, Rgb(0.9), {}}, 60, 16);
        scene.lights = {distantLight({0, 0, -1}), distantLight({0, 0, -1})};
        scene.lights[1].shadows = false;
        scene.dials.splat = splat;
        EXPECT_EQ(planAsTable(scene, makePlan(scene, 2)).find("larger than shadow_texel"), std::string::npos);
        scene.dials.shadowTexel = 0.003;  // 49 / 0.003, kernels included, are twice 8,192
        const std::string table = planAsTable(scene, makePlan(scene, 2));
        EXPECT_NE(table.find("cells of their rasters are larger than shadow_texel says: 'light' 2 times"),
                  std::string::npos)
            << table;
    }
}

TEST(LightRaster, OfASlideIsAsLargeAsItsBeam) {
    ViewScene scene = someScene();
    scene.lights = {distantSlide({0.1, 0.2, -1}, 5, quarters())};
    const LightView narrow = makePlan(scene, 2).groups[0].lights.at(0).view;
    EXPECT_LE(narrow.width, 32);  // 10 texels and margins
    EXPECT_LE(narrow.height, 32);
    scene.lights[0].slide->outside = SlideOutside::clamp;
    EXPECT_GT(makePlan(scene, 2).groups[0].lights.at(0).view.height, 32);
}

TEST(Plan, OfASlideThatIsNotLoadedIsAnError) {
    ViewScene scene = someScene();
    scene.lights = {distantSlide({0, 0, -1}, 5, nullptr)};
    scene.lights[0].slide->file = "a.png";
    EXPECT_EQ(errorOf(ErrorKind::usage, [&] { makePlan(scene, 2); }),
              "the slide 'a.png' of light 'slide' is not loaded");
}

TEST(Memory, LimitMakesBatchesSmallerButNotThePicture) {
    ViewScene scene = someScene();
    const Plan free = makePlan(scene, 4);
    scene.memoryLimit = free.bytes / 2;
    const Plan tight = makePlan(scene, 4);
    EXPECT_LE(tight.bytes, scene.memoryLimit);
    EXPECT_LT(tight.groups[0].batchSheets, free.groups[0].batchSheets);
    EXPECT_GE(tight.groups[0].batchSheets, 1);
    EXPECT_EQ(render(scene, free).image.rgba, render(scene, tight).image.rgba);
}

TEST(Memory, PlannedIsNoLessThanWhatBuffersTake) {
    const ViewScene scene = someScene();
    for (const int threads : {1, 4}) {
        const Plan plan = makePlan(scene, threads);
        EXPECT_LE(render(scene, plan).work.bytes.total(), plan.bytes * 101 / 100) << threads;
    }
}

TEST(Memory, LimitBelowOneSheetIsAnError) {
    ViewScene scene = someScene();
    scene.memoryLimit = std::size_t{1} << 20;
    scene.region = {0, 0, 400, 200};
    const std::string text = errorOf(ErrorKind::memory, [&] { makePlan(scene, 2); });
    EXPECT_TRUE(text.starts_with("one sheet at a time needs ")) << text;
    EXPECT_NE(text.find(" KB of buffers and 2.6 MB for the picture, more than the 1.0 MB that the memory limit leaves"),
              std::string::npos)
        << text;
}

// Where the shadow buffers of all lights do not fit, lights take turns: the same picture, to the rounding of a sum.
TEST(Memory, LightsThatDoNotFitTakeTurns) {
    ViewScene scene = someScene();
    scene.lights.clear();
    for (int i = 0; i < 40; ++i) {
        scene.lights.push_back(distantLight({1, -0.5 + 0.01 * i, -0.6}, 0.1));
        scene.lights.back().name = "light" + std::to_string(i);
    }
    scene.ambient = Rgb(0.2);
    const Plan free = makePlan(scene, 2);
    ASSERT_EQ(free.groups.size(), 1u);
    const Image whole = render(scene, free).image;
    scene.memoryLimit = free.bytes / 8;
    const Plan tight = makePlan(scene, 2);
    EXPECT_LE(tight.bytes, scene.memoryLimit);
    ASSERT_GT(tight.groups.size(), 2u);
    int lights = 0, primaries = 0;
    for (const GroupPlan& group : tight.groups) {
        lights += static_cast<int>(group.lights.size());
        primaries += group.primary > 0 ? 1 : 0;
        EXPECT_EQ(group.passes, static_cast<int>(tight.groups.size()));
        EXPECT_EQ(group.sheets.ssFromWs, free.groups[0].sheets.ssFromWs);
    }
    EXPECT_EQ(lights, 40);
    EXPECT_EQ(primaries, 1);
    const Image parts = render(scene, tight).image;
    for (std::size_t i = 0; i < whole.rgba.size(); ++i) ASSERT_NEAR(parts.rgba[i], whole.rgba[i], 2e-6) << i;
    EXPECT_NE(planAsTable(scene, tight).find("(pass 2 of "), std::string::npos);
}

TEST(Planning, OfMoreSheetsThanCanBeAddressedIsRefused) {
    for (const Vec3& scale : {Vec3(1e8, 1, 1), Vec3(1e-6, 1, 1), Vec3(1, 1e-300, 1), Vec3(1, 1, 1e300)}) {
        ViewScene scene = someScene();
        for (int axis = 0; axis < 3; ++axis) scene.volumes[0].wsFromIs[axis] *= scale[axis];
        const std::string text = errorOf(ErrorKind::render, [&] { makePlan(scene, 2); });
        EXPECT_NE(text.find("expected at most 1048576"), std::string::npos) << text;
    }
}

TEST(Planning, IsBoundedByTheMemoryLimit) {
    ViewScene scene = someScene();
    scene.dials.sheetThickness = 0.01;
    scene.memoryLimit = 20000;  // the picture alone takes more, but the plan of some thousand sheets comes first
    const std::string text = errorOf(ErrorKind::memory, [&] { makePlan(scene, 2); });
    EXPECT_NE(text.find("planning "), std::string::npos) << text;
}

TEST(Planning, CanBeInterruptedAtEveryStep) {
    const ViewScene scene = someScene();
    int asked = 0;
    makePlan(scene, 2, [&](double) { return ++asked > 0; });
    EXPECT_GT(asked, 10);
    for (const int at : {1, asked / 2, asked}) {
        int calls = 0;
        EXPECT_EQ(errorOf(ErrorKind::interrupted, [&] { makePlan(scene, 2, [&](double) { return ++calls < at; }); }),
                  "the planning was interrupted");
        EXPECT_EQ(calls, at);
    }
}

// The numbers that `scrim plan` shows: bounds where it says "at most", the right size where it says "rough".
TEST(ExpectedWork, BoundsTheWorkThatIsDone) {
    const ViewScene scene = someScene();
    const Plan plan = makePlan(scene, 2);
    const RenderWork work = render(scene, plan).work;
    EXPECT_LE(work.texelsShaded, plan.work.texelsShaded);
    EXPECT_LE(work.pixelSheets, plan.work.pixelSheets);
    EXPECT_GT(2 * work.footprints, plan.work.footprints);
    EXPECT_LT(work.footprints, 2 * plan.work.footprints);
}

}  // namespace
}  // namespace scrim::test
