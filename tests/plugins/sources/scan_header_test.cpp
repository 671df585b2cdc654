// SPDX-License-Identifier: Apache-2.0
// Scans that describe themselves: NRRD and NIfTI.
#include "plugins/sources/generated.h"

#include "support/data.h"
#include "support/source_files.h"

namespace scrim::test {
namespace {

class ScanHeader : public ScanSource {
  protected:
    /// 24 bytes 1, 2, ... for 2 x 3 x 4 samples.
    static std::string counting() {
        std::string bytes;
        for (int i = 1; i <= 24; ++i) bytes += static_cast<char>(i);
        return bytes;
    }
    std::string nrrd(const std::string& name, const std::string& fields, const std::string& data = "") const {
        return write(name, "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 3 4\n" + fields +
                               (name.ends_with(".nhdr") ? "" : "\n" + data));
    }
    static void expectCounting(const SparseField& f) {
        for (int z = 0; z < 4; ++z)
            for (int y = 0; y < 3; ++y)
                for (int x = 0; x < 2; ++x) EXPECT_EQ(valueAt(f, Int3(x, y, z)), 1 + x + 2 * y + 6 * z);
    }
};

TEST_F(ScanHeader, NrrdIsReadAttachedAndDetached) {
    expectCounting(read(nrrd("a.nrrd", "encoding: raw\n", counting())));
    write("samples.bin", counting());
    expectCounting(read(nrrd("b.nhdr", "encoding: raw\ndata file: samples.bin\n")));
    std::string text;
    for (int i = 1; i <= 24; ++i) text += std::to_string(i) + " ";
    expectCounting(read(nrrd("c.nrrd", "encoding: ascii\n", text)));
}

TEST_F(ScanHeader, UnitsOfTheScanAreKeptInAWindow) {
    const std::string path = nrrd("a.nrrd", "encoding: raw\n", counting());
    const SparseField f = read(path, {{"units", "scan"}, {"window", "5, 20"}});
    EXPECT_EQ(valueAt(f, Int3(0, 2, 0)), 0) << "5: what is not above the window's begin is empty";
    EXPECT_EQ(valueAt(f, Int3(1, 2, 0)), 6);
    EXPECT_EQ(valueAt(f, Int3(1, 2, 3)), 20);
    EXPECT_EQ(refused(path, {{"units", "scan"}, {"window", "-5, 20"}}),
              "'window' begins at -5, but units=scan keeps values as they are, and values below 0 are empty; without "
              "it a window maps them to 0 to 1");
}

TEST_F(ScanHeader, DescribesItself) {
    const std::string path = nrrd("a.nrrd",
                                  "space: right-anterior-superior\nspace directions: (2,0,0) (0,3,0) (0,0,4)\n"
                                  "space origin: (10,20,30)\nencoding: raw\n",
                                  counting());
    const auto fields = generate("scan", {{"file", path}, {"describe", "true"}}, {});
    ASSERT_EQ(fields.size(), 2u);
    EXPECT_EQ(fields[0].name, "histogram");
    EXPECT_EQ(fields[0].activeVoxels, 24u);  // every value once
    EXPECT_EQ(transformPoint(fields[0].wsFromIs, Vec3(0)).x, 1);
    EXPECT_EQ(transformPoint(fields[0].wsFromIs, Vec3(23, 0, 0)).x, 24);
    EXPECT_EQ(fields[1].name, "samples of uint8, right-anterior-superior");
    EXPECT_EQ(fields[1].activeVoxels, 2u);
    EXPECT_EQ(valueAt(fields[1], Int3(1, 2, 3)), 1);
    EXPECT_EQ(transformPoint(fields[1].wsFromIs, Vec3(1, 2, 3)), Vec3(12, 26, 42));
}

TEST_F(ScanHeader, NrrdOfOtherTypesAndByteOrdersIsRead) {
    const std::string path =
        write("s.nrrd", "NRRD0004\ntype: int16\ndimension: 3\nsizes: 2 1 1\nendian: big\nencoding: raw\n\n" +
                            std::string("\1\2\0\5", 4));
    const SparseField f = read(path);
    EXPECT_EQ(valueAt(f, Int3(0, 0, 0)), 258);
    EXPECT_EQ(valueAt(f, Int3(1, 0, 0)), 5);
}

TEST_F(ScanHeader, NrrdMayLeaveTheDimensionOfSpaceOut) {
    const std::string place = "space directions: (0,2,0) (0,0,3) (4,0,0)\nspace origin: (5, 6, 7)\n";
    const SparseField f = read(nrrd("a.nrrd", place + "encoding: raw\n", counting()));
    EXPECT_EQ(transformPoint(f.wsFromIs, Vec3(1, 1, 1)), Vec3(9, 8, 10));
    expectCounting(read(nrrd("b.nrrd", "# space dimension: none\n" + place + "encoding: raw\n", counting())));
    std::string text;
    for (int i = 1; i <= 24; ++i) text += std::to_string(i) + "\n\n";
    expectCounting(read(nrrd("c.nrrd", place + "encoding: ascii\n", text)));
    // What is wrong otherwise is still said.
    EXPECT_NE(refused(nrrd("d.nrrd", place + "encoding: raw\n", "few")).find("d.nrrd"), std::string::npos);
}

TEST_F(ScanHeader, NrrdsPlaceIsKept) {
    const SparseField spaced = read(nrrd("a.nrrd", "spacings: 1 2 3\nencoding: raw\n", counting()));
    EXPECT_EQ(transformPoint(spaced.wsFromIs, Vec3(1, 1, 1)), Vec3(1, 2, 3));
    const std::string turned = nrrd("b.nrrd",
                                    "space: left-posterior-superior\nspace directions: (0,2,0) (0,0,3) (4,0,0)\n"
                                    "space origin: (10,20,30)\nencoding: raw\n",
                                    counting());
    const SparseField f = read(turned);
    expectCounting(f);
    EXPECT_EQ(transformPoint(f.wsFromIs, Vec3(0, 0, 0)), Vec3(10, 20, 30));
    EXPECT_EQ(transformPoint(f.wsFromIs, Vec3(1, 0, 0)), Vec3(10, 22, 30));
    EXPECT_EQ(transformPoint(f.wsFromIs, Vec3(0, 1, 0)), Vec3(10, 20, 33));
    const SparseField straight = read(turned, {{"orientation", "false"}});
    EXPECT_EQ(transformPoint(straight.wsFromIs, Vec3(1, 1, 1)), Vec3(2, 3, 4));
    const SparseField respaced = read(turned, {{"spacing", "1, 1, 1"}});
    EXPECT_EQ(transformPoint(respaced.wsFromIs, Vec3(1, 0, 0)), Vec3(10, 21, 30));
}

// A step along x of the file is a step along x of the world, which is right-handed, or against it.
TEST_F(ScanHeader, NrrdsLeftHandedSpacesAreTurned) {
    const std::string place = "space directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (10,20,30)\n";
    struct Case {
        std::string space, world;
        int x;
    };
    for (const auto& [space, world, x] : std::vector<Case>{
             {"right-anterior-superior", "right-anterior-superior", 1},
             {"left-anterior-superior", "right-anterior-superior", -1},
             {"left-posterior-superior", "left-posterior-superior", 1},
             {"right-posterior-superior", "left-posterior-superior", -1},
             {"left-anterior-inferior", "left-anterior-inferior", 1},
             {"right-anterior-inferior", "left-anterior-inferior", -1},
             {"right-posterior-inferior", "right-posterior-inferior", 1},
             {"left-posterior-inferior", "right-posterior-inferior", -1},
             {"RAS", "right-anterior-superior", 1},
             {"LAS", "right-anterior-superior", -1},
             {"LPS", "left-posterior-superior", 1},
             {"rps", "left-posterior-superior", -1},
             {"scanner-xyz", "scanner-xyz", 1},
             {"3D-right-handed", "3D-right-handed", 1},
             {"3D-left-handed", "3D-right-handed", -1},
         }) {
        const std::string path = nrrd("a.nrrd", "space: " + space + "\n" + place + "encoding: raw\n", counting());
        const SparseField f = read(path);
        expectCounting(f);
        EXPECT_EQ(transformPoint(f.wsFromIs, Vec3(1, 1, 1)), Vec3(x * 12, 23, 34)) << space;
        const auto described = generate("scan", {{"file", path}, {"describe", "true"}}, {});
        EXPECT_EQ(described.at(1).name, "samples of uint8, " + world) << space;
    }
    for (const auto& [space, x] :
         {std::pair{"RAST", 12}, {"LAST", -12}, {"left-anterior-superior-time", -12}, {"3D-left-handed-time", -12}}) {
        const SparseField f = read(nrrd("t.nrrd",
                                        std::string("space: ") + space +
                                            "\nspace directions: (2,0,0,0) (0,3,0,0) (0,0,4,0)\n"
                                            "space origin: (10,20,30,7)\nencoding: raw\n",
                                        counting()));
        EXPECT_EQ(transformPoint(f.wsFromIs, Vec3(1, 1, 1)), Vec3(x, 23, 34)) << space;
    }
    write("samples.bin", counting());
    const SparseField apart =
        read(nrrd("b.nhdr", "space: LPI\r\n" + place + "encoding: raw\ndata file: samples.bin\n"));
    expectCounting(apart);
    EXPECT_EQ(transformPoint(apart.wsFromIs, Vec3(1, 1, 1)), Vec3(-12, 23, 34));
    EXPECT_NE(refused(nrrd("c.nrrd", "space: up-and-down\n" + place + "encoding: raw\n", counting())), "");
}

TEST_F(ScanHeader, BadNrrdIsRefused) {
    const std::string other = write("other.nrrd", "JUNK");
    EXPECT_EQ(refused(other), other + ": is not an NRRD file: it does not begin with 'NRRD'");
    const std::string cut = nrrd("cut.nrrd", "encoding: raw\n", counting().substr(0, 3));
    EXPECT_EQ(
        refused(nrrd("lost.nhdr", "encoding: raw\ndata file: none.raw\n")),
        file("lost.nhdr") + ": couldn't open \"" + m_folder.path() + "/none.raw\" (data file 1 of 1) for reading");
    write("few.bin", counting().substr(1));
    EXPECT_EQ(refused(nrrd("few.nhdr", "encoding: raw\ndata file: few.bin\n")),
              file("few.nhdr") + ": 2 x 3 x 4 of unsigned char need at least 24 bytes as raw, and " + file("few.bin") +
                  " has 23");
    EXPECT_NE(refused(cut).find("cut.nrrd: "), std::string::npos);
    const std::string flat =
        write("flat.nrrd", "NRRD0004\ntype: uint8\ndimension: 2\nsizes: 2 2\nencoding: raw\n\nabcd");
    EXPECT_EQ(refused(flat), flat + ": has 2 dimensions, expected 3 or 4");
    const std::string huge = write(
        "huge.nrrd", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2000000 2000000 2000000\nencoding: raw\n\nabcd");
    EXPECT_EQ(refused(huge), huge + ": 2000000 x 2000000 x 2000000 samples are too many, expected at most 2147483648");
    const std::string large =
        write("large.nrrd", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1000 1000 1000\nencoding: gzip\n\nabcd");
    const std::string text = refused(large);
    EXPECT_TRUE(text.starts_with(large + ": declares 1000000000 bytes of samples, more than its ")) << text;
    const std::string blocks =
        write("blocks.nrrd",
              "NRRD0004\ntype: block\nblocksize: 4\nendian: little\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n\nabcd");
    EXPECT_EQ(refused(blocks), blocks + ": holds samples of type 'block', expected numbers");
    write("x1.raw", counting());
    write("x2.raw", counting());
    for (const std::string files : {"x%d.raw 1 2 1", "LIST\nx1.raw\nx2.raw", "x%03d.raw 0 3 1", "LIST\nnone\nneither"})
        EXPECT_EQ(refused(nrrd("several.nhdr", "encoding: raw\ndata file: " + files + "\n")),
                  file("several.nhdr") +
                      ": its samples are in several files, expected one; join them (unu save -f nrrd -i several.nhdr "
                      "-o WHOLE.nrrd does, or 3D Slicer)");
}

TEST_F(ScanHeader, NiftiIsReadPlainAndCompressed) {
    const std::string plain = write("a.nii", NiftiHeader{}.bytes() + counting());
    const SparseField f = read(plain);
    expectCounting(f);
    EXPECT_EQ(transformPoint(f.wsFromIs, Vec3(1, 1, 1)), Vec3(2, 3, 4));
    const std::string bytes = NiftiHeader{}.bytes() + counting();
    expectCounting(read(write("b.nii.gz", gzipped(bytes))));
}

TEST_F(ScanHeader, NiftiIsReadInPairsAndAnalyzeIsRefused) {
    NiftiHeader header;
    header.pair = true;
    const std::string path = write("pair.hdr", header.bytes());
    write("pair.img", counting());
    expectCounting(read(path));
    const std::string lonely = write("lonely.hdr", header.bytes());
    EXPECT_EQ(refused(lonely), file("lonely.img") + ": there is no such file");
    const std::string analyze = write("analyze.hdr", std::string("\x5c\1\0\0", 4) + std::string(344, '\0'));
    EXPECT_EQ(refused(analyze), analyze +
                                    ": is no NIfTI header; if it is one of Analyze 7.5, which does not say where left "
                                    "is, convert it to NIfTI (fslchfiletype NIFTI, or 3D Slicer)");
}

TEST_F(ScanHeader, NiftisPlaceAndSlopeAreKept) {
    NiftiHeader header;
    header.sform = true;
    header.slope = 2;
    header.intercept = 0.5;
    const SparseField f = read(write("a.nii", header.bytes() + counting()));
    EXPECT_EQ(valueAt(f, Int3(1, 0, 0)), 4.5);
    EXPECT_EQ(transformPoint(f.wsFromIs, Vec3(0, 0, 0)), Vec3(10, 20, 30));
    EXPECT_EQ(transformPoint(f.wsFromIs, Vec3(1, 0, 0)), Vec3(10, 22, 30));
    EXPECT_EQ(transformPoint(f.wsFromIs, Vec3(0, 0, 1)), Vec3(14, 20, 30));
}

TEST_F(ScanHeader, BadNiftiIsRefused) {
    const std::string junk = write("junk.nii", std::string(400, 'x'));
    EXPECT_EQ(refused(junk), junk + ": is not a NIfTI file, or its header is damaged");
    const std::string cut = write("cut.nii", NiftiHeader{}.bytes() + counting().substr(4));
    EXPECT_EQ(refused(cut), cut + ": has 372 bytes, expected 376 bytes (2 x 3 x 4 of uint8 after 352 bytes of header)");
    NiftiHeader series;
    series.dims[0] = 4;
    series.dims[4] = 2;
    const std::string film = write("film.nii", series.bytes() + counting() + counting());
    EXPECT_EQ(refused(film), film + ": holds 2 volumes, expected one; component = 0 to 1 takes one of them");
    EXPECT_EQ(refused(film, {{"component", "2"}}), film + ": holds 2 volumes, and no component 2");
    expectCounting(read(film, {{"component", "1"}}));
    NiftiHeader colour;
    colour.type = 128;
    colour.bits = 24;
    const std::string rgb = write("rgb.nii", colour.bytes() + counting() + counting() + counting());
    EXPECT_EQ(refused(rgb),
              rgb + ": holds NIFTI_TYPE_RGB24 samples, expected whole or real numbers of up to 32 bits or double");
    NiftiHeader large;
    for (int k = 1; k <= 3; ++k) large.dims[k] = 32000;
    const std::string huge = write("huge.nii", large.bytes() + counting());
    EXPECT_EQ(refused(huge), huge + ": 32000 x 32000 x 32000 samples are too many, expected at most 2147483648");
}

TEST_F(ScanHeader, WhatTheHeaderSaysMustNotBeGiven) {
    const std::string path = nrrd("a.nrrd", "encoding: raw\n", counting());
    for (const auto& [key, value] :
         Parameters{{"size", "2,3,4"}, {"type", "uint8"}, {"endian", "little"}, {"header", "3"}})
        EXPECT_EQ(refused(path, {{key, value}}),
                  path + ": has its own '" + key + "'; that parameter is for raw files only");
}

TEST_F(ScanHeader, ReadsRealScans) {
    for (const char* name : {"bonsai_256.nrrd", "ch2bet.nii.gz", "tooth.nhdr"})
        SCRIM_NEEDS_DATA(std::string("scan/") + name);
    const auto extent = [](const SparseField& f) {
        Int3 most(0);
        forVoxels(f, [&](const Int3& p, float) {
            for (int k = 0; k < 3; ++k) most[k] = std::max(most[k], p[k] + 1);
        });
        return most;
    };
    const SparseField bonsai = read(dataFile("scan/bonsai_256.nrrd"), {{"halve", "z"}});
    const Int3 voxels = extent(bonsai);
    EXPECT_EQ(voxels.x, 256);
    EXPECT_EQ(voxels.z, 128);
    EXPECT_EQ(transformVector(bonsai.wsFromIs, {0, 0, 1}), Vec3(0, 0, 2));
    EXPECT_EQ(transformPoint(bonsai.wsFromIs, {0, 0, 0}), Vec3(-128, -128, -127.5));

    const SparseField tooth = read(dataFile("scan/tooth.nhdr"));
    EXPECT_EQ(extent(tooth), Int3(103, 94, 161));
    EXPECT_EQ(tooth.maxValue, 1300);  // in the wrong byte order it would be some 60000

    const SparseField brain = read(dataFile("scan/ch2bet.nii.gz"));
    EXPECT_EQ(brain.activeVoxels, 1737193u);
    // 181 x 217 x 181 voxels of 1 mm, turned and placed as the header has it: the brain is around the origin.
    const Vec3 x = transformVector(brain.wsFromIs, {1, 0, 0});
    EXPECT_NEAR(x.x * x.x + x.y * x.y + x.z * x.z, 1, 1e-5);
    Vec3 middle(0);
    forVoxels(brain, [&](const Int3& p, float) { middle += transformPoint(brain.wsFromIs, Vec3(p)); });
    middle /= static_cast<double>(brain.activeVoxels);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(middle[k], 0, 40) << k;
}

TEST_F(ScanHeader, AnNrrdHeaderWithoutAnEndIsRefused) {
    std::string text = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 12 12 12\nspacings:";
    for (int i = 0; i < 1728; ++i) text += " " + std::to_string(i % 256);
    EXPECT_EQ(refused(write("a.nrrd", text)),
              file("a.nrrd") + ": damaged: its header has no end, which is an empty line");
}

}  // namespace
}  // namespace scrim::test
