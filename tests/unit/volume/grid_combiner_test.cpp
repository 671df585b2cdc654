// SPDX-License-Identifier: Apache-2.0
// Grids that are put together from several files hold what their definition says, voxel by voxel, in this process and
// in a child.
#include <scrim/guard/load_fields.h>
#include <scrim/volume/grid_edit.h>

#include "support/expect_error.h"
#include "support/loaded_fields.h"
#include "support/temp_folder.h"
#include "support/vdb_make.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

namespace scrim::test {
namespace {

using How = CombinedGrid::How;

double aAt(const Int3& p) {
    return p.x >= 0 && p.x <= 5 && p.y >= 0 && p.y <= 5 && p.z >= 0 && p.z <= 5 ? 0.1 + 0.2 * p.x + 0.03 * p.z : 0;
}
double bAt(const Int3& p) {
    return p.x >= 3 && p.x <= 12 && p.y >= 2 && p.y <= 9 && p.z >= -3 && p.z <= 4 ? 0.5 + 0.05 * p.y : 0;
}

std::vector<MadeVoxel> voxelsOf(double (*value)(const Int3&)) {
    std::vector<MadeVoxel> voxels;
    for (const MadeVoxel& v : box({-4, -4, -4}, {14, 14, 14}, 0))
        if (value(v.at) > 0) voxels.push_back({v.at, value(v.at)});
    return voxels;
}

class GridCombinerTest : public ::testing::Test {
  protected:
    void SetUp() override {
        makeVdb(file("a.vdb"), {{.voxels = voxelsOf(aAt)}, {.name = "heat", .voxels = {{{1, 1, 1}, 9}}}});
        makeVdb(file("b.vdb"), {{.name = "smoke", .type = "double", .voxels = voxelsOf(bAt)}});
        makeVdb(file("c.vdb"), {{.name = "vel", .type = "vec3s", .colours = {{{1, 2, 3}, {1, 2, 3}}}},
                                {.name = "Cd", .type = "vec3s", .colours = {{{1, 2, 3}, {4, 5, 6}}}}});
    }
    std::string file(const std::string& name) const { return m_folder.file(name); }
    GridEdit edit(const std::vector<CombinedGrid>& grids) const {
        GridEdit edit;
        edit.grids = grids;
        edit.files = {file("a.vdb"), file("b.vdb"), file("c.vdb")};
        edit.where = "s.toml:7:9";
        return edit;
    }
    /// What both ways of loading give, which must be the same.
    std::vector<SparseField> load(const GridEdit& edit, const std::vector<GridRequest>& requests) {
        std::vector<std::vector<SparseField>> both;
        for (const LoadOptions& way : kWays) {
            heard.clear();
            const auto hear = [this](Severity, const std::string& text) { heard.push_back(text); };
            both.push_back(loadFields(edit.files.front(), requests, way, hear, {}, &edit));
        }
        for (std::size_t i = 0; i < requests.size(); ++i) {
            EXPECT_EQ(both[0][i].blockOrigins, both[1][i].blockOrigins);
            EXPECT_EQ(both[0][i].activeVoxels, both[1][i].activeVoxels);
        }
        return std::move(both[1]);
    }
    std::string failure(const GridEdit& edit, const std::vector<GridRequest>& requests) {
        std::vector<std::string> texts;
        for (const LoadOptions& way : kWays)
            texts.push_back(
                errorOf(ErrorKind::input, [&] { loadFields(edit.files.front(), requests, way, {}, {}, &edit); }));
        EXPECT_EQ(texts[0], texts[1]);
        return texts[0];
    }
    static void expectValues(const SparseField& field, const std::function<double(const Int3&)>& expected) {
        for (const MadeVoxel& v : box({-6, -6, -6}, {18, 18, 18}, 0))
            ASSERT_NEAR(valueAt(field, v.at), expected(v.at), 1e-6)
                << field.name << " at " << v.at.x << " " << v.at.y << " " << v.at.z;
    }

    std::vector<std::string> heard;

  private:
    TempFolder m_folder;
};

TEST(CombinedGridText, ComesBackAsItWas) {
    GridEdit edit;
    edit.files = {"a.vdb", "b \"c\".vdb"};
    edit.grids = {{"density", How::max, {{0, "density[1]", "s.toml:1:2"}, {1, "", "s.toml:1:9"}}},
                  {"heat", How::copied, {{1, "heat", ""}}}};
    EXPECT_EQ(gridEditFrom(toText(edit)), edit);
    edit.files.pop_back();
    EXPECT_EQ(errorOf(ErrorKind::usage, [&] { gridEditFrom(toText(edit)); }),
              "not an edit of grids: there is no such file");
}

TEST_F(GridCombinerTest, GridsOfSeveralFilesStandSideBySide) {
    const auto fields = load(edit({{"density", How::copied, {{0, "", "p"}}},
                                   {"temperature", How::copied, {{1, "", "q"}}},
                                   {"glow", How::copied, {{0, "heat", "r"}}}}),
                             {{"density"}, {"temperature"}, {"glow"}});
    expectValues(fields[0], aAt);
    expectValues(fields[1], bAt);
    expectValues(fields[2], [](const Int3& p) { return p == Int3(1) ? 9 : 0; });
    ASSERT_EQ(heard.size(), 1u) << "of what the scene does not say";
    EXPECT_EQ(heard[0], "q: grid 'temperature' is " + file("b.vdb") + ": 'smoke'");
}

TEST_F(GridCombinerTest, MaxSumAndProductAreThoseOfTheVoxels) {
    const std::vector<CombinedGrid::Part> parts{{0, "", "p"}, {1, "smoke", "q"}};
    expectValues(load(edit({{"density", How::max, parts}}), {{""}})[0],
                 [](const Int3& p) { return std::max(aAt(p), bAt(p)); });
    EXPECT_EQ(heard.at(0),
              "p: grid 'density' is the max of " + file("a.vdb") + ": 'density', " + file("b.vdb") + ": 'smoke'");
    expectValues(load(edit({{"density", How::add, parts}}), {{""}})[0], [](const Int3& p) { return aAt(p) + bAt(p); });
    const SparseField product = load(edit({{"density", How::multiply, parts}}), {{""}})[0];
    expectValues(product, [](const Int3& p) { return aAt(p) * bAt(p); });
    EXPECT_EQ(product.activeVoxels, 3u * 4 * 5) << "voxels of both alone";
    // Three parts, one of them twice: nothing that was read is changed by what is computed from it.
    const auto more = load(edit({{"density", How::add, {{0, "", "p"}, {1, "smoke", "q"}, {0, "", "r"}}},
                                 {"own", How::copied, {{0, "density", "s"}}}}),
                           {{"density"}, {"own"}});
    expectValues(more[0], [](const Int3& p) { return 2 * aAt(p) + bAt(p); });
    expectValues(more[1], aAt);
}

TEST_F(GridCombinerTest, TilesAndVoxelsCombine) {
    makeVdb(file("a.vdb"), {{.voxels = {{{9, 0, 0}, 0.25}}, .tiles = {{{0, 0, 0}, 8, 0.5}}}});
    makeVdb(file("b.vdb"), {{.voxels = {{{2, 2, 2}, 0.75}, {{9, 0, 0}, 2}}}});
    const GridEdit sum = edit({{"density", How::add, {{0, "", "p"}, {1, "density", "q"}}}});
    const SparseField field = load(sum, {{"density"}})[0];
    EXPECT_EQ(field.activeVoxels, 513u);
    expectValues(field, [](const Int3& p) {
        const auto isIn = [](int v) { return v >= 0 && v < 8; };
        return p == Int3(9, 0, 0) ? 2.25 : p == Int3(2) ? 1.25 : isIn(p.x) && isIn(p.y) && isIn(p.z) ? 0.5 : 0;
    });
}

TEST_F(GridCombinerTest, VectorsAddAndMultiplyByComponents) {
    const auto fields = load(edit({{"velocity", How::add, {{2, "vel", "p"}, {2, "Cd", "q"}}},
                                   {"Cd", How::multiply, {{2, "vel", "p"}, {2, "Cd", "q"}}},
                                   {"density", How::copied, {{0, "", "r"}}}}),
                             {{"velocity", 1, GridPart::positive}, {"Cd", 2}, {"density"}});
    EXPECT_FLOAT_EQ(fields[0].maxValue, 7);
    EXPECT_FLOAT_EQ(fields[1].maxValue, 18);
    EXPECT_EQ(failure(edit({{"density", How::max, {{2, "vel", "p"}, {2, "Cd", "q"}}}}), {{"density"}}),
              "p: " + file("c.vdb") + ": 'vel' holds vec3s values; expected numbers");
    EXPECT_EQ(failure(edit({{"density", How::add, {{0, "", "p"}, {2, "Cd", "q"}}}}), {{"density"}}),
              "q: " + file("c.vdb") + ": 'Cd' holds vec3s values; expected numbers, or vectors in all of them");
}

TEST_F(GridCombinerTest, OtherVoxelsAreInterpolatedAtThoseOfTheFirst) {
    // A linear function on a lattice of another voxel, turned and displaced, is that function wherever it is known.
    const auto linear = [](const Vec3& ws) { return 1 + 0.1 * ws.x - 0.05 * ws.y + 0.02 * ws.z; };
    const double voxel = 0.7;
    const Vec3 place(0.3, -0.2, 0.1);
    std::vector<MadeVoxel> fine;
    for (const MadeVoxel& v : box({-6, -6, -6}, {16, 16, 16}, 0)) {
        fine.push_back({v.at, linear(voxel * Vec3(v.at) + place)});
    }
    makeVdb(file("a.vdb"), {{.voxels = box({0, 0, 0}, {7, 7, 7}, 2)}});
    makeVdb(file("b.vdb"), {{.voxels = fine, .voxelSize = voxel, .translate = place}});
    const GridEdit sum = edit({{"density", How::multiply, {{0, "", "p"}, {1, "density", "q"}}}});
    expectValues(load(sum, {{"density"}})[0], [&](const Int3& p) {
        const auto isIn = [](int v) { return v >= 0 && v < 8; };
        return isIn(p.x) && isIn(p.y) && isIn(p.z) ? 2 * linear(Vec3(p)) : 0;
    });
    EXPECT_EQ(heard.at(0), "p: grid 'density' is the product of " + file("a.vdb") + ": 'density', " + file("b.vdb") +
                               ": 'density' (interpolated)");
}

TEST_F(GridCombinerTest, RefusesTransformsThatCannotBeInterpolated) {
    makeVdb(file("b.vdb"), {{.name = "density", .voxels = {{{1, 1, 1}, 1}}, .frustum = true}});
    EXPECT_EQ(failure(edit({{"density", How::max, {{0, "", "p"}, {1, "density", "q"}}}}), {{"density"}}),
              "q: " + file("b.vdb") +
                  ": 'density' has other voxels than the first grid, and a transform that is not affine; expected "
                  "affine ones, or the same voxels");
    makeVdb(file("b.vdb"), {{.tiles = {{{0, 0, 0}, 4096, 1}}, .voxelSize = 1}});
    makeVdb(file("a.vdb"), {{.voxels = {{{1, 1, 1}, 1}}, .voxelSize = 0.5}});
    EXPECT_EQ(failure(edit({{"density", How::max, {{0, "", "p"}, {1, "density", "q"}}}}), {{"density"}}),
              "q: " + file("b.vdb") +
                  ": 'density' would have 5.5e+11 voxels of the first grid's size; expected at most 1e+09");
}

TEST_F(GridCombinerTest, LevelSetsBecomeFogBeforeTheyAreCombined) {
    makeVdb(file("b.vdb"), {{.name = "ball", .type = "sphere"}});
    const auto fields =
        load(edit({{"density", How::max, {{0, "", "p"}, {1, "ball", "q"}}}, {"ball", How::copied, {{1, "", "r"}}}}),
             {{"density"}, {"ball"}});
    // Fog is 1 in the ball, and nothing outside.
    EXPECT_FLOAT_EQ(fields[1].maxValue, 1);
    for (const MadeVoxel& v : box({-12, -12, -12}, {12, 12, 12}, 0))
        ASSERT_NEAR(valueAt(fields[0], v.at), std::max(aAt(v.at), valueAt(fields[1], v.at)), 1e-6);
}

TEST_F(GridCombinerTest, SaysWhichGridIsNotThere) {
    EXPECT_EQ(failure(edit({{"density", How::copied, {{0, "smoke", "p"}}}}), {{"density"}}),
              "p: " + file("a.vdb") + ": no grid 'smoke'; it holds 'density' (float), 'heat' (float)");
    EXPECT_EQ(failure(edit({{"fuel", How::copied, {{0, "", "p"}}}}), {{"fuel"}}),
              "p: " + file("a.vdb") + ": no grid 'fuel'; it holds 'density' (float), 'heat' (float)")
        << "a file with two grids has no only one";
    EXPECT_EQ(
        failure(edit({{"density", How::copied, {{0, "", "p"}}}}), {{"heat"}}),
        fmt::format("{0}, {1}, {2}: no grid 'heat' among those of 'grids': 'density'; {0} holds 'density' (float), "
                    "'heat' (float); {1} holds 'smoke' (double); {2} holds 'vel' (vec3s), 'Cd' (vec3s)",
                    file("a.vdb"), file("b.vdb"), file("c.vdb")))
        << "grids that are not named are not there";
}

#ifdef SCRIM_WITH_AX

TEST_F(GridCombinerTest, ExpressionsReadAndWriteGridsOfAllFiles) {
    GridEdit both = edit({{"density", How::copied, {{0, "", "p"}}}, {"heat", How::copied, {{1, "smoke", "q"}}}});
    both.programs = {{"f@density += 2 * f@heat;", "s.toml:7:6", "s.toml", 7, 9}};
    expectValues(load(both, {{"density"}})[0], [](const Int3& p) { return aAt(p) > 0 ? aAt(p) + 2 * bAt(p) : 0; });
}

#endif

}  // namespace
}  // namespace scrim::test
