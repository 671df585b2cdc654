// SPDX-License-Identifier: Apache-2.0
// Fields that are made of a scene's grids: colours times densities, and light by ramps.
#include "support/expect_error.h"
#include "support/fields.h"

#include <scrim/shot/assemble.h>
#include <scrim/shot/derived_fields.h>
#include <scrim/volume/field_sampler.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace scrim::test {
namespace {

double voxelOf(const FieldPointer& field, const Int3& at) {
    return FieldSampler(*field, Kernel::linear).voxel(at);
}

FieldPointer withVoxelAt(const FieldPointer& field, const Int3& origin, float value) {
    auto out = std::make_shared<SparseField>(*field);
    std::vector<float> values(field->block(0), field->block(0) + field->blockCount() * kBlockVoxels);
    values.resize(values.size() + kBlockVoxels, 0.0f);
    values[values.size() - kBlockVoxels + std::size_t(blockOffset(3, 3, 3))] = value;
    out->blockOrigins.push_back(origin);
    const auto kept = std::make_shared<std::vector<float>>(std::move(values));
    out->blockValues = {kept, kept->data()};
    ++out->activeVoxels;
    return out;
}

TEST(Strays, AreLeftOutWhereTheyAreFaintAndFar) {
    const auto smoke = smokeField(16);
    for (const Int3 far : {Int3(50000, 0, 0), Int3(8000, 16000, 8000000)}) {
        const FieldPointer whole = withVoxelAt(smoke, far, 0.001f);
        const FieldPointer rest = withoutStrays(whole, 1);
        EXPECT_EQ(rest->isBounds(), smoke->isBounds());
        EXPECT_EQ(rest->activeVoxels, smoke->activeVoxels);
        EXPECT_EQ(voxelOf(rest, {2, 1, 3}), voxelOf(smoke, {2, 1, 3}));
        EXPECT_EQ(withoutStrays(whole, 2000), whole) << "an optical depth of 2 shows";
    }
    EXPECT_EQ(withoutStrays(smoke, 1), smoke);
    // Next to the smoke it enlarges nothing.
    const FieldPointer beside = withVoxelAt(smoke, {40, 0, 0}, 0.001f);
    EXPECT_EQ(withoutStrays(beside, 1), beside);
}

// Each block is as faint, but together they take more than a little.
TEST(Strays, AreKeptWhereTheyAreMany) {
    FieldPointer fog = smokeField(16);
    for (int i = 0; i < 60; ++i) fog = withVoxelAt(fog, Int3(5000 + 8 * i, 0, 0), 0.02f);
    const FieldPointer rest = withoutStrays(fog, 1);
    EXPECT_GT(rest->isBounds().upper.x, 5000);
}

TEST(ScatteringFields, AreDensityTimesAlbedoAtTheDensitysVoxels) {
    const auto density = makeField({-5, -5, -5}, {9, 9, 9}, 1, [](const Vec3& is) { return 1 + 0.1 * is.x; });
    std::array<FieldPointer, 3> albedo;
    for (int c = 0; c < 3; ++c)
        albedo[static_cast<std::size_t>(c)] =
            makeField({-8, -8, -8}, {15, 15, 15}, 1, [c](const Vec3& is) { return 0.02 * (c + 1) * (is.y + 9); });
    ColourGrid look;
    look.scale = 0.5;
    const std::vector<FieldPointer> fields = scatteringFields(*density, albedo, look);
    ASSERT_EQ(fields.size(), 3u);
    for (int c = 0; c < 3; ++c)
        for (const Int3& at : {Int3(-5, -5, -5), Int3(0, 3, 2), Int3(9, 9, 9)})
            EXPECT_NEAR(voxelOf(fields[static_cast<std::size_t>(c)], at),
                        (1 + 0.1 * at.x) * 0.5 * 0.02 * (c + 1) * (at.y + 9), 1e-6);
    EXPECT_EQ(voxelOf(fields[0], {12, 0, 0}), 0);
}

TEST(ScatteringFields, TakeColoursFromOtherLatticesAndSpaces) {
    const auto density = boxField({0, 0, 0}, {7, 7, 7});
    // Half as fine, and shifted: linear in between.
    const auto ramp = makeField({-8, -8, -8}, {15, 15, 15}, 2, [](const Vec3& is) { return 0.4 + 0.02 * is.x; });
    auto shifted = std::make_shared<SparseField>(*ramp);
    shifted->wsFromIs[3] = {0.5, 0, 0, 1};
    ColourGrid look;
    look.workingFromGrid = Mat3(0.0);
    look.workingFromGrid[0] = {1, 0.5, 0.25};  // what was red has some of all
    const auto fields = scatteringFields(*density, {shifted, shifted, shifted}, look);
    for (const int x : {0, 3, 7}) {
        const double red = 0.4 + 0.02 * (x - 0.5) / 2;
        EXPECT_NEAR(voxelOf(fields[0], {x, 2, 5}), red, 1e-6);
        EXPECT_NEAR(voxelOf(fields[1], {x, 2, 5}), 0.5 * red, 1e-6);
        EXPECT_NEAR(voxelOf(fields[2], {x, 2, 5}), 0.25 * red, 1e-6);
    }
}

TEST(ScatteringFields, AreNeverBrighterThanTheDensity) {
    const auto density = boxField({0, 0, 0}, {7, 7, 7});
    const auto bright = makeField({0, 0, 0}, {7, 7, 7}, 1, [](const Vec3&) { return 3.0; });
    EXPECT_EQ(voxelOf(scatteringFields(*density, {bright, bright, bright}, {})[1], {3, 3, 3}), 1);
}

TEST(ScatteringFields, CutTilesIntoBlocks) {
    auto density = std::make_shared<SparseField>();
    density->tiles = {{{0, 0, 0}, 16, 0.5f}};
    density->activeVoxels = 16 * 16 * 16;
    const auto albedo = makeField({0, 0, 0}, {15, 15, 15}, 1, [](const Vec3& is) { return is.z / 20; });
    const auto fields = scatteringFields(*density, {albedo, albedo, albedo}, {});
    for (const Int3& at : {Int3(1, 2, 3), Int3(15, 9, 12)}) EXPECT_NEAR(voxelOf(fields[0], at), 0.025 * at.z, 1e-6);
}

TEST(EmittedFields, AreOneForShadesOfOneColourAndThreeForOthers) {
    const auto field = makeField({0, 0, 0}, {7, 7, 7}, 1, [](const Vec3& is) { return is.x / 7; });
    Emission emission;
    emission.scale = 2;
    EXPECT_EQ(emittedFields(field, emission).at(0).field, field);  // nothing to change: nothing copied
    EXPECT_EQ(emittedFields(field, emission).at(0).color, Rgb(2));
    emission.ramp = {{0, Rgb(0)}, {0.5, {0.5, 0.25, 0}}, {1, {2, 1, 0}}};
    const auto shades = emittedFields(field, emission);
    ASSERT_EQ(shades.size(), 1u);
    emission.ramp.back().second = {2, 1, 0.5};
    const auto colours = emittedFields(field, emission);
    ASSERT_EQ(colours.size(), 3u);
    for (const int x : {0, 2, 5, 7}) {
        const double v = x / 7.0, t = v < 0.5 ? 0.5 * v / 0.5 : 0.5 + 1.5 * (v - 0.5) / 0.5;
        const Rgb shade = voxelOf(shades[0].field, {x, 1, 1}) * shades[0].color;
        Rgb sum(0);
        for (const EmittedField& e : colours) sum += voxelOf(e.field, {x, 1, 1}) * e.color;
        EXPECT_NEAR(shade.x, 2 * t, 1e-5);
        EXPECT_NEAR(shade.y, t, 1e-5);
        EXPECT_NEAR(sum.x, 2 * t, 1e-5);
        EXPECT_NEAR(sum.y, t, 1e-5);
    }
    emission.ramp = {{0, Rgb(0)}, {1, Rgb(0)}};
    EXPECT_TRUE(emittedFields(field, emission).empty());
}

Scene sceneOfOneVolume() {
    Scene scene;
    scene.camera.resolution = {20, 20};
    scene.camera.wsPosition = {4, 4, 60};
    scene.volumes.resize(1);
    scene.volumes[0].name = "smoke";
    return scene;
}

TEST(Assemble, LinksLightsByName) {
    Scene scene = sceneOfOneVolume();
    for (const char* name : {"key", "fill", "rim"}) {
        scene.lights.push_back(distantLight({0, 0, -1}));
        scene.lights.back().name = name;
    }
    const std::vector<VolumeFields> fields{{boxField({0, 0, 0}, {7, 7, 7}), {}, {}}};
    EXPECT_TRUE(assemble(scene, fields, {}, 0).volumes.at(0).lights.empty());
    scene.volumes[0].lights = {"rim", "key"};
    EXPECT_EQ(assemble(scene, fields, {}, 0).volumes.at(0).lights, (std::vector<bool>{true, false, true}));
    scene.volumes[0].lights.emplace();
    EXPECT_EQ(assemble(scene, fields, {}, 0).volumes.at(0).lights, (std::vector<bool>{false, false, false}));
}

TEST(Assemble, CountsWhatItMakesAgainstTheMemoryLimit) {
    Scene scene = sceneOfOneVolume();
    const auto density = boxField({0, 0, 0}, {7, 7, 7});
    scene.volumes[0].albedoGrid.emplace();
    const std::vector<VolumeFields> fields{{density, {density, density, density}, {}}};
    EXPECT_EQ(assemble(scene, fields, {}, 100'000).memoryLimit, 100'000 - 3 * density->bytes());
    const std::string message = errorOf(ErrorKind::memory, [&] { assemble(scene, fields, {}, 3 * density->bytes()); });
    EXPECT_NE(message.find("the data made from the volumes' grids"), std::string::npos) << message;
}

TEST(Assemble, LeavesOutVolumesOutOfViewAndSaysSo) {
    Scene scene = sceneOfOneVolume();
    scene.volumes.push_back(scene.volumes[0]);
    scene.volumes[1].name = "far";
    scene.volumes[1].wsFromAsset[3] = {900, 0, 0, 1};
    const auto density = boxField({0, 0, 0}, {7, 7, 7});
    const ViewScene view = assemble(scene, {{density, {}, {}}, {density, {}, {}}}, {}, 0);
    EXPECT_EQ(view.volumes.size(), 1u);
    ASSERT_EQ(view.culled.size(), 1u);
    EXPECT_EQ(view.culled[0].first, "far");
}

}  // namespace
}  // namespace scrim::test
