// SPDX-License-Identifier: Apache-2.0
// scrim study, and renders with a tolerance, from the command line.
#include "support/program_test.h"

#include <scrim/image/exr_read.h>

#include <nlohmann/json.hpp>

#include <map>

namespace scrim::test {
namespace {

using StudyCommand = ProgramTest;
using ToleranceOption = ProgramTest;

TEST_F(StudyCommand, WritesATableDataAndAPage) {
    const ProgramResult result =
        runWell({"study", "scene.toml", "-o", "out/deep", "--budget", "2", "--progress", "none"});
    EXPECT_NE(result.out.find("error below"), std::string::npos) << result.out;
    const auto json = nlohmann::json::parse(readBytes(file("out/deep/study.json")));
    EXPECT_EQ(json.at("scene"), "scene.toml");
    EXPECT_EQ(json.at("recommendations").size(), 5u);
    EXPECT_EQ(readBytes(file("out/deep/study.csv")).rfind("setting,", 0), 0u);
    EXPECT_EQ(readBytes(file("out/deep/index.html")).rfind("<!doctype html>", 0), 0u);
}

TEST_F(StudyCommand, RefusesWhatItCannotStudy) {
    expectFailure({"study", "scene.toml"}, 2, "study: expected -o DIR, the folder for the results");
    expectFailure({"study", "scene.toml", "smoke.vdb", "-o", "out"}, 2, "study: expected one scene or asset");
    expectFailure({"study", "scene.toml", "-o", "out", "--frames", "1-2"}, 2,
                  "study: expected one frame; give it with --frames");
    expectFailure({"study", "scene.toml", "-o", "out", "--budget", "0"}, 2,
                  "--budget 0: expected seconds, more than 0");
    expectFailure({"study", "scene.toml", "-o", "smoke.vdb"}, 4, "cannot make the folder 'smoke.vdb': Not a directory");
    expectFailure({"study", "scene.toml", "-o", "out", "--set", "camera.target=[0, 0, 90]"}, 1,
                  "there is nothing to study: the picture is empty");
}

// The sun turns by one and a half degrees a frame.
const std::string kTurningSun =
    "[[light]]\nname = \"key\"\ntype = \"distant\"\n"
    "direction = { keys = [[1, [-1, -1, -1]], [9, [-1, -1, -0.7]]] }\n";

TEST_F(StudyCommand, FindsAShotSteady) {
    write("moving.toml", kCamera + kVolume + kTurningSun + "[output]\nlayers = [\"light\", \"depth\"]\n");
    const ProgramResult result =
        runWell({"study", "moving.toml", "--steady", "--frames", "2-6", "-o", "out", "--progress", "none"});
    EXPECT_TRUE(contains(result.out, "frames 2 to 6, 32 x 24 pixels")) << result.out;
    EXPECT_TRUE(contains(result.out, "'standard' promises at most 1 % more")) << result.out;
    const auto json = nlohmann::json::parse(readBytes(file("out/steady.json")));
    EXPECT_TRUE(json.at("kept"));
    ASSERT_EQ(json.at("layers").size(), 2u);  // a depth is no colour
    EXPECT_EQ(json.at("layers").at(1).at("layer"), "light.key");
    for (const auto& layer : json.at("layers")) {
        EXPECT_LT(layer.at("excess"), 0.01);
        EXPECT_GT(layer.at("excess"), 0);
        EXPECT_GT(layer.at("shown"), 0);
        EXPECT_EQ(layer.at("frames").size(), 3u);
        EXPECT_GT(layer.at("pixels"), 3 * 100);
    }
    EXPECT_TRUE(contains(json.at("render"), "quality = \"standard\"")) << json.at("render");
    EXPECT_EQ(readBytes(file("out/steady.csv")).rfind("layer,frame,shown,converged,excess,error\n\"beauty\",,", 0), 0u);
}

// Four more motions that shots have, with a ramp of densities in place of the box's edges.
TEST_F(StudyCommand, FindsMotionsSteady) {
    const std::string lamp = "[[light]]\nname = \"lamp\"\ntype = \"point\"\nintensity = 500\nposition = ";
    const auto keys = [](const std::string& from, const std::string& to) {
        return "{ keys = [[1, " + from + "], [9, " + to + "]] }\n";
    };
    const std::string still = lamp + "[14, 10, 12]\n";
    const std::string noise =
        "[[volume]]\nname = \"smoke\"\nsource = \"noise\"\nparameters = { resolution = 24 }\n"
        "density = { scale = 2.0 }\ntransform = { scale = ";
    const std::string camera = "[camera]\nfov = 35\nresolution = [32, 24]\n", middle = "target = [0, 0, 0]\n";
    const std::string stands = "position = [0, 0, 40]\n", size = "[8, 8, 8] }\n";
    const std::map<std::string, std::string> motions = {
        {"orbit", camera + middle + "position = " + keys("[0, 0, 40]", "[4, 0, 39.8]") + noise + size + still},
        {"pan", camera + "position = " + keys("[0, 0, 40]", "[0.5, 0, 40]") +
                    "target = " + keys("[0, 0, 0]", "[0.5, 0, 0]") + noise + size + still},
        {"lamp", camera + middle + stands + noise + size + lamp + keys("[14, 10, 12]", "[12, 10, 12]")},
        {"swelling",
         camera + middle + stands + noise + "{ keys = [[1, [8, 8, 8]], [9, [8.4, 8.4, 8.4]]] } }\n" + still},
    };
    for (const auto& [name, text] : motions) {
        write(name + ".toml", text);
        runWell({"study", name + ".toml", "--steady", "--frames", "1-4", "--progress", "none", "-o", name});
        const auto beauty = nlohmann::json::parse(readBytes(file(name + "/steady.json"))).at("layers").at(0);
        EXPECT_LT(beauty.at("excess"), 0.01) << name;
        EXPECT_GT(beauty.at("excess"), 1e-6) << name;
        EXPECT_LT(beauty.at("error"), 0.01) << name;
        EXPECT_GT(beauty.at("pixels"), 2 * 50) << name;
    }
}

// Texels of six voxels jump from one pattern to another as they turn with the sun.
TEST_F(StudyCommand, FindsAShotThatFlickers) {
    write("moving.toml", kCamera + kVolume + kTurningSun + "[render]\ntexel = 6\nsheet_thickness = 6\n");
    const ProgramResult result =
        run({"study", "moving.toml", "--steady", "--frames", "1-5", "--progress", "none", "-o", "out"});
    EXPECT_EQ(result.status, 5) << result.err;
    EXPECT_EQ(result.lastErrorLine().rfind("scrim: error: 'beauty' flickers: its second differences exceed those of "
                                           "converged frames by ",
                                           0),
              0u)
        << result.err;
    EXPECT_TRUE(contains(result.lastErrorLine(), "'standard' promises 1 %")) << result.err;
    EXPECT_FALSE(nlohmann::json::parse(readBytes(file("out/steady.json"))).at("kept"));
}

TEST_F(StudyCommand, ShrinksOnlyPicturesWhoseSizeNobodyAsksFor) {
    write("moving.toml", kCamera + kVolume + kTurningSun);
    const auto resolution = [&](const std::vector<std::string>& more) {
        std::vector<std::string> arguments{"study", "moving.toml", "--steady", "--frames", "1-9", "--budget", "0.001"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return runWell(arguments);
    };
    const ProgramResult shrunk = resolution({"--set", "camera.resolution=[640, 320]"});
    EXPECT_TRUE(contains(shrunk.out, "frames 1 to 3, 256 x 128 pixels")) << shrunk.out;
    EXPECT_TRUE(contains(shrunk.err, "--budget ended the study after 3 of 9 frames")) << shrunk.err;
    EXPECT_TRUE(contains(resolution({"--res", "300x60"}).out, "300 x 60 pixels"));
}

TEST_F(StudyCommand, RefusesFramesThatCannotFlicker) {
    write("moving.toml", kCamera + kVolume + kTurningSun);
    const std::string three = "study --steady: expected three or more frames that follow one another: --frames 1-5";
    expectFailure({"study", "moving.toml", "--steady"}, 2, three);
    expectFailure({"study", "moving.toml", "--steady", "--frames", "1-2"}, 2, three);
    expectFailure({"study", "moving.toml", "--steady", "--frames", "1-9x2"}, 2, three);
    expectFailure({"study", "scene.toml", "--steady", "--frames", "1-3"}, 2,
                  "scene.toml: nothing in the scene is keyed, and no volume is a sequence of files, so all frames are "
                  "equal");
    expectFailure({"study", "moving.toml", "--steady", "--frames", "1-3", "--set", "render.tolerance=0.01"}, 2,
                  "moving.toml: a tolerance chooses other texels and sheets for each frame; --quality chooses them "
                  "once");
    const ProgramResult empty = run({"study", "moving.toml", "--steady", "--frames", "1-3", "--set",
                                     "camera.target=[0, 0, 90]", "-o", "out", "--progress", "none"});
    EXPECT_EQ(empty.status, 1);
    EXPECT_EQ(empty.lastErrorLine(), "scrim: error: there is nothing to study: the picture is empty");
    EXPECT_FALSE(exists("out"));
}

TEST_F(ToleranceOption, IsMetAndReported) {
    runWell({"render", "scene.toml", "--tolerance", "0.02", "--stats", "stats.json"});
    const auto frame = nlohmann::json::parse(readBytes(file("stats.json"))).at(0);
    EXPECT_EQ(frame.at("tolerance").at("wanted"), 0.02);
    EXPECT_LE(frame.at("tolerance").at("predicted").get<double>(), 0.02);
    EXPECT_TRUE(frame.at("tolerance").at("met").get<bool>());
    EXPECT_LE(frame.at("tolerance").at("bound").get<double>(), 0.02);
    EXPECT_LE(frame.at("verification").at("error"), frame.at("tolerance").at("bound"));
    EXPECT_GT(frame.at("verification").at("pixels").get<int>(), 0);
    const auto attributes = readExrAttributes(file("scene.exr"));
    EXPECT_EQ(attributes.count("scrim:tolerance:predicted"), 1u);
    EXPECT_EQ(attributes.count("scrim:verify:worst"), 1u);
}

TEST_F(ToleranceOption, ThatIsMissedIsStatusFiveAndThePictureSaysSo) {
    const ProgramResult result = run({"render", "scene.toml", "--tolerance", "0.0000001", "--stats", "stats.json"});
    EXPECT_EQ(result.status, 5) << result.err;
    const auto frame = nlohmann::json::parse(readBytes(file("stats.json"))).at(0);
    EXPECT_FALSE(frame.at("tolerance").at("met").get<bool>());
    EXPECT_EQ(result.lastErrorLine().rfind("scrim: error: frame 1: written, but its error may be ", 0), 0u)
        << result.err;
    EXPECT_EQ(readExrAttributes(file("scene.exr")).at("scrim:tolerance:met"), "0");
}

// What emits without density has no alpha: it was once taken for nothing, and nothing for a tolerance that is met.
TEST_F(ToleranceOption, OfWhatOnlyEmitsLooksAtPixels) {
    write("flame.toml",
          kCamera +
              "[[volume]]\nfile = \"smoke.vdb\"\ndensity = { scale = 0.0 }\n[volume.medium]\nemission = { "
              "grid = \"density\", ramp = [[0, [0, 0, 0]], [1, [1, 0.5, 0.1]]], scale = 2.0 }\n");
    run({"render", "flame.toml", "--tolerance", "0.02", "--stats", "stats.json"});
    const auto frame = nlohmann::json::parse(readBytes(file("stats.json"))).at(0);
    EXPECT_GT(frame.at("verification").at("pixels").get<int>(), 50);
    EXPECT_GT(frame.at("verification").at("error").get<double>(), 0);
}

using VerifyOption = ProgramTest;

TEST_F(VerifyOption, CountsThePixelsThatShowSomething) {
    for (const int count : {7, 60}) {
        runWell({"render", "scene.toml", "--verify", std::to_string(count), "--stats", "stats.json"});
        const auto v = nlohmann::json::parse(readBytes(file("stats.json"))).at(0).at("verification");
        EXPECT_EQ(v.at("pixels"), count);
        EXPECT_GE(v.at("pixels_looked_at"), count);
    }
}

TEST_F(VerifyOption, OfAllKnowsTheErrorExactly) {
    const ProgramResult result = runWell({"render", "scene.toml", "--verify", "all", "--stats", "stats.json"});
    const auto v = nlohmann::json::parse(readBytes(file("stats.json"))).at(0).at("verification");
    EXPECT_TRUE(v.at("complete").get<bool>());
    EXPECT_EQ(v.at("lower"), v.at("upper"));
    EXPECT_NE(result.err.find("pixels that are not empty"), std::string::npos) << result.err;
}

TEST_F(VerifyOption, OfAnEmptyPictureSaysThatItIsEmpty) {
    const ProgramResult result =
        runWell({"render", "scene.toml", "--verify", "50", "--set", "volume.volume1.density.scale=0"});
    EXPECT_NE(result.err.find("nothing to verify"), std::string::npos) << result.err;
}

TEST_F(VerifyOption, EndsAtItsLimit) {
    const ProgramResult result = runWell({"render", "scene.toml", "--verify", "all", "--verify-limit", "0.000001"});
    EXPECT_NE(result.err.find("--verify-limit ended the verification after"), std::string::npos) << result.err;
    expectFailure({"render", "scene.toml", "--verify-limit", "0"}, 2,
                  "--verify-limit 0: expected seconds, more than 0");
    expectFailure({"render", "scene.toml", "--verify", "some"}, 2,
                  "--verify some: expected 'all' or a whole number from 0 to 2147483646");
}

TEST_F(ToleranceOption, OfASceneGivesWayToAPresetOfTheCommandLine) {
    write("tolerant.toml", kCamera + kVolume + kLight + "[render]\ntolerance = 0.05\n");
    runWell({"render", "tolerant.toml", "--stats", "a.json"});
    EXPECT_TRUE(nlohmann::json::parse(readBytes(file("a.json"))).at(0).contains("tolerance"));
    runWell({"render", "tolerant.toml", "--quality", "draft", "--stats", "b.json"});
    EXPECT_FALSE(nlohmann::json::parse(readBytes(file("b.json"))).at(0).contains("tolerance"));
}

TEST_F(ToleranceOption, IsSaidByThePlan) {
    const ProgramResult result = runWell({"plan", "scene.toml", "--tolerance", "0.03"});
    EXPECT_NE(result.out.find("0.03: a render chooses texels and sheets for it"), std::string::npos) << result.out;
}

TEST_F(ToleranceOption, IsRefusedWhereItMakesNoSense) {
    expectFailure({"render", "scene.toml", "--tolerance", "0"}, 2,
                  "--tolerance 0: expected a relative RMSE between 0 and 1, such as 0.005");
    write("both.toml", kCamera + kVolume + kLight + "[render]\ntolerance = 0.05\ntexel = 0.5\n");
    expectFailure({"render", "both.toml"}, 3,
                  "both.toml:14:9: 'texel' cannot be combined with 'tolerance', which chooses it");
}

}  // namespace
}  // namespace scrim::test
