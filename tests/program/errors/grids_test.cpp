// SPDX-License-Identifier: Apache-2.0
// Volumes that are put together from grids of several files: pictures, sequences, and files that are missing.
#include "support/program_test.h"

#include <scrim/image/exr_read.h>

#include <nlohmann/json.hpp>

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

}  // namespace
}  // namespace scrim::test
