// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/whole_picture.h>

#include <scrim/image/exr.h>
#include <scrim/image/preview.h>

#include "support/temp_folder.h"
#include "support/vdb_make.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDeepFrameBuffer.h>
#include <OpenEXR/ImfDeepScanLineOutputFile.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfTiledOutputFile.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <vector>

namespace scrim::test {
namespace {

constexpr int kWidth = 40, kHeight = 50;

class WholePicture : public ::testing::Test {
  protected:
    std::string file(const std::string& name) const { return m_folder.file(name); }

    std::string scanlines(const std::string& compression) const {
        Image image = emptyImage({-3, -5, kWidth - 3, kHeight - 5});
        for (std::size_t i = 0; i < image.rgba.size(); ++i) image.rgba[i] = 0.1f + 0.01f * static_cast<float>(i % 97);
        ExrOptions options;
        options.compression = compression;
        options.displayWindow = image.window;
        writeExr(file("scanlines.exr"), image, options);
        return file("scanlines.exr");
    }

    Imf::Header header() const {
        Imf::Header header(kWidth, kHeight);
        header.channels().insert("R", Imf::Channel(Imf::FLOAT));
        return header;
    }
    Imf::FrameBuffer buffer() const {
        Imf::FrameBuffer frame;
        frame.insert("R", Imf::Slice::Make(Imf::FLOAT, m_values.data(), header().dataWindow()));
        return frame;
    }

    std::string tiles() const {
        Imf::Header tiled = header();
        tiled.setTileDescription({16, 16, Imf::MIPMAP_LEVELS});
        Imf::TiledOutputFile out(file("tiles.exr").c_str(), tiled);
        out.setFrameBuffer(buffer());
        for (int level = 0; level < out.numLevels(); ++level)
            out.writeTiles(0, out.numXTiles(level) - 1, 0, out.numYTiles(level) - 1, level);
        return file("tiles.exr");
    }

    std::string parts() const {
        std::array<Imf::Header, 2> headers{header(), header()};
        for (std::size_t i = 0; i < headers.size(); ++i) {
            headers[i].setName(i == 0 ? "one" : "two");
            headers[i].setType(Imf::SCANLINEIMAGE);
        }
        Imf::MultiPartOutputFile out(file("parts.exr").c_str(), headers.data(), 2);
        for (int i = 0; i < 2; ++i) {
            Imf::OutputPart part(out, i);
            part.setFrameBuffer(buffer());
            part.writePixels(kHeight);
        }
        return file("parts.exr");
    }

    std::string deep() const {
        Imf::Header samples = header();
        samples.setType(Imf::DEEPSCANLINE);
        samples.compression() = Imf::ZIPS_COMPRESSION;
        std::vector<unsigned> counts(std::size_t{kWidth} * kHeight, 1);
        std::vector<const float*> pointers;
        for (const float& value : m_values) pointers.push_back(&value);
        Imf::DeepFrameBuffer frame;
        frame.insertSampleCountSlice(
            Imf::Slice(Imf::UINT, reinterpret_cast<char*>(counts.data()), sizeof(unsigned), sizeof(unsigned) * kWidth));
        frame.insert("R", Imf::DeepSlice(Imf::FLOAT, reinterpret_cast<char*>(pointers.data()), sizeof(float*),
                                         sizeof(float*) * kWidth, sizeof(float)));
        Imf::DeepScanLineOutputFile out(file("deep.exr").c_str(), samples);
        out.setFrameBuffer(frame);
        out.writePixels(kHeight);
        return file("deep.exr");
    }

    /// Whole as it is; cut anywhere it is not.
    void expectWholeOnlyWhole(const std::string& path) const {
        EXPECT_TRUE(isWholePicture(path).value_or(false)) << path;
        const std::string bytes = readBytes(path);
        for (std::size_t size = 0; size < bytes.size(); size += std::max<std::size_t>(bytes.size() / 301, 1)) {
            writeBytes(file("cut"), bytes.substr(0, size));
            EXPECT_FALSE(isWholePicture(file("cut")).value_or(false)) << path << " cut after " << size << " bytes";
        }
        writeBytes(file("cut"), bytes.substr(0, bytes.size() - 1));
        EXPECT_FALSE(isWholePicture(file("cut")).value_or(false)) << path << " without its last byte";
    }

    TempFolder m_folder;
    std::vector<float> m_values = std::vector<float>(std::size_t{kWidth} * kHeight, 0.5f);
};

TEST_F(WholePicture, IsTheOnlyOneOfEveryCompression) {
    for (const std::string& compression : exrCompressions()) expectWholeOnlyWhole(scanlines(compression));
}

TEST_F(WholePicture, IsTheOnlyOneOfEveryKindOfExr) {
    for (const std::string& path : {tiles(), parts(), deep()}) {
        EXPECT_TRUE(isWholeExr(path));
        expectWholeOnlyWhole(path);
    }
}

TEST_F(WholePicture, IsTheOnlyOneOfPreviews) {
    const DisplayImage picture{{0, 0, 8, 8}, std::vector<std::uint8_t>(256, 100)};
    for (const char* name : {"a.png", "a.jpg"}) {
        const std::vector<unsigned char> bytes = pictureBytes(name, picture);
        writeBytes(file(name), {bytes.begin(), bytes.end()});
        expectWholeOnlyWhole(file(name));
        EXPECT_FALSE(isWholeExr(file(name)));
    }
}

TEST_F(WholePicture, HasNoZerosWhereItsPiecesBegin) {
    std::string bytes = readBytes(scanlines("none"));
    std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 2), bytes.end(), '\0');
    writeBytes(file("zeros"), bytes);
    EXPECT_FALSE(isWholeExr(file("zeros")));
}

TEST_F(WholePicture, IsNotToldOfWhatIsNone) {
    writeBytes(file("text"), "some text that is no picture");
    EXPECT_FALSE(isWholePicture(file("text")).has_value());
    EXPECT_FALSE(isWholeExr(file("text")));
    EXPECT_FALSE(isWholeExr(file("missing")));
    EXPECT_FALSE(isWholeExr("/dev/zero"));
    EXPECT_FALSE(isWholeExr(m_folder.path()));
}

// Whatever a byte says, nothing is read that is not there, and it comes to an end.
TEST_F(WholePicture, MayHaveAnyByteDamaged) {
    for (const std::string& path : {scanlines("zip"), tiles(), parts(), deep()}) {
        const std::string sound = readBytes(path);
        const std::size_t head = std::min<std::size_t>(sound.size(), 900);
        for (std::size_t i = 0; i < head; ++i) {
            std::string bytes = sound;
            bytes[i] = static_cast<char>(bytes[i] ^ (i % 2 == 0 ? 0x80 : 0xff));
            writeBytes(file("damaged"), bytes);
            const bool whole = isWholeExr(file("damaged"));
            EXPECT_TRUE(i >= 4 || !whole) << i;
        }
    }
}

}  // namespace
}  // namespace scrim::test
