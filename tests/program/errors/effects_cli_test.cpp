// SPDX-License-Identifier: Apache-2.0
// Effects from scenes with files to pictures: grids of colours and heat, layers, and what is not read at all.
#include "support/program_test.h"

#include <scrim/image/exr_read.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>

namespace scrim::test {
namespace {

class CliEffects : public ProgramTest {
  protected:
    void SetUp() override {
        ProgramTest::SetUp();
        std::vector<MadeColour> colours;
        for (const MadeVoxel& voxel : box({-6, -6, -6}, {6, 6, 6}, 0.2)) colours.push_back({voxel.at, {0.9, 0.3, 0.1}});
        makeVdb(file("fire.vdb"), {{.voxels = box({-6, -6, -6}, {6, 6, 6}, 0.2)},
                                   {.name = "Cd", .type = "vec3s", .colours = colours},
                                   {.name = "heat", .voxels = box({-3, -3, -3}, {3, 3, 3}, 1)}});
    }
    nlohmann::json effectOf(const std::string& scene, const std::string& name) const {
        const auto plan = nlohmann::json::parse(runWell({"plan", scene, "--json"}).out);
        for (const auto& effect : plan[0]["plan"]["effects"])
            if (effect["name"] == name) return effect;
        return {};
    }
    nlohmann::json workOf(const std::string& scene, const std::vector<std::string>& more = {}) const {
        std::vector<std::string> arguments{"render", scene, "-o", "x.exr", "--stats", "x.json"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        runWell(arguments);
        return nlohmann::json::parse(readBytes(file("x.json")))[0]["work"];
    }
    double centre(const std::string& channel) const {
        const Image picture = readExr(file("x.exr"));
        const std::vector<float> values = readExrChannel(file("x.exr"), channel);
        const auto width = static_cast<std::size_t>(picture.window.width());
        return values[(static_cast<std::size_t>(12 - picture.window.y0)) * width +
                      static_cast<std::size_t>(16 - picture.window.x0)];
    }
};

const std::string kFire = "[[volume]]\nname = \"fire\"\nfile = \"fire.vdb\"\n[volume.medium]\n";

TEST_F(CliEffects, ColourGridTintsThePicture) {
    write("s.toml", kCamera + kFire + "albedo = { grid = \"Cd\" }\n" + kLight);
    runWell({"render", "s.toml", "-o", "x.exr", "--verify", "20"});
    EXPECT_NEAR(centre("R") / centre("B"), 9, 0.02);
    EXPECT_NEAR(centre("G") / centre("B"), 3, 0.01);
    const auto effect = effectOf("s.toml", "albedo grids");
    EXPECT_EQ(effect["on"], true);
    EXPECT_EQ(effect["where"][0], "s.toml:10:19");
}

TEST_F(CliEffects, ScalarGridIsAGreyAlbedoAndMissingOnesAreLocated) {
    write("s.toml", kCamera + kFire + "albedo = { grid = \"density\", scale = 2 }\n" + kLight);
    runWell({"render", "s.toml", "-o", "x.exr"});
    EXPECT_NEAR(centre("R"), centre("B"), 1e-3 * centre("R"));
    write("s.toml", kCamera + kFire + "albedo = { grid = \"colour\" }\n" + kLight);
    const ProgramResult result = run({"render", "s.toml", "-o", "x.exr"});
    EXPECT_EQ(result.status, 3);
    EXPECT_NE(result.err.find("s.toml:10:19: "), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("'Cd'"), std::string::npos) << result.err;
}

TEST_F(CliEffects, VolumesHaveAlphasAndMattes) {
    write("s.toml", kCamera + kFire +
                        "albedo = [0.5, 0.5, 0.5]\n[[volume]]\nname = \"be hind\"\nfile = \"fire.vdb\"\n"
                        "transform = { translate = [4, 0, -20] }\n" +
                        kLight);
    runWell({"render", "s.toml", "-o", "x.exr", "--set", "output.layers=[\"volume\", \"cryptomatte\"]"});
    const double front = centre("volume.fire.A"), behind = centre("volume.be_hind.A"), alpha = centre("A");
    EXPECT_GT(front, 0.5);
    EXPECT_GT(behind, 0.05);
    EXPECT_NEAR(front + behind, alpha, 2e-3) << "half floats";
    EXPECT_NEAR(centre("CryptoObject00.G"), front, 1e-3);
    EXPECT_NEAR(centre("CryptoObject00.A"), behind, 1e-3);
    const auto attributes = readExrAttributes(file("x.exr"));
    const auto manifest = nlohmann::json::parse(attributes.at("cryptomatte/3ae39a5/manifest"));
    EXPECT_EQ(manifest.size(), 2u);
    EXPECT_TRUE(contains(attributes.at("channels"), "CryptoObject00.R:float")) << attributes.at("channels");
    // A matte by the rules of its specification: the parts of all ranks whose id is that of the name.
    for (const auto& [name, part] : {std::pair{"fire", front}, std::pair{"be hind", behind}}) {
        const auto id = static_cast<std::uint32_t>(std::stoul(manifest[name].get<std::string>(), nullptr, 16));
        double matte = 0;
        for (const auto& [ids, parts] :
             {std::pair{"CryptoObject00.R", "CryptoObject00.G"}, std::pair{"CryptoObject00.B", "CryptoObject00.A"}})
            if (std::bit_cast<std::uint32_t>(static_cast<float>(centre(ids))) == id) matte += centre(parts);
        EXPECT_NEAR(matte, part, 1e-3) << name;
    }
    const ProgramResult lossy = run({"render", "s.toml", "-o", "y.exr", "--set", "output.layers=[\"cryptomatte\"]",
                                     "--set", "output.compression=\"dwaa\""});
    EXPECT_EQ(lossy.status, 3);
    EXPECT_TRUE(contains(lossy.err, "'cryptomatte' needs exact numbers")) << lossy.err;
}

TEST_F(CliEffects, LightsOfAGroupShareALayer) {
    const std::string group = "group = \"prac ticals\"\n";
    write("s.toml", kCamera + kFire + "albedo = [0.5, 0.5, 0.5]\n" + kLight + group +
                        "[[light]]\nname = \"two\"\ntype = \"distant\"\ndirection = [0, -1, 0]\n" + group +
                        "[output]\nlayers = [\"light\"]\ntype = \"float\"\n");
    runWell({"render", "s.toml", "-o", "x.exr"});
    EXPECT_NEAR(centre("light.prac_ticals.R"), centre("R"), 1e-6);
    const std::string channels = readExrAttributes(file("x.exr")).at("channels");
    EXPECT_FALSE(contains(channels, "light.two")) << channels;
    const ProgramResult twice = run({"render", "s.toml", "-o", "y.exr", "--set", "light.two.group=\"prac_ticals\""});
    EXPECT_EQ(twice.status, 3);
    EXPECT_TRUE(contains(twice.err, "'prac ticals' and 'prac_ticals' would both be the layer 'light.prac_ticals'"))
        << twice.err;
}

TEST_F(CliEffects, ShutterOffIsNoMotionBlur) {
    write("s.toml", kCamera + kFire + "albedo = [0.5, 0.5, 0.5]\n" + kLight);
    runWell({"render", "s.toml", "-o", "still.exr", "--set", "camera.position=[0, 0, 40]"});
    const std::string open = "camera.shutter=[-0.5, 0.5]";
    runWell({"render", "s.toml", "-o", "blurred.exr", "--set", open});
    runWell({"render", "s.toml", "-o", "off.exr", "--set", open, "--shutter", "off"});
    runWell({"render", "s.toml", "-o", "word.exr", "--set", open, "--set", "camera.shutter=\"off\""});
    EXPECT_EQ(readExr(file("off.exr")).rgba, readExr(file("word.exr")).rgba);
    runWell({"render", "s.toml", "-o", "never.exr"});
    EXPECT_EQ(readExrAttributes(file("off.exr")).at("scrim:plan"),
              readExrAttributes(file("never.exr")).at("scrim:plan"));
    EXPECT_NE(readExrAttributes(file("blurred.exr")).at("scrim:plan"),
              readExrAttributes(file("never.exr")).at("scrim:plan"));
    expectFailure({"render", "s.toml", "--shutter", "1"}, 2,
                  "--shutter 1: expected 'off'; --set camera.shutter=[OPEN, CLOSE] gives times");
}

TEST_F(CliEffects, EmissionGlowsWithoutLights) {
    write("s.toml",
          kCamera + kFire + "emission = { grid = \"heat\", ramp = [[0,[0,0,0]],[1,[1,0.5,0]]], scale = 0.1 }\n");
    const auto work = workOf("s.toml");
    EXPECT_NEAR(centre("G"), 0.5 * centre("R"), 1e-3);
    EXPECT_GT(centre("R"), 0.1);
    EXPECT_GT(work["emissions"].get<double>(), 0);
    EXPECT_EQ(work["light_lookups"], 0);
}

TEST_F(CliEffects, BlackBodiesAreRedderWhereTheyAreCooler) {
    const auto redToBlue = [&](const std::string& kelvin) {
        write("s.toml", kCamera + kFire + "blackbody = { grid = \"heat\", scale = " + kelvin + ", intensity = 0.1 }\n");
        runWell({"render", "s.toml", "-o", "x.exr"});
        return centre("R") / centre("B");
    };
    EXPECT_GT(redToBlue("2000"), 2 * redToBlue("4000"));
    EXPECT_LT(redToBlue("10000"), 1);
}

TEST_F(CliEffects, LightsOfAnyNameHaveChannelsThatAreRead) {
    const std::string scene =
        kCamera + kVolume + "[[light]]\nname = \"key light.1\"\ntype = \"distant\"\ndirection = [0, 0, -1]\n";
    const std::string output = "[output]\nlayers = [\"light\"]\n";
    write("s.toml", scene + output);
    runWell({"render", "s.toml", "-o", "x.exr"});
    EXPECT_NE(readExrAttributes(file("x.exr")).at("channels").find(" light.key_light_1.R:"), std::string::npos);
    write("s.toml", scene + "[[light]]\nname = \"key_light_1\"\ntype = \"distant\"\ndirection = [0, 0, 1]\n" + output);
    expectFailure({"render", "s.toml", "-o", "y.exr"}, 3,
                  "s.toml:17:10: lights 'key light.1' and 'key_light_1' would both be the layer 'light.key_light_1', "
                  "whose name has only letters, digits and underscores; expected different names");
}

TEST_F(CliEffects, VolumesHaveChannelsOfTheirOwnAndMotionHasTwo) {
    const std::string output = "[output]\nlayers = [\"motion\", \"volume\"]\n";
    write("s.toml", kCamera + kVolume + "name = \"my smoke\"\n" + kVolume + "name = \"far\"\n" +
                        "transform = { translate = [900, 0, 0] }\n" + kLight + output);
    runWell({"render", "s.toml", "-o", "x.exr"});
    const std::string channels = readExrAttributes(file("x.exr")).at("channels");
    for (const char* channel : {"motion.u:float", "motion.v:float", "volume.my_smoke.G:half", "volume.far.B:half"})
        EXPECT_NE(channels.find(channel), std::string::npos) << channel << " in " << channels;
    EXPECT_EQ(readExrChannel(file("x.exr"), "volume.my_smoke.R"), readExrChannel(file("x.exr"), "R"));
    write("s.toml", kCamera + kVolume + "name = \"my smoke\"\n" + kVolume + "name = \"my-smoke\"\n" + kLight + output);
    expectFailure({"render", "s.toml", "-o", "y.exr"}, 3,
                  "s.toml:17:10: volumes 'my smoke' and 'my-smoke' would both be the layer 'volume.my_smoke', whose "
                  "name has only letters, digits and underscores; expected different names");
}

TEST_F(CliEffects, LayersAreInTheFileAndAddUp) {
    write(
        "s.toml",
        kCamera + kFire + "emission = { grid = \"heat\", scale = 0.02 }\n" + kLight +
            "[[light]]\nname = \"rim\"\ntype = \"distant\"\ndirection = [1, 0, 1]\n[ambient]\ncolor = [0.1, 0.2, 0.3]\n"
            "[output]\nlayers = [\"light\", \"ambient\", \"emission\", \"albedo\", \"depth\", \"transmittance\"]\n"
            "type = \"float\"\n");
    runWell({"render", "s.toml", "-o", "x.exr"});
    EXPECT_EQ(readExrAttributes(file("x.exr")).at("channels"),
              "A:float B:float G:float R:float Z:float albedo.B:float albedo.G:float albedo.R:float ambient.B:float "
              "ambient.G:float ambient.R:float depth.mean:float emission.B:float emission.G:float emission.R:float "
              "light.key.B:float light.key.G:float light.key.R:float light.rim.B:float light.rim.G:float "
              "light.rim.R:float transmittance.B:float transmittance.G:float transmittance.R:float");
    for (const std::string c : {"R", "G", "B"})
        EXPECT_NEAR(
            centre(c),
            centre("light.key." + c) + centre("light.rim." + c) + centre("ambient." + c) + centre("emission." + c),
            1e-5);
    EXPECT_NEAR(centre("transmittance.G"), 1 - centre("A"), 1e-5);
    EXPECT_NEAR(centre("Z"), 40 - 6.5, 1.5);
    EXPECT_GT(centre("depth.mean"), centre("Z"));
    // Beyond the smoke everything comes through, up to the picture's border.
    EXPECT_EQ(readExrAttributes(file("x.exr")).at("dataWindow"), "0 0 32 24");
    EXPECT_EQ(readExrChannel(file("x.exr"), "transmittance.R").front(), 1);
}

TEST_F(CliEffects, DepthStaysFloatInAHalfFile) {
    runWell({"render", "scene.toml", "-o", "x.exr", "--set", "output.layers=[\"depth\"]"});
    const std::string channels = readExrAttributes(file("x.exr")).at("channels");
    EXPECT_EQ(channels, "A:half B:half G:half R:half Z:float depth.mean:float");
}

TEST_F(CliEffects, VolumesThatThePictureHasNoUseForAreNotLoaded) {
    // A file whose voxels are damaged is an error where it is looked at, and none where it is not.
    makeVdb(file("far.vdb"), {{.voxels = box({-6, -6, -6}, {6, 6, 6}, 0.2)}});
    std::string bytes = readBytes(file("far.vdb"));
    for (std::size_t i = bytes.size() - 400; i < bytes.size() - 100; ++i) bytes[i] = '\x7f';
    write("far.vdb", bytes);
    const std::string far = "[[volume]]\nname = \"far\"\nfile = \"far.vdb\"\ntransform = { translate = [300, 0, 0] }\n";
    write("s.toml", kCamera + kVolume + far + kLight);
    runWell({"render", "s.toml", "-o", "x.exr"});
    const auto effect = effectOf("s.toml", "volumes culled");
    EXPECT_EQ(effect["on"], true);
    EXPECT_EQ(effect["reason"], "'far': it is out of view and casts no shadow into view");
    EXPECT_EQ(effect["where"][0], "s.toml:8:1");
    // Light that passes it on its way to what is in view needs it.
    write("s.toml", kCamera + kVolume + far + "[[light]]\ntype = \"distant\"\ndirection = [-1, 0, 0]\n");
    EXPECT_EQ(run({"render", "s.toml", "-o", "x.exr"}).status, 3);
}

TEST_F(CliEffects, VolumesOfNoDensityAreCulledUnlessTheyEmit) {
    makeVdb(file("other.vdb"), {{.voxels = box({-6, -6, -6}, {6, 6, 6}, 0.2)}});
    const std::string none = "[[volume]]\nname = \"none\"\nfile = \"other.vdb\"\ndensity = { scale = 0 }\n";
    write("s.toml", kCamera + kVolume + none + kLight);
    EXPECT_EQ(effectOf("s.toml", "volumes culled")["reason"], "'none': its density is 0");
    write("s.toml",
          kCamera + kVolume + none + "[volume.medium]\nemission = { grid = \"density\", scale = 1 }\n" + kLight);
    EXPECT_EQ(effectOf("s.toml", "volumes culled")["on"], false);
}

TEST_F(CliEffects, PictureOfNothingSaysWhy) {
    const ProgramResult result =
        runWell({"render", "scene.toml", "-o", "x.exr", "-q", "--set", "camera.target=[0,0,90]"});
    EXPECT_EQ(result.err,
              "scrim: warning: frame 1: volume 'volume1' is culled: it is out of view and casts no shadow into view\n");
}

TEST_F(CliEffects, LightsThatLightNothingAreNamedInThePlan) {
    write("s.toml", kCamera + "[[volume]]\nfile = \"smoke.vdb\"\nlights = [\"key\"]\n" + kLight +
                        "[[light]]\nname = \"rim\"\ntype = \"distant\"\ndirection = [1, 0, 0]\n");
    const auto effect = effectOf("s.toml", "lights culled");
    EXPECT_EQ(effect["reason"], "'rim': no volume is linked to it");
    EXPECT_EQ(effect["where"][0], "s.toml:13:1");
    EXPECT_EQ(effectOf("s.toml", "light linking")["where"][0], "s.toml:8:10");
}

TEST_F(CliEffects, VolumesCastShadowsInTheLightsThatTheyName) {
    const std::string volume = kCamera + "[[volume]]\nfile = \"smoke.vdb\"\nshadows = ",
                      light = kLight + "[[light]]\nname = \"rim\"\ntype = \"distant\"\ndirection = [1, 0, 0]\n";
    write("s.toml", volume + "[\"rim\"]\n" + light);
    EXPECT_EQ(effectOf("s.toml", "shadow linking")["reason"], "'volume1' in 1 of 2 lights");
    EXPECT_EQ(effectOf("s.toml", "shadow linking")["where"][0], "s.toml:8:11");
    runWell({"render", "s.toml", "-o", "x.exr", "--verify", "60", "--tolerance", "0.02"});
    write("s.toml", volume + "[\"key\", \"rim\"]\n" + light);
    EXPECT_EQ(effectOf("s.toml", "shadow linking")["on"], false);
    write("s.toml", volume + "false\n[volume.medium]\nscattering = \"full\"\n" + light);
    expectFailure({"render", "s.toml", "-o", "x.exr"}, 3,
                  "s.toml:7:8: volume 'volume1' does not cast shadows in all lights; with scattering = \"full\" in "
                  "volume 'volume1' it must");
}

TEST_F(CliEffects, PlanInThePictureIsThatOfThePlanCommand) {
    runWell({"render", "scene.toml", "-o", "x.exr"});
    const auto inPicture = nlohmann::json::parse(readExrAttributes(file("x.exr")).at("scrim:plan"));
    const auto planned = nlohmann::json::parse(runWell({"plan", "scene.toml", "--json"}).out)[0]["plan"];
    EXPECT_EQ(inPicture["effects"], planned["effects"]);
}

// With and without the mention of effects that are off: the same counts, to the last one.
TEST_F(CliEffects, WhatIsOffDoesNoWork) {
    write("off.toml",
          kCamera + kVolume +
              "lights = [\"key\"]\n[volume.medium]\nextinction_tint = [1, 1, 1]\nphase = { type = \"two-lobe\", "
              "g1 = 0, g2 = 0 }\noctaves = { count = 1 }\n" +
              kLight + "[ambient]\ncolor = [0, 0, 0]\n[output]\nlayers = []\n");
    EXPECT_EQ(workOf("off.toml"), workOf("scene.toml"));
}

TEST_F(CliEffects, TellsOfTheScenesOwnTextOnceAndNotForEveryFrame) {
    write("scene.toml", kCamera + kFire + "blackbody = { grid = \"heat\" }\n");
    const ProgramResult result = run({"render", "scene.toml", "--frames", "1-3", "-o", "x.####.exr", "-q"});
    ASSERT_EQ(result.status, 0) << result.err;
    const std::size_t first = result.err.find("'normalize' of the blackbody");
    ASSERT_NE(first, std::string::npos) << result.err;
    EXPECT_EQ(result.err.find("'normalize' of the blackbody", first + 1), std::string::npos) << result.err;
}

// The picture is there, and says what was reached.
TEST_F(CliEffects, ScatteringThatDoesNotSettleIsWrittenAndHasAStatusOfItsOwn) {
    write("s.toml", kCamera + kFire + "albedo = [0.9999, 0.9999, 0.9999]\nscattering = \"full\"\n" + kLight +
                        "[render]\nscatter_error = 1e-6\n");
    const ProgramResult result =
        run({"render", "s.toml", "-o", "x.exr", "--set", "volume.fire.density.scale=10000", "-v"});
    EXPECT_EQ(result.status, 5) << result.err;
    EXPECT_NE(result.err.find("scatter"), std::string::npos) << result.err;
    EXPECT_TRUE(exists("x.exr"));
    runWell({"render", "s.toml", "-o", "x.exr", "--set", "render.scatter_error=0.002"});
}

}  // namespace
}  // namespace scrim::test
