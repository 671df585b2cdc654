// SPDX-License-Identifier: Apache-2.0
// Raw samples: types, byte orders, what is done to values and axes, and files that are not what they should be.
#include "plugins/sources/generated.h"

#include "support/data.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>

#include <sys/stat.h>
#include <zlib.h>

namespace scrim::test {
namespace {

/// The bytes of a number, least significant first or last.
template <typename T>
std::string bytesOf(T value, bool big = false) {
    std::string bytes(sizeof(T), '\0');
    std::memcpy(bytes.data(), &value, sizeof(T));
    if (big == (std::endian::native == std::endian::little)) std::reverse(bytes.begin(), bytes.end());
    return bytes;
}

void writeGz(const std::string& path, const std::string& bytes) {
    gzFile file = gzopen(path.c_str(), "wb");
    gzwrite(file, bytes.data(), static_cast<unsigned>(bytes.size()));
    gzclose(file);
}

class ScanRaw : public BuiltSource {
  protected:
    /// 3 x 4 x 5 bytes; that of (x, y, z) is 1 + x + 3 y + 12 z.
    std::string counting() const {
        std::string bytes;
        for (int i = 1; i <= 60; ++i) bytes += static_cast<char>(i);
        return write("count.raw", bytes);
    }
    SparseField counted(Parameters more = {}) const {
        more.insert(more.begin(), {{"file", counting()}, {"size", "3, 4, 5"}});
        return make("scan", more);
    }
    std::string countedReason(Parameters more) const {
        more.insert(more.begin(), {{"file", counting()}, {"size", "3, 4, 5"}});
        return reason("scan", more);
    }
};

TEST_F(ScanRaw, SamplesLieWithXFastest) {
    const SparseField f = counted();
    EXPECT_EQ(f.name, "density");
    EXPECT_EQ(f.wsFromIs, Mat4(1.0));
    EXPECT_EQ(f.activeVoxels, 60u);
    for (int z = 0; z < 5; ++z)
        for (int y = 0; y < 4; ++y)
            for (int x = 0; x < 3; ++x) EXPECT_EQ(valueAt(f, Int3(x, y, z)), 1 + x + 3 * y + 12 * z);
}

template <typename T>
void expectTypeRead(const BuiltSource&, const std::string& path, const char* type, T value) {
    for (const bool big : {false, true}) {
        writeBytes(path, std::string(7, 'h') + bytesOf(T(1), big) + bytesOf(value, big));
        const SparseField f = generate("scan",
                                       {{"file", path},
                                        {"size", "2,1,1"},
                                        {"type", type},
                                        {"endian", big ? "big" : "little"},
                                        {"header", "7"}},
                                       {})
                                  .at(0);
        EXPECT_EQ(valueAt(f, Int3(0, 0, 0)), 1) << type;
        EXPECT_EQ(valueAt(f, Int3(1, 0, 0)), static_cast<float>(value)) << type;
    }
}

TEST_F(ScanRaw, AllTypesAreReadInBothByteOrders) {
    const std::string path = file("t.raw");
    expectTypeRead<std::uint8_t>(*this, path, "uint8", 255);
    expectTypeRead<std::int8_t>(*this, path, "int8", 127);
    expectTypeRead<std::uint16_t>(*this, path, "uint16", 65281);
    expectTypeRead<std::int16_t>(*this, path, "int16", 258);
    expectTypeRead<std::uint32_t>(*this, path, "uint32", 4000000000u);
    expectTypeRead<std::int32_t>(*this, path, "int32", 16909060);
    expectTypeRead<float>(*this, path, "float", 0.1f);
    expectTypeRead<double>(*this, path, "double", 0.1);
}

TEST_F(ScanRaw, SpacingAndCentreSetThePlace) {
    const SparseField f = counted({{"spacing", "2, 3, 4"}});
    EXPECT_EQ(transformPoint(f.wsFromIs, Vec3(1, 1, 1)), Vec3(2, 3, 4));
    const SparseField c = counted({{"spacing", "2, 3, 4"}, {"center", "true"}});
    EXPECT_EQ(transformPoint(c.wsFromIs, Vec3(1, 1.5, 2)), Vec3(0, 0, 0));
}

TEST_F(ScanRaw, ThresholdWindowAndScaleMapValues) {
    const SparseField t = counted({{"threshold", "10"}});
    EXPECT_EQ(t.activeVoxels, 50u);
    EXPECT_EQ(valueAt(t, Int3(1, 3, 0)), 11);
    const SparseField w = counted({{"window", "10, 30"}, {"scale", "4"}});
    EXPECT_EQ(valueAt(w, Int3(0, 3, 0)), 0);           // 10
    EXPECT_FLOAT_EQ(valueAt(w, Int3(1, 3, 0)), 0.2f);  // 11
    EXPECT_EQ(valueAt(w, Int3(2, 3, 4)), 4);           // 60
    const SparseField full = counted({{"window", "full"}, {"threshold", "30"}});
    EXPECT_EQ(valueAt(full, Int3(2, 1, 2)), 0);                 // 30
    EXPECT_FLOAT_EQ(valueAt(full, Int3(0, 2, 2)), 30.0f / 59);  // 31
    EXPECT_EQ(full.maxValue, 1);
}

TEST_F(ScanRaw, HalvingTakesMeansAndKeepsThePlace) {
    const SparseField f = counted({{"halve", "z"}});
    EXPECT_EQ(transformPoint(f.wsFromIs, Vec3(0, 0, 0)), Vec3(0, 0, 0.5));
    EXPECT_EQ(transformPoint(f.wsFromIs, Vec3(1, 1, 1)), Vec3(1, 1, 2.5));
    EXPECT_EQ(f.activeVoxels, 3u * 4 * 3);
    EXPECT_EQ(valueAt(f, Int3(0, 0, 0)), 7);   // 1 and 13
    EXPECT_EQ(valueAt(f, Int3(2, 3, 2)), 60);  // the last layer is alone
    const SparseField all = counted({{"halve", "yx"}});
    EXPECT_EQ(valueAt(all, Int3(0, 0, 0)), 3);  // 1, 2, 4, 5
    EXPECT_EQ(transformPoint(all.wsFromIs, Vec3(0, 0, 0)), Vec3(0.5, 0.5, 0));
}

TEST_F(ScanRaw, CropsKeepThePlace) {
    const SparseField f = counted({{"crop_from", "1, 2, 3"}, {"crop_to", "3, 4, 5"}});
    EXPECT_EQ(f.activeVoxels, 8u);
    EXPECT_EQ(valueAt(f, Int3(0, 0, 0)), 1 + 1 + 6 + 36);
    EXPECT_EQ(transformPoint(f.wsFromIs, Vec3(0, 0, 0)), Vec3(1, 2, 3));
    EXPECT_EQ(counted({{"crop_from", "0, 3, 0"}}).activeVoxels, 15u);
}

TEST_F(ScanRaw, ConstantPartsAreTiles) {
    const std::string path = write("c.raw", std::string(16 * 8 * 8, '\5'));
    const SparseField f = make("scan", {{"file", path}, {"size", "16,8,8"}});
    EXPECT_EQ(f.blockCount(), 0u);
    ASSERT_EQ(f.tiles.size(), 2u);
    EXPECT_EQ(f.tiles[1].value, 5);
}

TEST_F(ScanRaw, IsDecompressedWhereItsNameSaysSo) {
    writeGz(file("c.raw.gz"), std::string("head") + std::string(64, '\2'));
    EXPECT_EQ(mass(make("scan", {{"file", file("c.raw.gz")}, {"size", "4,4,4"}, {"header", "4"}})), 128);
}

TEST_F(ScanRaw, FilesOfAnotherSizeAreRefusedWithBothNumbers) {
    const auto size = [&](const char* text) { return reason("scan", {{"file", counting()}, {"size", text}}); };
    const std::string path = counting();
    EXPECT_EQ(size("3,4,6"), path + ": has 60 bytes, expected 72 bytes (3 x 4 x 6 of uint8 after 0 bytes of header)");
    EXPECT_EQ(size("3,4,4"), path + ": has 60 bytes, expected 48 bytes (3 x 4 x 4 of uint8 after 0 bytes of header)");
    EXPECT_EQ(countedReason({{"type", "float"}, {"header", "10"}}),
              path + ": has 60 bytes, expected 250 bytes (3 x 4 x 5 of float after 10 bytes of header)");
    EXPECT_EQ(size("1000000,1000000,1000000"),
              path + ": 1000000 x 1000000 x 1000000 samples are too many, expected at most 2147483648");
    EXPECT_EQ(size("3,0,5"), path + ": 3 x 0 x 5 samples, expected at least 1 along each axis");
    EXPECT_EQ(size("3,4,5.5"), "'size' is 3, 4, 5.5, expected whole numbers");
    EXPECT_EQ(size("0,0,0"), path + ": a raw file has no header with its size: give 'size', such as 128,128,64");
}

TEST_F(ScanRaw, DamagedCompressionIsRefused) {
    std::string bytes;
    for (unsigned i = 0; i < 1000; ++i) bytes += static_cast<char>(i * i * 7919U >> 5);
    const std::string path = file("g.raw.gz");
    writeGz(path, bytes);
    const Parameters parameters{{"file", path}, {"size", "10,10,10"}};
    const std::string good = [&] {
        std::string text(std::filesystem::file_size(path), '\0');
        std::unique_ptr<FILE, int (*)(FILE*)> in(std::fopen(path.c_str(), "rb"), &std::fclose);
        EXPECT_EQ(std::fread(text.data(), 1, text.size(), in.get()), text.size());
        return text;
    }();
    EXPECT_GT(make("scan", parameters).activeVoxels, 900u);

    const std::string expected = "1000 bytes (10 x 10 x 10 of uint8 after 0 bytes of header)";
    writeBytes(path, good.substr(0, good.size() / 2));
    const std::string cut = reason("scan", parameters);
    EXPECT_TRUE(cut.starts_with(path + ": ends after ") && cut.ends_with(" bytes, expected " + expected)) << cut;
    std::string flipped = good;
    flipped[good.size() - 6] = static_cast<char>(flipped[good.size() - 6] ^ 0x55);  // the checksum
    writeBytes(path, flipped);
    const std::string damaged = reason("scan", parameters);
    EXPECT_TRUE(damaged.starts_with(path + ": its compressed data is damaged: ")) << damaged;
    writeGz(path, bytes + "x");
    EXPECT_EQ(reason("scan", parameters), path + ": has data after " + expected);
}

TEST_F(ScanRaw, CompressionThatCannotHoldSoMuchIsRefusedBeforeReading) {
    writeGz(file("bomb.raw.gz"), std::string(1000, '\0'));
    const std::string text = reason("scan", {{"file", file("bomb.raw.gz")}, {"size", "1000,1000,1000"}});
    EXPECT_TRUE(text.starts_with(file("bomb.raw.gz") + ": declares 1000000000 bytes of samples, more than its "))
        << text;
    EXPECT_TRUE(text.ends_with(" compressed bytes can hold")) << text;
}

TEST_F(ScanRaw, WhatIsNoFileIsRefused) {
    EXPECT_EQ(reason("scan", {}),
              "expected 'file', a .nrrd, .nhdr, .nii, .nii.gz, .hdr, .mha, .mhd, .npy, .mrc, .vti, .tif, .dcm or raw "
              "file, or a folder");
    for (const char* name : {"none.raw", "none.nrrd", "none.nii.gz"})
        EXPECT_EQ(reason("scan", {{"file", file(name)}, {"size", name[5] == 'r' ? "1,1,1" : "0,0,0"}}),
                  file(name) + ": there is no such file");
    ASSERT_EQ(::mkfifo(file("pipe.raw").c_str(), 0600), 0);
    EXPECT_EQ(reason("scan", {{"file", file("pipe.raw")}, {"size", "1,1,1"}}), file("pipe.raw") + ": is not a file");
}

TEST_F(ScanRaw, EditsThatMakeNoSenseAreRefused) {
    EXPECT_EQ(countedReason({{"halve", "w"}}), "'halve' is 'w', expected some of x, y and z, each once");
    EXPECT_EQ(countedReason({{"halve", "zz"}}), "'halve' is 'zz', expected some of x, y and z, each once");
    EXPECT_EQ(countedReason({{"crop_from", "0,0,2"}, {"crop_to", "3,4,2"}}),
              "a crop from 0, 0, 2 to 3, 4, 2 is empty or outside of the 3 x 4 x 5 samples");
    EXPECT_EQ(countedReason({{"crop_to", "3,4,6"}}),
              "a crop from 0, 0, 0 to 3, 4, 6 is empty or outside of the 3 x 4 x 5 samples");
    for (const char* window : {"5", "5, 5", "9, 5", "a, b", "1, 2, 3", "0, inf"})
        EXPECT_EQ(countedReason({{"window", window}}), "'window' is '" + std::string(window) +
                                                           "', expected two ascending numbers such as 0, 255, or "
                                                           "'full'");
    EXPECT_EQ(countedReason({{"spacing", "1, 0, 1"}}), "'spacing' has a 0, expected three numbers above 0");
    const std::string even = write("even.raw", "aaaa");
    EXPECT_EQ(reason("scan", {{"file", even}, {"size", "4,1,1"}, {"window", "full"}}),
              "'window' is 'full', but all samples are equal");
}

TEST_F(ScanRaw, ReadsRealScans) {
    SCRIM_NEEDS_DATA("scan/teddybear_128x128x62_u8.raw");
    SCRIM_NEEDS_DATA("scan/neghip_64x64x64_u8.raw");
    const SparseField teddy = make("scan", {{"file", dataFile("scan/teddybear_128x128x62_u8.raw")},
                                            {"size", "128,128,62"},
                                            {"spacing", "2.8,2.8,5"},
                                            {"center", "true"}});
    EXPECT_EQ(teddy.activeVoxels, 1015808u);  // noise everywhere: classify or use a threshold
    EXPECT_NEAR(transformPoint(teddy.wsFromIs, Vec3(127, 127, 61)).x, 0.5 * 127 * 2.8, 1e-9);
    const SparseField hip = make("scan", {{"file", dataFile("scan/neghip_64x64x64_u8.raw")}, {"size", "64,64,64"}});
    EXPECT_EQ(hip.maxValue, 255);
    EXPECT_EQ(hip.activeVoxels, 121586u);
}

}  // namespace
}  // namespace scrim::test
