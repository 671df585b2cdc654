// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/source.h>

#include "support/expect_error.h"
#include "support/temp_folder.h"

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>

// Folders of the shared objects built from tests/support/test_source.c, and of the built-in sources.
#if !defined(SCRIM_TEST_SOURCES) || !defined(SCRIM_BUILT_SOURCES)
#error "define SCRIM_TEST_SOURCES and SCRIM_BUILT_SOURCES as folders, as strings"
#endif

namespace scrim {
namespace {

using test::errorOf;
using Parameters = std::vector<std::pair<std::string, std::string>>;

class Source : public ::testing::Test {
  protected:
    void SetUp() override { setPath(SCRIM_TEST_SOURCES ":" SCRIM_BUILT_SOURCES); }
    void TearDown() override { ::unsetenv("SCRIM_PLUGIN_PATH"); }
    static void setPath(const std::string& path) { ::setenv("SCRIM_PLUGIN_PATH", path.c_str(), 1); }
    static std::string reason(const std::string& name, const Parameters& parameters = {}) {
        return errorOf(ErrorKind::input, [&] { generate(name, parameters, {}); });
    }
    static std::string file(const std::string& name) { return SCRIM_TEST_SOURCES "/scrim_source_" + name + ".so"; }
};

TEST_F(Source, GivesItsParametersAndTakesItsGrids) {
    const auto fields = generate("test", {{"count", "4"}}, {});
    ASSERT_EQ(fields.size(), 1u);
    const SparseField& field = fields[0];
    EXPECT_EQ(field.name, "density");
    EXPECT_EQ(transformPoint(field.wsFromIs, Vec3(1, 0, 0)), Vec3(12, 20, 30));
    ASSERT_EQ(field.blockCount(), 1u);
    EXPECT_EQ(field.blockOrigins[0], Int3(-8, 0, 8));
    EXPECT_EQ(field.block(0)[7], 4.0f);
    EXPECT_EQ(field.block(0)[8], 0.0f);
    ASSERT_EQ(field.tiles.size(), 1u);
    EXPECT_EQ(field.tiles[0].value, 4.0f);
    EXPECT_EQ(generate("test", {{"whole", "false"}, {"place", "[1, 0.25, -1]"}}, {})[0].maxValue, 0.25f);
}

TEST_F(Source, DescribesItself) {
    const SourceDescription d = describeSource("test");
    EXPECT_EQ(d.description, "does as it is told");
    EXPECT_EQ(d.path, file("test"));
    ASSERT_EQ(d.parameters.size(), 5u);
    EXPECT_EQ(d.parameters[0].choices.size(), 13u);
    EXPECT_EQ(typeName(d.parameters[2].type), "vec3");
    EXPECT_EQ(d.parameters[1].maximum, 9);
    EXPECT_FALSE(d.parameters[3].limited());
}

TEST_F(Source, RefusesParametersItDoesNotHave) {
    EXPECT_EQ(reason("test", {{"cuont", "4"}}),
              "source 'test': unknown parameter 'cuont', expected 'act', 'count', 'place', 'width' or 'whole'");
    EXPECT_EQ(reason("test", {{"count", "4"}, {"count", "5"}}), "source 'test': parameter 'count' is given twice");
}

TEST_F(Source, RefusesValuesOfTheWrongTypeOrRange) {
    const auto p = [](const char* key, const char* value) { return reason("test", {{key, value}}); };
    EXPECT_EQ(p("count", "4.5"), "source 'test': parameter 'count' is '4.5', expected a whole number such as 12");
    EXPECT_EQ(p("count", "10"), "source 'test': parameter 'count' is 10, expected 1 to 9");
    EXPECT_EQ(p("width", "nan"), "source 'test': parameter 'width' is 'nan', expected a number such as 0.5");
    EXPECT_EQ(p("width", "1x"), "source 'test': parameter 'width' is '1x', expected a number such as 0.5");
    EXPECT_EQ(p("width", ""), "source 'test': parameter 'width' is '', expected a number such as 0.5");
    EXPECT_EQ(p("place", "1, 2"),
              "source 'test': parameter 'place' is '1, 2', expected three numbers such as 0, 1.5, 0");
    EXPECT_EQ(p("place", "0,0,0,0"),
              "source 'test': parameter 'place' is '0,0,0,0', expected three numbers such as 0, 1.5, 0");
    EXPECT_EQ(p("place", "0, 0, 2"), "source 'test': parameter 'place' is 0, 0, 2, expected -1 to 1");
    EXPECT_EQ(p("whole", "yes"), "source 'test': parameter 'whole' is 'yes', expected true or false");
    EXPECT_TRUE(p("act", "dance").starts_with("source 'test': parameter 'act' is 'dance', expected 'well', 'fail', "));
}

TEST_F(Source, PassesOnWhatTheSourceSays) {
    EXPECT_EQ(reason("test", {{"act", "fail"}}), "source 'test': the weather is bad");
    EXPECT_EQ(reason("test", {{"act", "silent"}}), "source 'test': it failed with code 6 and gave no reason");
    std::vector<std::string> heard;
    generate("test", {{"act", "warn"}}, [&](Severity, const std::string& text) { heard.push_back(text); });
    EXPECT_EQ(heard, std::vector<std::string>{"source 'test': it may rain"});
}

TEST_F(Source, RefusesGridsThatBreakTheRules) {
    const auto act = [](const char* what) { return reason("test", {{"act", what}}); };
    EXPECT_EQ(act("nothing"), "source 'test': it made no grid");
    EXPECT_EQ(act("flat"), "source 'test': grid 'density': its transform cannot be inverted");
    EXPECT_EQ(act("misplaced block"),
              "source 'test': grid 'density': a block at -8, 4, 8: origins must be multiples of 8");
    EXPECT_EQ(act("block twice"), "source 'test': grid 'density': two blocks at -8, 0, 8");
    EXPECT_EQ(act("overlap"), "source 'test': grid 'density': values at 0, 0, 8 lie inside the tile at 0, 0, 8");
    EXPECT_EQ(act("wrong grid"), "source 'test': it used grid number 7, but has added 1 grids");
    EXPECT_EQ(act("grid twice"), "source 'test': it added two grids called 'density'");
    EXPECT_EQ(act("odd tile"),
              "source 'test': grid 'density': a tile of edge 24 at 0, 0, 8: the edge must be 8 times a power of two "
              "and the origin a multiple of it");
}

TEST_F(Source, ReportsValuesThatCountAsZero) {
    std::vector<std::string> heard;
    const auto fields =
        generate("test", {{"act", "nan"}}, [&](Severity, const std::string& text) { heard.push_back(text); });
    EXPECT_EQ(fields[0].nonFinite, 1u);
    ASSERT_EQ(heard.size(), 1u);
    EXPECT_EQ(heard[0],
              "source 'test': grid 'density': of 520 voxels with a value 1 are below 0 and 1 are not finite, and count "
              "as empty");
}

TEST_F(Source, StopsWhenAsked) {
    double seen = 0;
    EXPECT_EQ(errorOf(ErrorKind::interrupted,
                      [&] {
                          generate("test", {}, {}, [&](double done) {
                              seen = done;
                              return false;
                          });
                      }),
              "source 'test': interrupted");
    EXPECT_EQ(seen, 0.5);
}

TEST_F(Source, IsRefusedBeforeAnythingIsCalled) {
    EXPECT_EQ(reason("wrongabi"), file("wrongabi") + ": is made for version 2 of the interface, expected 1");
    EXPECT_EQ(reason("short"), file("short") + ": its description has 8 bytes, expected at least " +
                                   std::to_string(sizeof(scrim_source)));
    EXPECT_EQ(reason("nosymbol"), file("nosymbol") + ": is not a volume source: it does not export scrim_source_v1");
    EXPECT_EQ(reason("othername"),
              file("othername") + ": calls itself 'test', expected 'othername' as in its file name");
    EXPECT_EQ(reason("baddefault"),
              file("baddefault") + ": default: parameter 'width' is 'wide', expected a number such as 0.5");
}

TEST_F(Source, MissingIsSaidWithThoseFound) {
    const std::string text = reason("smoke");
    EXPECT_TRUE(text.starts_with("no volume source 'smoke' in " SCRIM_TEST_SOURCES ", ")) << text;
    EXPECT_NE(text.find("; there is 'baddefault', 'mesh', 'noise', 'nosymbol', "), std::string::npos) << text;
    EXPECT_TRUE(reason("../test").starts_with("no volume source '../test' in "));
}

TEST_F(Source, ThatIsNoLibraryIsRefusedWithTheReason) {
    const test::TempFolder folder;
    std::filesystem::copy_file(SCRIM_SOURCE_DIR "/README.md", folder.file("scrim_source_text.so"));
    setPath(folder.path());
    const std::string text = reason("text");
    EXPECT_TRUE(text.starts_with(folder.file("scrim_source_text.so") + ": cannot be loaded: ")) << text;
}

TEST_F(Source, ListLeavesOutBadOnesWithAWarning) {
    std::vector<std::string> heard;
    const auto sources = listSources([&](Severity, const std::string& text) { heard.push_back(text); });
    std::vector<std::string> names;
    for (const auto& s : sources) names.push_back(s.name);
    EXPECT_EQ(names, (std::vector<std::string>{"mesh", "noise", "primitives", "scan", "test"}));
    EXPECT_EQ(heard.size(), 5u);
}

TEST_F(Source, NoiseIsTheSameOnEveryRunAndNotForEverySeed) {
    const auto run = [](const std::string& seed) {
        return generate("noise", {{"resolution", "48"}, {"seed", seed}}, {}).at(0);
    };
    const SparseField a = run("1"), b = run("1"), c = run("2");
    ASSERT_EQ(a.blockOrigins, b.blockOrigins);
    EXPECT_EQ(std::memcmp(a.block(0), b.block(0), a.blockCount() * kBlockVoxels * sizeof(float)), 0);
    EXPECT_NE(a.activeVoxels, c.activeVoxels);
}

TEST_F(Source, NoiseFillsItsBoxWithoutTouchingIt) {
    for (const std::string shape : {"plume", "ball", "slab"}) {
        const SparseField field =
            generate("noise", {{"resolution", "64"}, {"size", "10"}, {"shape", shape}, {"density", "3"}}, {}).at(0);
        EXPECT_GT(field.activeVoxels, 3000u) << shape;
        EXPECT_GT(field.maxValue, 1.5f) << shape;
        EXPECT_LE(field.maxValue, 3.0f) << shape;
        Bounds ws;
        for (std::size_t i = 0; i < field.blockCount(); ++i)
            for (int x = 0; x < 8; ++x)
                for (int y = 0; y < 8; ++y)
                    for (int z = 0; z < 8; ++z)
                        if (field.block(i)[blockOffset(x, y, z)] > 0)
                            ws.include(transformPoint(field.wsFromIs, Vec3(field.blockOrigins[i] + Int3(x, y, z))));
        for (int k = 0; k < 3; ++k) {
            EXPECT_GT(ws.lower[k], -5) << shape;
            EXPECT_LT(ws.upper[k], 5) << shape;
        }
        EXPECT_GT(ws.size()[shape == "plume" ? 1 : 0], 6) << shape;
    }
}

TEST_F(Source, NoiseWidensTowardsTheTop) {
    const SparseField field = generate("noise", {{"resolution", "64"}}, {}).at(0);
    std::uint64_t low = 0, high = 0;
    for (std::size_t i = 0; i < field.blockCount(); ++i)
        for (int n = 0; n < kBlockVoxels; ++n) (field.blockOrigins[i].y < 0 ? low : high) += field.block(i)[n] > 0;
    // The envelope's upper half holds some 2.5 times as much; turbulence takes more from where it is rougher.
    EXPECT_GT(2 * high, 3 * low);
}

}  // namespace
}  // namespace scrim
