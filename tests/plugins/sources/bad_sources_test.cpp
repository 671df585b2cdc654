// SPDX-License-Identifier: Apache-2.0
// Sources that break the interface: each gets a reason, none a crash. (What the loader's own tests have is not
// repeated.)
#include "plugins/sources/generated.h"

namespace scrim::test {
namespace {

class BadSource : public ::testing::Test {
  protected:
    void SetUp() override { ::setenv("SCRIM_PLUGIN_PATH", SCRIM_BAD_SOURCES, 1); }
    void TearDown() override { ::unsetenv("SCRIM_PLUGIN_PATH"); }

    static std::string described(const std::string& name) {
        const std::string start = SCRIM_BAD_SOURCES "/scrim_source_" + name + ".so: ";
        const std::string text = errorOf(ErrorKind::input, [&] { generate(name, {}, {}); });
        EXPECT_TRUE(text.starts_with(start)) << text;
        return text.substr(std::min(start.size(), text.size()));
    }
    static std::string acted(const std::string& act) {
        return errorOf(ErrorKind::input, [&] { generate("badcalls", {{"act", act}}, {}); });
    }
};

TEST_F(BadSource, DescriptionIsRefusedWithTheReason) {
    EXPECT_EQ(described("nothing"), "its scrim_source_v1 returns no description");
    EXPECT_EQ(described("no_generate"), "its description lacks 'generate'");
    const std::string size = std::to_string(sizeof(scrim_parameter) + 24);
    EXPECT_EQ(described("no_parameters"), "its 2 parameters of " + size + " bytes are invalid");
    EXPECT_EQ(described("many_parameters"), "its 1000000 parameters of " + size + " bytes are invalid");
    EXPECT_EQ(described("small_parameters"),
              "its 2 parameters of " + std::to_string(sizeof(scrim_parameter) - 8) + " bytes are invalid");
    EXPECT_EQ(described("odd_parameters"),
              "its 2 parameters of " + std::to_string(sizeof(scrim_parameter) + 25) + " bytes are invalid");
    EXPECT_EQ(described("unnamed_parameter"), "one of its parameters has no name");
    EXPECT_EQ(described("unknown_type"), "its parameter 'first' has the unknown type 17");
    EXPECT_EQ(described("no_default"), "its parameter 'first' has no default");
    EXPECT_EQ(described("empty_range"), "its parameter 'first' has an empty range");
    EXPECT_EQ(described("parameter_twice"), "it has two parameters called 'first'");
}

TEST_F(BadSource, LargerStructuresOfLaterVersionsAreWelcome) {
    const auto fields = generate("larger", {{"second", "0.25"}}, {});
    ASSERT_EQ(fields.size(), 1u);
    EXPECT_EQ(fields[0].maxValue, 0.25f);
    EXPECT_EQ(describeSource("larger").parameters.at(1).help, "value");
}

TEST_F(BadSource, ExceptionsAreCaughtAtTheBoundary) {
    const std::string expected = "source 'badcalls': it threw an exception; a source must not throw";
    EXPECT_EQ(acted("throws"), expected);
    EXPECT_EQ(acted("throws a number"), expected);
}

TEST_F(BadSource, CallsThatBreakTheRulesAreRefused) {
    const std::string it = "source 'badcalls': it ", grid = "source 'badcalls': grid 'density': ";
    EXPECT_EQ(acted("no grid"), it + "used grid number 0, but has added 0 grids");
    EXPECT_EQ(acted("negative grid"), it + "used grid number -1, but has added 1 grids");
    EXPECT_EQ(acted("nameless grid"), it + "added a grid without a name");
    EXPECT_EQ(acted("null name"), it + "added a grid without a name");
    EXPECT_EQ(acted("null transform"), it + "added a grid without a transform");
    EXPECT_EQ(acted("nan transform"), grid + "its transform is not finite");
    EXPECT_EQ(acted("projective"), grid + "its transform is not affine");
    EXPECT_EQ(acted("null origin"), it + "added a block without origin or values");
    EXPECT_EQ(acted("null values"), it + "added a block without origin or values");
    EXPECT_EQ(acted("null tile"), it + "added a tile without an origin");
    const std::string rule = ": the edge must be 8 times a power of two and the origin a multiple of it";
    EXPECT_EQ(acted("tile of nothing"), grid + "a tile of edge 0 at 0, 0, 0" + rule);
    EXPECT_EQ(acted("tile of less"), grid + "a tile of edge -8 at 0, 0, 0" + rule);
    EXPECT_EQ(acted("tile off grid"), grid + "a tile of edge 16 at 8, 0, 0" + rule);
    EXPECT_TRUE(acted("tiles overlap").starts_with(grid)) << acted("tiles overlap");
    EXPECT_EQ(acted("other thread"), it + "called the host from another thread");
}

TEST_F(BadSource, FailuresAreNotLostWhereItReturnsZero) {
    EXPECT_EQ(acted("goes on"), "source 'badcalls': it used grid number 9, but has added 1 grids");
    EXPECT_EQ(acted("fails late"), "source 'badcalls': on second thoughts");
    EXPECT_EQ(acted("null texts"), "source 'badcalls': it failed with code 4 and gave no reason");
}

TEST_F(BadSource, EndlessReasonsAreCut) {
    EXPECT_LT(acted("long text").size(), 10000u);
}

TEST_F(BadSource, WellBehavedItWorks) {
    EXPECT_EQ(generate("badcalls", {}, {}).at(0).activeVoxels, 1u);
}

}  // namespace
}  // namespace scrim::test
