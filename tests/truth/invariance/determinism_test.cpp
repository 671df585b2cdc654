// SPDX-License-Identifier: Apache-2.0
// What must not change a picture: threads, memory, the order of lights and volumes, where the scene stands.
#include "support/fields.h"
#include "support/slides.h"
#include "support/temp_folder.h"
#include "support/vdb_make.h"

#include <scrim/base/parallel.h>
#include <scrim/geometry/camera.h>
#include <scrim/shot/shot.h>

#include <tbb/global_control.h>

#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

// Smoke under three lights that need two sweeps, seen in perspective.
ViewScene smokeScene() {
    Medium medium;
    medium.densityScale = 0.15;
    medium.phase.g = 0.3;
    ViewScene scene = orthographicScene(smokeField(24), medium, 60, 64);
    scene.camera.type = CameraType::perspective;
    scene.camera.wsPosition = {10, 20, 110};
    scene.camera.wsFromCamera = lookAt(scene.camera.wsPosition, {0, 0, 0}, {0, 1, 0});
    scene.lights.push_back(distantLight({-1, -1, -0.5}));
    scene.lights.push_back(distantLight({0.3, -0.2, 1}, 0.5));
    Light bulb;
    bulb.name = "bulb";
    bulb.kind = Light::Point{};
    bulb.wsPosition = {60, 50, 40};
    bulb.intensity = Rgb(2000, 1000, 500);
    scene.lights.push_back(bulb);
    scene.lights[1].name = "rim";
    scene.ambient = Rgb(0.05);
    return scene;
}

double largestDifference(const Image& a, const Image& b) {
    double most = 0;
    for (std::size_t i = 0; i < a.rgba.size(); ++i)
        most = std::max(most, std::abs(double(a.rgba[i]) - double(b.rgba[i])));
    return most;
}

double brightest(const Image& image) {
    return *std::max_element(image.rgba.begin(), image.rgba.end());
}

TEST(Threads, DoNotChangeABit) {
    const tbb::global_control seven(tbb::global_control::max_allowed_parallelism, 7);  // on however few processors
    const ViewScene scene = smokeScene();
    const auto with = [&](int threads) { return render(scene, makePlan(scene, threads)).image.rgba; };
    const auto one = with(1);
    EXPECT_EQ(one, with(2));
    EXPECT_EQ(one, with(7));
}

TEST(Threads, DoNotChangeAByteOfTheFile) {
    const tbb::global_control seven(tbb::global_control::max_allowed_parallelism, 7);
    const TempFolder folder;
    writeBytes(folder.file("s.toml"),
               "[camera]\nposition = [0, 0, 40]\ntarget = [0, 0, 0]\nfov = 35\nresolution = [48, 32]\n"
               "[[volume]]\nsource = \"noise\"\nparameters = { resolution = 48, size = 16 }\n"
               "[[light]]\ntype = \"distant\"\ndirection = [-1, -1, -1]\n");
    Shot shot = Shot::open(folder.file("s.toml"));
    const auto with = [&](int threads) {
        RenderOptions options;
        options.threads = threads;
        ShotFrame frame = shot.render(1, options);
        EXPECT_EQ(frame.report().threads, threads);
        frame.write(folder.file("x.exr"));
        return readBytes(folder.file("x.exr"));
    };
    const std::string one = with(1);
    EXPECT_TRUE(one == with(2));
    EXPECT_TRUE(one == with(7));
}

// Each instruction set is its own rounding, but the same picture, and a pinned one stays what it is.
TEST(InstructionSets, AgreeToRounding) {
    ViewScene scene = smokeScene();
    scene.dials.simd = "sse4";
    const Image narrow = renderScene(scene).image;
    EXPECT_EQ(narrow.rgba, renderScene(scene).image.rgba);
    for (const char* name : {"avx2", "avx512", "auto"}) {
        scene.dials.simd = name;
        EXPECT_LT(largestDifference(narrow, renderScene(scene).image), 1e-5 * brightest(narrow)) << name;
    }
}

// Slides: threads change no bit, crops and instruction sets the last ones only, at texels and at pixels.
TEST(Slides, AreTheSameForThreadsCropsAndInstructionSets) {
    const tbb::global_control three(tbb::global_control::max_allowed_parallelism, 3);
    for (const ShadeMode mode : {ShadeMode::texel, ShadeMode::pixel}) {
        ViewScene scene = smokeScene();
        scene.dials.shade = mode;
        scene.lights.push_back(projector({-70, 60, 50}, 30, quarters(48)));
        const auto with = [&](int threads) { return render(scene, makePlan(scene, threads)).image; };
        const Image whole = with(1);
        EXPECT_EQ(whole.rgba, with(3).rgba);
        ViewScene part = scene;
        part.region = {13, 21, 50, 44};
        const Image crop = renderScene(part).image;
        EXPECT_LT(largestDifference(crop, reframed(whole, part.region)), 1e-4 * brightest(whole));
        scene.dials.simd = "sse4";
        EXPECT_LT(largestDifference(renderScene(scene).image, whole), 1e-4 * brightest(whole));
        scene.dials.simd = "auto";
    }
}

void expectTheSameWithAnyBatch(const ViewScene& scene) {
    Plan plan = makePlan(scene, 2);
    const auto whole = render(scene, plan).image.rgba;
    for (const int sheets : {1, 3, 8, 20}) {
        for (GroupPlan& group : plan.groups) group.batchSheets = sheets;
        EXPECT_EQ(whole, render(scene, plan).image.rgba) << sheets << " sheets a batch";
    }
}

TEST(BatchSize, DoesNotChangeABit) {
    expectTheSameWithAnyBatch(smokeScene());
}

// Rays follow surfaces from sheet to sheet, and lights from two sheets before.
TEST(BatchSize, DoesNotChangeABitOfASurface) {
    ViewScene scene = smokeScene();
    Classified look;
    look.transfer = {{0.2, Rgb(1), 0}, {0.3, Rgb(1, 0.5, 0.2), 2}, {1, Rgb(0.2, 0.5, 0.2), 2}};
    scene.volumes[0].classified = std::make_shared<const Classified>(look);
    scene.lights.push_back(lamp({40, 30, 60}, 4000));
    expectTheSameWithAnyBatch(scene);
}

TEST(OrderOfLights, DoesNotChangeAnything) {
    ViewScene scene = smokeScene();
    const Image before = renderScene(scene).image;
    std::reverse(scene.lights.begin(), scene.lights.end());
    EXPECT_LT(largestDifference(before, renderScene(scene).image), 1e-6 * brightest(before));
}

TEST(OppositeLights, NeedTwoSweepsAndAddUp) {
    ViewScene scene = smokeScene();
    scene.ambient = Rgb(0);
    scene.lights = {distantLight({0.1, -0.3, -1}), distantLight({0.2, 0.1, 1})};
    scene.dials.crossFade = 0;  // alpha is that of one sweep
    const Plan plan = makePlan(scene, 2);
    EXPECT_EQ(plan.groups.size(), 2u);
    const Image both = render(scene, plan).image;
    ViewScene first = scene, second = scene;
    first.lights.resize(1);
    second.lights.erase(second.lights.begin());
    const Image a = renderScene(first).image, b = renderScene(second).image;
    for (std::size_t i = 0; i < both.rgba.size(); ++i)
        if (i % 4 < 3)
            ASSERT_NEAR(both.rgba[i], a.rgba[i] + b.rgba[i], 1e-5);
        else
            ASSERT_NEAR(both.rgba[i], a.rgba[i], 1e-5);
}

// The same scene a million units away: everything is made local in double before it becomes float.
TEST(PlaceOfTheScene, AMillionUnitsAwayIsTheSamePicture) {
    ViewScene scene = smokeScene();
    const Image here = renderScene(scene).image;
    const Vec3 shift(1e6, -2e6, 3e6);
    scene.camera.wsPosition += shift;
    scene.volumes[0].wsFromIs[3] += glm::dvec4(shift, 0);
    for (Light& light : scene.lights) light.wsPosition += shift;
    EXPECT_LT(largestDifference(here, renderScene(scene).image), 2e-5 * brightest(here));
}

TEST(SizeOfTheScene, AThousandthWithAThousandTimesTheExtinctionIsTheSamePicture) {
    ViewScene scene = smokeScene();
    const Image here = renderScene(scene).image;
    const double factor = 1e-3;
    scene.camera.wsPosition *= factor;
    scene.volumes[0].wsFromIs = Mat4(glm::dmat3(factor));
    scene.volumes[0].medium.densityScale /= factor;
    for (Light& light : scene.lights) {
        light.wsPosition *= factor;
        if (!light.distant()) light.intensity *= factor * factor;
    }
    EXPECT_LT(largestDifference(here, renderScene(scene).image), 1e-5 * brightest(here));
}

TEST(Mirror, OfSceneAndCameraMirrorsThePicture) {
    const auto scene = [](double side) {
        ViewScene s = orthographicScene(smokeField(20), {0.2, Rgb(0.9), {}}, 50, 48);
        s.volumes[0].wsFromIs[0][0] *= side;
        s.lights.push_back(distantLight({side, -1, -0.7}));
        return s;
    };
    const Frame a = renderScene(scene(1)), b = renderScene(scene(-1));
    for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 48; ++x) ASSERT_NEAR(pixelOf(a, x, y)[0], pixelOf(b, 47 - x, y)[0], 3e-4) << x << "," << y;
}

TEST(ActiveTiles, LookLikeTheVoxelsTheyStandFor) {
    const auto voxels = boxField({-16, -16, -16}, {15, 15, 15});
    auto tiles = std::make_shared<SparseField>();
    tiles->wsFromIs = voxels->wsFromIs;
    for (int i = 0; i < 8; ++i) tiles->tiles.push_back({Int3(i >> 2 & 1, i >> 1 & 1, i & 1) * 16 - 16, 16, 1.0f});
    tiles->activeVoxels = voxels->activeVoxels;
    tiles->maxValue = 1;
    const auto picture = [](const std::shared_ptr<const SparseField>& field) {
        ViewScene scene = orthographicScene(field, {0.1, Rgb(0.9), {}}, 50, 32);
        scene.lights.push_back(distantLight({1, -1, -1}));
        return renderScene(scene).image;
    };
    EXPECT_LT(largestDifference(picture(voxels), picture(tiles)), 1e-6);
}

TEST(EmptyVolume, IsABlackPicture) {
    auto empty = std::make_shared<SparseField>();
    ViewScene scene = smokeScene();
    scene.volumes[0].field = empty;
    const Frame frame = renderScene(scene);
    for (const float v : frame.image.rgba) ASSERT_EQ(v, 0);
}

}  // namespace
}  // namespace scrim::test
