// SPDX-License-Identifier: Apache-2.0
// Grids that are cut, refined, and changed by expressions hold what closed forms say, in this process and in a child.
#include <scrim/guard/load_fields.h>
#include <scrim/volume/field_sampler.h>
#include <scrim/volume/grid_edit.h>

#include "support/data.h"
#include "support/expect_error.h"
#include "support/loaded_fields.h"
#include "support/temp_folder.h"
#include "support/vdb_make.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

namespace scrim::test {
namespace {

using Values = std::function<double(const Int3& is)>;

double sumOf(const SparseField& field) {
    double sum = 0;
    for (std::size_t b = 0; b < field.blockCount(); ++b)
        for (int i = 0; i < kBlockVoxels; ++i) sum += double(field.block(b)[i]);
    return sum;
}

/// A lattice that is neither at the origin nor of unit voxels.
constexpr double kVoxel = 0.25;
const Vec3 kPlace{3, -1, 2};

Vec3 wsOf(const Int3& is) {
    return kVoxel * Vec3(is) + kPlace;
}

class GridEditTest : public ::testing::Test {
  protected:
    void SetUp() override {
        std::vector<MadeVoxel> voxels, heat;
        for (const MadeVoxel& v : box(kLower, kUpper, 0)) {
            voxels.push_back({v.at, densityAt(v.at)});
            if (v.at.x < 3) heat.push_back({v.at, 2.0});
        }
        makeVdb(path(), {{.voxels = voxels, .voxelSize = kVoxel, .translate = kPlace},
                         {.name = "heat", .type = "double", .voxels = heat, .voxelSize = kVoxel, .translate = kPlace},
                         {.name = "vel", .type = "vec3s", .colours = {{{1, 1, 1}, {1, 2, 3}}}, .voxelSize = kVoxel}});
    }
    static double densityAt(const Int3& is) { return 0.5 + 0.1 * is.x + 0.01 * is.z; }

    GridEdit code(const std::string& text) const {
        GridEdit edit;
        edit.programs = {{text, "s.toml:7:6", "s.toml", 7, 9}};
        edit.where = "s.toml:7:6";
        return edit;
    }
    enum class Compare { bits, places };
    /// What both ways of loading give, which must be the same bits.
    std::vector<SparseField> load(const GridEdit& edit, const std::vector<GridRequest>& requests,
                                  Compare compare = Compare::bits) {
        std::vector<std::vector<SparseField>> both;
        for (const LoadOptions& way : kWays) {
            heard.clear();
            both.push_back(loadFields(
                path(), requests, way,
                [this](Severity severity, const std::string& text) {
                    (severity == Severity::warning ? warned : heard).push_back(text);
                },
                {}, &edit));
        }
        for (std::size_t i = 0; i < requests.size(); ++i) {
            EXPECT_EQ(both[0][i].blockOrigins, both[1][i].blockOrigins);
            EXPECT_TRUE(
                compare == Compare::places ||
                std::equal(both[0][i].block(0), both[0][i].block(both[0][i].blockCount()), both[1][i].block(0)));
        }
        return std::move(both[1]);
    }
    std::string failure(const GridEdit& edit, const std::vector<GridRequest>& requests = {{"density"}}) {
        std::vector<std::string> texts;
        for (const LoadOptions& way : kWays)
            texts.push_back(errorOf(ErrorKind::input, [&] { loadFields(path(), requests, way, {}, {}, &edit); }));
        EXPECT_EQ(texts[0], texts[1]);
        return texts[0];
    }
    void expectValues(const SparseField& field, const Values& expected, double tolerance = 1e-6) {
        for (const MadeVoxel& v : box(kLower, kUpper, 0))
            ASSERT_NEAR(valueAt(field, v.at), expected(v.at), tolerance)
                << field.name << " at " << v.at.x << " " << v.at.y << " " << v.at.z;
    }
    std::string path() const { return m_folder.file("a.vdb"); }

    const Int3 kLower{-3, -2, 0}, kUpper{9, 6, 10};
    std::vector<std::string> heard, warned;

  private:
    TempFolder m_folder;
};

TEST(GridEditText, ComesBackAsItWas) {
    GridEdit edit;
    edit.clip = Bounds{{-1, 0.1, 2}, {3, 4, 5e-9}};
    edit.resample = 1.7;
    edit.density = "smoke[1]";
    edit.where = "s.toml:1:2";
    edit.programs = {{"f@a = 1;\n// \"'", "s.toml:4:6", "s.toml", 5, 1}, {"", "--set volume.v.ax", "", 1, 1}};
    edit.variables = {{"frame", {7}}, {"wind", {1, 0.3, -2}}};
    EXPECT_EQ(gridEditFrom(toText(edit)), edit);
    EXPECT_EQ(toText(gridEditFrom(toText(edit))), toText(edit));
    EXPECT_EQ(errorOf(ErrorKind::usage, [] { gridEditFrom("[]"); }).substr(0, 21), "not an edit of grids:");
}

TEST(GridEditText, NamesTheVariablesOfCode) {
    EXPECT_EQ(variablesIn("f@density = $a + v$wind.x * $a_2 - f$frame; // $"),
              (std::vector<std::string>{"a", "wind", "a_2", "frame"}));
}

TEST(GridEditText, PlacesAreThoseOfTheFile) {
    const AxCode lines{"", "s.toml:7:6", "s.toml", 8, 1}, line{"", "s.toml:7:6", "s.toml", 7, 7};
    const AxCode file{"", "s.toml:7:11", "/a/wisps.ax", 1, 1}, set{"", "--set volume.v.ax", "", 1, 1};
    EXPECT_EQ(lines.placeOf(2, 5), "s.toml:9:5");
    EXPECT_EQ(line.placeOf(1, 5), "s.toml:7:11");
    EXPECT_EQ(line.placeOf(2, 5), "s.toml:8:5");
    EXPECT_EQ(file.placeOf(3, 4), "s.toml:7:11: /a/wisps.ax:3:4");
    EXPECT_EQ(set.placeOf(1, 4), "--set volume.v.ax: line 1, column 4");
}

TEST_F(GridEditTest, KeepsVoxelsThatTheBoxDependsOn) {
    GridEdit edit;
    edit.clip = Bounds{wsOf({-5, -6, -4}), wsOf({1, 0, 2})};
    const auto fields = load(edit, {{"density"}, {"heat"}});
    const Vec3 last(4, 3, 5);  // three voxels beyond
    const auto isIn = [&](const Int3& p) { return p.x <= last.x && p.y <= last.y && p.z <= last.z; };
    expectValues(fields[0], [&](const Int3& p) { return isIn(p) ? densityAt(p) : 0; });
    expectValues(fields[1], [&](const Int3& p) { return isIn(p) && p.x < 3 ? 2.0 : 0; });
}

TEST_F(GridEditTest, CutsThroughTiles) {
    makeVdb(path(), {{.tiles = {{{0, 0, 0}, 128, 0.5}}}});
    GridEdit edit;
    edit.clip = Bounds{{10.5, -5, 20}, {100.2, 1000, 90}};
    const auto fields = load(edit, {{"density"}});
    // From 10.5 - 3 to 100.2 + 3, outwards; from 20 - 3 to 90 + 3.
    EXPECT_EQ(fields[0].activeVoxels, (104u - 7 + 1) * 128 * (93 - 17 + 1));
}

TEST_F(GridEditTest, RefinedGridsFillTheSameSpaceAndKeepSlopes) {
    for (const double factor : {2.0, 3.0, 0.5}) {
        GridEdit edit;
        edit.resample = factor;
        const SparseField field = load(edit, {{"density"}})[0];
        const Vec3 first(field.wsFromIs * glm::dvec4(0, 0, 0, 1)), next(field.wsFromIs * glm::dvec4(1, 0, 0, 1));
        EXPECT_NEAR(next.x - first.x, kVoxel / factor, 1e-12);
        // Linear interpolation of a linear function is that function, inside.
        std::size_t compared = 0;
        for (const MadeVoxel& v : box({-20, -20, -20}, {40, 40, 40}, 0)) {
            const Vec3 is = (Vec3(field.wsFromIs * glm::dvec4(Vec3(v.at), 1)) - kPlace) / kVoxel;
            if (!Bounds{Vec3(kLower), Vec3(kUpper)}.contains(is)) continue;
            ++compared;
            ASSERT_NEAR(valueAt(field, v.at), 0.5 + 0.1 * is.x + 0.01 * is.z, 1e-5) << factor;
        }
        EXPECT_GT(compared, 100u);
        if (factor < 1) continue;
        // The tents of a finer lattice add up to 1, so that mass stays, but for the faintest voxels of the rim.
        double mass = 0;
        for (const MadeVoxel& v : box(kLower, kUpper, 0)) mass += densityAt(v.at);
        EXPECT_NEAR(sumOf(field) / std::pow(factor, 3), mass, 0.015 * mass) << factor;
    }
}

TEST_F(GridEditTest, RefusesToRefineWithoutBounds) {
    makeVdb(path(), {{.tiles = {{{0, 0, 0}, 4096, 0.5}}}});
    GridEdit edit;
    edit.resample = 2;
    edit.where = "s.toml:7:1";
    EXPECT_EQ(failure(edit),
              "s.toml:7:1: " + path() + ": grid 'density' would have 5.5e+11 voxels; expected at most 1e+09");
}

TEST_F(GridEditTest, RefusesToRefineAFrustum) {
    makeVdb(path(), {{.voxels = box({2, 2, 2}, {14, 14, 14}, 1), .voxelSize = 0.5, .frustum = true}});
    GridEdit edit;
    edit.resample = 2;
    edit.where = "s.toml:7:1";
    const std::string wrong = ": grid 'density' has a transform that is not affine; 'resample' expects an affine one";
    EXPECT_EQ(failure(edit), "s.toml:7:1: " + path() + wrong);
}

#ifdef SCRIM_WITH_AX

TEST_F(GridEditTest, RunsAtEachVoxelWithItsPlace) {
    const auto fields = load(code("vec3f p = getvoxelpws();\nf@density = f@density * 2 + p.y + 3;"), {{"density"}});
    expectValues(fields[0], [](const Int3& p) { return densityAt(p) * 2 + wsOf(p).y + 3; });
    ASSERT_EQ(heard.size(), 1u);
    EXPECT_EQ(heard[0].substr(0, heard[0].find(" in ")),
              "s.toml:7:6: ax on " + path() + ": reads 'density'; writes 'density'; 1287 voxels");
}

TEST_F(GridEditTest, MakesGridsOnTheVoxelsOfTheDensity) {
    const auto fields = load(code("f@temperature = f@density * 1000; v@Cd = {0.1, 0.2, 0.3} * f@density; i@n = 3;"),
                             {{"temperature"}, {"Cd", 0}, {"Cd", 2}, {"density"}});
    expectValues(
        fields[0], [](const Int3& p) { return densityAt(p) * 1000; }, 1e-3);
    expectValues(fields[1], [](const Int3& p) { return densityAt(p) * 0.1; });
    expectValues(fields[2], [](const Int3& p) { return densityAt(p) * 0.3; });
    expectValues(fields[3], densityAt);
}

TEST_F(GridEditTest, RunsOnceForAllGridsThatItWrites) {
    // The generator of rand() goes on from voxel to voxel: two runs would give two numbers. It is seeded nowhere.
    const auto fields = load(code("if (f@density < -1) rand(1); float r = rand(); f@density = 1 + r; v@Cd = r + 1;"),
                             {{"density"}, {"Cd", 2}}, Compare::places);
    double most = 0, least = 1e9;
    for (const MadeVoxel& v : box(kLower, kUpper, 0)) {
        ASSERT_EQ(valueAt(fields[0], v.at), valueAt(fields[1], v.at));
        most = std::max(most, valueAt(fields[0], v.at));
        least = std::min(least, valueAt(fields[0], v.at));
    }
    EXPECT_GT(most, least);
}

TEST_F(GridEditTest, WritesAsManyGridsAsItLikes) {
    // From 2 to 20 numbers a voxel: what is written in one go, and what is not. 'return' makes it run for each grid.
    for (const std::string& code : {std::string(), std::string("if (f@density < 0) return;")})
        for (const int count : {1, 2, 3, 4, 8, 9, 15, 16, 19}) {
            std::string text = code;
            std::vector<GridRequest> requests{{"density"}};
            for (int i = 0; i < count; ++i) {
                text += fmt::format("f@g{0} = f@density * {0} + f@g{0} + 1;", i);
                requests.push_back({fmt::format("g{}", i)});
            }
            text += "f@density += 0.5; if (getcoordx() > 2) f@g0 = 7;";
            const auto fields = load(this->code(text), requests);
            expectValues(fields[0], [](const Int3& p) { return densityAt(p) + 0.5; });
            for (int i = 0; i < count; ++i)
                expectValues(
                    fields[std::size_t(i) + 1],
                    [&](const Int3& p) { return i == 0 && p.x > 2 ? 7 : densityAt(p) * i + 1; }, 1e-5);
        }
    const auto mixed = load(code("v@a = getvoxelpws() + 9; f@b = v@a.y; v@c = v@a * 2; v@c.x = f@b; f@density *= 2;"),
                            {{"a", 0}, {"b"}, {"c", 0}, {"c", 2}, {"density"}});
    expectValues(
        mixed[0], [](const Int3& p) { return wsOf(p).x + 9; }, 1e-5);
    expectValues(
        mixed[1], [](const Int3& p) { return wsOf(p).y + 9; }, 1e-5);
    expectValues(
        mixed[2], [](const Int3& p) { return wsOf(p).y + 9; }, 1e-5);
    expectValues(
        mixed[3], [](const Int3& p) { return 2 * (wsOf(p).z + 9); }, 1e-5);
    expectValues(mixed[4], [](const Int3& p) { return 2 * densityAt(p); });
}

TEST_F(GridEditTest, KeepsTilesWhereSeveralGridsAreWritten) {
    makeVdb(path(), {{.voxels = {{{-1, 0, 0}, 0.25}}, .tiles = {{{0, 0, 0}, 128, 0.5}}}});
    const auto fields = load(code("f@density *= 2; f@heat = f@density + 1;"), {{"density"}, {"heat"}});
    ASSERT_EQ(fields[0].tiles.size(), 1u);
    EXPECT_FLOAT_EQ(fields[0].tiles[0].value, 1);
    ASSERT_EQ(fields[1].tiles.size(), 1u);
    EXPECT_FLOAT_EQ(fields[1].tiles[0].value, 2);
    EXPECT_FLOAT_EQ(float(valueAt(fields[1], {-1, 0, 0})), 1.5f);
}

TEST_F(GridEditTest, IsExactFarFromTheOrigin) {
    // Positions in single precision tell these voxels apart no more, but each grid still has its own.
    makeVdb(path(),
            {{.voxels = box(kLower, kUpper, 0.25), .voxelSize = 0.01, .translate = Vec3(3e5, 0, 0)},
             {.name = "heat", .voxels = box(kLower, kUpper, 2), .voxelSize = 0.01, .translate = Vec3(3e5, 0, 0)}});
    const auto fields = load(code("f@density *= 2; f@heat *= 3;"), {{"density"}, {"heat"}});
    expectValues(fields[0], [](const Int3&) { return 0.5; });
    expectValues(fields[1], [](const Int3&) { return 6.0; });
}

TEST_F(GridEditTest, ReadsOtherGridsOfTheFile) {
    const auto fields = load(code("f@density = f@heat; v@out = v@vel;"), {{"density"}, {"out", 1}});
    expectValues(fields[0], [](const Int3& p) { return p.x < 3 ? 2.0 : 0; });
}

TEST_F(GridEditTest, RaisesToWholePowers) {
    // LLVM's own power of a double and an integer crashes.
    const auto fields = load(code("double d = f@density; int k = 3; float g = f@density; f@density = pow(d, k) + "
                                  "pow(clamp(1 - d, -5, 5), 2) + pow(g, 2); f@b = pow(d, -1) + pow(d, k - 1);"),
                             {{"density"}, {"b"}});
    const auto p = [](double x, int n) { return std::pow(x, n); };
    expectValues(
        fields[0],
        [&](const Int3& at) {
            const double d = densityAt(at);
            return p(d, 3) + p(1 - d, 2) + p(d, 2);
        },
        1e-5);
    expectValues(
        fields[1], [&](const Int3& at) { return p(densityAt(at), -1) + p(densityAt(at), 2); }, 1e-4);
}

TEST_F(GridEditTest, KnowsItsVariables) {
    GridEdit edit = code("vec3f w = v$wind; f@density = $frame + w.z * $gain;");
    edit.variables = {{"frame", {12}}, {"wind", {1, 2, 3}}, {"gain", {0.5}}};
    expectValues(load(edit, {{"density"}})[0], [](const Int3&) { return 13.5; });
}

TEST_F(GridEditTest, RunsAfterCuttingAndRefining) {
    GridEdit edit = code("f@density = 1;");
    edit.clip = Bounds{wsOf({0, 0, 0}), wsOf({3, 3, 3})};
    edit.resample = 2;
    const SparseField field = load(edit, {{"density"}})[0];
    EXPECT_FLOAT_EQ(field.maxValue, 1);
    EXPECT_GE(field.activeVoxels, 8u * 8 * 8);
    EXPECT_LE(field.activeVoxels, 20u * 20 * 20);  // with three voxels on either side
}

TEST_F(GridEditTest, CleansAndCountsWhatExpressionsLeave) {
    const auto fields =
        load(code("f@density = getcoordx() == 0 ? log(-1.0f) : getcoordx() < 0 ? -1 : 1;"), {{"density"}});
    EXPECT_EQ(fields[0].nonFinite, 9u * 11);
    EXPECT_EQ(fields[0].negative, 3u * 9 * 11);
    ASSERT_FALSE(warned.empty());
    EXPECT_NE(warned[0].find("99"), std::string::npos) << warned[0];
}

TEST_F(GridEditTest, SaysWhereCodeIsWrong) {
    EXPECT_EQ(failure(code("f@density = f@density *;")), "s.toml:7:32: unexpected SEMICOLON");
    EXPECT_EQ(failure(code("f@density = 1;\n  f@density = foo(1);")), "s.toml:8:15: unable to locate function \"foo\"");
    EXPECT_EQ(failure(code("f@density = 1;\n  f@density = f@fuel;")),
              "s.toml:8:15: the expression reads grid 'fuel', which " + path() + " does not have; there is 'density'");
    EXPECT_EQ(failure(code("f@density = v@heat.x;")),
              "s.toml:7:21: grid 'heat' of " + path() + " holds float, but the expression takes it for vec3s");
    EXPECT_EQ(failure(code("f@density = f@a; v@a = {1,2,3};")),
              "s.toml:7:26: grid 'a' is used as float and as vec3f; expected one type");
    EXPECT_EQ(failure(code("f@density = $gain;")),
              "s.toml:7:21: there is no parameter 'gain'; expected it in [volume.parameters]");
    GridEdit edit = code("vec3f g = v$gain;");
    edit.variables = {{"gain", {1}}};
    EXPECT_EQ(failure(edit), "s.toml:7:19: parameter 'gain' is a number; expected $gain");
}

TEST_F(GridEditTest, EditsTheGridsOfSources) {
    for (const LoadOptions& way : kWays) {
        const auto made = sourceFields("noise", {{"resolution", "16"}}, way, {});
        const GridEdit edit = code("f@density = 0.25; f@heat = 3;");
        const auto fields = editedFields(made, "source 'noise'", {{"density"}, {"heat"}}, edit, way, {});
        EXPECT_EQ(fields[0].activeVoxels, made[0].activeVoxels);
        EXPECT_FLOAT_EQ(fields[0].maxValue, 0.25f);
        EXPECT_EQ(fields[1].activeVoxels, made[0].activeVoxels);
        EXPECT_FLOAT_EQ(fields[1].maxValue, 3);
    }
}

// A remap of the range and a gain, on a file of a simulation.
TEST_F(GridEditTest, RemapsARealFileAsArithmeticDoes) {
    SCRIM_NEEDS_DATA("vdb/smoke1.vdb");
    const std::string smoke = dataFile("vdb/smoke1.vdb");
    const GridEdit edit = code("f@density = pow(fit(f@density, 0.1f, 0.8f, 0.0f, 1.0f), 2.0f) * 3;");
    const SparseField plain = loadFields(smoke, {{"density"}}, kWays[1], {})[0];
    const SparseField edited = loadFields(smoke, {{"density"}}, kWays[1], {}, {}, &edit)[0];
    double most = 0;
    for (std::size_t b = 0; b < plain.blockCount(); ++b)
        for (int i = 0; i < kBlockVoxels; ++i) {
            const double unit = std::clamp((double(plain.block(b)[i]) - 0.1) / 0.7, 0.0, 1.0);
            const Int3 at = plain.blockOrigins[b] + Int3(i / 64, i / 8 % 8, i % 8);
            most = std::max(most, std::abs(unit * unit * 3 - (unit > 0 ? valueAt(edited, at) : 0)));
        }
    EXPECT_LT(most, 1e-5);
}

#else

TEST_F(GridEditTest, NamesThePackageThatExpressionsNeed) {
    EXPECT_NE(errorOf(ErrorKind::render,
                      [&] {
                          const GridEdit edit = code("f@density = 1;");
                          loadFields(path(), {{"density"}}, kWays[1], {}, {}, &edit);
                      })
                  .find("libopenvdb-ax-dev"),
              std::string::npos);
}

#endif

}  // namespace
}  // namespace scrim::test
