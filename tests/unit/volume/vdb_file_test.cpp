// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/vdb_file.h>

#include <scrim/base/parallel.h>
#include <scrim/volume/vdb_write.h>

#include "support/data.h"
#include "support/expect_error.h"
#include "support/temp_folder.h"
#include "support/vdb_make.h"

#include <cmath>
#include <cstring>
#include <limits>

#include <sys/stat.h>

namespace scrim::test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

struct Heard {
    std::vector<std::string> infos, warnings;
    MessageSink sink() {
        return
            [this](Severity s, const std::string& text) { (s == Severity::info ? infos : warnings).push_back(text); };
    }
};

VdbFile made(const TempFolder& folder, const std::vector<MadeGrid>& grids) {
    makeVdb(folder.file("a.vdb"), grids);
    return VdbFile::open(folder.file("a.vdb"));
}

SparseField fieldOf(const MadeGrid& grid) {
    const TempFolder folder;
    return made(folder, {grid}).field("", {});
}

TEST(VdbFile, ReadsVoxelsWhereTheyAre) {
    const SparseField field =
        fieldOf({.voxels = {{{-1, 0, 9}, 0.25}, {{7, 2, 3}, 4.0}}, .voxelSize = 0.5, .translate = {1, 2, 3}});
    ASSERT_EQ(field.blockCount(), 2u);
    EXPECT_EQ(field.blockOrigins[0], Int3(-8, 0, 8));
    EXPECT_EQ(field.blockOrigins[1], Int3(0, 0, 0));
    EXPECT_EQ(field.block(0)[blockOffset(7, 0, 1)], 0.25f);
    EXPECT_EQ(field.block(1)[blockOffset(7, 2, 3)], 4.0f);
    EXPECT_EQ(field.activeVoxels, 2u);
    EXPECT_EQ(field.maxValue, 4.0f);
    EXPECT_EQ(transformPoint(field.wsFromIs, Vec3(2, 0, -2)), Vec3(2, 2, 2));
}

TEST(VdbFile, ReadsHalfAndDoubleGrids) {
    for (const char* type : {"half", "double"}) {
        const SparseField field = fieldOf({.type = type, .voxels = {{{1, 2, 3}, 0.75}}});
        ASSERT_EQ(field.blockCount(), 1u) << type;
        EXPECT_EQ(field.block(0)[blockOffset(1, 2, 3)], 0.75f) << type;
    }
}

TEST(VdbFile, InactiveVoxelsAreEmptyWhateverTheyHold) {
    const SparseField field = fieldOf({.voxels = {{{0, 0, 0}, 1.0}}, .inactive = {{{1, 0, 0}, 5.0}}, .background = 3});
    EXPECT_EQ(field.activeVoxels, 1u);
    EXPECT_EQ(field.block(0)[blockOffset(1, 0, 0)], 0.0f);
    EXPECT_EQ(field.block(0)[blockOffset(2, 0, 0)], 0.0f);
}

TEST(VdbFile, ReportsNonFiniteVoxelsOnceWithTheirNumber) {
    const TempFolder folder;
    const VdbFile file =
        made(folder, {{.voxels = {{{0, 0, 0}, kNaN}, {{0, 0, 1}, INFINITY}, {{0, 0, 2}, -2.0}, {{0, 0, 3}, 1.0}}}});
    Heard heard;
    const SparseField field = file.field("density", heard.sink());
    EXPECT_EQ(field.nonFinite, 2u);
    EXPECT_EQ(field.negative, 1u);
    EXPECT_EQ(field.activeVoxels, 1u);
    ASSERT_EQ(heard.warnings.size(), 1u);
    EXPECT_EQ(heard.warnings[0],
              folder.file("a.vdb") +
                  ": grid 'density': of 4 voxels with a value 1 are below 0 and 2 are not finite, and count as empty");
    EXPECT_TRUE(heard.infos.empty());
}

TEST(VdbFile, DropsBlocksThatHoldNothing) {
    const SparseField field = fieldOf({.voxels = {{{0, 0, 0}, 0.0}, {{8, 0, 0}, -1.0}, {{16, 0, 0}, 1.0}}});
    ASSERT_EQ(field.blockCount(), 1u);
    EXPECT_EQ(field.blockOrigins[0], Int3(16, 0, 0));
    EXPECT_EQ(field.block(0)[0], 1.0f);
}

TEST(VdbFile, KeepsTilesAsTiles) {
    const SparseField field = fieldOf({.voxels = {{{300, 0, 0}, 1.0}},
                                       .tiles = {{{-1, 0, 0}, 128, 2.0},
                                                 {{8, 0, 0}, 8, 0.5},
                                                 {{16, 0, 0}, 8, -1.0},
                                                 {{24, 0, 0}, 8, kNaN},
                                                 {{32, 0, 0}, 8, 0.0}}});
    ASSERT_EQ(field.tiles.size(), 2u);
    EXPECT_EQ(field.tiles[0].origin, Int3(-128, 0, 0));
    EXPECT_EQ(field.tiles[0].edge, 128);
    EXPECT_EQ(field.tiles[0].value, 2.0f);
    EXPECT_EQ(field.tiles[1].origin, Int3(8, 0, 0));
    EXPECT_EQ(field.tiles[1].edge, 8);
    EXPECT_EQ(field.blockCount(), 1u);
    EXPECT_EQ(field.activeVoxels, 128u * 128 * 128 + 512 + 1);
    EXPECT_EQ(field.negative, 512u);
    EXPECT_EQ(field.nonFinite, 512u);
}

TEST(VdbFile, IsTheSameForAnyNumberOfThreads) {
    const TempFolder folder;
    std::vector<test::MadeVoxel> voxels;
    for (int i = 0; i < 4000; ++i) voxels.push_back({{(i * 37) % 301 - 150, (i * 53) % 211, (i * 91) % 97}, i - 50.0});
    const VdbFile file = made(folder, {{.voxels = voxels}});
    const SparseField many = file.field("", {});
    SparseField one;
    TaskArena(1).run([&] { one = file.field("", {}); });
    ASSERT_EQ(many.blockOrigins, one.blockOrigins);
    EXPECT_EQ(std::memcmp(many.block(0), one.block(0), one.blockCount() * kBlockVoxels * sizeof(float)), 0);
    EXPECT_EQ(many.activeVoxels, one.activeVoxels);
}

TEST(VdbFile, TurnsALevelSetIntoFogAndSaysSo) {
    const TempFolder folder;
    const VdbFile file = made(folder, {{.name = "ball", .type = "sphere", .voxelSize = 0.1}});
    Heard heard;
    const SparseField field = file.field("", heard.sink());
    ASSERT_EQ(heard.infos.size(), 1u);
    EXPECT_EQ(heard.infos[0], folder.file("a.vdb") + ": grid 'ball' is a level set: turned into fog of density 1");
    EXPECT_EQ(field.maxValue, 1.0f);
    // Voxels whose centre lies inside a ball of radius 10 voxels.
    EXPECT_NEAR(static_cast<double>(field.activeVoxels), 4.0 / 3 * M_PI * 1000, 150);
    EXPECT_EQ(field.negative, 0u);
}

TEST(VdbFile, ResamplesAFrustumAndKeepsItsVolume) {
    const TempFolder folder;
    const MadeGrid frustum{.voxels = box({2, 2, 2}, {14, 14, 14}, 1), .voxelSize = 0.5, .frustum = true};
    const VdbFile file = made(folder, {frustum});
    EXPECT_FALSE(file.info().grids.at(0).affine);
    Heard heard;
    const SparseField field = file.field("", heard.sink());
    ASSERT_EQ(heard.infos.size(), 1u);
    EXPECT_NE(heard.infos[0].find(": grid 'density' has a transform that is not affine: resampled to voxels of edge "),
              std::string::npos)
        << heard.infos[0];
    double sum = 0;
    for (std::size_t i = 0; i < field.blockCount(); ++i)
        for (int n = 0; n < kBlockVoxels; ++n) sum += field.block(i)[n];
    const double edge = field.wsFromIs[0][0];
    // Trilinear interpolation spreads each voxel over one more, so the integral is the volume of the voxels;
    // what is left is the error of sums over a lattice, and of the ramps at the sides being not quite
    // straight.
    const double volume = test::frustumVolume(frustum, {2, 2, 2}, {14, 14, 14});
    EXPECT_NEAR(sum * edge * edge * edge, volume, 0.02 * volume);
    EXPECT_LE(field.maxValue, 1.0f);
}

TEST(VdbFile, PrefersDensityThenFogThenAnythingThatIsNotALevelSet) {
    const TempFolder folder;
    const MadeGrid sphere{.name = "ball", .type = "sphere"};
    const MadeGrid heat{.name = "heat", .gridClass = "", .voxels = {{{0, 0, 0}, 1.0}}};
    const MadeGrid fog{.name = "fog", .voxels = {{{0, 0, 0}, 1.0}}};
    const MadeGrid density{.name = "density", .gridClass = "", .voxels = {{{0, 0, 0}, 1.0}}};
    const MadeGrid vector{.name = "Cd", .type = "vec3s", .voxels = {{{0, 0, 0}, 1.0}}};
    EXPECT_EQ(made(folder, {vector, sphere, heat, fog, density}).field("", {}).name, "density");
    EXPECT_EQ(made(folder, {vector, sphere, heat, fog}).field("", {}).name, "fog");
    EXPECT_EQ(made(folder, {vector, sphere, heat}).field("", {}).name, "heat");
    EXPECT_EQ(made(folder, {vector, sphere}).field("", {}).name, "ball");
}

TEST(VdbFile, TellsEqualNamesApartByIndex) {
    const TempFolder folder;
    const VdbFile file = made(
        folder,
        {{.voxels = {{{0, 0, 0}, 1.0}}}, {.voxels = {{{0, 0, 0}, 2.0}}}, {.name = "", .voxels = {{{0, 0, 0}, 3.0}}}});
    EXPECT_EQ(file.usableGrids(), (std::vector<std::string>{"density[0]", "density[1]", "[0]"}));
    EXPECT_EQ(file.field("density[1]", {}).maxValue, 2.0f);
    EXPECT_EQ(file.field("density", {}).maxValue, 1.0f);
    EXPECT_EQ(file.field("[0]", {}).maxValue, 3.0f);
    EXPECT_EQ(errorOf(ErrorKind::input, [&] { file.field("density[2]", {}); }),
              folder.file("a.vdb") +
                  ": no grid 'density[2]'; it holds 'density[0]' (float), 'density[1]' (float), '[0]' (float)");
}

TEST(VdbFile, MakesFieldsOfWholeNumbersAndMasks) {
    const TempFolder folder;
    for (const std::string type : {"int32", "int64", "bool", "mask"}) {
        const VdbFile file = made(folder, {{.name = "x",
                                            .type = type,
                                            .voxels = {{{1, 2, 3}, 1.0}, {{9, 2, 3}, 5.0}},
                                            .tiles = {{{64, 0, 0}, 8, 3.0}}}});
        const bool isTruth = type == "bool" || type == "mask";
        const SparseField field = file.field("x", {});
        EXPECT_EQ(field.activeVoxels, 2u + 512u) << type;
        EXPECT_EQ(field.maxValue, isTruth ? 1.0f : 5.0f) << type;
        ASSERT_EQ(field.tiles.size(), 1u) << type;
        EXPECT_EQ(field.tiles[0].value, isTruth ? 1.0f : 3.0f) << type;
        EXPECT_EQ(file.info().grids.at(0).maxValue, isTruth ? 1.0 : 5.0) << type;
        EXPECT_TRUE(file.info().grids.at(0).usable) << type;
    }
}

TEST(VdbFile, MakesFieldsOfTheComponentsOfVectors) {
    const TempFolder folder;
    const VdbFile file = made(folder, {{.name = "Le", .type = "vec3s", .colours = {{{1, 2, 3}, {4, 5, 6}}}}});
    EXPECT_EQ(file.field("Le.r", {}).maxValue, 4);
    EXPECT_EQ(file.field("Le.y", {}).maxValue, 5);
    EXPECT_EQ(file.field("Le.b", {}).maxValue, 6);
}

TEST(VdbFile, RefusesAGridThatIsNotAScalarField) {
    const TempFolder folder;
    const VdbFile file = made(folder, {{.name = "x", .type = "vec3i", .voxels = {{{0, 0, 0}, 1.0}}},
                                       {.name = "heat", .voxels = {{{0, 0, 0}, 1.0}}}});
    EXPECT_EQ(errorOf(ErrorKind::input, [&] { file.field("x", {}); }),
              folder.file("a.vdb") +
                  ": grid 'x' holds vec3i values, where a scalar grid is expected; of those there is 'heat'");
    const VdbFile only = made(folder, {{.name = "v", .type = "vec3s"}});
    EXPECT_EQ(errorOf(ErrorKind::input, [&] { only.field("", {}); }),
              folder.file("a.vdb") + ": holds no scalar grid, only 'v' (vec3s)");
    const VdbFile none = made(folder, {});
    EXPECT_EQ(errorOf(ErrorKind::input, [&] { none.field("", {}); }), folder.file("a.vdb") + ": holds no grids");
}

TEST(VdbFile, DescribesItsGrids) {
    const TempFolder folder;
    const VdbFileInfo info = made(folder, {{.type = "half",
                                            .voxels = {{{-3, 0, 0}, -1.0}, {{9, 1, 2}, 2.0}},
                                            .tiles = {{{64, 0, 0}, 8, 4.0}},
                                            .voxelSize = 0.25},
                                           {.name = "v", .type = "vec3s"}})
                                 .info();
    EXPECT_EQ(info.path, folder.file("a.vdb"));
    EXPECT_EQ(info.fileVersion, 224u);
    EXPECT_EQ(info.libraryMajor, 10u);
    ASSERT_EQ(info.metadata.size(), 1u);
    EXPECT_EQ(info.metadata[0], (std::pair<std::string, std::string>("creator", "vdb_make")));
    ASSERT_EQ(info.grids.size(), 2u);
    const GridInfo& g = info.grids[0];
    EXPECT_EQ(g.name, "density");
    EXPECT_EQ(g.valueType, "float");
    EXPECT_EQ(g.gridClass, "fog volume");
    EXPECT_EQ(g.codec, "blosc + active values");
    EXPECT_TRUE(g.savedAsHalf);
    EXPECT_TRUE(g.usable);
    EXPECT_EQ(g.activeVoxels, 2u);
    EXPECT_EQ(g.activeTiles, 1u);
    EXPECT_EQ(g.voxelSize, Vec3(0.25));
    EXPECT_EQ(g.isLower, Int3(-3, 0, 0));
    EXPECT_EQ(g.isUpper, Int3(71, 7, 7));
    EXPECT_EQ(g.minValue, -1.0);
    EXPECT_EQ(g.maxValue, 4.0);
    EXPECT_EQ(g.negative, 1u);
    EXPECT_FALSE(info.grids[1].usable);
    EXPECT_LT(info.grids[1].isUpper.x, info.grids[1].isLower.x);
}

TEST(VdbFile, ReadsFilesWithoutOffsets) {
    const TempFolder folder;
    makeVdb(folder.file("a.vdb"), {{.voxels = {{{1, 2, 3}, 1.0}}}}, test::Container::stream);
    EXPECT_EQ(VdbFile::open(folder.file("a.vdb")).field("", {}).activeVoxels, 1u);
}

TEST(VdbFile, RefusesWhatIsNotAVdbFile) {
    const TempFolder folder;
    const auto text = [](const std::string& path) { return errorOf(ErrorKind::input, [&] { VdbFile::open(path); }); };
    EXPECT_EQ(text(folder.file("none.vdb")), folder.file("none.vdb") + ": no such file");
    EXPECT_EQ(text(folder.path()), folder.path() + ": is a folder, not a VDB file");
    EXPECT_EQ(text("/dev/null"), "/dev/null: is not a regular file");
    ASSERT_EQ(::mkfifo(folder.file("fifo").c_str(), 0600), 0);
    EXPECT_EQ(text(folder.file("fifo")), folder.file("fifo") + ": is not a regular file");
    const std::string path = folder.file("a.vdb");
    test::writeBytes(path, "");
    EXPECT_EQ(text(path), path + ": not a VDB file (it is empty)");
    test::writeBytes(path, "#?RADIANCE\n");
    EXPECT_EQ(text(path), path + ": not a VDB file (starts with '#?RADIAN')");
}

TEST(VdbFile, RefusesEveryTruncation) {
    const TempFolder folder;
    const std::string path = folder.file("a.vdb");
    for (const auto container : {test::Container::file, test::Container::stream}) {
        makeVdb(path, {{.voxels = box({0, 0, 0}, {9, 9, 9}, 0.5)}, {.name = "p", .type = "points"}}, container);
        const std::string whole = test::readBytes(path);
        for (std::size_t size = 9; size < whole.size(); size += 1 + size / 50) {
            test::writeBytes(path, whole.substr(0, size));
            const std::string reason = errorOf(ErrorKind::input, [&] { VdbFile::open(path); });
            EXPECT_TRUE(reason.starts_with(path + ": truncated or damaged: ")) << size << " bytes: " << reason;
        }
        test::writeBytes(path, whole + "x");
        const std::string reason = errorOf(ErrorKind::input, [&] { VdbFile::open(path); });
        EXPECT_TRUE(reason.starts_with(path + ": truncated or damaged: ")) << reason;
    }
}

// OpenVDB 12's successor writes 225.
TEST(VdbFile, ReadsAFileOfANewerVersionAndWarns) {
    const TempFolder folder;
    const std::string path = folder.file("a.vdb");
    makeVdb(path, {{.voxels = {{{1, 2, 3}, 0.5}}}});
    std::string bytes = test::readBytes(path);
    bytes[8] = static_cast<char>(225);
    test::writeBytes(path, bytes);
    std::vector<std::string> warnings;
    const SparseField field = VdbFile::open(path).field("", [&](Severity severity, const std::string& text) {
        if (severity == Severity::warning) warnings.push_back(text);
    });
    EXPECT_EQ(field.activeVoxels, 1u);
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_TRUE(warnings[0].starts_with(path + ": file version 225 is newer than OpenVDB ")) << warnings[0];
    // And where that cannot be done says what is the matter.
    test::writeBytes(path, bytes.substr(0, bytes.size() - 20));
    const std::string reason = errorOf(ErrorKind::input, [&] { VdbFile::open(path); });
    EXPECT_TRUE(reason.starts_with(path + ": file version 225 is newer than what OpenVDB ")) << reason;
}

TEST(VdbFile, RefusesAVersionThatIsNone) {
    const TempFolder folder;
    const std::string path = folder.file("a.vdb");
    makeVdb(path, {{}});
    std::string bytes = test::readBytes(path);
    bytes[9] = 1;
    test::writeBytes(path, bytes);
    EXPECT_EQ(errorOf(ErrorKind::input, [&] { VdbFile::open(path); }),
              path + ": VDB file version 480 (versions 211 to 224 can be read)");
}

TEST(VdbFile, NamesAGridTypeThatCannotBeRead) {
    const TempFolder folder;
    const std::string path = folder.file("a.vdb");
    makeVdb(path, {{}});
    std::string bytes = test::readBytes(path);
    const std::size_t at = bytes.find("Tree_float_5_4_3");
    ASSERT_NE(at, std::string::npos);
    bytes.replace(at, 16, "Tree_flaot_5_4_3");
    test::writeBytes(path, bytes);
    const VdbFileInfo info = VdbFile::open(path).info();
    ASSERT_EQ(info.grids.size(), 1u);
    EXPECT_TRUE(info.grids[0].problem.starts_with("grid 'density' has the type 'Tree_flaot_5_4_3', which OpenVDB "))
        << info.grids[0].problem;
    EXPECT_FALSE(info.grids[0].usable);
}

TEST(VdbFile, RefusesImplausibleSizesBeforeAllocatingThem) {
    const TempFolder folder;
    const std::string path = folder.file("a.vdb");
    makeVdb(path, {{}});
    std::string bytes = test::readBytes(path);
    // The length of the first metadata name, behind magic, versions, offset flag, UUID and the number of
    // entries.
    const std::size_t at = 8 + 12 + 1 + 36 + 4;
    const std::uint32_t huge = 0xf0000000;
    std::memcpy(bytes.data() + at, &huge, sizeof huge);
    test::writeBytes(path, bytes);
    const std::string reason = errorOf(ErrorKind::input, [&] { VdbFile::open(path); });
    EXPECT_TRUE(reason.starts_with(path + ": truncated or damaged: a metadata name at byte 65 needs 4026531840 bytes"))
        << reason;
}

TEST(VdbFile, WritesWhatItReads) {
    const TempFolder folder;
    const VdbFile file = made(folder, {{.voxels = box({-5, -5, -5}, {20, 3, 3}, 0.3),
                                        .tiles = {{{128, 0, 0}, 128, 2.0}, {{64, 0, 0}, 8, 1.0}},
                                        .voxelSize = 0.1,
                                        .translate = {4, 5, 6}}});
    const SparseField before = file.field("", {});
    writeVdb(folder.file("b.vdb"), {before});
    EXPECT_EQ(folder.entryCount(), 2u);
    const VdbFile again = VdbFile::open(folder.file("b.vdb"));
    EXPECT_EQ(again.info().grids.at(0).gridClass, "fog volume");
    const SparseField after = again.field("density", {});
    ASSERT_EQ(after.blockOrigins, before.blockOrigins);
    EXPECT_EQ(std::memcmp(after.block(0), before.block(0), before.blockCount() * kBlockVoxels * sizeof(float)), 0);
    ASSERT_EQ(after.tiles.size(), 2u);
    EXPECT_EQ(after.activeVoxels, before.activeVoxels);
    // OpenVDB simplifies a transform by sums with its translation, here 0.1 + 6, which is rounded to 2^-50.
    for (int i = 0; i < 16; ++i) EXPECT_NEAR(after.wsFromIs[i / 4][i % 4], before.wsFromIs[i / 4][i % 4], 1e-15) << i;
    const std::string reason = errorOf(ErrorKind::output, [&] { writeVdb(folder.file("b.vdb/c.vdb"), {before}); });
    EXPECT_NE(reason.find(folder.file("b.vdb/c.vdb")), std::string::npos) << reason;
}

TEST(RealVdbFiles, HoldWhatTheirReadmeSays) {
    SCRIM_NEEDS_DATA("vdb/wdas_cloud_sixteenth.vdb");
    const VdbFileInfo cloud = VdbFile::open(test::dataFile("vdb/wdas_cloud_sixteenth.vdb")).info();
    EXPECT_EQ(cloud.grids.at(0).activeVoxels + 512 * cloud.grids.at(0).activeTiles, 415642u);
    EXPECT_EQ(cloud.grids.at(0).activeTiles, 130u);
    const SparseField smoke = VdbFile::open(test::dataFile("vdb/smoke1.vdb")).field("", {});
    EXPECT_EQ(smoke.activeVoxels, 1049275u);
    EXPECT_FLOAT_EQ(smoke.maxValue, 5.71484375f);
}

TEST(RealVdbFiles, AreTheSameInAnotherCodec) {
    SCRIM_NEEDS_DATA("edge/smoke1_resaved_blosc.vdb");
    const SparseField a = VdbFile::open(test::dataFile("vdb/smoke1.vdb")).field("", {});
    const SparseField b = VdbFile::open(test::dataFile("edge/smoke1_resaved_blosc.vdb")).field("", {});
    ASSERT_EQ(a.blockOrigins, b.blockOrigins);
    EXPECT_EQ(std::memcmp(a.block(0), b.block(0), a.blockCount() * kBlockVoxels * sizeof(float)), 0);
}

TEST(RealVdbFiles, AreAllReadOrRefusedWithAReason) {
    SCRIM_NEEDS_DATA("edge");
    for (const char* folder : {"vdb", "edge", "sequence/stormscape", "sequence/usd_smoke"})
        for (const auto& entry : std::filesystem::directory_iterator(test::dataFile(folder))) {
            if (entry.path().extension() != ".vdb") continue;
            const VdbFile file = VdbFile::open(entry.path().string());
            EXPECT_FALSE(file.info().grids.empty()) << entry.path();
            for (const std::string& name : file.usableGrids()) EXPECT_NO_THROW(file.field(name, {})) << entry.path();
        }
}

}  // namespace
}  // namespace scrim::test
