// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/preview.h>

#include <scrim/base/error.h>

#include "support/file_size_limit.h"
#include "support/temp_folder.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>

namespace scrim {
namespace {

constexpr PixelWindow kFrame{0, 0, 4, 3};

ColourConfig ownConfig() {
    ::unsetenv("OCIO");
    return ColourConfig::open("");
}

struct Picture {
    int width = 0;
    int height = 0;
    int channels = 0;
    std::vector<unsigned char> bytes;

    std::vector<int> at(int x, int y) const {
        std::vector<int> pixel;
        for (int c = 0; c < channels; ++c)
            pixel.push_back(bytes[static_cast<std::size_t>((y * width + x) * channels + c)]);
        return pixel;
    }
};

Picture readPicture(const std::string& path) {
    Picture picture;
    const auto in = OIIO::ImageInput::open(path);
    if (!in) return picture;
    const OIIO::ImageSpec& spec = in->spec();
    picture.width = spec.width;
    picture.height = spec.height;
    picture.channels = spec.nchannels;
    picture.bytes.resize(spec.image_pixels() * static_cast<std::size_t>(spec.nchannels));
    in->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT8, picture.bytes.data());
    return picture;
}

std::string errorOf(ErrorKind kind, const std::string& path, const PixelWindow& window, const std::string& view) {
    try {
        writePreview(path, emptyImage(kFrame), window, ownConfig(), {"", view});
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), kind);
        return error.what();
    }
    return "no error";
}

TEST(Preview, ClampsAndCompositesOverBlack) {
    const test::TempFolder folder;
    Image image = emptyImage(kFrame);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float pixels[] = {2, -1, nan, 1, 0.5f, 0.25f, 0, 0.5f};
    std::copy(std::begin(pixels), std::end(pixels), image.rgba.begin());
    writePreview(folder.file("a.png"), image, kFrame, ownConfig(), {"sRGB", "Raw"});
    const Picture picture = readPicture(folder.file("a.png"));
    ASSERT_EQ(picture.channels, 3) << "opaque";
    EXPECT_EQ(picture.at(0, 0), (std::vector<int>{255, 0, 0}));
    EXPECT_EQ(picture.at(1, 0), (std::vector<int>{128, 64, 0})) << "premultiplied colour is not divided by alpha";
    EXPECT_EQ(picture.at(3, 2), (std::vector<int>{0, 0, 0}));
    EXPECT_EQ(folder.entryCount(), 1u);
}

TEST(Preview, ShowsTheWholeFrameAndNoOverscan) {
    const test::TempFolder folder;
    Image image = emptyImage({-1, 1, 2, 7});
    for (float& value : image.rgba) value = 1.0f;
    writePreview(folder.file("a.png"), image, kFrame, ownConfig(), {"", "Raw"});
    const Picture picture = readPicture(folder.file("a.png"));
    ASSERT_EQ(picture.width, 4);
    ASSERT_EQ(picture.height, 3);
    EXPECT_EQ(picture.at(0, 0), (std::vector<int>{0, 0, 0}));
    EXPECT_EQ(picture.at(1, 1), (std::vector<int>{255, 255, 255}));
    EXPECT_EQ(picture.at(2, 2), (std::vector<int>{0, 0, 0}));
}

TEST(Preview, UsesTheConfigsDefaultView) {
    const test::TempFolder folder;
    Image image = emptyImage(kFrame);
    for (float& value : image.rgba) value = 0.18f;
    writePreview(folder.file("a.png"), image, kFrame, ownConfig(), {"", ""});
    for (const int byte : readPicture(folder.file("a.png")).at(2, 1)) EXPECT_NEAR(byte, 0.356 * 255, 1);
}

TEST(Preview, WritesJpegByExtension) {
    const test::TempFolder folder;
    writePreview(folder.file("a.jpg"), emptyImage(kFrame), kFrame, ownConfig(), {"", ""});
    const Picture picture = readPicture(folder.file("a.jpg"));
    EXPECT_EQ(picture.width, 4);
    EXPECT_EQ(picture.channels, 3);
}

TEST(Preview, SaysWhatIsWrongAndLeavesNothing) {
    const test::TempFolder folder;
    for (const char* name : {"a", "a.zzz", "a.png.tmp"})
        EXPECT_EQ(errorOf(ErrorKind::output, folder.file(name), kFrame, ""),
                  "cannot write '" + folder.file(name) +
                      "': its extension must name a picture format, such as '.png' or '.jpg'");
    EXPECT_EQ(errorOf(ErrorKind::output, "/proc/no/a.png", kFrame, ""),
              "cannot write '/proc/no/a.png': cannot make the folder '/proc/no': No such file or directory");
    EXPECT_EQ(errorOf(ErrorKind::usage, "a.png", {}, ""), "cannot write 'a.png': the display window is empty");
    EXPECT_EQ(errorOf(ErrorKind::input, folder.file("a.png"), kFrame, "Film"),
              "unknown view 'Film' of display 'sRGB' in the OpenColorIO config 'scrim-aces'; expected 'ACES 1.0 "
              "SDR', 'Un-tone-mapped' or 'Raw'");
    EXPECT_EQ(folder.entryCount(), 0u);
}

TEST(Preview, AFullDiskLeavesNothing) {
    const test::TempFolder folder;
    Image noise = emptyImage({0, 0, 200, 200});
    unsigned state = 1;
    for (float& value : noise.rgba)
        value = static_cast<float>((state = state * 1664525u + 1013904223u) >> 8) * 0x1p-24f;
    for (const char* name : {"a.png", "a.jpg"})
        for (const std::size_t limit : {10u, 3000u, 20000u}) {
            const test::FileSizeLimit full(limit);
            try {
                writePreview(folder.file(name), noise, noise.window, ownConfig(), {"", "Raw"});
                FAIL() << "no error with " << name << " and " << limit;
            } catch (const Error& error) {
                EXPECT_EQ(std::string(error.what()),
                          "cannot write '" + folder.file(name) + "': File too large; raise the limit (ulimit -f)");
            }
            EXPECT_EQ(folder.entryCount(), 0u);
        }
}

}  // namespace
}  // namespace scrim
