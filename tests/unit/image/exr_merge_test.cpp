// SPDX-License-Identifier: Apache-2.0
// Crops put together are the file of the whole, byte by byte; what does not fit together is told.
#include <scrim/image/exr_merge.h>

#include <scrim/base/error.h>
#include <scrim/image/exr_deep.h>
#include <scrim/image/exr_read.h>

#include "support/expect_error.h"
#include "support/file_size_limit.h"
#include "support/temp_folder.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>

namespace scrim {
namespace {

constexpr PixelWindow kWhole{-2, -1, 70, 150};  // with overscan, and of more rows than are read at a time
constexpr PixelWindow kDisplay{0, 0, 68, 149};

std::string bytesOf(const std::string& path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

ExrOptions options() {
    ExrOptions out;
    out.displayWindow = kDisplay;
    out.colorInteropId = "lin_ap1_scene";
    return out;
}

ExrAttributes attributesOf(const PixelWindow& crop) {
    ExrAttributes out{{"software", "scrim"}, {"imageCounter", 7}, {"worldToCamera", glm::dmat4(2)}};
    if (crop != kWhole)
        out.emplace_back("scrim:crop", fmt::format("{},{},{},{} of {},{},{},{}", crop.x0, crop.y0, crop.x1, crop.y1,
                                                   kWhole.x0, kWhole.y0, kWhole.x1, kWhole.y1));
    return out;
}

/// Empty in a margin and in all of the upper left, with values that half floats round to 0.
float valueAt(int x, int y, int c) {
    if (x < 5 || x > 60 || y > 130 || (x < 40 && y < 70)) return 0;
    if (x == 60 || y == 130) return 1e-12f;
    return 0.01f * static_cast<float>((x * 7 + y * 13 + c * 5) % 101) + 0.001f;
}

/// Writes the part of the picture that is in `crop`, with layers of both types.
void writeFlat(const std::string& path, const PixelWindow& crop, const ExrOptions& how = options(), float more = 0) {
    Image image = emptyImage(crop);
    ExrLayer key{{"light.key.R", "light.key.G", "light.key.B"}, {}}, depth{{"Z"}, {}, true};
    for (int y = crop.y0; y < crop.y1; ++y)
        for (int x = crop.x0; x < crop.x1; ++x) {
            for (int c = 0; c < 4; ++c) image.rgba[image.indexOf(x, y) + std::size_t(c)] = valueAt(x, y, c);
            for (int c = 4; c < 7; ++c) key.data.push_back(valueAt(x, y, c));
            depth.data.push_back(valueAt(x, y, 8) + (valueAt(x, y, 8) > 0 ? more : 0));
        }
    writeExr(path, image, how, attributesOf(crop), {key, depth});
}

void writeDeep(const std::string& path, const PixelWindow& crop) {
    DeepImage image{crop, {}};
    for (int y = crop.y0; y < crop.y1; ++y) {
        DeepImage::Row& row = image.rows.emplace_back();
        row.first.push_back(0);
        for (int x = crop.x0; x < crop.x1; ++x) {
            float alpha = 0;
            const int count = valueAt(x, y, 0) == 0 ? 0 : (3 * x + 5 * y) % 4;
            for (int i = 0; i < count; ++i) {
                alpha += (1 - alpha) * 0.2f;
                const float z = 2 + 0.1f * static_cast<float>(i + x);
                row.pieces.push_back({z, z + 0.05f, {alpha / 2, alpha / 3, alpha / 4, alpha}});
            }
            row.first.push_back(static_cast<std::uint32_t>(row.pieces.size()));
        }
    }
    writeDeepExr(path, image, options(), attributesOf(crop));
}

const std::vector<PixelWindow> kTiles{{-2, -1, 33, 67}, {33, -1, 70, 67}, {-2, 67, 33, 150}, {33, 67, 70, 150}};

class ExrMerge : public testing::Test {
  protected:
    std::string file(const std::string& name) const { return m_folder.file(name); }

    /// Writes tiles as `write` does, and names them.
    template <typename Write>
    std::vector<std::string> tiles(const std::vector<PixelWindow>& crops, const Write& write) const {
        std::vector<std::string> paths;
        for (const PixelWindow& crop : crops) {
            paths.push_back(file(fmt::format("tile{}.exr", paths.size())));
            write(paths.back(), crop);
        }
        return paths;
    }
    std::vector<std::string> flatTiles(const std::vector<PixelWindow>& crops = kTiles) const {
        return tiles(crops, [](const std::string& path, const PixelWindow& crop) { writeFlat(path, crop); });
    }
    std::string errorOfMerging(const std::vector<std::string>& paths) const {
        const std::string error = test::errorOf(ErrorKind::input, [&] { mergeExr(paths, file("merged.exr")); });
        EXPECT_FALSE(std::filesystem::exists(file("merged.exr")));
        return error;
    }

    test::TempFolder m_folder;
};

TEST_F(ExrMerge, OfFlatTilesIsTheFileOfTheWhole) {
    for (const std::string compression : {"zip", "zips", "piz", "none"}) {
        ExrOptions how = options();
        how.compression = compression;
        writeFlat(file("whole.exr"), kWhole, how);
        const auto paths =
            tiles(kTiles, [&](const std::string& path, const PixelWindow& crop) { writeFlat(path, crop, how); });
        const MergedExr merged = mergeExr(paths, file("merged.exr"));
        EXPECT_EQ(merged.window, (PixelWindow{5, -1, 61, 131}));
        EXPECT_FALSE(merged.deep);
        EXPECT_TRUE(merged.leftOut.empty());
        EXPECT_TRUE(bytesOf(file("merged.exr")) == bytesOf(file("whole.exr"))) << compression;
    }
}

TEST_F(ExrMerge, NamesATileThatHoldsWhatIsNotFinite) {
    EXPECT_EQ(mergeExr(flatTiles(), file("merged.exr")).notFinite, "");
    for (const float odd : {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()}) {
        const auto paths = tiles(kTiles, [&](const std::string& path, const PixelWindow& crop) {
            writeFlat(path, crop, options(), crop == kTiles.back() ? odd : 0);
        });
        EXPECT_EQ(mergeExr(paths, file("merged.exr")).notFinite, paths.back());
    }
}

TEST_F(ExrMerge, OfDeepTilesIsTheFileOfTheWhole) {
    writeDeep(file("whole.exr"), kWhole);
    const MergedExr merged = mergeExr(tiles(kTiles, writeDeep), file("merged.exr"));
    EXPECT_TRUE(merged.deep);
    EXPECT_TRUE(bytesOf(file("merged.exr")) == bytesOf(file("whole.exr")));
}

TEST_F(ExrMerge, TakesTilesThatOverlapAndAreTheSameThere) {
    writeFlat(file("whole.exr"), kWhole);
    mergeExr(flatTiles({{-2, -1, 40, 150}, {30, -1, 70, 90}, {20, 80, 70, 150}}), file("merged.exr"));
    EXPECT_TRUE(bytesOf(file("merged.exr")) == bytesOf(file("whole.exr")));
    writeDeep(file("whole.exr"), kWhole);
    mergeExr(tiles({{-2, -1, 40, 150}, {30, -1, 70, 150}}, writeDeep), file("merged.exr"));
    EXPECT_TRUE(bytesOf(file("merged.exr")) == bytesOf(file("whole.exr")));
}

TEST_F(ExrMerge, OfNothingIsTheOnePixelOfNothing) {
    const std::vector<PixelWindow> crops{{-2, -1, 5, 150}, {5, -1, 70, 150}};
    const auto write = [](const std::string& path, const PixelWindow& crop) {
        writeExr(path, emptyImage(crop), options(), attributesOf(crop));
    };
    write(file("whole.exr"), kWhole);
    mergeExr(tiles(crops, write), file("merged.exr"));
    EXPECT_TRUE(bytesOf(file("merged.exr")) == bytesOf(file("whole.exr")));
}

TEST_F(ExrMerge, CompressesTheWholeAsItIsTold) {
    ExrOptions lossy = options();
    lossy.compression = "dwaa";
    writeFlat(file("whole.exr"), kWhole, lossy);
    EXPECT_FALSE(mergeExr(flatTiles(), file("merged.exr"), "dwaa").lossyTwice);
    const Image whole = readExr(file("whole.exr")), merged = readExr(file("merged.exr"));
    EXPECT_EQ(merged.window, whole.window);
    EXPECT_TRUE(merged.rgba == whole.rgba);
    const auto paths =
        tiles(kTiles, [&](const std::string& path, const PixelWindow& crop) { writeFlat(path, crop, lossy); });
    EXPECT_TRUE(mergeExr(paths, file("merged.exr")).lossyTwice);
    EXPECT_EQ(test::errorOf(ErrorKind::usage, [&] { mergeExr(paths, file("other.exr"), "lzw"); }),
              "unknown EXR compression 'lzw'; expected 'zip', 'zips', 'piz', 'dwaa' or 'none'");
}

TEST_F(ExrMerge, KeepsWhatEachTileSaysOfItsPlanAsAList) {
    const auto write = [](const std::string& path, const PixelWindow& crop) {
        ExrAttributes attributes = attributesOf(crop);
        attributes.emplace_back("scrim:plan", fmt::format("{{\"x0\": {}}}", crop.x0));
        attributes.emplace_back("scrim:verify:error", 0.01 * crop.x1);
        writeExr(path, emptyImage(crop), options(), attributes);
    };
    const MergedExr merged = mergeExr(tiles({{-2, -1, 5, 150}, {5, -1, 70, 150}}, write), file("merged.exr"));
    EXPECT_EQ(merged.leftOut, std::vector<std::string>{"scrim:verify:error"});
    const auto texts = readExrAttributes(file("merged.exr"));
    EXPECT_EQ(texts.at("scrim:plan"), "[{\"x0\": -2}, {\"x0\": 5}]");
    EXPECT_EQ(texts.at("software"), "scrim");
    EXPECT_FALSE(texts.contains("scrim:verify:error"));
    EXPECT_FALSE(texts.contains("scrim:crop"));
}

TEST_F(ExrMerge, TellsOfTilesThatAreMissing) {
    auto paths = flatTiles();
    EXPECT_EQ(errorOfMerging({paths[0], paths[2], paths[3]}),
              "a tile is missing: none holds the pixels 33,-1,70,67 of the picture -2,-1,70,150");
    EXPECT_EQ(errorOfMerging({paths[1]}),
              "a tile is missing: none holds the pixels -2,-1,33,67, nor those of 2 more boxes of the picture "
              "-2,-1,70,150");
    EXPECT_EQ(errorOfMerging({paths[0], file("none.exr")}),
              "cannot merge '" + file("none.exr") + "': there is no such file");
    std::filesystem::resize_file(paths[1], std::filesystem::file_size(paths[1]) - 100);
    EXPECT_EQ(errorOfMerging(paths), "cannot merge '" + paths[1] + "': it is not an OpenEXR file, or it is truncated");
}

TEST_F(ExrMerge, TellsOfTilesThatOverlapAndDiffer) {
    auto paths = flatTiles({{-2, -1, 40, 150}, {30, -1, 70, 150}});
    writeFlat(paths[1], {30, -1, 70, 150}, options(), 0.5f);
    EXPECT_EQ(errorOfMerging(paths), "cannot merge '" + paths[1] + "': it overlaps '" + paths[0] +
                                         "', and at the pixel 30,70 their channel 'Z' differs");
    paths = tiles({{-2, -1, 40, 150}, {30, -1, 70, 150}}, writeDeep);
    DeepImage nothing{{30, -1, 70, 150}, std::vector<DeepImage::Row>(151)};
    for (DeepImage::Row& row : nothing.rows) row.first.assign(41, 0);
    writeDeepExr(paths[1], nothing, options(), attributesOf(nothing.window));
    EXPECT_EQ(errorOfMerging(paths), "cannot merge '" + paths[1] + "': it overlaps '" + paths[0] +
                                         "', and at the pixel 31,70 their number of samples differs");
}

TEST_F(ExrMerge, TellsOfTilesOfSeveralPictures) {
    const auto paths = flatTiles();
    const auto with = [&](const std::string& tile) {
        return std::vector<std::string>{paths[0], paths[1], paths[2], tile};
    };
    const std::string other = file("other.exr"), begin = "cannot merge '" + other + "': ";
    writeDeep(other, kTiles[3]);
    EXPECT_EQ(errorOfMerging(with(other)), begin + "it is deep, and '" + paths[0] + "' is flat");
    ExrOptions how = options();
    how.displayWindow = {0, 0, 70, 149};
    writeFlat(other, kTiles[3], how);
    EXPECT_EQ(errorOfMerging(with(other)),
              begin + "its display window is 0,0,70,149, that of '" + paths[0] + "' is 0,0,68,149");
    how = options();
    how.half = false;
    writeFlat(other, kTiles[3], how);
    EXPECT_EQ(errorOfMerging(with(other)),
              begin +
                  "its channels are A:float B:float G:float R:float Z:float light.key.B:float light.key.G:float "
                  "light.key.R:float, those of '" +
                  paths[0] +
                  "' are A:half B:half G:half R:half Z:float light.key.B:half light.key.G:half light.key.R:half");
    how = options();
    how.colorInteropId = "lin_ap0_scene";
    writeFlat(other, kTiles[3], how);
    EXPECT_EQ(errorOfMerging(with(other)),
              begin + "it is not of the same render as '" + paths[0] + "': the attribute 'colorInteropID' differs");
    const auto flat = [&](const std::string& crop) {
        writeExr(other, emptyImage({33, 67, 70, 150}), options(), {{"scrim:crop", crop}});
        writeExr(file("first.exr"), emptyImage({-2, -1, 33, 67}), options(), attributesOf(kTiles[0]));
        return errorOfMerging({file("first.exr"), other});
    };
    EXPECT_EQ(flat("33,67,70,150 of 0,0,70,150"),
              begin + "it is a part of 0,0,70,150, and '" + file("first.exr") + "' is one of -2,-1,70,150");
    EXPECT_EQ(flat("33,67"), begin +
                                 "its attribute scrim:crop is '33,67'; expected X0,Y0,X1,Y1 of X0,Y0,X1,Y1, around "
                                 "its data window 33,67,34,68");
}

TEST_F(ExrMerge, WritesAWholeFileOrNone) {
    const auto paths = flatTiles();
    const std::size_t before = m_folder.entryCount();
    {
        const test::FileSizeLimit limit(2000);
        EXPECT_EQ(test::errorOf(ErrorKind::output, [&] { mergeExr(paths, file("merged.exr")); }),
                  "cannot write '" + file("merged.exr") + "': File too large; raise the limit (ulimit -f)");
    }
    EXPECT_EQ(
        test::errorOf(
            ErrorKind::interrupted,
            [&] { mergeExr(paths, file("merged.exr"), "", [] { throw Error(ErrorKind::interrupted, "enough"); }); }),
        "enough");
    EXPECT_EQ(m_folder.entryCount(), before);
    EXPECT_EQ(test::errorOf(ErrorKind::usage, [&] { mergeExr({}, file("merged.exr")); }),
              "there are no tiles to merge");
}

}  // namespace
}  // namespace scrim
