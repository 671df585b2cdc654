// SPDX-License-Identifier: Apache-2.0
// Colours in .vdb files.
#include <scrim/volume/vdb_file.h>

#include "support/data.h"
#include "support/expect_error.h"
#include "support/temp_folder.h"
#include "support/vdb_make.h"

#include <array>
#include <cmath>
#include <limits>

namespace scrim {
namespace {

using test::errorOf;
using test::MadeColour;
using test::MadeGrid;
using test::makeVdb;
using test::TempFolder;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

VdbFile made(const TempFolder& folder, const std::vector<MadeGrid>& grids) {
    makeVdb(folder.file("a.vdb"), grids);
    return VdbFile::open(folder.file("a.vdb"));
}

std::vector<std::string> warningsOf(const VdbFile& file, const GridRequest& request) {
    std::vector<std::string> warnings;
    file.field(request, [&](Severity, const std::string& text) { warnings.push_back(text); });
    return warnings;
}

/// The value of `field` in a voxel, blocks only.
float valueAt(const SparseField& field, const Int3& at) {
    for (std::size_t i = 0; i < field.blockCount(); ++i) {
        const Int3 p = at - field.blockOrigins[i];
        if (p.x >= 0 && p.y >= 0 && p.z >= 0 && p.x < kBlockEdge && p.y < kBlockEdge && p.z < kBlockEdge)
            return field.block(i)[blockOffset(p.x, p.y, p.z)];
    }
    return 0;
}

TEST(VdbColour, IsThreeFieldsOfAVectorGrid) {
    for (const std::string type : {"vec3s", "vec3d", "vec3half"}) {
        const TempFolder folder;
        const VdbFile file = made(folder, {{.name = "Cd",
                                            .type = type,
                                            .colours = {{{-1, 2, 9}, {0.25, 0.5, 0.75}}, {{7, 2, 3}, {1, 0, 2}}},
                                            .tiles = {{{64, 0, 0}, 8, 0.5}},
                                            .voxelSize = 0.5,
                                            .translate = {1, 2, 3}}});
        const std::array<std::string, 3> names{"Cd.r", "Cd.g", "Cd.b"};
        for (int c = 0; c < 3; ++c) {
            const SparseField field = file.field(GridRequest{"Cd", c}, {});
            EXPECT_EQ(field.name, names[static_cast<std::size_t>(c)]);
            EXPECT_EQ(valueAt(field, {-1, 2, 9}), 0.25f * static_cast<float>(c + 1)) << type;
            EXPECT_EQ(valueAt(field, {7, 2, 3}), (std::array{1.0f, 0.0f, 2.0f})[static_cast<std::size_t>(c)]) << type;
            ASSERT_EQ(field.tiles.size(), 1u) << type;
            EXPECT_EQ(field.tiles[0].value, 0.5f);
            EXPECT_EQ(transformPoint(field.wsFromIs, Vec3(2, 0, -2)), Vec3(2, 2, 2));
        }
    }
}

TEST(VdbColour, IsThreeScalarGrids) {
    const TempFolder folder;
    const VdbFile file = made(folder, {{.name = "Cd.b", .voxels = {{{0, 0, 0}, 3}}},
                                       {.name = "Cd.r", .type = "double", .voxels = {{{0, 0, 0}, 1}}},
                                       {.name = "Cd.g", .type = "half", .voxels = {{{0, 0, 0}, 2}}}});
    for (int c = 0; c < 3; ++c) EXPECT_EQ(file.field(GridRequest{"Cd", c}, {}).maxValue, static_cast<float>(c + 1));
    EXPECT_EQ(file.field(GridRequest{"Cd", 1}, {}).name, "Cd.g");
}

TEST(VdbColour, IsGreyOfAScalarGridEvenALevelSet) {
    const TempFolder folder;
    const VdbFile file =
        made(folder, {{.name = "grey", .voxels = {{{0, 0, 0}, 0.5}}},
                      {.name = "level", .gridClass = "level set", .voxels = {{{0, 0, 0}, 0.25}}, .background = 3}});
    for (int c = 0; c < 3; ++c) {
        EXPECT_EQ(file.field(GridRequest{"grey", c}, {}).maxValue, 0.5f);
        EXPECT_EQ(file.field(GridRequest{"level", c}, {}).maxValue, 0.25f);
        EXPECT_EQ(warningsOf(file, {"level", c}).size(), 0u);
    }
}

TEST(VdbColour, CountsBadComponentsAsNothingAndSaysWhichComponent) {
    const TempFolder folder;
    const VdbFile file = made(
        folder, {{.name = "Cd", .type = "vec3s", .colours = {{{0, 0, 0}, {kNaN, -1, 1}}, {{0, 0, 1}, {1, 1, 1}}}}});
    const std::string start = folder.file("a.vdb") + ": grid 'Cd";
    EXPECT_EQ(warningsOf(file, {"Cd", 0}),
              (std::vector{start + ".r': of 2 voxels with a value 1 are not finite, and count as empty"}));
    EXPECT_EQ(warningsOf(file, {"Cd", 1}),
              (std::vector{start + ".g': of 2 voxels with a value 1 are below 0, and count as empty"}));
    EXPECT_EQ(warningsOf(file, {"Cd", 2}).size(), 0u);
}

// A component is resampled exactly as a scalar grid of its values is.
TEST(VdbColour, IsResampledInAFrustumAsAScalarGridIs) {
    const TempFolder folder;
    std::vector<MadeColour> colours;
    std::vector<test::MadeVoxel> greens;
    for (const test::MadeVoxel& v : test::box({2, 2, 2}, {14, 12, 10}, 1)) {
        const double green = 0.125 * (v.at.x % 5 + v.at.z);
        colours.push_back({v.at, {1, green, 3}});
        greens.push_back({v.at, green});
    }
    const VdbFile file =
        made(folder, {{.name = "Cd", .type = "vec3s", .colours = colours, .voxelSize = 0.5, .frustum = true},
                      {.name = "green", .voxels = greens, .voxelSize = 0.5, .frustum = true}});
    const SparseField colour = file.field(GridRequest{"Cd", 1}, {});
    const SparseField scalar = file.field("green", {});
    EXPECT_EQ(colour.name, "Cd.g");
    EXPECT_GT(scalar.activeVoxels, 1000u);
    EXPECT_EQ(colour.wsFromIs, scalar.wsFromIs);
    ASSERT_EQ(colour.blockOrigins, scalar.blockOrigins);
    for (std::size_t i = 0; i < scalar.blockCount(); ++i)
        for (int n = 0; n < kBlockVoxels; ++n) ASSERT_EQ(colour.block(i)[n], scalar.block(i)[n]) << i << " " << n;
    EXPECT_EQ(warningsOf(file, {"Cd", 0}).at(0).substr(0, folder.file("a.vdb").size() + 50),
              folder.file("a.vdb") + ": grid 'Cd.r' has a transform that is not affine: ");
}

TEST(VdbColour, IsRefusedWhereItIsMissingOrOfAnotherType) {
    const TempFolder folder;
    const VdbFile file = made(folder, {{.name = "density", .voxels = {{{0, 0, 0}, 1}}},
                                       {.name = "ids", .type = "vec3i", .voxels = {{{0, 0, 0}, 1}}}});
    try {
        file.field(GridRequest{"Cd", 2}, {});
        ADD_FAILURE() << "nothing was thrown";
    } catch (const GridError& error) {
        EXPECT_EQ(error.request(), (GridRequest{"Cd", 2}));
        EXPECT_EQ(error.what(), folder.file("a.vdb") + ": no grid 'Cd'; it holds 'density' (float), 'ids' (vec3i)");
    }
    const std::string reason = errorOf(ErrorKind::input, [&] { file.field(GridRequest{"ids", 0}, {}); });
    EXPECT_TRUE(reason.starts_with(folder.file("a.vdb") +
                                   ": grid 'ids' holds vec3i values, where a colour is expected: a vec3 grid, "))
        << reason;
}

TEST(VdbColour, IsToldByTheDescriptionOfItsGrid) {
    const TempFolder folder;
    const VdbFileInfo info =
        made(folder, {{.name = "density"}, {.name = "Cd", .type = "vec3d"}, {.type = "vec3i"}}).info();
    EXPECT_TRUE(info.grids.at(0).usable);
    EXPECT_FALSE(info.grids.at(0).colour);
    EXPECT_FALSE(info.grids.at(1).usable);
    EXPECT_TRUE(info.grids.at(1).colour);
    EXPECT_FALSE(info.grids.at(2).colour);
}

TEST(RealVdbFiles, HoldAColour) {
    SCRIM_NEEDS_DATA("edge/oiio_sphereCd.vdb");
    const VdbFile file = VdbFile::open(test::dataFile("edge/oiio_sphereCd.vdb"));
    std::string name;
    for (const GridInfo& grid : file.info().grids)
        if (grid.colour) name = grid.name;
    ASSERT_FALSE(name.empty());
    for (int c = 0; c < 3; ++c) EXPECT_GT(file.field(GridRequest{name, c}, {}).activeVoxels, 0u) << name << " " << c;
}

}  // namespace
}  // namespace scrim
