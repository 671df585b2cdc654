// SPDX-License-Identifier: Apache-2.0
// Fields that are read straight from a file are those of OpenVDB's grids.
#include <scrim/volume/vdb_file.h>

#include <scrim/volume/vdb_bytes.h>

#include "support/expect_error.h"
#include "support/temp_folder.h"
#include "support/vdb_make.h"

#include <cmath>
#include <cstring>
#include <limits>

namespace scrim {
namespace {

using test::Container;
using test::errorOf;
using test::MadeGrid;
using test::makeVdb;
using test::Packing;
using test::TempFolder;

/// Counts what is taken. Without direct reading, nothing is.
class CountingMemory : public BlockMemory {
  public:
    std::size_t blocks = 0, fields = 0;
    std::shared_ptr<float[]> take(std::size_t count) override {
        blocks += count;
        ++fields;
        return BlockMemory::take(count);
    }
    void shrink(float*, std::size_t count, std::size_t kept) override { blocks -= count - kept; }
};

void expectEqual(const SparseField& field, const SparseField& expected, const std::string& what) {
    EXPECT_EQ(field.name, expected.name) << what;
    EXPECT_EQ(field.wsFromIs, expected.wsFromIs) << what;
    ASSERT_EQ(field.blockOrigins, expected.blockOrigins) << what;
    EXPECT_EQ(std::memcmp(field.block(0), expected.block(0), field.blockCount() * kBlockVoxels * sizeof(float)), 0)
        << what;
    ASSERT_EQ(field.tiles.size(), expected.tiles.size()) << what;
    for (std::size_t i = 0; i < field.tiles.size(); ++i) {
        EXPECT_EQ(field.tiles[i].origin, expected.tiles[i].origin) << what;
        EXPECT_EQ(field.tiles[i].edge, expected.tiles[i].edge) << what;
        EXPECT_EQ(field.tiles[i].value, expected.tiles[i].value) << what;
    }
    EXPECT_EQ(field.activeVoxels, expected.activeVoxels) << what;
    EXPECT_EQ(field.nonFinite, expected.nonFinite) << what;
    EXPECT_EQ(field.negative, expected.negative) << what;
    EXPECT_EQ(field.maxValue, expected.maxValue) << what;
}

std::vector<std::string> messagesOf(const VdbFile& file, const GridRequest& request) {
    std::vector<std::string> messages;
    file.field(request, [&](Severity, const std::string& text) { messages.push_back(text); });
    return messages;
}

/// Expects of each request what OpenVDB's grids give. `direct`: how many of them need no grid.
void expectAsFromGrids(const std::string& path, const std::vector<GridRequest>& requests, std::size_t direct,
                       const std::string& what) {
    const VdbBytes bytes(path);
    CountingMemory memory;
    const VdbFile file = VdbFile::open(bytes, requests, memory), grids = VdbFile::open(path);
    EXPECT_EQ(memory.fields, direct) << what;
    std::size_t kept = 0;
    for (const GridRequest& request : requests) {
        const SparseField field = file.field(request, {});
        kept += field.blockCount();
        expectEqual(field, grids.field(request, {}), what);
        EXPECT_EQ(messagesOf(file, request), messagesOf(grids, request)) << what;
    }
    if (direct == requests.size()) {
        EXPECT_EQ(memory.blocks, kept) << what;
    }
}

/// Values of all kinds over several nodes, among them full, sparse and useless leaves.
MadeGrid scalar(const std::string& type) {
    MadeGrid grid{.name = "density", .type = type, .voxelSize = 0.25, .translate = {1, 2, 3}};
    grid.voxels = test::box({0, 0, 0}, {7, 7, 15}, 0.5);
    constexpr double kBad[] = {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN(), -2};
    for (int i = 0; i < 4000; ++i) {
        const int x = 37 * i % 211 - 100, y = 53 * i % 97, z = 29 * i % 307 - 150;
        grid.voxels.push_back({{x, y, z}, i % 40 < 3 ? kBad[i % 40] : 1e-6 * i * i});
    }
    grid.voxels.push_back({{5000, -5000, 8}, -1});     // a leaf with nothing above 0
    grid.voxels.push_back({{5000, -5000, 16}, 1e-6});  // small as a half, but not 0
    grid.tiles = {{{-128, 256, 0}, 128, 2}, {{512, 0, 0}, 8, 3}, {{520, 0, 0}, 8, -3}};
    grid.inactive = {{{1, 1, 20}, 4}, {{2, 1, 20}, 5}, {{3, 1, 20}, 6}, {{1, 40, 20}, 4}};
    return grid;
}

TEST(DirectFields, AreThoseOfOpenVdbsGridsHoweverTheFileIsPacked) {
    for (const std::string type : {"float", "half"})
        for (const std::string codec : {"none", "zip", "blosc"})
            for (const bool mask : {true, false}) {
                const TempFolder folder;
                makeVdb(folder.file("a.vdb"), {scalar(type)}, Container::file, {codec, mask});
                const std::string what = type + ", " + codec + (mask ? ", active values" : "");
                expectAsFromGrids(folder.file("a.vdb"), {{"density"}}, 1, what);
                expectAsFromGrids(folder.file("a.vdb"),
                                  {{"density", GridRequest::kScalar, GridPart::positive},
                                   {"density", GridRequest::kScalar, GridPart::negative}},
                                  2, what + ", as a velocity");
            }
}

MadeGrid vectors(const std::string& type, const std::string& gridClass) {
    MadeGrid grid{.name = "v", .type = type, .gridClass = gridClass, .voxelSize = 0.5};
    for (int i = 0; i < 1500; ++i)
        grid.colours.push_back(
            {{17 * i % 61, 31 * i % 83 - 40, 7 * i % 29}, {0.01 * i, 2.0 - 0.003 * i, i % 3 == 0 ? -1.0 : 0.0}});
    grid.tiles = {{{128, 0, 0}, 8, -0.5}};
    return grid;
}

TEST(DirectFields, OfVectorsTakeOnePassForAllComponents) {
    std::vector<GridRequest> requests;
    for (int axis = 0; axis < 3; ++axis)
        for (const GridPart part : {GridPart::whole, GridPart::positive, GridPart::negative})
            requests.push_back({"v", axis, part});
    for (const std::string type : {"vec3s", "vec3half"})
        for (const std::string codec : {"none", "zip", "blosc"})
            for (const std::string gridClass : {"", "staggered"}) {
                const TempFolder folder;
                makeVdb(folder.file("a.vdb"), {vectors(type, gridClass)}, Container::file, {codec, true});
                expectAsFromGrids(folder.file("a.vdb"), requests, requests.size(), type + ", " + codec);
            }
}

TEST(DirectFields, LeaveToOpenVdbWhatOnlyOpenVdbReads) {
    const TempFolder folder;
    makeVdb(folder.file("a.vdb"), {{.name = "sphere", .type = "sphere"},
                                   {.name = "double", .type = "double", .voxels = {{{1, 2, 3}, 4}}},
                                   {.name = "frustum", .voxels = {{{1, 2, 3}, 4}}, .frustum = true},
                                   {.name = "plain", .voxels = {{{1, 2, 3}, 4}}}});
    expectAsFromGrids(folder.file("a.vdb"), {{"sphere"}, {"double"}, {"frustum"}, {"plain"}}, 1, "mixed");
    // As a colour, a level set stays what it is.
    expectAsFromGrids(folder.file("a.vdb"), {{"sphere", 0}}, 1, "grey");
}

TEST(DirectFields, OfADamagedFileAreRefusedAsByOpenVdb) {
    const TempFolder folder;
    for (const std::string codec : {"none", "zip", "blosc"}) {
        makeVdb(folder.file("a.vdb"), {scalar("float")}, Container::file, {codec, true});
        const std::string whole = test::readBytes(folder.file("a.vdb"));
        for (std::size_t at = whole.size() - 4000; at < whole.size(); at += 397) {
            std::string bytes = whole;
            bytes[at] = static_cast<char>(bytes[at] ^ 0x55);
            const VdbBytes damaged("a.vdb", std::span<const char>(bytes));
            CountingMemory memory;
            std::string reason;
            try {
                const SparseField field =
                    VdbFile::open(damaged, std::vector<GridRequest>{{"density"}}, memory).field("density", {});
                EXPECT_EQ(memory.blocks, field.blockCount()) << codec << ' ' << at;
            } catch (const Error& error) {
                reason = error.what();
                EXPECT_EQ(memory.blocks, 0u) << codec << ' ' << at;
            }
            EXPECT_EQ(reason.empty() ? "" : errorOf(ErrorKind::input, [&] { VdbFile::open(damaged); }), reason);
        }
    }
}

}  // namespace
}  // namespace scrim
