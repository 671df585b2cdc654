// SPDX-License-Identifier: Apache-2.0
// The file of a deep picture, as OpenImageIO reads it.
#include <scrim/image/exr_deep.h>

#include <scrim/base/error.h>
#include <scrim/image/whole_picture.h>

#include "support/expect_error.h"
#include "support/file_size_limit.h"
#include "support/temp_folder.h"

#include <OpenImageIO/deepdata.h>
#include <OpenImageIO/imagebuf.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace scrim {
namespace {

// Of 40 x 70 pixels at (-3, 5), with 0 to 4 pieces each but for an empty margin of two pixels.
DeepImage somePicture() {
    DeepImage image{{-3, 5, 37, 75}, {}};
    for (int y = image.window.y0; y < image.window.y1; ++y) {
        DeepImage::Row& row = image.rows.emplace_back();
        row.first.push_back(0);
        for (int x = image.window.x0; x < image.window.x1; ++x) {
            const bool margin = x < -1 || y < 7 || x >= 35 || y >= 73;
            const int count = margin ? 0 : (3 * x + 5 * y + 1000) % 5;
            float alpha = 0;
            for (int i = 0; i < count; ++i) {
                alpha += (1 - alpha) * 0.1f * static_cast<float>(1 + (x + y + i + 100) % 3);
                const float z = 2 + 0.1f * static_cast<float>(i);
                row.pieces.push_back({z, z + 0.05f, {alpha / 2, alpha / 3, alpha / 4, alpha}});
            }
            row.first.push_back(static_cast<std::uint32_t>(row.pieces.size()));
        }
    }
    return image;
}

ExrOptions someOptions(bool half) {
    ExrOptions options;
    options.half = half;
    options.compression = "piz";
    options.displayWindow = {0, 0, 32, 64};
    options.pixelAspect = 2;
    options.colorInteropId = "lin_ap1_scene";
    return options;
}

class ExrDeep : public testing::TestWithParam<bool> {};

TEST_P(ExrDeep, HoldsEverySampleOfEveryPixel) {
    const test::TempFolder folder;
    const DeepImage image = somePicture();
    EXPECT_EQ(writeDeepExr(folder.file("d.exr"), image, someOptions(GetParam())), 0u);
    OIIO::ImageBuf file(folder.file("d.exr"));
    ASSERT_TRUE(file.read(0, 0, true)) << file.geterror();
    ASSERT_TRUE(file.deep());
    const OIIO::DeepData& deep = *file.deepdata();
    const std::vector<std::string> names{"R", "G", "B", "A", "Z", "ZBack"};
    EXPECT_EQ(file.spec().channelnames, names);
    EXPECT_EQ(deep.channeltype(0), GetParam() ? OIIO::TypeHalf : OIIO::TypeFloat);
    EXPECT_EQ(deep.channeltype(4), OIIO::TypeFloat);
    EXPECT_EQ(deep.channeltype(5), OIIO::TypeFloat);
    EXPECT_EQ(file.spec().x, -1);
    EXPECT_EQ(file.spec().y, 7);
    std::size_t clamped = 0, count = 0;
    for (int y = image.window.y0; y < image.window.y1; ++y)
        for (int x = image.window.x0; x < image.window.x1; ++x) {
            const auto samples = deepSamples(image.curve(x, y), GetParam(), clamped);
            const auto pixel = file.pixelindex(x, y, 0, true);
            ASSERT_EQ(pixel < 0 ? 0 : deep.samples(pixel), static_cast<int>(samples.size())) << x << ' ' << y;
            for (std::size_t s = 0; s < samples.size(); ++s, ++count) {
                const int at = static_cast<int>(s);
                for (int c = 0; c < 4; ++c) ASSERT_EQ(deep.deep_value(pixel, c, at), samples[s].rgba[std::size_t(c)]);
                ASSERT_EQ(deep.deep_value(pixel, 4, at), samples[s].z);
                ASSERT_EQ(deep.deep_value(pixel, 5, at), samples[s].zBack);
            }
        }
    EXPECT_EQ(count, image.pieceCount());
}

TEST_P(ExrDeep, IsAScanlineFileThatSaysWhatItIs) {
    const test::TempFolder folder;
    writeDeepExr(folder.file("d.exr"), somePicture(), someOptions(GetParam()), {{"software", "scrim"}});
    OIIO::ImageBuf file(folder.file("d.exr"));
    ASSERT_TRUE(file.init_spec(folder.file("d.exr"), 0, 0));
    const OIIO::ImageSpec& spec = file.spec();
    EXPECT_EQ(spec.tile_width, 0);
    EXPECT_EQ(spec.get_string_attribute("compression"), "zips");
    EXPECT_EQ(spec.get_string_attribute("software"), "scrim");
    EXPECT_EQ(spec.get_string_attribute("colorInteropID"), "lin_ap1_scene");
    EXPECT_EQ(spec.get_float_attribute("PixelAspectRatio"), 2);
    EXPECT_EQ(spec.full_width, 32);
    // An enumeration of one byte in the file: 2 or 3 are tidy, and OpenImageIO has no type for it.
    std::ifstream stream(folder.file("d.exr"), std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(stream)), {});
    const std::string name("deepImageState\0deepImageState\0\1\0\0\0", 34);
    const auto at = bytes.find(name);
    ASSERT_NE(at, std::string::npos);
    EXPECT_EQ(bytes[at + name.size()], 3) << "OpenEXR's DIS_TIDY";
}

TEST_P(ExrDeep, IsWholeOrIsNot) {
    const test::TempFolder folder;
    const std::string path = folder.file("d.exr");
    writeDeepExr(path, somePicture(), someOptions(GetParam()));
    EXPECT_TRUE(isWholeExr(path));
    const auto size = std::filesystem::file_size(path);
    for (const auto less : {std::uintmax_t{1}, size / 3, size - 100}) {
        std::filesystem::resize_file(path, size - less);
        EXPECT_FALSE(isWholeExr(path)) << less;
        writeDeepExr(path, somePicture(), someOptions(GetParam()));
    }
}

TEST_P(ExrDeep, OfNothingIsOneEmptyPixel) {
    const test::TempFolder folder;
    DeepImage image{{4, 6, 8, 9}, std::vector<DeepImage::Row>(3)};
    for (DeepImage::Row& row : image.rows) row.first.assign(5, 0);
    writeDeepExr(folder.file("d.exr"), image, someOptions(GetParam()));
    OIIO::ImageBuf file(folder.file("d.exr"));
    ASSERT_TRUE(file.read(0, 0, true)) << file.geterror();
    EXPECT_EQ(file.spec().x, 4);
    EXPECT_EQ(file.spec().y, 6);
    EXPECT_EQ(file.spec().width * file.spec().height, 1);
    EXPECT_EQ(file.deepdata()->samples(0), 0);
    EXPECT_TRUE(isWholeExr(folder.file("d.exr")));
}

INSTANTIATE_TEST_SUITE_P(Types, ExrDeep, testing::Values(true, false),
                         [](const auto& one) { return one.param ? "half" : "single"; });

TEST(ExrDeepErrors, AreToldAndLeaveNoFile) {
    const test::TempFolder folder;
    const std::string path = folder.file("d.exr");
    EXPECT_EQ(test::errorOf(ErrorKind::usage, [&] { writeDeepExr(path, {}, someOptions(true)); }),
              "cannot write '" + path + "': the deep picture has no pixels");
    const test::FileSizeLimit limit(2000);
    EXPECT_EQ(test::errorOf(ErrorKind::output, [&] { writeDeepExr(path, somePicture(), someOptions(true)); }),
              "cannot write '" + path + "': File too large; raise the limit (ulimit -f)");
    EXPECT_EQ(folder.entryCount(), 0u);
}

}  // namespace
}  // namespace scrim
