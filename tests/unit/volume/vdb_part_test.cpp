// SPDX-License-Identifier: Apache-2.0
// Reading some grids of a file and leaving the others where they are.
#include <scrim/volume/vdb_file.h>
#include <scrim/volume/vdb_layout.h>

#include "support/data.h"
#include "support/expect_error.h"
#include "support/temp_folder.h"
#include "support/vdb_make.h"

#include <cstring>

namespace scrim::test {
namespace {

const std::vector<MadeGrid> kSeveral{
    {.name = "ids", .type = "int32", .voxels = box({0, 0, 0}, {9, 9, 9}, 3)},
    {.name = "density", .voxels = box({-3, 0, 0}, {9, 9, 20}, 0.5), .tiles = {{{128, 0, 0}, 128, 2}}},
    {.name = "points", .type = "points", .voxels = box({0, 0, 0}, {3, 3, 3}, 1)},
    {.name = "Cd", .type = "vec3half", .voxels = box({0, 0, 0}, {30, 9, 9}, 0.25), .voxelSize = 0.5},
    {.name = "heat", .type = "double", .voxels = box({0, 0, 0}, {9, 9, 9}, 7)},
    {.name = "heat", .type = "half", .voxels = box({0, 0, 0}, {5, 5, 5}, 9)}};

/// Makes the bytes of all grids but `kept` useless.
void ruinOthers(const std::string& path, const std::vector<std::size_t>& kept) {
    std::string bytes = test::readBytes(path);
    const VdbLayout layout = checkVdbLayout(path, bytes);
    for (std::size_t i = 0; i < layout.grids.size(); ++i)
        if (std::find(kept.begin(), kept.end(), i) == kept.end())
            for (std::uint64_t at = layout.grids[i].mapAt; at < layout.grids[i].end; ++at) bytes[at] = '\x7f';
    test::writeBytes(path, bytes);
}

void expectSame(const SparseField& a, const SparseField& b, const std::string& what) {
    EXPECT_EQ(a.name, b.name) << what;
    EXPECT_EQ(a.wsFromIs, b.wsFromIs) << what;
    EXPECT_EQ(a.activeVoxels, b.activeVoxels) << what;
    EXPECT_EQ(a.tiles.size(), b.tiles.size()) << what;
    ASSERT_EQ(a.blockOrigins, b.blockOrigins) << what;
    EXPECT_EQ(std::memcmp(a.blockValues.get(), b.blockValues.get(), a.blockCount() * kBlockVoxels * sizeof(float)), 0)
        << what;
}

TEST(VdbPart, HoldsTheSameAsTheWholeFile) {
    const TempFolder folder;
    const std::string path = folder.file("a.vdb");
    makeVdb(path, kSeveral);
    const VdbFile whole = VdbFile::open(path);
    for (const GridRequest& request :
         {GridRequest{""}, GridRequest{"density"}, GridRequest{"Cd", 0}, GridRequest{"Cd", 2}, GridRequest{"heat", 1},
          GridRequest{"heat[0]"}, GridRequest{"heat[1]"}})
        expectSame(VdbFile::open(path, {request}).field(request, {}), whole.field(request, {}), toText(request));
}

TEST(VdbPart, IsReadWithoutTheGridsThatNobodyAsksFor) {
    const TempFolder folder;
    const std::string path = folder.file("a.vdb");
    makeVdb(path, kSeveral);
    const VdbFile whole = VdbFile::open(path);
    ruinOthers(path, {3, 5});
    errorOf(ErrorKind::input, [&] { VdbFile::open(path); });
    const VdbFile part = VdbFile::open(path, {{"heat[1]"}, {"Cd", 1}});
    expectSame(part.field(GridRequest{"Cd", 1}, {}), whole.field(GridRequest{"Cd", 1}, {}), "Cd");
    expectSame(part.field("heat[1]", {}), whole.field("heat[1]", {}), "heat");
    EXPECT_EQ(part.info().grids.size(), 2u);
    EXPECT_EQ(part.info().grids.at(1).codec, "blosc + active values");
    EXPECT_EQ(errorOf(ErrorKind::input, [&] { part.field("density", {}); }),
              path + ": grid 'density' was not requested when the file was opened");
}

TEST(VdbPart, ListsAllGridsOfTheFileWhereOneIsMissing) {
    const TempFolder folder;
    const std::string path = folder.file("a.vdb");
    makeVdb(path, kSeveral);
    ruinOthers(path, {2});  // what no grid is called may be an attribute of points
    const VdbFile none = VdbFile::open(path, {{"fuel"}});
    EXPECT_EQ(errorOf(ErrorKind::input, [&] { none.field("fuel", {}); }),
              path +
                  ": no grid 'fuel'; it holds 'ids' (int32), 'density' (float), 'points' (ptdataidx32), 'Cd' (vec3s), "
                  "'heat[0]' (double), 'heat[1]' (float); points 'points' have no attributes");
    EXPECT_EQ(none.usableGrids(), (std::vector<std::string>{"ids", "density", "points", "heat[0]", "heat[1]"}));
}

TEST(VdbPart, ChoosesTheDefaultGridByWhatTheFileSaysOfClasses) {
    const TempFolder folder;
    const std::string path = folder.file("a.vdb");
    makeVdb(path, {{.name = "v", .type = "vec3s", .voxels = {{{0, 0, 0}, 1}}},
                   {.name = "ball", .type = "sphere"},
                   {.name = "heat", .gridClass = "", .voxels = {{{0, 0, 0}, 1}}},
                   {.name = "fog", .voxels = {{{0, 0, 0}, 1}}}});
    ruinOthers(path, {3});
    EXPECT_EQ(VdbFile::open(path, {{""}}).field("", {}).name, "fog");
}

TEST(VdbPart, IsTheWholeFileWhereItsGridsCannotBeToldApart) {
    const TempFolder folder;
    const std::string path = folder.file("a.vdb");
    makeVdb(path, kSeveral, test::Container::stream);
    expectSame(VdbFile::open(path, {{"heat"}}).field("heat", {}), VdbFile::open(path).field("heat", {}), "stream");

    test::makeVdbWithInstance(path, {.voxels = box({0, 0, 0}, {9, 9, 9}, 0.5)});
    ASSERT_TRUE(checkVdbLayout(VdbBytes(path)).grids.at(1).instance);
    const VdbFile instance = VdbFile::open(path, {{"copy"}});
    expectSame(instance.field("copy", {}), VdbFile::open(path).field("copy", {}), "instance");
    EXPECT_EQ(instance.field("copy", {}).activeVoxels, 1000u);
}

TEST(VdbPart, IsRefusedWhereTheFileIsTruncated) {
    const TempFolder folder;
    const std::string path = folder.file("a.vdb");
    makeVdb(path, kSeveral);
    const std::string whole = test::readBytes(path);
    for (std::size_t size = 9; size < whole.size(); size += 1 + size / 20) {
        test::writeBytes(path, whole.substr(0, size));
        const std::string reason = errorOf(ErrorKind::input, [&] { VdbFile::open(path, {{"density"}}); });
        EXPECT_TRUE(reason.starts_with(path + ": truncated or damaged: ")) << size << " bytes: " << reason;
    }
}

TEST(RealVdbFiles, GiveEachGridAlone) {
    SCRIM_NEEDS_DATA("edge");
    for (const char* folder : {"vdb", "edge", "sequence/usd_smoke"})
        for (const auto& entry : std::filesystem::directory_iterator(test::dataFile(folder))) {
            const std::string path = entry.path().string();
            const VdbFile whole = VdbFile::open(path);
            for (const std::string& name : whole.usableGrids())
                expectSame(VdbFile::open(path, {{name}}).field(name, {}), whole.field(name, {}), path + " " + name);
        }
}

}  // namespace
}  // namespace scrim::test
