// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/exr.h>

#include <scrim/base/error.h>
#include <scrim/image/exr_read.h>

#include "support/file_size_limit.h"
#include "support/print_window.h"
#include "support/temp_folder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include <glm/gtc/matrix_transform.hpp>

namespace scrim {
namespace {

constexpr PixelWindow kFrame{0, 0, 32, 24};

ExrOptions frameOptions() {
    ExrOptions options;
    options.displayWindow = kFrame;
    return options;
}

/// Smooth values in every pixel of `window`; none is 0, so that nothing is cropped.
Image gradient(const PixelWindow& window) {
    Image image{window, {}};
    for (std::size_t i = 0; i < 4 * window.pixelCount(); ++i)
        image.rgba.push_back(0.01f + static_cast<float>(i) * 0.003f);
    return image;
}

template <typename Call>
std::string errorOf(ErrorKind kind, const Call& call) {
    try {
        call();
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), kind);
        return error.what();
    }
    return "no error";
}

class ExrCompression : public testing::TestWithParam<std::string> {};

TEST_P(ExrCompression, RoundTrips) {
    const test::TempFolder folder;
    const Image image = gradient(kFrame);
    ExrOptions options = frameOptions();
    options.compression = GetParam();
    for (const bool half : {true, false}) {
        options.half = half;
        EXPECT_EQ(writeExr(folder.file("a.exr"), image, options), 0u);
        const Image back = readExr(folder.file("a.exr"));
        ASSERT_EQ(back.window, image.window);
        // Half has 11 bits of mantissa. DWAA loses colour, never alpha: by its level 45, up to some percent.
        const double relative = half ? 0x1p-11 : 0.0;
        for (std::size_t i = 0; i < image.rgba.size(); ++i) {
            const bool lossy = GetParam() == "dwaa" && i % 4 != 3;
            const double value = std::fabs(image.rgba[i]);
            ASSERT_NEAR(back.rgba[i], image.rgba[i], lossy ? 0.005 + 0.05 * value : relative * value)
                << "value " << i << (half ? ", half" : ", float");
        }
        EXPECT_EQ(readExrAttributes(folder.file("a.exr")).at("compression"), GetParam());
    }
}

INSTANTIATE_TEST_SUITE_P(All, ExrCompression, testing::ValuesIn(exrCompressions()),
                         [](const auto& codec) { return codec.param; });

TEST(Exr, CropsTheDataWindowToWhatIsNotEmpty) {
    const test::TempFolder folder;
    Image image = emptyImage(kFrame);
    image.rgba[image.indexOf(5, 7) + 1] = 0.5f;
    image.rgba[image.indexOf(9, 20) + 3] = 1.0f;
    for (const bool half : {true, false}) {
        ExrOptions options = frameOptions();
        options.half = half;
        writeExr(folder.file("a.exr"), image, options);
        const Image back = readExr(folder.file("a.exr"));
        EXPECT_EQ(back.window, (PixelWindow{5, 7, 10, 21}));
        EXPECT_EQ(reframed(back, kFrame).rgba, image.rgba);
        EXPECT_EQ(readExrAttributes(folder.file("a.exr")).at("displayWindow"), "0 0 32 24");
    }
}

TEST(Exr, AnEmptyPictureIsOnePixel) {
    const test::TempFolder folder;
    writeExr(folder.file("a.exr"), emptyImage(kFrame), frameOptions());
    const Image back = readExr(folder.file("a.exr"));
    EXPECT_EQ(back.window, (PixelWindow{0, 0, 1, 1}));
    EXPECT_EQ(back.rgba, std::vector<float>(4, 0.0f));
}

TEST(Exr, OverscanGivesADataWindowBeyondTheFrame) {
    const test::TempFolder folder;
    const Image image = gradient({-4, -3, 36, 27});
    ExrOptions options = frameOptions();
    options.half = false;
    writeExr(folder.file("a.exr"), image, options);
    const Image back = readExr(folder.file("a.exr"));
    EXPECT_EQ(back.window, image.window);
    EXPECT_EQ(back.rgba, image.rgba);
    EXPECT_EQ(readExrAttributes(folder.file("a.exr")).at("dataWindow"), "-4 -3 36 27");
}

TEST(Exr, HalfClampsAndCountsWhatItCannotHold) {
    const test::TempFolder folder;
    const float infinity = std::numeric_limits<float>::infinity();
    const Image image{{0, 0, 2, 1}, {1e6f, -1e6f, infinity, 1, 65504, std::nanf(""), -65504, 1}};
    ExrOptions options = frameOptions();
    EXPECT_EQ(writeExr(folder.file("a.exr"), image, options), 3u);
    const Image back = readExr(folder.file("a.exr"));
    EXPECT_EQ(back.rgba[0], 65504.0f);
    EXPECT_EQ(back.rgba[1], -65504.0f);
    EXPECT_EQ(back.rgba[2], 65504.0f);
    EXPECT_TRUE(std::isnan(back.rgba[5]));
    options.half = false;
    EXPECT_EQ(writeExr(folder.file("a.exr"), image, options), 0u);
    EXPECT_EQ(readExr(folder.file("a.exr")).rgba[2], infinity);
}

TEST(Exr, LayersAreCroppedWithThePictureAndDepthStaysFloat) {
    const test::TempFolder folder;
    Image image = emptyImage({-2, -2, 6, 6});
    image.rgba[image.indexOf(1, 2) + 3] = 1.0f;
    image.rgba[image.indexOf(3, 4) + 3] = 1.0f;
    ExrLayer key{{"light.key.R", "light.key.G", "light.key.B"}, {}, false};
    ExrLayer depth{{"Z"}, {}, true};
    for (int y = -2; y < 6; ++y)
        for (int x = -2; x < 6; ++x) {
            for (int c = 0; c < 3; ++c) key.data.push_back(static_cast<float>(100 * c + 10 * y + x));
            depth.data.push_back(1e6f + 0.25f * static_cast<float>(10 * y + x));
        }
    EXPECT_EQ(writeExr(folder.file("a.exr"), image, frameOptions(), {}, {key, depth}), 0u);
    const std::string path = folder.file("a.exr");
    EXPECT_EQ(readExr(path).window, (PixelWindow{1, 2, 4, 5}));
    EXPECT_EQ(readExrAttributes(path).at("channels"),
              "A:half B:half G:half R:half Z:float light.key.B:half light.key.G:half light.key.R:half");
    const std::vector<float> green = readExrChannel(path, "light.key.G");
    const std::vector<float> z = readExrChannel(path, "Z");
    ASSERT_EQ(green.size(), 9u);
    std::size_t i = 0;
    for (int y = 2; y < 5; ++y)
        for (int x = 1; x < 4; ++x, ++i) {
            EXPECT_EQ(green[i], static_cast<float>(100 + 10 * y + x));
            EXPECT_EQ(z[i], 1e6f + 0.25f * static_cast<float>(10 * y + x));
        }
}

TEST(Exr, CarriesItsMetadata) {
    const test::TempFolder folder;
    ExrOptions options = frameOptions();
    options.colorInteropId = "lin_ap1_scene";
    options.pixelAspect = 2.0;
    const glm::dmat4 move = glm::translate(glm::dmat4(1), glm::dvec3(1, 2, 3));
    writeExr(folder.file("a.exr"), gradient(kFrame), options,
             {{"software", "Scrim"},
              {"worldToCamera", move},
              {"framesPerSecond", exactFrameRate(23.976)},
              {"scrim:error", 0.25},
              {"scrim:frame", 7}});
    const auto attributes = readExrAttributes(folder.file("a.exr"));
    EXPECT_EQ(attributes.at("software"), "Scrim");
    EXPECT_EQ(attributes.at("colorInteropID"), "lin_ap1_scene");
    EXPECT_EQ(attributes.at("framesPerSecond"), "24000/1001");
    EXPECT_EQ(attributes.at("scrim:error"), "0.25");
    EXPECT_EQ(attributes.at("scrim:frame"), "7");
    EXPECT_EQ(attributes.at("pixelAspectRatio"), "2");
    // EXR multiplies row vectors: the translation is the last row.
    EXPECT_EQ(attributes.at("worldToCamera"), "1 0 0 0 0 1 0 0 0 0 1 0 1 2 3 1");
    EXPECT_EQ(attributes.count("chromaticities"), 0u);
    EXPECT_EQ(attributes.count("acesImageContainerFlag"), 0u);
}

TEST(Exr, FrameRatesAreTheExactOnes) {
    EXPECT_EQ(exactFrameRate(24), (FrameRate{24, 1}));
    EXPECT_EQ(exactFrameRate(25), (FrameRate{25, 1}));
    EXPECT_EQ(exactFrameRate(29.97), (FrameRate{30000, 1001}));
}

TEST(Exr, AcesContainerFollowsTheStandard) {
    const test::TempFolder folder;
    ExrOptions options = frameOptions();
    options.acesContainer = true;
    options.colorInteropId = "lin_ap0_scene";
    options.chromaticities = findKnownSpace("ACES2065-1")->chromaticities;
    writeExr(folder.file("a.exr"), gradient(kFrame), options);
    const auto attributes = readExrAttributes(folder.file("a.exr"));
    EXPECT_EQ(attributes.at("acesImageContainerFlag"), "1");
    EXPECT_EQ(attributes.at("chromaticities"), "0.7347 0.2653 0 1 0.0001 -0.077 0.32168 0.33767");
    EXPECT_EQ(attributes.at("compression"), "none");
    EXPECT_EQ(attributes.at("channels"), "A:half B:half G:half R:half");
}

TEST(Exr, AcesContainerRefusesWhatTheStandardDoesNotAllow) {
    ExrOptions options = frameOptions();
    options.acesContainer = true;
    const Image image = gradient({0, 0, 1, 1});
    EXPECT_EQ(errorOf(ErrorKind::usage,
                      [&] {
                          writeExr("a.exr", image, options, {}, {{{"Z"}, {1}, true}});
                      }),
              "cannot write 'a.exr': an ACES container (SMPTE ST 2065-4) holds RGBA only; write layers in another "
              "colour space");
    options.half = false;
    EXPECT_EQ(errorOf(ErrorKind::usage, [&] { writeExr("a.exr", image, options); }),
              "cannot write 'a.exr': an ACES container (SMPTE ST 2065-4) holds half values only");
}

TEST(Exr, RefusesArgumentsThatDoNotFit) {
    const Image image = gradient({0, 0, 2, 1});
    ExrOptions options = frameOptions();
    const auto error = [&](const Image& picture, const std::vector<ExrLayer>& layers) {
        return errorOf(ErrorKind::usage, [&] { writeExr("a.exr", picture, options, {}, layers); });
    };
    EXPECT_EQ(error({}, {}), "cannot write 'a.exr': the picture has no pixels");
    EXPECT_EQ(error({{0, 0, 2, 1}, {1, 2}}, {}),
              "cannot write 'a.exr': the picture has 2 values, its window 2 x 1 x 4");
    EXPECT_EQ(error(image, {{{"R"}, {1, 1}, false}}),
              "cannot write 'a.exr': the channel name 'R' is empty or appears twice");
    EXPECT_EQ(error(image, {{{"Z"}, {1}, true}}),
              "cannot write 'a.exr': the layer with 'Z' has 1 values, expected 2 x 1 x 1");
    options.pixelAspect = 0;
    EXPECT_EQ(error(image, {}), "cannot write 'a.exr': the pixel aspect is 0; expected a number above 0");
    options.displayWindow = {};
    EXPECT_EQ(error(image, {}), "cannot write 'a.exr': the display window is empty");
}

TEST(Exr, UnknownCompressionListsTheChoicesAndLeavesNothing) {
    const test::TempFolder folder;
    ExrOptions options = frameOptions();
    options.compression = "rar";
    EXPECT_EQ(errorOf(ErrorKind::usage, [&] { writeExr(folder.file("a.exr"), gradient(kFrame), options); }),
              "unknown EXR compression 'rar'; expected 'zip', 'zips', 'piz', 'dwaa' or 'none'");
    EXPECT_EQ(folder.entryCount(), 0u);
}

TEST(Exr, ReservedAttributeOfAnotherTypeIsAnErrorThatLeavesNothing) {
    const test::TempFolder folder;
    const std::string text = errorOf(ErrorKind::output, [&] {
        writeExr(folder.file("a.exr"), gradient(kFrame), frameOptions(), {{"dataWindow", "everything"}});
    });
    EXPECT_EQ(text.rfind("cannot write '" + folder.file("a.exr") + "': ", 0), 0u) << text;
    EXPECT_EQ(folder.entryCount(), 0u);
}

TEST(Exr, AFullDiskKeepsTheOldFileAndSaysWhy) {
    const test::TempFolder folder;
    writeExr(folder.file("a.exr"), emptyImage(kFrame), frameOptions());
    ExrOptions options = frameOptions();
    options.compression = "none";
    for (const std::size_t limit : {100u, 2000u, 6000u}) {  // in the header, the pixels, the buffer flushed last
        const test::FileSizeLimit full(limit);
        EXPECT_EQ(errorOf(ErrorKind::output, [&] { writeExr(folder.file("a.exr"), gradient(kFrame), options); }),
                  "cannot write '" + folder.file("a.exr") + "': File too large; raise the limit (ulimit -f)");
    }
    EXPECT_EQ(readExr(folder.file("a.exr")).window, (PixelWindow{0, 0, 1, 1}));
    EXPECT_EQ(folder.entryCount(), 1u);
}

TEST(Exr, AFolderThatCannotBeMadeIsSaid) {
    EXPECT_EQ(errorOf(ErrorKind::output, [] { writeExr("/proc/no/a.exr", gradient(kFrame), frameOptions()); }),
              "cannot write '/proc/no/a.exr': cannot make the folder '/proc/no': No such file or directory");
}

TEST(Exr, ReadingSaysWhatIsWrong) {
    const test::TempFolder folder;
    std::ofstream(folder.file("text.exr")) << "not a picture";
    const std::string notExr = errorOf(ErrorKind::input, [&] { readExr(folder.file("text.exr")); });
    EXPECT_EQ(notExr.rfind("cannot read '" + folder.file("text.exr") + "': ", 0), 0u) << notExr;
    writeExr(folder.file("a.exr"), gradient(kFrame), frameOptions());
    EXPECT_EQ(errorOf(ErrorKind::input, [&] { readExrChannel(folder.file("a.exr"), "Z"); }),
              "'" + folder.file("a.exr") + "' has no channel 'Z'; it has A:half B:half G:half R:half");
}

TEST(Exr, TheThreadPoolDoesNotChangeTheFile) {
    const test::TempFolder folder;
    const Image image = gradient({0, 0, 300, 200});
    writeExr(folder.file("one.exr"), image, frameOptions());
    setExrThreads(2);
    writeExr(folder.file("two.exr"), image, frameOptions());
    setExrThreads(0);
    const auto bytes = [](const std::string& path) {
        std::ifstream in(path, std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(in), {});
    };
    EXPECT_EQ(bytes(folder.file("one.exr")), bytes(folder.file("two.exr")));
}

}  // namespace
}  // namespace scrim
