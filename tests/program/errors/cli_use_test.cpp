// SPDX-License-Identifier: Apache-2.0
// The program as it is used: from files to pictures, in all the ways the command line offers.
#include "support/program_test.h"

#include <scrim/image/exr_read.h>
#include <scrim/scene/frame_path.h>
#include <scrim/scene/quality.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <random>
#include <sstream>

namespace scrim::test {
namespace {

using CliUse = ProgramTest;

std::vector<std::string> linesOf(const std::string& text) {
    std::istringstream in(text);
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
}

// ---- pictures

TEST_F(CliUse, AssetAloneGivesAPicture) {
    const ProgramResult result = runWell({"render", "smoke.vdb", "-o", "x.exr", "--res", "48x32"});
    EXPECT_EQ(result.lastErrorLine().rfind("frame 1: x.exr 48x32, ", 0), 0u) << result.err;
    const Image picture = readExr(file("x.exr"));
    // Framed: it fills most of the picture's height, and stays inside.
    EXPECT_GT(picture.window.height(), 20);
    EXPECT_TRUE((PixelWindow{0, 0, 48, 32}.contains(picture.window)));
    EXPECT_GT(*std::max_element(picture.rgba.begin(), picture.rgba.end()), 0.1f);
}

TEST_F(CliUse, OutputOfAnAssetIsNamedAfterIt) {
    runWell({"render", "smoke.vdb", "--res", "16x16"});
    EXPECT_TRUE(exists("smoke.exr"));
}

TEST_F(CliUse, PictureTellsHowItWasMade) {
    const std::string scene = kCamera + kVolume + kLight + "[output]\nfps = 23.976\n";
    write("scene.toml", scene);
    runWell({"render", "scene.toml", "-o", "x.exr", "--verify", "10"});
    const auto attributes = readExrAttributes(file("x.exr"));
    EXPECT_EQ(attributes.at("displayWindow"), "0 0 32 24");
    EXPECT_EQ(attributes.at("channels"), "A:half B:half G:half R:half");
    EXPECT_EQ(attributes.at("colorInteropID"), "lin_ap1_scene");
    EXPECT_EQ(attributes.at("chromaticities"), "0.713 0.293 0.165 0.83 0.128 0.044 0.32168 0.33767");
    EXPECT_EQ(attributes.at("software").rfind("scrim ", 0), 0u);
    EXPECT_EQ(attributes.at("software"), "scrim " + attributes.at("scrim:version"));
    EXPECT_EQ(attributes.at("framesPerSecond"), "24000/1001");
    EXPECT_EQ(attributes.at("scrim:ocio:config"), "scrim-aces");
    EXPECT_EQ(attributes.at("scrim:scene"), scene);
    EXPECT_TRUE(attributes.contains("worldToCamera") && attributes.contains("worldToNDC"));
    EXPECT_TRUE(attributes.contains("scrim:verify:error"));
    EXPECT_EQ(nlohmann::json::parse(attributes.at("scrim:plan")).at("groups").size(), 1u);
    EXPECT_GT(nlohmann::json::parse(attributes.at("scrim:stats")).at("voxels_fed").get<int>(), 0);
}

TEST_F(CliUse, SameSceneGivesTheSameBytes) {
    runWell({"render", "scene.toml", "-o", "a.exr"});
    runWell({"render", "scene.toml", "-o", "b.exr"});
    EXPECT_TRUE(readBytes(file("a.exr")) == readBytes(file("b.exr")));
}

TEST_F(CliUse, Aces2065GivesAnAcesContainer) {
    runWell({"render", "scene.toml", "-o", "x.exr", "--set", "output.colorspace=ACES2065-1"});
    EXPECT_EQ(readExrAttributes(file("x.exr")).at("acesImageContainerFlag"), "1");
}

TEST_F(CliUse, PrimariesAreWrittenUnlessTheyAreNotWanted) {
    const auto attributesWith = [&](const std::vector<std::string>& set) {
        std::vector<std::string> arguments{"render", "scene.toml", "-o", "x.exr", "-q"};
        for (const std::string& value : set) arguments.insert(arguments.end(), {"--set", value});
        runWell(arguments);
        return readExrAttributes(file("x.exr"));
    };
    EXPECT_EQ(attributesWith({"output.colorspace=lin_rec709"}).at("chromaticities"),
              "0.64 0.33 0.3 0.6 0.15 0.06 0.3127 0.329");
    const auto without = attributesWith({"output.chromaticities=false"});
    EXPECT_EQ(without.count("chromaticities"), 0u);
    EXPECT_EQ(without.at("colorInteropID"), "lin_ap1_scene");
    EXPECT_EQ(attributesWith({"output.chromaticities=false", "output.colorspace=ACES2065-1"}).at("chromaticities"),
              "0.7347 0.2653 0 1 0.0001 -0.077 0.32168 0.33767");
    EXPECT_EQ(attributesWith({"output.colorspace=CIE-XYZ-D65"}).count("chromaticities"), 0u);
}

TEST_F(CliUse, ColoursThatAreEncodedForADisplayAreNotWrittenWithoutAWord) {
    write("scene.toml", kCamera + kVolume + kLight + "[output]\ncolorspace = \"sRGB\"\n");
    const ProgramResult result = runWell({"render", "scene.toml", "-o", "x.exr", "-q"});
    EXPECT_EQ(result.err,
              "scrim: warning: scene.toml:13:14: colorspace is 'sRGB', which is not linear: programs expect linear "
              "colours in EXR, and premultiplied ones that are encoded cannot be composited; expected a linear space, "
              "such as 'ACEScg', and 'preview' for a picture to look at\n");
    EXPECT_EQ(readExrAttributes(file("x.exr")).count("chromaticities"), 0u);
}

TEST_F(CliUse, PreviewIsWritten) {
    runWell({"render", "scene.toml", "--preview", "x.png"});
    EXPECT_EQ(readBytes(file("x.png")).substr(1, 3), "PNG");
}

// Tiles of a picture that were rendered on several machines must fit together.
TEST_F(CliUse, CropRendersThePixelsOfTheWholePicture) {
    runWell({"render", "scene.toml", "-o", "all.exr", "--set", "output.type=float"});
    runWell({"render", "scene.toml", "-o", "part.exr", "--set", "output.type=float", "--crop", "10,8,20,16"});
    const Image part = readExr(file("part.exr"));
    ASSERT_EQ(part.window, (PixelWindow{10, 8, 20, 16}));
    const Image same = reframed(readExr(file("all.exr")), part.window);
    for (std::size_t i = 0; i < part.rgba.size(); ++i) EXPECT_NEAR(part.rgba[i], same.rgba[i], 1e-5 * same.rgba[i]);
}

TEST_F(CliUse, PrintedSceneRendersToTheSamePixels) {
    runWell({"render", "smoke.vdb", "-o", "a.exr", "--res", "40x30", "--quality", "draft"});
    const ProgramResult printed =
        runWell({"render", "smoke.vdb", "-o", "b.exr", "--res", "40x30", "--quality", "draft", "--print-scene"});
    EXPECT_EQ(printed.err, "scrim: smoke.vdb: y is taken as the up axis; --up z changes this\n");
    EXPECT_FALSE(exists("b.exr"));
    write("printed.toml", printed.out);
    runWell({"render", "printed.toml"});  // b.exr is in it
    const Image a = readExr(file("a.exr")), b = readExr(file("b.exr"));
    EXPECT_EQ(a.window, b.window);
    EXPECT_EQ(a.rgba, b.rgba);
}

TEST_F(CliUse, OutputIsRelativeToTheCurrentFolderAndVolumesToTheScene) {
    std::filesystem::create_directory(file("shot"));
    std::filesystem::copy_file(file("smoke.vdb"), file("shot/smoke.vdb"));
    write("shot/s.toml", kCamera + kVolume + kLight);
    std::filesystem::remove(file("smoke.vdb"));
    runWell({"render", "shot/s.toml", "-o", "x.exr"});
    EXPECT_TRUE(exists("x.exr"));
}

TEST_F(CliUse, KeyedCameraMovesOverTheFrames) {
    write("move.toml",
          "[camera]\nposition = { keys = [[1, [0, 0, 40]], [3, [40, 0, 1]]] }\ntarget = [0, 0, 0]\n"
          "resolution = [24, 24]\n" +
              kVolume + kLight + "[output]\nfile = \"m.####.exr\"\n");
    runWell({"render", "move.toml", "--frames", "1-3"});
    const Image first = readExr(file("m.0001.exr")), second = readExr(file("m.0002.exr")),
                third = readExr(file("m.0003.exr"));
    EXPECT_NE(first.rgba, second.rgba);
    EXPECT_NE(second.rgba, third.rgba);
}

// Signs that stand for the frame elsewhere.
TEST_F(CliUse, FilesMayHaveAnyName) {
    for (const std::string name : {"take#2", "p%04d", "q$F4", "caf\xe9", "caf\xc3\xa9"}) {
        std::filesystem::copy_file(file("smoke.vdb"), file(name + ".vdb"));
        runWell({"render", name + ".vdb", "--stats", name + ".json"});
        EXPECT_GT(readExr(file(name + ".exr")).rgba.size(), 4u) << name;
        EXPECT_TRUE(nlohmann::json::accept(readBytes(file(name + ".json")))) << name;
    }
    write("shot#1.toml", kCamera + "[[volume]]\nfile = \"take#2.vdb\"\n" + kLight);
    runWell({"render", "shot#1.toml"});
    EXPECT_TRUE(exists("shot#1.exr"));
    write("caf\xe9.toml", kCamera + kVolume + kLight);
    runWell({"render", "caf\xe9.toml", "--preview", "\xe9.png"});
    EXPECT_TRUE(exists("caf\xe9.exr") && exists("\xe9.png"));
    runWell({"render", "take#2.vdb", "-o", "o.#.exr", "--frames", "1-2"});
    EXPECT_TRUE(exists("o.1.exr") && exists("o.2.exr"));
}

TEST_F(CliUse, SourceOfASceneIsRendered) {
    write("source.toml",
          kCamera + "[[volume]]\nsource = \"noise\"\nparameters = { resolution = 16, size = 10 }\n" + kLight);
    runWell({"render", "source.toml"});
    EXPECT_GT(readExr(file("source.exr")).rgba.size(), 4u);
}

TEST_F(CliUse, SequenceIsFramedAlikeWhicheverFramesAreRendered) {
    for (const char* name : {"s.1.vdb", "s.2.vdb", "s.3.vdb"})
        std::filesystem::copy_file(file("smoke.vdb"), file(name));
    makeVdb(file("s.1.vdb"), {{.voxels = box({0, 0, 0}, {1, 1, 1}, 0.2)}});
    const auto printed = [&](const std::string& frames) {
        return runWell({"render", "s.#.vdb", "--frames", frames, "--print-scene"}).out;
    };
    EXPECT_EQ(printed("1"), printed("2-3"));
}

// ---- what is told

TEST_F(CliUse, StatsTellEachFrame) {
    runWell({"render", "scene.toml", "-o", "o.#.exr", "--frames", "1-2", "--stats", "s.json", "--verify", "5"});
    const auto stats = nlohmann::json::parse(readBytes(file("s.json")));
    ASSERT_EQ(stats.size(), 2u);
    EXPECT_EQ(stats[1].at("file"), "o.2.exr");
    for (const char* stage : {"load", "plan", "render", "verify", "write", "total"})
        EXPECT_GE(stats[1].at("seconds").at(stage).get<double>(), 0) << stage;
    EXPECT_GT(stats[0].at("work").at("footprints").get<double>(), 0);
    EXPECT_GT(stats[0].at("peak_memory_bytes").get<double>(), 1e6);
    EXPECT_GE(stats[0].at("threads").get<int>(), 1);
    // A pixel that is all but transparent does not count.
    EXPECT_GE(stats[0].at("verification").at("pixels").get<int>(), 3);
    EXPECT_LE(stats[0].at("verification").at("pixels").get<int>(), 5);
    EXPECT_TRUE(stats[0].at("plan").contains("groups"));
}

TEST_F(CliUse, StatsSumUpAFrameInTheWordsOfItsLine) {
    const auto run = runWell({"render", "scene.toml", "-o", "o.exr", "--stats", "s.json", "--verify", "5"});
    const auto stats = nlohmann::json::parse(readBytes(file("s.json")));
    const std::string summary = stats.at(0).at("summary");
    EXPECT_NE(summary.find(" s (load "), std::string::npos) << summary;
    EXPECT_NE(summary.find("; error "), std::string::npos) << summary;
    EXPECT_NE(run.err.find("frame 1: o.exr 32x24, " + summary + "\n"), std::string::npos) << run.err;
}

TEST_F(CliUse, ProgressAlf) {
    const auto lines = linesOf(runWell({"render", "scene.toml", "--progress", "alf"}).out);
    ASSERT_GE(lines.size(), 2u);
    EXPECT_EQ(lines.front(), "ALF_PROGRESS 0%");
    EXPECT_EQ(lines.back(), "ALF_PROGRESS 100%");
    EXPECT_EQ(std::count(lines.begin(), lines.end(), "ALF_PROGRESS 100%"), 1);
}

TEST_F(CliUse, ProgressOpenJd) {
    const auto lines =
        linesOf(runWell({"render", "scene.toml", "-o", "o.#.exr", "--frames", "5-6", "--progress", "openjd"}).out);
    ASSERT_GE(lines.size(), 4u);
    EXPECT_EQ(lines[0], "openjd_status: frame 5 (1 of 2)");
    EXPECT_EQ(lines[1], "openjd_progress: 0.0");
    EXPECT_EQ(std::count(lines.begin(), lines.end(), "openjd_status: frame 6 (2 of 2)"), 1);
    EXPECT_EQ(lines.back(), "openjd_progress: 100.0");
}

TEST_F(CliUse, ProgressJson) {
    double last = -1;
    for (const std::string& line : linesOf(runWell({"render", "scene.toml", "--progress", "json"}).out)) {
        const double percent = nlohmann::json::parse(line).at("progress").get<double>();
        EXPECT_GT(percent, last);
        last = percent;
    }
    EXPECT_EQ(last, 100);
}

TEST_F(CliUse, ProgressPlainGoesToStderr) {
    const ProgramResult result = runWell({"render", "scene.toml", "--progress", "plain"});
    EXPECT_EQ(result.out, "");
    EXPECT_NE(result.err.find("100%  frame 1 (1 of 1)  0:0"), std::string::npos) << result.err;
}

TEST_F(CliUse, QuietSaysNothing) {
    const ProgramResult result = runWell({"render", "scene.toml", "-q"});
    EXPECT_EQ(result.out + result.err, "");
}

TEST_F(CliUse, PlanIsJsonOrATable) {
    const auto json = nlohmann::json::parse(runWell({"plan", "scene.toml", "--json"}).out);
    const auto& group = json.at(0).at("plan").at("groups").at(0);
    EXPECT_TRUE(group.at("primary").get<bool>());
    EXPECT_EQ(group.at("lights").at(0).at("name"), "key");
    EXPECT_GT(group.at("sheets").get<int>(), 0);
    const std::string table = runWell({"plan", "scene.toml"}).out;
    for (const char* word : {"shadows", "of 'key'", "group 1", "slant", "sheets", "raster", "batch", "memory"})
        EXPECT_NE(table.find(word), std::string::npos) << word << "\n" << table;
    EXPECT_FALSE(exists("scene.exr"));
}

TEST_F(CliUse, PlanSaysWhatARenderTakesAndWrites) {
    std::filesystem::create_directory(file("a##b$"));
    write("a##b$/moves.toml", "[variables]\nSHOT = \"s##\"\n" + kCamera + "[[volume]]\nfile = \"../smoke.vdb\"\n" +
                                  kLight + "[output]\nfile = \"${SHOT}.$$.exr\"\ndeep = \"/deep.%02d.exr\"\n");
    const auto planned = [&](const std::string& key) {
        const auto json =
            nlohmann::json::parse(runWell({"plan", "a##b$/moves.toml", "--frames", "7", "--json", "--quality", "draft",
                                           "--crop", "3,2,20,22", "--set", "render.antialias=3", "--set", key})
                                      .out);
        return json.at(0);
    };
    const auto still = planned("render.lod=0"), moves = planned("camera.fov={keys=[[1, 35], [9, 36]]}");
    const auto& render = still.at("plan").at("render");
    EXPECT_EQ(render.size(), dialTable().size());
    EXPECT_EQ(render.at("antialias"), 3);
    EXPECT_EQ(render.at("kernel"), "linear");
    EXPECT_GT(render.at("texel").get<double>(), 0);
    EXPECT_EQ(render.at("cross_fade"), 0);
    EXPECT_EQ(moves.at("plan").at("render").at("cross_fade"), "always");
    EXPECT_EQ(still.at("plan").at("window"), nlohmann::json::array({3, 2, 20, 22}));
    const std::string folder = std::filesystem::canonical(file("a##b$")).string(), deep = "/deep.%02d.exr";
    const nlohmann::json outputs = {
        {"file", {{"pattern", patternOf(folder) + "/s##.$$.exr"}, {"path", "a##b$/s07.$.exr"}}},
        {"deep", {{"pattern", deep}, {"path", "/deep.07.exr"}}}};
    EXPECT_EQ(still.at("outputs"), outputs);
    // Of the command line, relative to the current folder.
    const auto given = nlohmann::json::parse(
        runWell({"plan", "a##b$/moves.toml", "--json", "--frames", "-2", "-o", "x.####.exr", "--preview", "y.png"})
            .out);
    EXPECT_EQ(given.at(0).at("outputs").at("file").at("path"), "x.-002.exr");
    EXPECT_EQ(given.at(0).at("outputs").at("preview").at("path"), "y.png");
    ProgramOptions there;
    there.shell = "cd 'a##b$'; exec \"$0\" \"$@\"";
    const std::string printed = runWell({"render", "../scene.toml", "-o", "x.####.exr", "--print-scene"}, there).out;
    EXPECT_NE(printed.find("file = \"" + patternOf(folder) + "/x.####.exr\""), std::string::npos) << printed;
}

TEST_F(CliUse, InfoIsJsonOrATable) {
    const auto json = nlohmann::json::parse(runWell({"info", "smoke.vdb", "--json"}).out);
    EXPECT_EQ(json.at("grids").at(0).at("active_voxels").get<int>(), 13 * 13 * 13);
    const auto both = nlohmann::json::parse(runWell({"info", "smoke.vdb", "smoke.vdb", "--json"}).out);
    EXPECT_EQ(both.size(), 2u);
    const std::string table = runWell({"info", "smoke.vdb"}).out;
    for (const char* text : {"grid 'density'", "fog volume", "2197, and 0 tiles", "[-6, -6, -6] to [6, 6, 6]"})
        EXPECT_NE(table.find(text), std::string::npos) << text << "\n" << table;
}

TEST_F(CliUse, InfoCountsVoxelsAsFarAsTheyReach) {
    makeVdb(file("far.vdb"), {{.voxels = {{{-2147483640, -20, 0}, 0.5}, {{2147483640, 2147483640, 0}, 0.5}}}});
    EXPECT_NE(runWell({"info", "far.vdb"}).out.find("(4294967281 x 2147483661 x 1)"), std::string::npos)
        << runWell({"info", "far.vdb"}).out;
}

TEST_F(CliUse, InfoTellsColoursFromWhatCannotBeUsed) {
    makeVdb(file("c.vdb"),
            {{.name = "Cd", .type = "vec3half", .voxels = {{{0, 0, 0}, 1}}}, {.name = "i", .type = "vec3i"}});
    const auto json = nlohmann::json::parse(runWell({"info", "c.vdb", "--json"}).out);
    EXPECT_EQ(json.at("grids").at(0).at("colour"), true);
    EXPECT_EQ(json.at("grids").at(0).at("usable"), false);
    EXPECT_EQ(json.at("grids").at(1).at("colour"), false);
    const std::string table = runWell({"info", "c.vdb"}).out;
    const std::size_t second = table.find("grid 'i'");
    EXPECT_LT(table.find("usable         as a colour"), second) << table;
    EXPECT_NE(table.find("usable         no: neither numbers nor vectors of them", second), std::string::npos) << table;
}

TEST_F(CliUse, MakeWritesAnAssetAndExplainsSources) {
    runWell({"make", "noise", "resolution=16", "-o", "n.vdb"});
    runWell({"info", "n.vdb"});
    EXPECT_NE(runWell({"make", "--list"}).out.find("resolution=128"), std::string::npos);
    EXPECT_NE(runWell({"make", "noise", "--help-source"}).out.find("resolution=128"), std::string::npos);
}

TEST_F(CliUse, VersionNamesTheLibraries) {
    const std::string text = runWell({"--version"}).out;
    for (const char* name :
         {"scrim ", "OpenVDB ", "OpenEXR ", "OpenColorIO ", "OpenImageIO ", "TBB ", "Highway ", "zip"})
        EXPECT_NE(text.find(name), std::string::npos) << name << "\n" << text;
}

TEST_F(CliUse, HelpIsPrintedToStdout) {
    EXPECT_NE(runWell({"--help"}).out.find("render"), std::string::npos);
    const ProgramResult bare = run({});
    EXPECT_EQ(bare.status, 2);
    EXPECT_NE(bare.out.find("render"), std::string::npos);
}

// ---- what goes wrong from outside

TEST_F(CliUse, SigtermEndsARenderWithoutAPartialFile) {
    runWell({"make", "noise", "resolution=160", "-o", "large.vdb"});
    const std::set<std::string> before = listing();
    RunningProgram program(m_folder.path(), {"render", "large.vdb", "-o", "x.exr", "--res", "3000x3000", "--quality",
                                             "ultra", "--progress", "json"});
    ASSERT_TRUE(program.waitForOutput("\"progress\":1.0"));
    program.sendSignal(SIGTERM);
    const ProgramResult result = program.wait();
    EXPECT_EQ(result.status, 143) << result.err;
    EXPECT_EQ(result.lastErrorLine().rfind("scrim: error: ", 0), 0u) << result.err;
    EXPECT_NE(result.lastErrorLine().find("interrupted"), std::string::npos) << result.err;
    EXPECT_EQ(listing(), before);
}

TEST_F(CliUse, DamagedFilesAreRefusedOrRenderedAndNothingElse) {
    runWell({"make", "noise", "resolution=24", "-o", "good.vdb"});
    const std::string good = readBytes(file("good.vdb"));
    std::mt19937 random(7);
#ifdef SCRIM_ADDRESS_SANITIZED
    constexpr int kFlips = 30;  // a process takes several times as long
#else
    constexpr int kFlips = 200;
#endif
    int refused = 0;
    for (int i = 0; i < kFlips; ++i) {
        std::string bad = good;
        const std::size_t place = random() % bad.size();
        bad[place] = static_cast<char>(bad[place] ^ static_cast<char>(1 + random() % 255));
        write("bad.vdb", bad);
        const ProgramResult result =
            run({"render", "bad.vdb", "-o", "bad.exr", "--res", "16x16", "--quality", "draft", "-q"});
        EXPECT_TRUE(result.status == 0 || result.status == 3)
            << "byte " << place << ": status " << result.status << ", signal " << result.signal << "\n"
            << result.err;
        refused += result.status == 3;
        if (result.status == 3) {
            EXPECT_EQ(result.lastErrorLine().rfind("scrim: error: bad.vdb: ", 0), 0u)
                << "byte " << place << ": " << result.err;
        }
    }
    EXPECT_GT(refused, 0);
}

}  // namespace
}  // namespace scrim::test
