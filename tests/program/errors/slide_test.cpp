// SPDX-License-Identifier: Apache-2.0
// Slides from the command line: files found, read once, and missed in so many words.
#include "support/program_test.h"

#include <OpenImageIO/imageio.h>
#include <nlohmann/json.hpp>

#include <fstream>
#include <sstream>

namespace scrim::test {
namespace {

class SlideFiles : public ProgramTest {
  protected:
    void SetUp() override {
        ProgramTest::SetUp();
        write("scene.toml", sceneWith("slide.png"));
    }
    // The slide's file is at 12:18.
    static std::string sceneWith(const std::string& name) {
        return kCamera + kVolume +
               "[[light]]\nname = \"lamp\"\ntype = \"projector\"\nposition = [10, 0, 40]\nslide = { file = \"" + name +
               "\", fov = 30 }\ntarget = [0, 0, 0]\n";
    }
    void writePng(const std::string& name, float value) const {
        const auto out = OIIO::ImageOutput::create(file(name));
        ASSERT_TRUE(out);
        ASSERT_TRUE(out->open(file(name), OIIO::ImageSpec(8, 8, 3, OIIO::TypeDesc::UINT8)));
        const std::vector<float> pixels(8 * 8 * 3, value);
        ASSERT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, pixels.data()));
        ASSERT_TRUE(out->close());
    }
    nlohmann::json stats(const std::string& name) const {
        std::ifstream in(file(name));
        return nlohmann::json::parse(in);
    }
};

TEST_F(SlideFiles, MissingIsAnErrorWithItsPlaceInTheScene) {
    const std::string reason = "scene.toml:12:18: light 'lamp': there is no file 'slide.png'";
    expectFailure({"render", "scene.toml", "-o", "x.exr"}, 3, reason);
    expectFailure({"plan", "scene.toml"}, 3, reason);
}

TEST_F(SlideFiles, DamagedIsAnErrorWithItsPlaceInTheScene) {
    write("slide.png", "no picture");
    const ProgramResult result = run({"render", "scene.toml", "-o", "x.exr"});
    EXPECT_EQ(result.status, 3);
    EXPECT_EQ(result.err.find("scrim: error: scene.toml:12:18: light 'lamp': cannot read 'slide.png': "), 0u)
        << result.err;
}

TEST_F(SlideFiles, AreCountedInTheStatisticsAndNamedInThePlan) {
    writePng("slide.png", 1);
    runWell({"render", "scene.toml", "-o", "x.exr", "--stats", "s.json"});
    const auto frame = stats("s.json").at(0);
    EXPECT_GT(frame.at("work").at("slide_lookups").get<double>(), 0);
    EXPECT_EQ(frame.at("work").at("slide_lookups"), frame.at("work").at("light_lookups"));
    const auto light = frame.at("plan").at("groups").at(0).at("lights").at(0);
    EXPECT_EQ(light.at("slide").at("file"), "slide.png");
    EXPECT_EQ(light.at("slide").at("pixels"), nlohmann::json::parse("[8, 8]"));
    const ProgramResult plan = runWell({"plan", "scene.toml"});
    EXPECT_NE(plan.out.find("slides                  on   of 'lamp' (scene.toml:12:9)\n"), std::string::npos)
        << plan.out;
    EXPECT_NE(plan.out.find("  light 'lamp', slide of 8 x 8 pixels: shadow raster "), std::string::npos) << plan.out;

    write("plain.toml", kCamera + kVolume + kLight);
    runWell({"render", "plain.toml", "-o", "y.exr", "--stats", "t.json"});
    EXPECT_EQ(stats("t.json").at(0).at("work").at("slide_lookups"), 0);
}

TEST_F(SlideFiles, MayBeSequences) {
    write("scene.toml", sceneWith("slide.##.png"));
    writePng("slide.01.png", 1);
    writePng("slide.02.png", 0);
    runWell({"render", "scene.toml", "-o", "x.####.exr", "--frames", "1-2", "--stats", "s.json"});
    const auto frames = stats("s.json");
    ASSERT_EQ(frames.size(), 2u);
    EXPECT_EQ(frames.at(1).at("plan").at("groups").at(0).at("lights").at(0).at("slide").at("file"), "slide.02.png");
    expectFailure({"render", "scene.toml", "-o", "y.####.exr", "--frames", "3"}, 3,
                  "scene.toml:12:18: light 'lamp': there is no file 'slide.03.png'");
}

// A slide that stays is read once: what is wrong with it is said once.
TEST_F(SlideFiles, ThatStayAreReadOnce) {
    write("scene.toml", sceneWith("slide.pfm"));
    std::ostringstream bytes;
    bytes << "PF\n1 1\n-1.0\n";
    const float pixel[3] = {-1, 2, 3};
    bytes.write(reinterpret_cast<const char*>(pixel), sizeof pixel);
    write("slide.pfm", bytes.str());
    const ProgramResult result = runWell({"render", "scene.toml", "-o", "x.####.exr", "--frames", "1-3"});
    const std::string warning = "slide.pfm: 1 values that are not finite or less than 0 count as 0";
    const auto first = result.err.find(warning);
    EXPECT_NE(first, std::string::npos) << result.err;
    EXPECT_EQ(result.err.find(warning, first + 1), std::string::npos) << result.err;
}

}  // namespace
}  // namespace scrim::test
