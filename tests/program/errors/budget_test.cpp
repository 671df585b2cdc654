// SPDX-License-Identifier: Apache-2.0
// scrim render --budget, and what is said before a picture that takes long.
#include "support/program_test.h"

#include <nlohmann/json.hpp>

namespace scrim::test {
namespace {

class Budget : public ProgramTest {
  protected:
    /// The picture whose statistics are in budget.json is that of the preset.
    void expectPictureOf(const std::string& preset) const {
        runWell({"render", "scene.toml", "--quality", preset, "--stats", "preset.json"});
        const auto dials = [&](const char* name) {
            return nlohmann::json::parse(readBytes(file(name))).at(0).at("plan").at("render");
        };
        EXPECT_EQ(dials("budget.json"), dials("preset.json"));
    }
};

TEST_F(Budget, TakesTheFinestPresetThatFits) {
    const ProgramResult result = runWell({"render", "scene.toml", "--budget", "1000", "--stats", "budget.json"});
    EXPECT_TRUE(contains(result.err, "scene.toml: quality 'ultra', about ")) << result.err;
    EXPECT_TRUE(contains(result.err, " s a frame; an error of ")) << result.err;
    EXPECT_TRUE(contains(result.err, " % is expected, and 0.1 % promised")) << result.err;
    expectPictureOf("ultra");
}

TEST_F(Budget, TakesTheCoarsestWhereNothingFitsAndSaysSo) {
    const ProgramResult result =
        runWell({"render", "scene.toml", "--budget", "0.000001", "--stats", "budget.json", "--progress", "none"});
    EXPECT_TRUE(contains(result.err, "scrim: warning: scene.toml: quality 'draft', about ")) << result.err;
    EXPECT_TRUE(contains(result.err, "no preset fits into --budget 1e-06")) << result.err;
    expectPictureOf("draft");
}

TEST_F(Budget, IsThatOfTheFirstFrameThatIsThere) {
    makeVdb(file("smoke.2.vdb"), {{.voxels = box({0, 0, 0}, {7, 7, 7}, 0.2)}});
    write("sequence.toml", kCamera + "[[volume]]\nfile = \"smoke.#.vdb\"\n" + kLight);
    const ProgramResult result = runWell(
        {"render", "sequence.toml", "--frames", "1-2", "-o", "out.#.exr", "--missing", "skip", "--budget", "1000"});
    EXPECT_TRUE(contains(result.err, "sequence.toml: quality 'ultra', about ")) << result.err;
}

TEST_F(Budget, KeepsTheDialsThatASceneStates) {
    write("own.toml", kCamera + kVolume + kLight + "[render]\ntexel = 0.9\n");
    const ProgramResult result = runWell({"render", "own.toml", "--budget", "1000", "--stats", "budget.json"});
    EXPECT_TRUE(contains(result.err, "the scene states its own texels or sheets, so nothing is promised"))
        << result.err;
    const auto frame = nlohmann::json::parse(readBytes(file("budget.json"))).at(0);
    EXPECT_EQ(frame.at("plan").at("render").at("texel"), 0.9);
}

TEST_F(Budget, IsRefusedBesideAnotherChoice) {
    const std::string beside = "--budget chooses the preset; it cannot be combined with ";
    expectFailure({"render", "scene.toml", "--budget", "1", "--quality", "high"}, 2, beside + "--quality");
    expectFailure({"render", "scene.toml", "--budget", "1", "--tolerance", "0.01"}, 2, beside + "--tolerance");
    write("dials.toml", "[render]\ntexel = 0.5\n");
    expectFailure({"render", "scene.toml", "--budget", "1", "--dials", "dials.toml"}, 2, beside + "--dials");
    expectFailure({"render", "scene.toml", "--budget", "1", "--set", "render.tolerance=0.01"}, 2,
                  "scene.toml: --budget cannot be combined with render.tolerance");
    expectFailure({"render", "scene.toml", "--budget", "0"}, 2, "--budget 0: expected seconds, more than 0");
}

using CostWarning = ProgramTest;

TEST_F(CostWarning, ComesBeforeAPictureThatTakesMuchMemory) {
    makeVdb(file("block.vdb"), {{.voxels = box({0, 0, 0}, {31, 31, 31}, 0.2)}});
    write("white.toml", kCamera + "[[volume]]\nfile = \"block.vdb\"\n[volume.medium]\nscattering = \"full\"\n" +
                            "phase = { type = \"hg\", g = 0.5 }\n" + kLight +
                            "[render]\nscatter_cell = 0.25\nscatter_directions = 256\n");
    const ProgramResult plan = runWell({"plan", "white.toml"});
    EXPECT_TRUE(contains(plan.err, "scrim: warning: frame 1: the picture is expected to take about ")) << plan.err;
    EXPECT_TRUE(contains(plan.err, " GB")) << plan.err;
    EXPECT_FALSE(contains(runWell({"plan", "scene.toml"}).err, "expected to take"));
}

}  // namespace
}  // namespace scrim::test
