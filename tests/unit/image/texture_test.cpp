// SPDX-License-Identifier: Apache-2.0
// Pictures read as textures: pixels, alpha, colour, and their pyramid.
#include "support/expect_error.h"
#include "support/temp_folder.h"
#include "unit/scene/read_scene.h"

#include <scrim/image/backplate.h>
#include <scrim/image/texture.h>

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include <sys/stat.h>

namespace scrim::test {
namespace {

// Writes a picture of floats, which OpenImageIO turns into `spec`'s format.
void write(const std::string& path, OIIO::ImageSpec spec, const std::vector<float>& pixels) {
    const auto out = OIIO::ImageOutput::create(path);
    ASSERT_TRUE(out) << path;
    ASSERT_TRUE(out->open(path, spec)) << out->geterror();
    ASSERT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, pixels.data())) << out->geterror();
    ASSERT_TRUE(out->close());
}
OIIO::ImageSpec specOf(int width, int height, int channels, OIIO::TypeDesc type) {
    return {width, height, channels, type};
}

std::shared_ptr<const Texture> load(const std::string& path, const std::string& space = "",
                                    std::vector<std::string>* said = nullptr) {
    return readTexture(path, space, ownColours(), [said](Severity, const std::string& text) {
        if (said) said->push_back(text);
    });
}
std::vector<float> pixel(const Texture& texture, int x, int y) {
    const float* p = texture.levels().front().pixel(x, y);
    return {p, p + 4};
}

// The sRGB curve; grey keeps its chromaticity.
double linear(double encoded) {
    return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

TEST(Texture, IntegersAreTakenForSrgb) {
    const TempFolder folder;
    for (const auto& [type, steps] :
         {std::pair{OIIO::TypeDesc(OIIO::TypeDesc::UINT8), 255.0}, {OIIO::TypeDesc(OIIO::TypeDesc::UINT16), 65535.0}}) {
        write(folder.file("grey.png"), specOf(2, 1, 3, type), {0.5f, 0.5f, 0.5f, 1, 1, 1});
        const auto texture = load(folder.file("grey.png"));
        const double stored = std::round(0.5 * steps) / steps;  // 0.5 -> 0.2140
        for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(pixel(*texture, 0, 0)[c], linear(stored), 1e-4);
        EXPECT_NEAR(pixel(*texture, 0, 0)[0], 0.2140, 2.1e-3);  // 0.5 lies between two steps of 8 bits
        EXPECT_NEAR(pixel(*texture, 1, 0)[1], 1, 1e-4);
    }
}

TEST(Texture, FloatsAreInTheWorkingSpaceUnlessToldOtherwise) {
    const TempFolder folder;
    write(folder.file("a.exr"), specOf(1, 1, 3, OIIO::TypeDesc::FLOAT), {0.5f, 3, 0.125f});
    EXPECT_EQ(pixel(*load(folder.file("a.exr")), 0, 0), (std::vector<float>{0.5f, 3, 0.125f, 1}));
    const Rgb expected = ownColours().toWorking({0.5, 3, 0.125}, "sRGB");
    const auto found = pixel(*load(folder.file("a.exr"), "sRGB"), 0, 0);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[static_cast<std::size_t>(c)], expected[c], 1e-4);
}

TEST(Texture, RowsGoDownAndColumnsRight) {
    const TempFolder folder;
    write(folder.file("a.exr"), specOf(3, 2, 1, OIIO::TypeDesc::HALF), {0, 1, 2, 3, 4, 5});
    const auto texture = load(folder.file("a.exr"));
    EXPECT_EQ(texture->width(), 3);
    EXPECT_EQ(texture->height(), 2);
    EXPECT_EQ(texture->aspect(), 1.5);
    EXPECT_EQ(pixel(*texture, 2, 0), (std::vector<float>{2, 2, 2, 1}));
    EXPECT_EQ(pixel(*texture, 0, 1), (std::vector<float>{3, 3, 3, 1}));
}

TEST(Texture, OrientationTagsAndPixelAspectAreHeeded) {
    const TempFolder folder;
    OIIO::ImageSpec spec = specOf(2, 1, 3, OIIO::TypeDesc::UINT8);
    spec.attribute("Orientation", 6);  // to be turned clockwise for display
    write(folder.file("a.tif"), spec, {1, 1, 1, 0, 0, 0});
    const auto turned = load(folder.file("a.tif"));
    ASSERT_EQ(turned->width(), 1);
    ASSERT_EQ(turned->height(), 2);
    EXPECT_NEAR(pixel(*turned, 0, 0)[0], 1, 1e-4);  // left becomes top
    EXPECT_EQ(pixel(*turned, 0, 1)[0], 0);

    spec = specOf(2, 2, 3, OIIO::TypeDesc::HALF);
    spec.attribute("PixelAspectRatio", 2.0f);
    write(folder.file("a.exr"), spec, std::vector<float>(12, 1.0f));
    EXPECT_EQ(load(folder.file("a.exr"))->aspect(), 2);
}

TEST(Texture, CoversTheDisplayWindowOfACroppedFile) {
    const TempFolder folder;
    OIIO::ImageSpec spec = specOf(1, 1, 3, OIIO::TypeDesc::HALF);
    spec.x = 2;
    spec.y = 1;
    spec.full_width = 4;
    spec.full_height = 3;
    write(folder.file("a.exr"), spec, {1, 2, 4});
    const auto texture = load(folder.file("a.exr"));
    EXPECT_EQ(texture->width(), 4);
    EXPECT_EQ(texture->height(), 3);
    EXPECT_EQ(pixel(*texture, 2, 1)[2], 4);
    EXPECT_EQ(pixel(*texture, 1, 1)[2], 0);
}

// PNG keeps colour and alpha apart: colour is decoded first, then multiplied; transparent is black.
TEST(Texture, AlphaMultipliesTheDecodedColour) {
    const TempFolder folder;
    OIIO::ImageSpec spec = specOf(3, 1, 4, OIIO::TypeDesc::UINT16);
    spec.attribute("oiio:UnassociatedAlpha", 1);
    write(folder.file("a.png"), spec, {0.5f, 0.5f, 0.5f, 0.25f, 1, 1, 1, 0, 1, 1, 1, 1});
    const auto texture = load(folder.file("a.png"));
    EXPECT_NEAR(pixel(*texture, 0, 0)[0], 0.25 * linear(0.5), 1e-4);
    EXPECT_EQ(pixel(*texture, 1, 0)[0], 0);
    EXPECT_NEAR(pixel(*texture, 2, 0)[0], 1, 1e-4);
    // EXR holds them multiplied, and may shine where it is transparent.
    write(folder.file("a.exr"), specOf(2, 1, 4, OIIO::TypeDesc::FLOAT), {0.1f, 0.2f, 0.3f, 0.5f, 7, 7, 7, 0});
    const auto multiplied = load(folder.file("a.exr"));
    EXPECT_EQ(pixel(*multiplied, 0, 0), (std::vector<float>{0.1f, 0.2f, 0.3f, 0.5f}));
    EXPECT_EQ(pixel(*multiplied, 1, 0)[0], 7);
    EXPECT_NEAR(pixel(*load(folder.file("a.exr"), "sRGB"), 0, 0)[1],
                0.5 * ownColours().toWorking({0.2, 0.4, 0.6}, "sRGB").y, 1e-4);
}

TEST(Texture, WhatIsNoLightCountsAsNoneAndIsReported) {
    const TempFolder folder;
    const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    write(folder.file("a.exr"), specOf(2, 1, 3, OIIO::TypeDesc::FLOAT), {nan, -1, 2, inf, -inf, 3});
    std::vector<std::string> said;
    const auto texture = load(folder.file("a.exr"), "", &said);
    EXPECT_EQ(pixel(*texture, 0, 0), (std::vector<float>{0, 0, 2, 1}));
    EXPECT_EQ(pixel(*texture, 1, 0), (std::vector<float>{0, 0, 3, 1}));
    ASSERT_EQ(said.size(), 1u);
    EXPECT_EQ(said[0], folder.file("a.exr") + ": 4 values that are not finite or less than 0 count as 0");
}

TEST(Texture, FilesThatAreNoPicturesAreErrors) {
    const TempFolder folder;
    const auto error = [&](const std::string& name) {
        return errorOf(ErrorKind::input, [&] { load(folder.file(name)); });
    };
    EXPECT_EQ(error("none.png"), "there is no file '" + folder.file("none.png") + "'");
    EXPECT_EQ(errorOf(ErrorKind::input, [&] { load(folder.path()); }),
              "cannot read '" + folder.path() + "': it is not a regular file; expected a picture");
    ASSERT_EQ(::mkfifo(folder.file("pipe.png").c_str(), 0600), 0);
    EXPECT_NE(error("pipe.png").find("not a regular file"), std::string::npos);
    std::ofstream(folder.file("text.png")) << "This is not a picture.";
    EXPECT_EQ(error("text.png").find("cannot read '" + folder.file("text.png") + "': "), 0u);
    std::ofstream(folder.file("empty.exr")) << "";
    EXPECT_EQ(error("empty.exr").find("cannot read '" + folder.file("empty.exr") + "': "), 0u);
}

TEST(Texture, TruncatedFilesAreErrors) {
    const TempFolder folder;
    for (const char* name : {"a.exr", "a.png", "a.tif"}) {
        const std::string path = folder.file(name);
        std::vector<float> noise(64 * 64 * 3);
        for (std::size_t i = 0; i < noise.size(); ++i) noise[i] = static_cast<float>(i * 7919 % 1000) / 1000;
        write(path, specOf(64, 64, 3, std::string(name) == "a.exr" ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::UINT8),
              noise);
        std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
        EXPECT_EQ(errorOf(ErrorKind::input, [&] { load(path); }).find("cannot read '" + path + "': "), 0u);
    }
}

// A header that claims a picture of 60000 x 60000 pixels.
TEST(Texture, TooLargeIsAnErrorBeforeAnythingIsRead) {
    const TempFolder folder;
    std::ofstream(folder.file("huge.ppm"), std::ios::binary) << "P6\n60000 60000\n255\nxxx";
    EXPECT_EQ(errorOf(ErrorKind::input, [&] { load(folder.file("huge.ppm")); }),
              "cannot read '" + folder.file("huge.ppm") +
                  "': it has 60000 x 60000 pixels of 3 channels; expected at most 50 million pixels of 64");
}

TEST(TexturePyramid, KeepsTheMeanAtEveryLevelForAnySize) {
    for (const auto& [width, height] : {std::pair{64, 64}, {37, 5}, {1, 9}, {3, 2}, {255, 129}, {1, 1}}) {
        Image image = emptyImage({0, 0, width, height});
        for (std::size_t i = 0; i < image.rgba.size(); ++i) image.rgba[i] = static_cast<float>(i * 7919 % 101);
        const Texture texture(image);
        const auto mean = [](const Texture::Level& level) {
            double sum = 0;
            for (std::size_t i = 0; i < level.rgba.size(); i += 4) sum += level.rgba[i];
            return sum / (level.width * level.height);
        };
        const double expected = mean(texture.levels().front());
        for (const Texture::Level& level : texture.levels()) EXPECT_NEAR(mean(level), expected, 1e-4 * expected);
        EXPECT_EQ(texture.levels().back().width, 1);
        EXPECT_EQ(texture.levels().back().height, 1);
    }
}

TEST(TexturePyramid, OfThreePixelsCutsTheMiddleOne) {
    Image image = emptyImage({0, 0, 3, 1});
    for (std::size_t x = 0; x < 3; ++x) image.rgba[4 * x] = static_cast<float>(x == 1 ? 6 : 3 * x);
    const Texture texture(image);  // 0, 6, 6
    ASSERT_EQ(texture.levels()[1].width, 2);
    EXPECT_NEAR(texture.levels()[1].rgba[0], 2, 1e-6);  // (0 + 6 / 2) / 1.5
    EXPECT_NEAR(texture.levels()[1].rgba[4], 6, 1e-6);
}

// A plate of 2 x 1 pixels, black and white, behind a grey of half the alpha: a ramp between the middles of its pixels.
TEST(Backplate, IsStretchedBehindThePicture) {
    Image plate = emptyImage({0, 0, 2, 1});
    plate.rgba = {0, 0, 0, 1, 1, 1, 1, 1};
    Image picture = emptyImage({1, 0, 3, 1});
    picture.rgba = {0.25f, 0.25f, 0.25f, 0.5f, 0, 0, 0, 0};
    const Image over = overPlate(picture, Texture(plate), {0, 0, 4, 2});
    const float expected[] = {0, 0.25f + 0.5f * 0.25f, 0.75f, 1};
    for (int x = 0; x < 4; ++x) {
        EXPECT_FLOAT_EQ(over.rgba[over.indexOf(x, 0) + 1], expected[x]) << x;
        EXPECT_FLOAT_EQ(over.rgba[over.indexOf(x, 0) + 3], 1) << x;
    }
    EXPECT_FLOAT_EQ(over.rgba[over.indexOf(2, 1)], 0.75f);
}

}  // namespace
}  // namespace scrim::test
