// SPDX-License-Identifier: Apache-2.0
// Depth and deep pictures of files as holdouts: what the program reads and what it refuses, in so many words.
#include "support/program_test.h"

#include <scrim/image/exr_read.h>

#include <OpenImageIO/deepdata.h>
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace scrim::test {
namespace {

using Names = std::vector<std::string>;

// The camera stands at z = 40, the box of smoke reaches from -6.5 to 6.5; pictures are 32 x 24.
class HoldoutFiles : public ProgramTest {
  protected:
    // The path is at 15:21.
    std::string sceneOf(const std::string& name, const std::string& more = "") const {
        write("held.toml", kCamera + kVolume + kLight +
                               "[ambient]\ncolor = [1, 1, 1]\n[output]\nholdout = { depth = \"" + name + "\"" + more +
                               " }\n");
        return "held.toml";
    }
    /// Values of all channels of pixel (x, y) are value(x).
    template <class Value>
    void writeFlat(const std::string& name, const Names& channels, const Value& value, int width = 32, int height = 24,
                   OIIO::TypeDesc type = OIIO::TypeDesc::FLOAT) const {
        OIIO::ImageSpec spec(width, height, static_cast<int>(channels.size()), type);
        spec.channelnames = channels;
        const auto out = OIIO::ImageOutput::create(file(name));
        ASSERT_TRUE(out && out->open(file(name), spec));
        std::vector<float> pixels;
        for (int i = 0; i < width * height; ++i)
            for (std::size_t c = 0; c < channels.size(); ++c)
                pixels.push_back(static_cast<float>(value(i % width, channels[c])));
        ASSERT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, pixels.data()) && out->close());
    }
    /// One sample in every pixel of the left half: over [z, zBack), of this alpha.
    void writeDeep(const std::string& name, const Names& channels, const std::vector<float>& sample) const {
        OIIO::ImageSpec spec(32, 24, static_cast<int>(channels.size()), OIIO::TypeDesc::FLOAT);
        spec.channelnames = channels;
        spec.deep = true;
        OIIO::DeepData data(spec);
        for (int p = 0; p < 32 * 24; ++p) {
            data.set_samples(p, p % 32 < 16 ? 1 : 0);
            for (std::size_t c = 0; c < sample.size() && p % 32 < 16; ++c)
                data.set_deep_value(p, static_cast<int>(c), 0, sample[c]);
        }
        const auto out = OIIO::ImageOutput::create(file(name));
        ASSERT_TRUE(out && out->open(file(name), spec) && out->write_deep_image(data) && out->close());
    }
    double alphaOf(const std::string& name, int x, int y) const {
        const Image image = readExr(file(name));
        return image.window.contains(x, y) ? image.rgba[image.indexOf(x, y) + 3] : 0.0;
    }
    /// Alpha of the pixels at 12 and at 20 of the middle row.
    std::pair<double, double> rendered(const std::string& scene, const Names& more = {}) const {
        Names words{"render", scene, "-o", "out.exr"};
        words.insert(words.end(), more.begin(), more.end());
        runWell(words);
        return {alphaOf("out.exr", 12, 12), alphaOf("out.exr", 20, 12)};
    }
};

const auto kLeftAt30 = [](int x, const std::string&) { return x < 16 ? 30.0 : 1e10; };

TEST_F(HoldoutFiles, HideWhatIsBehindTheirDepths) {
    writeFlat("z.exr", {"Z"}, kLeftAt30);
    const auto [plain, plainRight] = rendered("scene.toml");
    EXPECT_GT(plain, 0.5);
    const auto [left, right] = rendered(sceneOf("z.exr"));
    EXPECT_EQ(left, 0);
    EXPECT_NEAR(right, plainRight, 1e-3);
    // Through the middle of the box.
    writeFlat("z.exr", {"Z"}, [](int, const std::string&) { return 40.0; });
    const auto [half, halfRight] = rendered(sceneOf("z.exr"));
    EXPECT_NEAR(half, 1 - std::sqrt(1 - plain), 0.02);
    EXPECT_NEAR(halfRight, 1 - std::sqrt(1 - plainRight), 0.02);
    // As a distance, which at the left of the picture is more than the depth: less is hidden there than by the same
    // number as z. (fov 35: at pixel 12 by 0.2 %.)
    writeFlat("z.exr", {"Z"}, [](int, const std::string&) { return 33.505; });
    EXPECT_GT(rendered(sceneOf("z.exr")).first, rendered(sceneOf("z.exr", ", kind = \"distance\"")).first);
}

TEST_F(HoldoutFiles, AreVerified) {
    writeFlat("z.exr", {"Z"}, [](int x, const std::string&) { return 36.0 + 0.3 * x; });
    const auto expectVerified =
        [&](const std::string& scene) {  // by the marcher, to less than 2 %: the box has hard edges
            const ProgramResult result = runWell({"render", scene, "-o", "x.exr", "--verify", "40"});
            const bool small = result.err.find("; error 0.") != std::string::npos ||
                               result.err.find("; error 1.") != std::string::npos;
            EXPECT_TRUE(small) << result.err;
        };
    expectVerified(sceneOf("z.exr"));
    expectVerified(sceneOf("z.exr", ", kind = \"distance\""));
    writeDeep("deep.exr", {"A", "Z", "ZBack"}, {0.6f, 36, 41});
    expectVerified(sceneOf("deep.exr"));
    write("held.toml", kCamera + kVolume + "name = \"a\"\nholdout = true\n" + kVolume +
                           "name = \"b\"\ntransform = { translate = [3, 2, -11] }\n" + kLight);
    expectVerified("held.toml");
}

TEST_F(HoldoutFiles, MayBeSequencesAndNameTheirChannel) {
    writeFlat("z.0007.exr", {"B", "G", "R", "depth.Z"}, kLeftAt30);
    runWell({"render", sceneOf("z.####.exr"), "-o", "c.####.exr", "--frames", "7"});
    EXPECT_EQ(alphaOf("c.0007.exr", 12, 12), 0);
    EXPECT_GT(alphaOf("c.0007.exr", 20, 12), 0.5);
    writeFlat("two.exr", {"cloud.Z", "wall.Z", "R"},
              [](int x, const std::string& name) { return name == "wall.Z" ? kLeftAt30(x, name) : 1e30; });
    EXPECT_EQ(rendered(sceneOf("two.exr", ", channel = \"wall.Z\"")).first, 0);
    EXPECT_GT(rendered(sceneOf("two.exr", ", channel = \"cloud.Z\"")).first, 0.5);
    writeFlat("only.exr", {"Y"}, kLeftAt30);
    EXPECT_EQ(rendered(sceneOf("only.exr")).first, 0);
}

TEST_F(HoldoutFiles, OfDeepPicturesHideByTheirAlpha) {
    const auto [plain, plainRight] = rendered("scene.toml");
    writeDeep("deep.exr", {"A", "Z", "ZBack"}, {0.75f, 30, 31});
    const auto [left, right] = rendered(sceneOf("deep.exr"), {"--set", "output.deep=out.deep.exr"});
    EXPECT_NEAR(left, 0.25 * plain, 2e-3);
    EXPECT_NEAR(right, plainRight, 2e-3);
    EXPECT_TRUE(exists("out.deep.exr"));
    // Without ZBack a sample is a surface.
    writeDeep("deep.exr", {"A", "Z"}, {1, 30});
    EXPECT_EQ(rendered(sceneOf("deep.exr")).first, 0);
}

TEST_F(HoldoutFiles, OfOwnDeepPicturesAddUpToTheWhole) {
    // What shows of a thing, and all else held out by its deep picture, is all.
    const std::string two = kCamera + kVolume + "name = \"a\"\n" + kVolume +
                            "name = \"b\"\ntransform = { translate = [3, 2, 11] }\n[ambient]\ncolor = [1, 1, 1]\n";
    write("two.toml", two);
    const double whole = rendered("two.toml").first;
    // Held out by one another the two add up, too.
    const double a = rendered("two.toml", {"--set", "volume.b.holdout=true"}).first;
    const double b = rendered("two.toml", {"--set", "volume.a.holdout=true"}).first;
    EXPECT_NEAR(a + b, whole, 4e-3);  // texels of 0.34 and 0.17 voxels: 0.2 to 0.4 % off
    EXPECT_GT(a, 0.05);
    EXPECT_GT(b, 0.05);
    runWell({"render", "two.toml", "--set", "volume.a.density.scale=0", "--set", "output.deep=b.deep.exr", "--set",
             "output.deep_type=float", "-o", "b.exr"});
    const double held =
        rendered("two.toml", {"--set", "volume.b.density.scale=0", "--set", "output.holdout.depth=b.deep.exr"}).first;
    EXPECT_NEAR(held, a, 5e-3);
}

TEST_F(HoldoutFiles, ThatCannotBeUsedAreLocatedErrors) {
    const std::string place = "held.toml:15:21: holdout: ";
    const auto expectRefusal = [&](const std::string& scene, const std::string& problem) {
        expectFailure({"render", scene, "-o", "x.exr"}, 3, place + problem);
    };
    expectRefusal(sceneOf("none.exr"), "there is no file 'none.exr'");
    expectFailure({"plan", sceneOf("none.exr")}, 3, place + "there is no file 'none.exr'");
    writeFlat("z.exr", {"Z"}, kLeftAt30, 64, 48);
    expectRefusal(sceneOf("z.exr"),
                  "the display window of 'z.exr' is 64 x 48; expected 32 x 24, the resolution of the picture");
    expectRefusal(sceneOf("z.exr", ", window = \"data\""),
                  "the data window of 'z.exr' is 64 x 48; expected 32 x 24, the resolution of the picture");
    writeFlat("rgb.exr", {"R", "G", "B"}, kLeftAt30);
    expectRefusal(sceneOf("rgb.exr"),
                  "cannot read 'rgb.exr': no channel is called Z or depth; expected 'channel' to be one of "
                  "'R', 'G', 'B'");
    expectRefusal(sceneOf("rgb.exr", ", channel = \"Z\""),
                  "cannot read 'rgb.exr': it has no channel 'Z'; expected one of 'R', 'G', 'B'");
    writeFlat("two.exr", {"a.Z", "b.Z"}, kLeftAt30);
    expectRefusal(sceneOf("two.exr"),
                  "cannot read 'two.exr': it has several channels of depths; expected 'channel' to be one of 'a.Z', "
                  "'b.Z'");
    writeFlat("z.png", {"Y"}, kLeftAt30, 32, 24, OIIO::TypeDesc::UINT8);
    expectRefusal(sceneOf("z.png"),
                  "cannot read 'z.png': its channel 'Y' holds whole numbers; expected depths as floats");
    writeDeep("deep.exr", {"Z", "ZBack"}, {30, 31});
    expectRefusal(sceneOf("deep.exr"),
                  "cannot read 'deep.exr': its deep samples have no channel 'A' for their opacity");
    write("text.exr", "no picture");
    const ProgramResult damaged = run({"render", sceneOf("text.exr"), "-o", "x.exr"});
    EXPECT_EQ(damaged.status, 3);
    EXPECT_NE(damaged.err.find(place + "cannot read 'text.exr': "), std::string::npos) << damaged.err;
    expectFailure({"render", sceneOf("z.exr", ", kind = \"depth\""), "-o", "x.exr"}, 3,
                  "held.toml:15:37: 'kind' is the string \"depth\"; expected 'z' or 'distance'");
    expectFailure({"render", sceneOf("z.exr", ", background = 0"), "-o", "x.exr"}, 3,
                  "held.toml:15:43: 'background' is 0; expected a number greater than 0");
    write("held.toml", kCamera + kVolume + "[output]\nholdout = { kind = \"z\" }\n");
    expectFailure({"render", "held.toml", "-o", "x.exr"}, 3,
                  "held.toml:9:11: 'holdout' of [output] lacks 'depth'; expected a path such as \"z.####.exr\"");
    EXPECT_FALSE(exists("x.exr"));
}

TEST_F(HoldoutFiles, AreLeftAsTheyAre) {
    writeFlat("z.exr", {"Z"}, kLeftAt30);
    expectFailure(
        {"render", sceneOf("z.exr"), "-o", "z.exr"}, 2,
        "the picture of held.toml 'z.exr' would overwrite the holdout's picture, which is read; write to another file");
}

// Whatever becomes of a file, the program renders it or says where the scene names it.
TEST_F(HoldoutFiles, ThatAreDamagedByLotNeverCrashTheProgram) {
    writeDeep("deep.exr", {"A", "Z", "ZBack"}, {0.6f, 36, 41});
    const std::string whole = readBytes(file("deep.exr"));
    std::uint32_t state = 11;
    const auto below = [&state](std::size_t n) {
        state = state * 1664525U + 1013904223U;
        return std::size_t(state >> 8) % n;
    };
    for (int i = 0; i < 12; ++i) {
        std::string bytes = whole;
        for (int k = 0; k < 6; ++k) bytes[8 + below(bytes.size() - 8)] = static_cast<char>(below(256));
        write("damaged.exr", bytes);
        const ProgramResult result = run({"plan", sceneOf("damaged.exr")});
        EXPECT_TRUE(result.status == 0 || result.status == 3) << result.status << ": " << result.err;
        EXPECT_TRUE(result.status == 0 || result.err.find("held.toml:15:21: holdout: ") != std::string::npos)
            << result.err;
    }
}

}  // namespace
}  // namespace scrim::test
