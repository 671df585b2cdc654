// SPDX-License-Identifier: Apache-2.0
// Which grids of a volume are read, and what is said where they cannot be.
#include <scrim/shot/field_store.h>

#include <scrim/shot/assemble.h>
#include <scrim/base/error.h>
#include <scrim/guard/field_transfer.h>
#include <scrim/volume/vdb_file.h>

#include "support/expect_error.h"
#include "support/temp_folder.h"
#include "support/vdb_make.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>

#include <unistd.h>

namespace scrim::cli {
namespace {

using test::box;
using test::errorOf;

ColourGrid colour(const std::string& grid, const std::string& where = "") {
    ColourGrid albedo;
    albedo.grid = grid;
    albedo.where = where;
    return albedo;
}

Emission glow(const std::string& grid, const std::string& where = "") {
    Emission emission;
    emission.grid = grid;
    emission.where = where;
    return emission;
}

class FieldStoreTest : public ::testing::Test {
  protected:
    void SetUp() override {
        test::makeVdb(path(), {{.name = "density", .voxels = box({0, 0, 0}, {9, 9, 9}, 0.5)},
                               {.name = "Cd", .type = "vec3s", .colours = {{{0, 0, 0}, {1, 2, 3}}}},
                               {.name = "heat", .voxels = box({0, 0, 0}, {3, 3, 3}, 7)},
                               {.name = "ids", .type = "int32"}});
        scene.volumes.resize(1);
        scene.camera.wsPosition = {5, 5, 60};  // sees it
        volume().file = path();
        volume().where = "s.toml:2:8";
    }

    std::string path() const { return m_folder.file("a.vdb"); }
    SceneVolume& volume() { return scene.volumes.front(); }
    Fields fields() { return store.fieldsOf(scene, store.filesOf(scene)); }
    std::string failure() {
        return errorOf(ErrorKind::input, [&] { fields(); });
    }

    Scene scene;
    std::vector<std::string> heard;
    FieldStore store{{}, [this](Severity, const std::string& text) { heard.push_back(text); }};

  private:
    test::TempFolder m_folder;
};

TEST_F(FieldStoreTest, ShadesDensitiesAndEmissionAndKeepsTheResults) {
    volume().shading.mask = Mask{"heat", Remap{{0, 14}, {0, 1}}, "s.toml:4:9"};
    volume().emission = {glow("density")};
    volume().emission[0].mask = Mask{"heat", {}, ""};
    const Fields first = fields();
    EXPECT_EQ(first[0].density->activeVoxels, 4u * 4 * 4) << "there is no heat elsewhere";
    EXPECT_FLOAT_EQ(first[0].density->maxValue, 0.25f);
    ASSERT_EQ(first[0].emissionMasks.size(), 1u);
    EXPECT_FLOAT_EQ(first[0].emissionMasks[0]->maxValue, 7);
    EXPECT_EQ(fields()[0].density, first[0].density) << "it is computed once";
    volume().shading.mask->remap.to = {0, 2};
    EXPECT_FLOAT_EQ(fields()[0].density->maxValue, 0.5f);
    volume().shading = {};
    EXPECT_EQ(fields()[0].density->activeVoxels, 1000u);
    volume().displacement = Noise{.amount = 3, .frequency = 0.1, .octaves = 1};
    const Fields moved = fields();
    EXPECT_NE(moved[0].density->blockOrigins, first[0].density->blockOrigins);
    EXPECT_NE(moved[0].emissionMasks[0], first[0].emissionMasks[0]) << "all grids are displaced";
    volume().shading.mask = Mask{"fuel", {}, "s.toml:4:9"};
    EXPECT_EQ(failure().substr(0, 12), "s.toml:4:9: ");
}

TEST_F(FieldStoreTest, GivesAllGridsOfAVolume) {
    volume().albedoGrid = colour("Cd");
    volume().emission = {glow("heat"), glow("density")};
    const Fields all = fields();
    ASSERT_EQ(all.size(), 1u);
    EXPECT_EQ(all[0].density->name, "density");
    EXPECT_EQ(all[0].albedo[0]->name, "Cd.r");
    EXPECT_EQ(all[0].albedo[2]->maxValue, 3);
    ASSERT_EQ(all[0].emission.size(), 2u);
    EXPECT_EQ(all[0].emission[0]->maxValue, 7);
    EXPECT_EQ(all[0].emission[1]->maxValue, 0.5f);
    const Fields again = fields();
    EXPECT_EQ(again[0].albedo[1], all[0].albedo[1]) << "read twice";
    EXPECT_GT(bytesOf(all), 6 * 512 * sizeof(float));
}

TEST_F(FieldStoreTest, ReadsTheFilesOfAFrameSideBySide) {
    // Each of these loads ends only once another has begun.
    const int sent = createTransfer();
    SparseField sample = VdbFile::open(path()).field("density", {});
    sendFields(sent, {sample}, {});
    std::string bytes(static_cast<std::size_t>(::lseek(sent, 0, SEEK_END)), '\0');
    ASSERT_EQ(::pread(sent, bytes.data(), bytes.size(), 0), static_cast<ssize_t>(bytes.size()));
    ::close(sent);
    scene.volumes.push_back(volume());
    for (std::size_t i = 0; i < 2; ++i) {
        scene.volumes[i].file = path() + "_" + std::to_string(i);
        test::writeBytes(scene.volumes[i].file, "with another\n" + bytes);
    }
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    store.listen({VolumeLoading::guarded, SCRIM_ECHO_LOADER}, {}, [&] {
        if (std::chrono::steady_clock::now() > end) throw Error(ErrorKind::interrupted, "one waits for the other");
    });
    const Fields all = store.fieldsOf(scene, store.filesOf(scene), VolumesOf::scene);
    ASSERT_EQ(all.size(), 2u);
    EXPECT_EQ(all[0].density->activeVoxels, 1000u);
    EXPECT_EQ(all[1].density->activeVoxels, 1000u);
}

TEST_F(FieldStoreTest, ReadersOfTheNextFrameShareTheMemoryThatIsLeft) {
    constexpr std::size_t kGigabyte = std::size_t{1} << 30;
    for (const char* name : {"b", "c"}) {
        const SceneVolume& another = scene.volumes.emplace_back(volume());
        scene.volumes.back().file = path() + name + ".vdb";
        std::filesystem::copy_file(path(), another.file);
    }
    store.listen({VolumeLoading::guarded}, {}, {});
    const auto ahead = [&](std::size_t memory) {
        store.readAhead(scene, store.filesOf(scene), VolumesOf::scene, memory);
        return store.memoryAhead();
    };
    const std::size_t unlimited = ahead(0);
    EXPECT_GT(unlimited, 20 * kGigabyte);
    EXPECT_EQ(ahead(100 * kGigabyte), 100 * kGigabyte / 6 * 6);
    EXPECT_EQ(ahead(7 * kGigabyte), 7 * kGigabyte / 6 * 6);
    EXPECT_EQ(ahead(5 * kGigabyte), 5 * kGigabyte / 4 * 4) << "the third would have too little to read anything";
    EXPECT_EQ(ahead(2 * kGigabyte), 2 * kGigabyte);
    EXPECT_EQ(ahead(2 * kGigabyte - 1), 0u);
    EXPECT_EQ(ahead(1), 0u);
    EXPECT_EQ(ahead(7 * kGigabyte), 7 * kGigabyte / 6 * 6);
    EXPECT_EQ(fields().size(), 3u) << "and what they read is taken";
}

TEST_F(FieldStoreTest, LeavesGridsThatNothingIsMadeOf) {
    volume().densityScale = 0;
    volume().densityGrid = "missing";
    volume().albedoGrid = colour("missing");
    volume().emission = {glow("heat")};
    const Fields all = fields();
    EXPECT_FALSE(all[0].density);
    EXPECT_FALSE(all[0].albedo[0]);
    EXPECT_EQ(all[0].emission.at(0)->name, "heat");
    volume().densityGrid = "";
    volume().albedoGrid.reset();
    volume().emission.clear();
    EXPECT_EQ(fields()[0].density->name, "density") << "of a volume without anything, as ever";
}

TEST_F(FieldStoreTest, HasNothingOfAVolumeThatIsNotThere) {
    volume().albedoGrid = colour("Cd");
    volume().emission = {glow("heat")};
    std::vector<VolumeFile> files = store.filesOf(scene);
    files[0].state = FileState::black;
    const Fields all = store.fieldsOf(scene, files);
    EXPECT_FALSE(all[0].density);
    EXPECT_FALSE(all[0].albedo[2]);
    ASSERT_EQ(all[0].emission.size(), 1u);
    EXPECT_FALSE(all[0].emission[0]);
}

TEST_F(FieldStoreTest, SaysWhereAGridIsAskedForThatIsNotThere) {
    const std::string list = "'density' (float), 'Cd' (vec3s), 'heat' (float), 'ids' (int32)";
    volume().emission = {glow("heat", "s.toml:7:1"), glow("flames", "s.toml:9:1")};
    EXPECT_EQ(failure(), "s.toml:9:1: " + path() + ": no grid 'flames'; it holds " + list);
    volume().emission.clear();
    volume().albedoGrid = colour("color", "s.toml:5:20");
    EXPECT_EQ(failure(), "s.toml:5:20: " + path() + ": no grid 'color'; it holds " + list);
    volume().albedoGrid->grid = "ids";
    EXPECT_TRUE(failure().starts_with("s.toml:5:20: " + path() + ": grid 'ids' holds int32 values, where a colour is "))
        << failure();
    volume().densityGrid = "rho";
    EXPECT_EQ(failure(), path() + ": no grid 'rho'; it holds " + list);
    volume().densityWhere = "s.toml:4:9";
    EXPECT_EQ(failure(), "s.toml:4:9: " + path() + ": no grid 'rho'; it holds " + list);
}

TEST_F(FieldStoreTest, SaysOnceWhatIsWrongWithAGreyColour) {
    test::makeVdb(path(), {{.name = "density", .voxels = {{{0, 0, 0}, 1}}},
                           {.name = "grey", .voxels = {{{0, 0, 0}, -1}, {{1, 0, 0}, 1}}}});
    volume().albedoGrid = colour("grey");
    const Fields all = fields();
    for (const auto& component : all[0].albedo) EXPECT_EQ(component->maxValue, 1);
    EXPECT_EQ(heard,
              (std::vector{path() + ": grid 'grey': of 2 voxels with a value 1 are below 0, and count as empty"}));
}

// A check of a picture must not rely on what was left out of it.
TEST_F(FieldStoreTest, LoadsWhatIsOutOfViewWhereAllIsWanted) {
    scene.camera.wsPosition = {5, 5, -60};  // and looks away
    const std::vector<VolumeFile> files = store.filesOf(scene);
    const Fields seen = store.fieldsOf(scene, files), all = store.fieldsOf(scene, files, VolumesOf::scene);
    EXPECT_FALSE(seen[0].density);
    ASSERT_TRUE(all[0].density);
    EXPECT_EQ(all[0].culled, seen[0].culled);  // and yet the picture does without
    EXPECT_TRUE(assemble(scene, all, {}, 0).volumes.empty());
    EXPECT_EQ(assemble(scene, all, {}, 0, VolumesOf::scene).volumes.size(), 1u);
}

class SourceStoreTest : public FieldStoreTest {
  protected:
    void SetUp() override {
        FieldStoreTest::SetUp();
        volume().file.clear();
        volume().source = "noise";
        ::setenv("SCRIM_PLUGIN_PATH", SCRIM_BUILT_SOURCES, 1);
    }
    void TearDown() override { ::unsetenv("SCRIM_PLUGIN_PATH"); }
};

TEST_F(SourceStoreTest, RunsASourceOnceForAllItsGrids) {
    volume().albedoGrid = colour("density");
    volume().emission = {glow("density")};
    const Fields all = fields();
    ASSERT_TRUE(all[0].density);
    for (const auto& component : all[0].albedo) EXPECT_EQ(component, all[0].density);
    EXPECT_EQ(all[0].emission.at(0), all[0].density);
}

TEST_F(SourceStoreTest, SaysWhereAGridIsAskedForThatTheSourceDoesNotMake) {
    volume().emission = {glow("flames", "s.toml:9:1")};
    EXPECT_EQ(failure(), "s.toml:9:1: source 'noise' makes no grid 'flames'; there is 'density'");
    volume().albedoGrid = colour("Cd", "s.toml:5:20");
    EXPECT_EQ(failure(),
              "s.toml:5:20: source 'noise' makes no grid 'Cd' (nor 'Cd.r', 'Cd.g', 'Cd.b'); there is 'density'");
    volume().densityGrid = "rho";
    EXPECT_EQ(failure(), "s.toml:2:8: source 'noise' makes no grid 'rho'; there is 'density'");
}

}  // namespace
}  // namespace scrim::cli
