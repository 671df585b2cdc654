// SPDX-License-Identifier: Apache-2.0
// One set of dials for all frames of a shot: chosen by a plan, kept in a file, given to renders.
#include "support/program_test.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <string>
#include <vector>

namespace scrim::test {
namespace {

class DialsFile : public ProgramTest {
  protected:
    // Smoke that swells becomes thicker, and scatters more of its light again.
    void SetUp() override {
        ProgramTest::SetUp();
        write("shot.toml", kCamera + kVolume + "transform = { scale = { keys = [[1, 0.5], [3, 2]] } }\n" +
                               "[volume.density]\nscale = 1.0\n[volume.medium]\nscattering = \"full\"\n" + kLight);
    }
    nlohmann::json planOf(const std::vector<std::string>& more) const {
        std::vector<std::string> arguments{"plan", "shot.toml", "--json"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return nlohmann::json::parse(runWell(arguments).out);
    }
};

TEST_F(DialsFile, HoldsTheMostExactOfAllFrames) {
    const nlohmann::json frames = planOf({"--frames", "1-3", "--write-dials", "dials.toml"});
    ASSERT_EQ(frames.size(), 3u);
    const nlohmann::json same = planOf({"--frames", "1-3", "--dials", "dials.toml"});
    for (const char* key : {"texel", "sheet_thickness", "scatter_cell"}) {
        std::vector<double> chosen, given;
        for (std::size_t i = 0; i < 3; ++i) {
            chosen.push_back(frames[i]["plan"]["render"][key]);
            given.push_back(same[i]["plan"]["render"][key]);
        }
        EXPECT_LT(*std::ranges::min_element(chosen), *std::ranges::max_element(chosen)) << key;
        EXPECT_EQ(given, std::vector<double>(3, *std::ranges::min_element(chosen))) << key;
    }
}

TEST_F(DialsFile, GivesAFrameAloneTheBitsThatItHasAmongOthers) {
    runWell({"plan", "shot.toml", "--frames", "1-3", "--write-dials", "dials.toml"});
    runWell({"render", "shot.toml", "--frames", "1-3", "--dials", "dials.toml", "-o", "all.####.exr"});
    runWell({"render", "shot.toml", "--frames", "2", "--dials", "dials.toml", "-o", "one.####.exr"});
    EXPECT_EQ(readBytes(file("all.0002.exr")), readBytes(file("one.0002.exr")));
    // What --set says comes last.
    const nlohmann::json set = planOf({"--dials", "dials.toml", "--set", "render.texel=0.7"});
    EXPECT_EQ(set[0]["plan"]["render"]["texel"], 0.7);
}

TEST_F(DialsFile, OfAnotherKindIsRefused) {
    expectFailure({"render", "shot.toml", "--dials", "none.toml", "-o", "x.exr"}, 3,
                  "none.toml: cannot be read: No such file or directory");
    write("other.toml", "[camera]\nfov = 3\n");
    expectFailure({"render", "shot.toml", "--dials", "other.toml", "-o", "x.exr"}, 3,
                  "other.toml: expected one table, [render], as scrim plan --write-dials writes it");
    const auto told = [&](const std::string& text, const std::string& part) {
        write("dials.toml", text);
        const ProgramResult result = run({"render", "shot.toml", "--dials", "dials.toml", "-o", "x.exr"});
        EXPECT_EQ(result.status, 3);
        EXPECT_TRUE(contains(result.err, part)) << result.err;
        EXPECT_FALSE(exists("x.exr"));
    };
    told("[render]\ntexel = \n", "dials.toml:2:9: malformed TOML");
    told("[render]\ntexels = 1\n", "'texels' is not known");
}

}  // namespace
}  // namespace scrim::test
