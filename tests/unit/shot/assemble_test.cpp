// SPDX-License-Identifier: Apache-2.0
#include "support/expect_error.h"
#include "support/fields.h"

#include <scrim/shot/assemble.h>
#include <scrim/volume/field_sampler.h>

#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

// One volume, seen from 100 units away.
Scene someScene() {
    Scene scene;
    scene.camera.resolution = {200, 100};
    scene.camera.fov = 40;
    scene.camera.wsPosition = {0, 0, 100};
    scene.volumes.push_back({});
    scene.volumes[0].name = "smoke";
    scene.volumes[0].densityScale = 0.25;
    return scene;
}

ViewScene assembled(const Scene& scene, const std::vector<std::shared_ptr<const SparseField>>& fields,
                    const std::optional<PixelWindow>& crop = {}) {
    std::vector<VolumeFields> of;
    for (const auto& field : fields) of.push_back({field, {}, {}});
    return assemble(scene, of, crop, 0);
}

TEST(Assemble, HandsOverWhatTheSceneSays) {
    Scene scene = someScene();
    scene.lights.push_back(distantLight({0, -1, 0}));
    scene.ambient = {0.1, 0.2, 0.3};
    scene.dials.texel = 0.75;
    scene.volumes[0].wsFromAsset[3] = {5, 6, 7, 1};
    const auto field = smokeField(6, 0.5);
    const ViewScene view = assemble(scene, {{field, {}, {}}}, {}, 12345);
    ASSERT_EQ(view.volumes.size(), 1u);
    EXPECT_EQ(view.volumes[0].name, "smoke");
    EXPECT_EQ(view.volumes[0].field, field);  // nothing to change: nothing copied
    EXPECT_EQ(view.volumes[0].medium.densityScale, 0.25);
    EXPECT_EQ(transformPoint(view.volumes[0].wsFromIs, Vec3(2, 0, 0)), Vec3(6, 6, 7));
    EXPECT_EQ(view.lights.size(), 1u);
    EXPECT_EQ(view.ambient, Rgb(0.1, 0.2, 0.3));
    EXPECT_EQ(view.dials.texel, 0.75);
    EXPECT_EQ(view.memoryLimit, 12345u);
    EXPECT_EQ(view.region, (PixelWindow{0, 0, 200, 100}));
}

TEST(Assemble, ScalesAMediumAndALookByTheOneScaleOfTheVolume) {
    Scene scene = someScene();
    Classified look;
    look.transfer = {{1, Rgb(1), 0}, {2, Rgb(1), 3}};
    scene.volumes[0].classified = std::make_shared<const Classified>(look);
    scene.volumes[0].medium.densityScale = 9;  // does not count
    const ViewScene view = assembled(scene, {smokeField(6, 0.5)});
    EXPECT_EQ(view.volumes.at(0).medium.densityScale, 0.25);
    EXPECT_EQ(classify(*view.volumes[0].classified, 2).extinction, 0.75);
}

TEST(Assemble, AWindowsExtinctionIsPerVoxel) {
    Scene scene = someScene();
    Classified look;
    look.transfer = {{1, Rgb(1), 0}, {2, Rgb(1), 3}};
    look.perVoxel = true;
    scene.volumes[0].classified = std::make_shared<const Classified>(look);
    scene.volumes[0].wsFromAsset = Mat4(3, 0, 0, 0, 0, 3, 0, 0, 0, 0, 3, 0, 0, 0, 0, 1);
    const ViewScene view = assembled(scene, {smokeField(6, 0.5)});
    EXPECT_NEAR(classify(*view.volumes.at(0).classified, 2).extinction, 0.25 * 3 / 1.5, 1e-12);
}

TEST(Assemble, CutsTheVoxelsOfAMediumAndTellsAClassifiedVolumeItsFaces) {
    Scene scene = someScene();
    scene.volumes[0].clip = {{{1, 0, 0}, 0.25}};  // from x = -0.25 on, in the file's world
    scene.volumes[0].wsFromAsset[3] = {10, 0, 0, 1};
    const auto field = boxField(Int3(-3), Int3(3), 1);
    const ViewScene medium = assembled(scene, {field});
    EXPECT_TRUE(medium.volumes.at(0).wsClip.empty());
    const FieldSampler cut(*medium.volumes[0].field);
    EXPECT_EQ(cut.voxel({-1, 0, 0}), 0);
    EXPECT_EQ(cut.voxel({0, 0, 0}), 0.75);
    EXPECT_EQ(cut.voxel({1, 0, 0}), 1);
    Classified look;
    look.transfer = {{1, Rgb(1), 0}, {2, Rgb(1), 3}};
    scene.volumes[0].classified = std::make_shared<const Classified>(look);
    const ViewScene classified = assembled(scene, {field});
    EXPECT_EQ(classified.volumes.at(0).field, field);
    EXPECT_EQ(classified.volumes[0].wsClip, (std::vector<HalfSpace>{{{1, 0, 0}, -9.75}}));
}

TEST(Assemble, FadesLightsAcrossThePerpendicularOnlyWhereSomethingMoves) {
    const auto fadeOf = [](bool moves, std::optional<double> dial) {
        Scene scene = someScene();
        scene.moves = moves;
        scene.dials.crossFade = dial;
        return assembled(scene, {smokeField(6, 0.5)}).dials.crossFade.value_or(kCrossFade);
    };
    EXPECT_EQ(fadeOf(false, {}), 0);
    EXPECT_EQ(fadeOf(true, {}), kCrossFade);
    EXPECT_EQ(fadeOf(false, kCrossFade), kCrossFade);
    EXPECT_EQ(fadeOf(false, 7), 7);
    EXPECT_EQ(fadeOf(true, 0), 0);
}

TEST(Assemble, LeavesOutVolumesThatShowNothing) {
    Scene scene = someScene();
    scene.volumes.resize(3, scene.volumes[0]);
    scene.volumes[2].name = "last";
    const ViewScene view = assembled(scene, {nullptr, std::make_shared<SparseField>(), smokeField(6)});
    ASSERT_EQ(view.volumes.size(), 1u);
    EXPECT_EQ(view.volumes[0].name, "last");
}

TEST(Ramp, RemapsVoxelsAndTilesButNotEmptySpace) {
    Scene scene = someScene();
    scene.volumes[0].ramp = {{0.25, 1}, {0.5, 3}, {0.75, 2}};
    SparseField field = *makeField({0, 0, 0}, {7, 7, 7}, 1, [](const Vec3& is) { return is.x / 8; });
    field.tiles = {{{8, 0, 0}, 8, 0.375f}, {{16, 0, 0}, 8, 50.0f}};
    const ViewScene view = assembled(scene, {std::make_shared<SparseField>(field)});
    const SparseField& out = *view.volumes.at(0).field;
    ASSERT_EQ(out.blockCount(), 1u);
    // Constant below 1/4 and above 3/4, straight lines in between; 0 was empty and stays so.
    const float expected[] = {0, 1, 1, 2, 3, 2.5f, 2, 2};
    for (int x = 0; x < 8; ++x) EXPECT_FLOAT_EQ(out.block(0)[blockOffset(x, 3, 4)], expected[x]) << x;
    EXPECT_EQ(out.tiles.at(0).value, 2);
    EXPECT_EQ(out.tiles.at(1).value, 2);
    EXPECT_EQ(out.maxValue, 3);
    EXPECT_EQ(field.block(0)[blockOffset(4, 0, 0)], 0.5f);  // the asset may be shared: it is not touched
}

TEST(Lod, HalvesTheResolutionUntilVoxelsAreAsLargeAsAsked) {
    // A pixel is 2 tan(20 deg) / 200 of the distance, about 0.36 at the volume's near side: voxels are 0.27 pixels.
    const double voxel = 0.1;
    const auto field = boxField({-32, -32, -32}, {31, 31, 31}, voxel);
    for (const auto& [lod, factor] : {std::pair{0.0, 1.0}, {0.5, 1.0}, {0.6, 2.0}, {1.2, 4.0}, {2.5, 8.0}}) {
        Scene scene = someScene();
        scene.dials.lod = lod;
        const ViewScene view = assembled(scene, {field});
        const ViewVolume& volume = view.volumes.at(0);
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_NEAR(glm::length(Vec3(volume.wsFromIs[axis])), voxel * factor, 1e-12) << "lod " << lod;
        EXPECT_EQ(volume.field->activeVoxels, static_cast<std::uint64_t>(64 * 64 * 64 / (factor * factor * factor)));
        EXPECT_EQ(volume.field == field, factor == 1);
        // The middle of the volume stays where it was.
        const Vec3 middle = transformed(volume.wsFromIs, volume.field->isBounds()).center();
        EXPECT_LT(glm::length(middle - Vec3(-0.5 * voxel)), 1e-9);
    }
}

// Slices that are far thinner than pixels are put together until they are as thick as asked, or voxels are cubes.
TEST(Lod, HalvesOnlyTheShortEdgesOfFlatVoxels) {
    const auto field = boxField({-32, -32, -32}, {31, 31, 31}, 0.1);
    const Vec3 flat(1, 1, 1.0 / 32);
    for (const auto& [lod, x, z] :
         {std::tuple{0.035, 1.0, 4.0}, {0.13, 1.0, 16.0}, {0.3, 1.0, 32.0}, {0.6, 2.0, 64.0}}) {
        Scene scene = someScene();
        scene.camera.type = CameraType::orthographic;
        scene.camera.height = 40;
        scene.volumes[0].wsFromAsset = glm::scale(Mat4(1), flat);
        scene.dials.lod = lod;
        const ViewVolume volume = assembled(scene, {field}).volumes.at(0);
        const Vec3 edges(volume.wsFromIs[0].x, volume.wsFromIs[1].y, volume.wsFromIs[2].z);
        EXPECT_LT(glm::distance(edges, 0.1 * flat * Vec3(x, x, z)), 1e-12) << "lod " << lod;
        const double layers = std::max(64 / z, 2.0);  // there are some to both sides of 0
        EXPECT_EQ(volume.field->activeVoxels, static_cast<std::uint64_t>(64 * 64 / (x * x) * layers)) << "lod " << lod;
    }
}

// In an orthographic picture distance does not count: 0.1 units are 0.25 pixels of 40 / 100 units.
TEST(Lod, OfAnOrthographicPictureIsMeasuredInItsPixels) {
    Scene scene = someScene();
    scene.camera.type = CameraType::orthographic;
    scene.camera.height = 40;
    const auto field = boxField({-32, -32, -32}, {31, 31, 31}, 0.1);
    scene.dials.lod = 0.49;
    EXPECT_EQ(assembled(scene, {field}).volumes.at(0).field, field);
    scene.dials.lod = 0.51;
    EXPECT_EQ(assembled(scene, {field}).volumes.at(0).field->activeVoxels, 32u * 32 * 32);
}

// However small it is in the picture, coarsening ends.
TEST(Lod, EndsAtOneVoxel) {
    Scene scene = someScene();
    scene.camera.wsPosition = {0, 0, 1e9};
    scene.dials.lod = 4;
    EXPECT_GE(assembled(scene, {boxField({-8, -8, -8}, {7, 7, 7})}).volumes.at(0).field->activeVoxels, 1u);
}

TEST(Region, IsThePictureWithItsOverscan) {
    Scene scene = someScene();
    scene.overscan = 7;
    EXPECT_EQ(assembled(scene, {nullptr}).region, (PixelWindow{-7, -7, 207, 107}));
}

TEST(Region, IsLimitedByTheCrop) {
    Scene scene = someScene();
    scene.overscan = 10;
    EXPECT_EQ(assembled(scene, {nullptr}, PixelWindow{20, 30, 40, 50}).region, (PixelWindow{20, 30, 40, 50}));
    EXPECT_EQ(assembled(scene, {nullptr}, PixelWindow{-50, 30, 40, 5000}).region, (PixelWindow{-10, 30, 40, 110}));
}

TEST(Region, OutsideOfThePictureIsAnError) {
    Scene scene = someScene();
    scene.overscan = 2;
    EXPECT_EQ(errorOf(ErrorKind::usage,
                      [&] {
                          assembled(scene, {nullptr}, PixelWindow{300, 0, 310, 20});
                      }),
              "the crop 300,0,310,20 holds no pixel of the picture, which is -2,-2,202,102");
    EXPECT_EQ(errorOf(ErrorKind::usage,
                      [&] {
                          assembled(scene, {nullptr}, PixelWindow{50, 50, 50, 60});
                      }),
              "the crop 50,50,50,60 holds no pixel of the picture, which is -2,-2,202,102");
}

}  // namespace
}  // namespace scrim::test
