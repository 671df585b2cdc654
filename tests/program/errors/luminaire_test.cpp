// SPDX-License-Identifier: Apache-2.0
// Photometric files from the command line: found, read once, and refused in so many words.
#include "support/luminaires.h"
#include "support/program_test.h"

#include <scrim/guard/load_fields.h>
#include <scrim/image/exr_read.h>

#include <nlohmann/json.hpp>

#include <filesystem>
#include <fstream>

#include <sys/stat.h>

namespace scrim::test {
namespace {

class LuminaireFiles : public ProgramTest {
  protected:
    void SetUp() override {
        ProgramTest::SetUp();
        write("scene.toml", sceneWith("lamp.ies"));
        std::filesystem::copy_file(SCRIM_SOURCE_DIR "/examples/scenes/luminaires/wall.ies", file("wall.ies"));
    }
    // The file is at 12:7.
    static std::string sceneWith(const std::string& name) {
        return kCamera + kVolume + "[[light]]\nname = \"lamp\"\ntype = \"point\"\nposition = [0, 60, 0]\nies = \"" +
               name + "\"\nintensity = 9000\n";
    }
    void refuses(const std::string& reason) const {
        expectFailure({"render", "scene.toml", "-o", "x.exr"}, 3, "scene.toml:12:7: light 'lamp': " + reason);
    }
};

TEST_F(LuminaireFiles, ThatAreBadAreErrorsWithTheirPlaceInSceneAndFile) {
    refuses("lamp.ies: there is no such file");
    write("lamp.ies", "no photometry");
    refuses("lamp.ies:1: the file ends before a line TILT=; expected a photometric file (IES LM-63)");
    std::string text = readBytes(file("wall.ies"));
    write("lamp.ies", text.substr(0, text.size() / 2));
    const ProgramResult cut = run({"render", "scene.toml", "-o", "x.exr"});
    EXPECT_EQ(cut.status, 3);
    EXPECT_TRUE(contains(cut.err, "lamp.ies:18: the file ends before candela value ")) << cut.err;
    text.replace(text.find(" 13 1 2"), 7, " 20000000 1 2");
    write("lamp.ies", text);
    refuses("lamp.ies:6: 2e+07; expected the number of horizontal angles, a whole number from 1 to 7201");
    std::filesystem::remove(file("lamp.ies"));
    ASSERT_EQ(::mkfifo(file("lamp.ies").c_str(), 0600), 0);
    refuses("lamp.ies: is not a file");
}

// What a confined process makes of the file is what this one does.
TEST_F(LuminaireFiles, AreReadAsThisProcessReadsThem) {
    LoadOptions guarded, plain;
    guarded.volumes = VolumeLoading::guarded;
    plain.volumes = VolumeLoading::plain;
    for (const std::string name : {"downlight", "batwing", "wall"}) {
        const std::string path = SCRIM_SOURCE_DIR "/examples/scenes/luminaires/" + name + ".ies";
        const FilePhotometry here = loadPhotometry(path, plain), there = loadPhotometry(path, guarded);
        EXPECT_EQ(there.vertical, here.vertical) << name;
        EXPECT_EQ(there.horizontal, here.horizontal) << name;
        EXPECT_EQ(there.candela, here.candela) << name;
        EXPECT_FALSE(here.candela.empty()) << name;
    }
}

TEST_F(LuminaireFiles, TurnWithTheirLightFromFrameToFrameAndAreNamedInThePlan) {
    write("scene.toml",
          sceneWith("wall.ies") +
              "direction = { keys = [[1, [0.1, -1, 0]], [2, [0.1, 1, 0]]] }\n[output]\nlayers = [\"light\"]\n");
    runWell({"render", "scene.toml", "-o", "x.####.exr", "--frames", "1-2", "--stats", "s.json", "--verify", "60"});
    std::ifstream in(file("s.json"));
    const auto stats = nlohmann::json::parse(in);
    for (const auto& frame : stats) {
        // The faces of a small box, at few pixels, leave 2 % whatever the light.
        EXPECT_LT(frame.at("verification").at("error").get<double>(), 0.03);
        int named = 0;
        for (const auto& group : frame.at("plan").at("groups"))
            for (const auto& light : group.at("lights")) named += light.at("ies") == "wall.ies" ? 1 : 0;
        EXPECT_GT(named, 0);
    }
    const auto brightness = [&](const std::string& name) {
        double sum = 0;
        const Image image = readExr(file(name));
        for (std::size_t i = 0; i < image.rgba.size(); i += 4) sum += double(image.rgba[i]);
        return sum;
    };
    EXPECT_GT(brightness("x.0001.exr"), 3 * brightness("x.0002.exr"));
    EXPECT_TRUE(contains(runWell({"plan", "scene.toml"}).out, "profile that reaches 180 degrees"));
}

}  // namespace
}  // namespace scrim::test
