// SPDX-License-Identifier: Apache-2.0
// Scans of TIFF pages: stacks in one file, and slices in many. The files of the folder `tiff` are what other programs
// wrote: tifffile 2026.3.3 and Pillow 13.
#include "plugins/sources/generated.h"

#include "support/tiff_files.h"

#include <array>
#include <bit>
#include <filesystem>

namespace scrim::test {
namespace {

class ScanTiff : public ScanSource {
  protected:
    static std::string written(const std::string& name) { return std::string(SCRIM_TIFF_FILES) + "/" + name; }
    /// 2 x 3 x 4 samples: factor * (1 + x + 2 y + 6 z) + more.
    static void expectCounting(const SparseField& f, const std::string& what, float more = 0, float factor = 1) {
        for (int z = 0; z < 4; ++z)
            for (int y = 0; y < 3; ++y)
                for (int x = 0; x < 2; ++x)
                    EXPECT_EQ(valueAt(f, Int3(x, y, z)), factor * float(1 + x + 2 * y + 6 * z) + more) << what;
    }
    static void expectSpacing(const SparseField& f, const Vec3& spacing, const std::string& what) {
        for (int k = 0; k < 3; ++k)
            for (int row = 0; row < 3; ++row) EXPECT_NEAR(f.wsFromIs[k][row], row == k ? spacing[k] : 0, 1e-6) << what;
    }
    /// What the source says of a file.
    static std::string noteOn(const std::string& path, Parameters more = {}) {
        more.insert(more.begin(), {"file", path});
        std::string notes;
        const std::string start = "source 'scan': ";
        generate("scan", more, [&](Severity, const std::string& text) {
            EXPECT_TRUE(text.starts_with(start)) << text;
            notes += text.substr(start.size()) + "\n";
        });
        return notes;
    }
};

TEST_F(ScanTiff, StacksOfOtherProgramsAreReadWhateverTheirPacking) {
    // 20 x 18 x 3 samples of uint8, or floats: 1 + x + 3 y + 50 z. The tiles are a big endian BigTIFF, deflated.
    for (const char* name : {"pillow_lzw.tif", "pillow_packbits.tif", "pillow_adobe_deflate.tif",
                             "pillow_lzw_differences.tif", "pillow_float_differences.tif", "tiles.tif"}) {
        const SparseField f = read(written(name));
        for (int z = 0; z < 3; ++z)
            for (int y = 0; y < 18; ++y)
                for (int x = 0; x < 20; ++x)
                    ASSERT_EQ(valueAt(f, Int3(x, y, z)), float(1 + x + 3 * y + 50 * z)) << name << " " << x << " " << y;
        EXPECT_EQ(f.activeVoxels, 20u * 18 * 3) << name;
    }
}

TEST_F(ScanTiff, CodesOfLzwGrowToTwelveBitsAndBeginAgain) {
    const SparseField f = read(written("pillow_lzw_long.tif"));
    for (int y = 0; y < 72; ++y)
        for (int x = 0; x < 64; ++x)
            ASSERT_EQ(valueAt(f, Int3(x, y, 0)), float((x * x * 31 + y * y * 17 + x * y * 13) % 251 + 1))
                << x << " " << y;
}

TEST_F(ScanTiff, PackBitsMayHoldBytesThatMeanNothing) {
    TiffPages pages = countingPages(0, 1);
    pages.compression = 32773;
    pages.pages[0] = "\x80" + std::string("\x03\x01\x02\x03\x04\x80\xff\x09", 8);  // -128; 4 bytes; -128; 2 times 9
    const SparseField f = read(write("bits.tif", pages.bytes()));
    const std::array<float, 6> values{1, 2, 3, 4, 9, 9};
    for (int i = 0; i < 6; ++i) EXPECT_EQ(valueAt(f, Int3(i % 2, i / 2, 0)), values[std::size_t(i)]) << i;
}

TEST_F(ScanTiff, ImageJSaysHowFarSamplesAreApart) {
    // unit=um, spacing=2.5, 4 columns and 2 rows per unit; and one header for all pages, of floats.
    expectSpacing(read(written("imagej_hyperstack.tif"), {{"component", "0"}}), Vec3(0.25, 0.5, 2.5), "hyperstack");
    expectSpacing(read(written("imagej_contiguous.tif")), Vec3(0.2, 0.2, 0.5), "contiguous");
    expectCounting(read(written("imagej_contiguous.tif")), "contiguous");
    expectSpacing(read(written("imagej_contiguous.tif"), {{"spacing", "1, 2, 3"}}), Vec3(1, 2, 3), "given");
    EXPECT_EQ(noteOn(written("imagej_contiguous.tif")), "");
}

TEST_F(ScanTiff, ChannelsAndFramesOfImageJAreComponents) {
    // 3 frames of 4 slices of 2 channels: a channel adds 1000, a frame 10000.
    const std::string path = written("imagej_hyperstack.tif");
    for (int frame = 0; frame < 3; ++frame)
        for (int channel = 0; channel < 2; ++channel) {
            const std::string component = std::to_string(2 * frame + channel);
            expectCounting(read(path, {{"component", component}}), component, float(1000 * channel + 10000 * frame));
        }
    EXPECT_EQ(refused(path), path + ": holds 6 volumes, expected one; component = 0 to 5 takes one of them");
    EXPECT_EQ(refused(path, {{"component", "6"}}), path + ": holds 6 volumes, and no component 6");
}

TEST_F(ScanTiff, OmeSaysHowFarSamplesAreApart) {
    const SparseField f = read(written("ome.tif"));  // big endian floats
    expectCounting(f, "OME", 0.25f, 0.25f);
    expectSpacing(f, Vec3(0.25, 0.5, 2), "OME");
    TiffPages pages = countingPages(0, 8);  // two channels, slices first
    pages.description = "<OME><Pixels ID=\"0\" DimensionOrder=\"XYZCT\" SizeC=\"2\" SizeT=\"1\" SizeZ=\"4\"></OME>";
    write("slices.tif", pages.bytes());
    expectCounting(read(file("slices.tif"), {{"component", "1"}}), "slices first", 24);
}

TEST_F(ScanTiff, SamplesOfEveryTypeAreRead) {
    const auto filled = [](std::uint16_t bits, std::uint16_t format, bool big) {
        TiffPages pages;
        pages.bits = bits;
        pages.format = format;
        pages.bigEndian = big;
        for (int z = 0; z < 4; ++z) {
            pages.pages.emplace_back();
            for (int i = 0; i < 6; ++i) {
                const int value = 1 + i + 6 * z;
                const auto whole = static_cast<std::uint32_t>(value);
                pages.pages.back() += bits == 8     ? std::string(1, static_cast<char>(value))
                                      : bits == 16  ? pages.word(static_cast<std::uint16_t>(value))
                                      : format == 3 ? pages.number(std::bit_cast<std::uint32_t>(float(value)))
                                                    : pages.number(whole);
            }
        }
        return pages.bytes();
    };
    for (const bool big : {false, true})
        for (const auto& [bits, format] :
             {std::pair<int, int>{8, 1}, {8, 2}, {16, 1}, {16, 2}, {32, 1}, {32, 2}, {32, 3}}) {
            const std::string bytes = filled(std::uint16_t(bits), std::uint16_t(format), big);
            expectCounting(read(write("a.tif", bytes)),
                           std::to_string(bits) + " bits in format " + std::to_string(format));
        }
    EXPECT_EQ(refused(write("a.tif", filled(8, 3, false))),
              file("a.tif") + ": holds samples of 8 bits in format 3; expected numbers of 8, 16, 32 or 64");
}

TEST_F(ScanTiff, WhatTheSamplesMeanIsKept) {
    TiffPages pages = countingPages();
    pages.colours = 0;  // 0 is white
    expectCounting(read(write("white.tif", pages.bytes())), "white", 255, -1);
    pages = countingPages(0, 5);
    pages.isThumbnail = 1;
    const SparseField f = read(write("thumbnail.tif", pages.bytes()));
    expectCounting(f, "thumbnail");
    EXPECT_EQ(f.activeVoxels, 24u);
}

TEST_F(ScanTiff, ColoursAreGridsBesideTheirLuma) {
    expectColours(written("rgb.tif"), 255, "RGB of uint8");
    expectColours(written("rgb_planes.tif"), 65535, "RGB of uint16");
}

TEST_F(ScanTiff, ColoursAreCroppedAndHalvedWithTheirDensity) {
    const auto grids = makeAll("scan", {{"file", written("rgb.tif")}, {"crop_from", "0, 0, 2"}, {"halve", "x"}});
    for (int z = 0; z < 2; ++z)
        for (int y = 0; y < 3; ++y) {
            const auto n = static_cast<float>(1 + 2 * y + 6 * (z + 2));
            EXPECT_NEAR(valueAt(grids.at(1), Int3(0, y, z)), (lightOf(n) + lightOf(n + 1)) / 2, 1e-6f);
            EXPECT_NEAR(valueAt(grids.at(3), Int3(0, y, z)), (lightOf(255 - n) + lightOf(254 - n)) / 2, 1e-6f);
        }
    EXPECT_EQ(grids[1].activeVoxels, 6u);
    EXPECT_EQ(valueAt(grids[1], Int3(1, 0, 0)), 0);
}

// Interpolation reaches one voxel beyond density; what is farther away is never seen.
TEST_F(ScanTiff, ColoursFarFromDensityAreLeftOut) {
    TiffPages pages;
    pages.columns = 32;
    pages.rows = 1;
    pages.parts = 3;
    pages.colours = 2;
    pages.pages.emplace_back();
    for (int x = 0; x < 32; ++x) pages.pages[0] += std::string(3, static_cast<char>(x == 8 ? 200 : 10));
    const auto grids = makeAll("scan", {{"file", write("far.tif", pages.bytes())}, {"threshold", "100"}});
    EXPECT_EQ(grids.at(0).activeVoxels, 1u);
    EXPECT_EQ(grids.at(1).activeVoxels, 16u) << "the block of voxel 8, and the one beside it";
    EXPECT_NEAR(valueAt(grids[1], Int3(7, 0, 0)), lightOf(10), 1e-6f);
}

TEST_F(ScanTiff, AFileThatDoesNotSayHowFarSamplesAreApartIsAWord) {
    const std::string path = write("plain.tif", countingPages().bytes());
    EXPECT_EQ(noteOn(path), path + ": does not say how far its samples are apart: 1; 'spacing' sets it\n");
    EXPECT_EQ(noteOn(path, {{"spacing", "1, 1, 3"}}), "");
    TiffPages film = countingPages();
    film.description = "ImageJ=1.54\nimages=4\nframes=4\nunit=um\n";
    EXPECT_EQ(noteOn(write("film.tif", film.bytes())),
              file("film.tif") + ": its 4 pages are frames of a film: read as slices\n");
    expectCounting(read(file("film.tif")), "film");
    film.description = "<OME><Pixels SizeC=\"3\" SizeT=\"1\" SizeZ=\"4\" PhysicalSizeX=\"1\"></OME>";
    EXPECT_EQ(noteOn(write("set.tif", film.bytes())),
              file("set.tif") + ": its 4 pages are not as many as its description states: read as slices\n");
    expectCounting(read(file("set.tif")), "set");
    const std::string one = write("one.tif", countingPages(0, 1).bytes());
    EXPECT_NE(noteOn(one).find(one + ": holds one slice; slices in many files are read by their folder, or by a "
                                     "pattern such as 'slice_*.tif'\n"),
              std::string::npos);
}

class TiffSlices : public ScanTiff {
  protected:
    TiffSlices() { std::filesystem::create_directories(file("slices")); }
    void add(const std::string& name, int z) const { write("slices/" + name, countingPages(z, 1).bytes()); }
};

TEST_F(TiffSlices, AreSortedByTheNumberInTheirNames) {
    for (int z = 0; z < 4; ++z) add("cell_" + std::to_string(8 + z) + "_8bit.tif", z);  // 10 is behind 9
    write("slices/notes.txt", "not a slice");
    for (const std::string path : {"slices", "slices/", "slices/cell_*.tif", "slices/*bit.t*"})
        expectCounting(read(file(path), {{"spacing", "1, 1, 2"}}), path);
    expectSpacing(read(file("slices"), {{"spacing", "1, 1, 2"}}), Vec3(1, 1, 2), "slices");
}

TEST_F(TiffSlices, OfOneVolumeArePickedByAPattern) {
    for (int z = 0; z < 4; ++z)
        for (int c = 0; c < 2; ++c) add("cell_C" + std::to_string(c) + "_Z" + std::to_string(z) + ".tif", z + 4 * c);
    expectCounting(read(file("slices/cell_C0_*.tif")), "first");
    expectCounting(read(file("slices/cell_C1_*.tif")), "second", 24);
    EXPECT_EQ(refused(file("slices")),
              file("slices") +
                  ": 'cell_C0_Z0.tif' and 'cell_C0_Z1.tif' differ in more than one number, expected the "
                  "slices of one volume; name them by a pattern, such as 'cell_C1_*.tif'");
    EXPECT_EQ(refused(file("slices/cell_C2_*.tif")),
              file("slices/cell_C2_*.tif") + ": there is no TIFF file of such a name");
}

TEST_F(TiffSlices, ThatDoNotBelongTogetherAreRefused) {
    for (const int z : {0, 1, 3}) add("z" + std::to_string(z) + ".tif", z);
    EXPECT_EQ(refused(file("slices")), file("slices") + ": a slice is missing between 'z1.tif' and 'z3.tif'");
    add("z03.tif", 3);
    EXPECT_EQ(refused(file("slices")), file("slices") + ": 'z03.tif' and 'z3.tif' have the same number");
    std::filesystem::remove(file("slices/z03.tif"));
    TiffPages wide = countingPages(2, 1);
    wide.columns = 3;
    wide.rows = 2;
    write("slices/z2.tif", wide.bytes());
    EXPECT_EQ(refused(file("slices")), file("slices") +
                                           ": 'z2.tif': is 3 x 2 of uint8, expected 2 x 3 of uint8 as "
                                           "'z0.tif'");
    write("slices/z2.tif", countingPages(2, 2).bytes());
    EXPECT_EQ(refused(file("slices")), file("slices") + ": 'z2.tif': holds 2 pages beside other slices, expected one");
}

TEST_F(ScanTiff, WhatIsNotReadIsRefusedWithAReason) {
    EXPECT_EQ(refused(write("a.tif", "nothing")), file("a.tif") + ": is not a TIFF file");
    TiffPages pages = countingPages();
    pages.compression = 7;
    EXPECT_EQ(refused(write("a.tif", pages.bytes())),
              file("a.tif") + ": its samples are compressed by JPEG; expected LZW, deflate, PackBits or nothing");
    pages = countingPages();
    pages.rows = 1000000;
    EXPECT_EQ(refused(write("a.tif", pages.bytes())),
              file("a.tif") + ": 4 pages of 2 x 1000000 of uint8 have 8000000 bytes, more than its 680 bytes can hold");
    pages = countingPages();
    pages.bits = 4;
    EXPECT_EQ(refused(write("a.tif", pages.bytes())),
              file("a.tif") + ": holds samples of 4 bits; expected numbers of 8, 16, 32 or 64");
    pages = countingPages();
    pages.description = "ImageJ=1.54\nimages=9\nslices=9\n";
    EXPECT_EQ(refused(write("a.tif", pages.bytes())),
              file("a.tif") + ": holds 4 of the 9 pages that its description states");
    std::string ring = countingPages().bytes();
    const std::string first = ring.substr(4, 4);  // where the first header is
    ring.replace(ring.rfind(std::string(4, '\0') + countingPages().pages.back()), 4, first);
    EXPECT_EQ(refused(write("ring.tif", ring)), file("ring.tif") + ": damaged: its pages go round in a circle");
    EXPECT_EQ(refused(file("a.tif"), {{"size", "2, 3, 4"}}),
              file("a.tif") + ": has its own 'size'; that parameter is for raw files only");
    const std::string whole = countingPages().bytes();
    const std::string cut = refused(write("a.tif", whole.substr(0, whole.size() - 40)));
    EXPECT_TRUE(cut.starts_with(file("a.tif") + ": ")) << cut;
}

}  // namespace
}  // namespace scrim::test
