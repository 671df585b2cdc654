// SPDX-License-Identifier: Apache-2.0
// Volumes that are put together from grids of several files: pictures, sequences, and files that are missing.
#include "support/program_test.h"

#include <scrim/image/exr_read.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace scrim::test {
namespace {

class Grids : public ProgramTest {
  protected:
    void SetUp() override {
        ProgramTest::SetUp();
        const auto ball = [](const std::string& name, double value) {
            return std::vector<MadeGrid>{{.name = name, .voxels = box({-6, -6, -6}, {6, 6, 6}, value)}};
        };
        makeVdb(file("whole.vdb"), {ball("density", 0.2)[0], ball("temperature", 1500)[0]});
        makeVdb(file("heat.vdb"), ball("temperature", 1500));
        for (const char* const frame : {"0001", "0002"}) {
            makeVdb(file(std::string("d.") + frame + ".vdb"), ball("density", 0.2));
            makeVdb(file(std::string("t.") + frame + ".vdb"), ball("temperature", frame[3] == '1' ? 1200 : 1500));
        }
    }
    void scene(const std::string& keys) const {
        write("scene.toml", kCamera + "[[volume]]\n" + keys + "\n[volume.medium]\n" +
                                "blackbody = { grid = 'temperature', intensity = 50, normalize = false }\n" + kLight);
    }
    std::vector<float> picture(const std::string& keys, const std::vector<std::string>& more = {}) const {
        scene(keys);
        std::vector<std::string> arguments{"render",           "scene.toml", "-o",
                                           "out.exr",          "-q",         "--set",
                                           "render.texel=0.2", "--set",      "render.sheet_thickness=0.4"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        runWell(arguments);
        return readExr(file("out.exr")).rgba;
    }
};

TEST_F(Grids, PictureIsThatOfOneFileWithAllOfThem) {
    const std::vector<float> whole = picture("file = 'whole.vdb'");
    EXPECT_EQ(picture("grids = { density = 'smoke.vdb', temperature = 'heat.vdb' }"), whole);
    EXPECT_EQ(picture("grids = { density = 'smoke.vdb:density', temperature = 'whole.vdb:temperature' }"), whole);
    EXPECT_EQ(picture("grids = { density = { add = ['smoke.vdb', 'whole.vdb'] }, temperature = 'heat.vdb' }\n"
                      "density = { scale = 0.5 }"),
              whole);
    EXPECT_EQ(picture("grids = { density = { max = ['smoke.vdb', 'heat.vdb'] }, temperature = 'heat.vdb' }\n"
                      "density = { scale = 1e-4 }",
                      {"--set", "volume.volume1.grids.density=smoke.vdb", "--set", "volume.volume1.density.scale=1"}),
              whole);
    EXPECT_NE(
        picture("grids = { density = 'smoke.vdb', temperature = { multiply = ['heat.vdb', 'smoke.vdb:density'] } }"),
        whole);
}

TEST_F(Grids, SequencesGoOnTogetherAndHoldEachAtItsEnd) {
    const std::string keys = "grids = { density = 'd.####.vdb', temperature = 't.####.vdb' }\n";
    const std::vector<float> second = picture("file = 'whole.vdb'");
    EXPECT_EQ(picture(keys, {"--frames", "2"}), second);
    EXPECT_NE(picture(keys, {"--frames", "1"}), second);
    EXPECT_EQ(picture("grids = { density = 'smoke.vdb', temperature = 't.####.vdb' }", {"--frames", "2"}), second);
    EXPECT_EQ(picture(keys + "frame = { outside = 'hold' }", {"--frames", "9"}), second);
    for (const float v : picture(keys + "frame = { outside = 'black' }", {"--frames", "9"})) ASSERT_EQ(v, 0);
    scene(keys);
    expectFailure(
        {"render", "scene.toml", "-o", "out.exr", "--frames", "3"}, 3,
        "scene.toml:7:9: volume 'volume1': there is no file 'd.0003.vdb' for frame 3; the sequence has frames "
        "1 to 2");
    expectFailure({"render", "scene.toml", "-o", "out.exr"}, 2,
                  "scene.toml: 'd.####.vdb' is a sequence; give the frames with --frames (files exist for 1 to 2)");
}

TEST_F(Grids, EveryMistakeHasAPlaceInTheScene) {
    scene("grids = { density = 'smoke.vdb', temperature = 'none.vdb' }");
    expectFailure({"render", "scene.toml", "-o", "out.exr"}, 3,
                  "scene.toml:7:9: volume 'volume1': there is no file 'none.vdb'");
    scene("grids = { density = 'smoke.vdb', temperature = 'smoke.vdb:heat' }");
    expectFailure({"render", "scene.toml", "-o", "out.exr"}, 3,
                  "scene.toml:7:48: smoke.vdb: no grid 'heat'; it holds 'density' (float)");
    // The file has that grid, and the scene gives it another name.
    scene("grids = { density = 'smoke.vdb', other = 'whole.vdb:temperature' }");
    EXPECT_NE(run({"render", "scene.toml", "-o", "out.exr"})
                  .err.find("smoke.vdb, whole.vdb: no grid 'temperature' among those of 'grids': 'density', 'other'; "
                            "smoke.vdb holds 'density' (float); whole.vdb holds 'density' (float), 'temperature' "
                            "(float)"),
              std::string::npos);
    write("broken.vdb", "this is no volume");
    scene("grids = { density = 'smoke.vdb', temperature = 'broken.vdb' }");
    const ProgramResult broken = run({"render", "scene.toml", "-o", "out.exr"});
    EXPECT_EQ(broken.status, 3);
    EXPECT_NE(broken.err.find("broken.vdb: not a VDB file"), std::string::npos) << broken.err;
}

TEST_F(Grids, APlanSaysWhereEachGridIsFrom) {
    scene("grids = { density = { add = ['smoke.vdb', 'whole.vdb'] }, temperature = 'heat.vdb' }");
    const auto plan = nlohmann::json::parse(runWell({"plan", "scene.toml", "--json"}).out);
    const auto& messages = plan[0]["messages"];
    ASSERT_EQ(messages.size(), 1u) << messages;
    EXPECT_EQ(messages[0], "scene.toml:7:30: grid 'density' is the sum of smoke.vdb: 'density', whole.vdb: 'density'");
}

class GridTypes : public ProgramTest {
  protected:
    /// The pixels of a scene of volumes of `file` (in the working folder), with these keys each.
    std::vector<float> picture(const std::string& name, const std::vector<std::string>& volumes) const {
        std::string text = kCamera;
        for (const std::string& keys : volumes) text += "[[volume]]\nfile = \"" + name + "\"\n" + keys + "\n";
        write("scene.toml", text + kLight);
        runWell({"render", "scene.toml", "-o", "out.exr", "-q", "--set", "render.texel=0.2", "--set",
                 "render.sheet_thickness=0.4", "--set", "output.type=float"});
        return readExr(file("out.exr")).rgba;
    }
    static void expectNear(const std::vector<float>& a, const std::vector<float>& b, double part) {
        ASSERT_EQ(a.size(), b.size());
        for (std::size_t i = 0; i < a.size(); ++i)
            if (i % 4 != 3) {  // alpha has no colours
                EXPECT_NEAR(a[i], b[i], part * std::abs(b[i]) + 1e-5) << i;
            }
    }
    static std::vector<MadeColour> colours(const Vec3& value) {
        std::vector<MadeColour> out;
        for (const MadeVoxel& v : box({-6, -6, -6}, {6, 6, 6}, 1)) out.push_back({v.at, value});
        return out;
    }
};

TEST_F(GridTypes, EmissionTakesTheColoursOfAGrid) {
    makeVdb(file("a.vdb"), {{.name = "Le", .type = "vec3s", .colours = colours({1, 2, 4})},
                            {.name = "heat", .voxels = box({-6, -6, -6}, {6, 6, 6}, 1)}});
    const std::string off = "density = { grid = 'Le.x', scale = 0 }\n[volume.medium]\n";
    const std::vector<float> of = picture("a.vdb", {off + "emission = { grid = 'Le', colors = true, scale = 0.1 }"});
    EXPECT_EQ(of,
              picture("a.vdb", {off + "emission = { grid = 'heat', ramp = [[0, [0, 0, 0]], [1, [1, 2, 4]]], scale = "
                                      "0.1 }"}));
    EXPECT_GT(*std::max_element(of.begin(), of.end()), 1);
}

TEST_F(GridTypes, ExtinctionOfColoursIsThatOfAVolumeForEachChannel) {
    makeVdb(file("a.vdb"), {{.name = "sigma", .type = "vec3s", .colours = colours({0.2, 0.1, 0.05})},
                            {.name = "density", .voxels = box({-6, -6, -6}, {6, 6, 6}, 0.2)}});
    std::vector<std::string> channels;
    for (const char* const keys :
         {"r' }\n[volume.medium]\nextinction_tint = [1, 0, 0]", "g' }\n[volume.medium]\nextinction_tint = [0, 1, 0]",
          "b' }\n[volume.medium]\nextinction_tint = [0, 0, 1]"})
        channels.push_back(std::string("density = { grid = 'sigma.") + keys);
    std::vector<float> apart = picture("a.vdb", channels);
    std::vector<float> one = picture("a.vdb", {"[volume.medium]\nextinction_tint = [1, 0.5, 0.25]"});
    expectNear(apart, one, 0.01);
}

TEST_F(GridTypes, NanoVdbFilesArePicturesOfTheirOwn) {
    const MadeGrid smoke{.voxels = box({-6, -6, -6}, {6, 6, 6}, 0.2)};
    makeNvdb(file("a.nvdb"), {smoke}, NanoCodec::blosc);
    makeVdb(file("a.vdb"), {smoke});
    EXPECT_EQ(picture("a.nvdb", {""}), picture("a.vdb", {""}));
    EXPECT_EQ(picture("a.nvdb", {"clip = [[-3, -9, -9], [3, 9, 9]]"}),
              picture("a.vdb", {"clip = [[-3, -9, -9], [3, 9, 9]]"}));
    const std::string info = runWell({"info", "a.nvdb"}).out;
    EXPECT_NE(info.find("file version     NanoVDB 32."), std::string::npos) << info;
    EXPECT_NE(info.find("blosc (NanoVDB float)"), std::string::npos) << info;
    runWell({"render", "a.nvdb", "--res", "16x16", "-q"});
    EXPECT_TRUE(exists("a.exr"));
}

}  // namespace
}  // namespace scrim::test
