// SPDX-License-Identifier: Apache-2.0
// What a render promised is there when it ends well, whole and finite; and names and files that are odd are told as
// what they are.
#include "support/program_test.h"

#include <scrim/image/exr_read.h>

#include <nlohmann/json.hpp>

#include <cmath>
#include <string>

namespace scrim::test {
namespace {

constexpr int kFailed = 1, kInput = 3;

using WrittenFiles = ProgramTest;

// ---- values

TEST_F(WrittenFiles, AreFinite) {
    const ProgramResult result = run({"render", "scene.toml", "-o", "x.exr", "--preview", "x.png", "--deep", "d.exr",
                                      "--set", "light.key.intensity=1e30", "--set", "light.key.exposure=64"});
    EXPECT_EQ(result.status, kFailed) << result.err;
    EXPECT_NE(result.err.find("scrim: error: frame 1: 'R' is "), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("; nothing is written. A light that is too bright for floats can cause this"),
              std::string::npos)
        << result.err;
    for (const char* name : {"x.exr", "x.png", "d.exr"}) EXPECT_FALSE(exists(name)) << name;
    expectFailure({"bake", "scene.toml", "-o", "light.vdb", "--set", "light.key.intensity=1e30", "--set",
                   "light.key.exposure=64"},
                  kFailed,
                  "frame 1: the grid 'key' contains infinite or NaN values, so nothing is written; is a light brighter "
                  "than floats can hold?");
}

TEST_F(WrittenFiles, OfHalvesAreClampedAndToldSo) {
    const std::vector<std::string> bright{"render", "scene.toml", "-o", "x.exr", "--set", "light.key.intensity=1e8"};
    const ProgramResult result = runWell(bright);
    EXPECT_NE(result.err.find("values beyond the range of half floats were clamped; type = \"float\" keeps them"),
              std::string::npos)
        << result.err;
    float most = 0;
    for (const float value : readExr(file("x.exr")).rgba) {
        ASSERT_TRUE(std::isfinite(value));
        most = std::max(most, value);
    }
    EXPECT_EQ(most, 65504);
}

// ---- statistics

TEST_F(WrittenFiles, OfStatisticsTellOfARunThatEndedEarlyWhatItDid) {
    for (const char* name : {"s.1.vdb", "s.2.vdb"}) std::filesystem::copy_file(file("smoke.vdb"), file(name));
    write("s.toml", kCamera + "[[volume]]\nfile = \"s.#.vdb\"\n" + kLight);
    EXPECT_EQ(run({"render", "s.toml", "-o", "o.#.exr", "--frames", "1-3", "--stats", "s.json"}).status, kInput);
    const auto stats = nlohmann::json::parse(readBytes(file("s.json")));
    ASSERT_EQ(stats.size(), 2u);
    for (int frame : {1, 2}) EXPECT_EQ(stats[std::size_t(frame) - 1].at("frame"), frame);
    // Of none that did nothing, and of all that were left out.
    EXPECT_EQ(run({"render", "s.toml", "-o", "o.#.exr", "--frames", "3", "--stats", "none.json"}).status, kInput);
    EXPECT_FALSE(exists("none.json"));
    runWell({"render", "s.toml", "-o", "o.#.exr", "--frames", "3-4", "--missing", "skip", "--stats", "left.json"});
    EXPECT_EQ(readBytes(file("left.json")), "[]\n");
    for (const std::string& name : listing()) EXPECT_NE(name.rfind(".scrim-", 0), 0u) << name;
}

// ---- names and other files

TEST_F(WrittenFiles, WithLinesInTheirNamesArePrintedAsAnyOther) {
    const std::string name = "a\nb\t.exr";
    runWell({"render", "scene.toml", "-o", name});
    EXPECT_TRUE(exists(name));
    for (const char* input : {"scene.toml", "smoke.vdb"}) {
        const std::string printed = runWell({"render", input, "-o", name, "--print-scene"}).out;
        std::filesystem::remove(file(name));
        write("printed.toml", printed);
        runWell({"render", "printed.toml", "--res", "16x12"});
        EXPECT_TRUE(exists(name)) << printed;
    }
    expectFailure({"render", "scene.toml", "-o", "caf\xe9.exr", "--print-scene"}, 2,
                  "--output: the name is not UTF-8, so no scene can name it");
}

TEST_F(WrittenFiles, AreNotMergedOfWhatIsNoFile) {
    runWell({"render", "scene.toml", "-o", "a.exr"});
    expectFailure({"merge", "a.exr", "/dev/zero", "-o", "b.exr"}, kInput,
                  "cannot merge '/dev/zero': it is not a regular file");
    expectFailure({"merge", "a.exr", "none.exr", "-o", "b.exr"}, kInput,
                  "cannot merge 'none.exr': there is no such file");
}

TEST_F(WrittenFiles, NeedNoViewer) {
    const ProgramResult result = runWell({"render", "scene.toml", "-o", "x.exr", "--display-server", "127.0.0.1:1"});
    EXPECT_NE(result.err.find("scrim: warning: --display-server 127.0.0.1:1: no viewer answers: Connection refused; "
                              "pictures are rendered but not shown\n"),
              std::string::npos)
        << result.err;
    EXPECT_TRUE(exists("x.exr"));
}

}  // namespace
}  // namespace scrim::test
