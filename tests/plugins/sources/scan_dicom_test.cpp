// SPDX-License-Identifier: Apache-2.0
// Scans in many files: DICOM series.
#include "plugins/sources/generated.h"

#include "support/dicom_files.h"
#include "support/source_files.h"

#include <filesystem>

namespace scrim::test {
namespace {

class ScanDicom : public BuiltSource {
  protected:
    ScanDicom() { std::filesystem::create_directories(folder()); }

    std::string folder() const { return file("series"); }
    std::string add(const std::string& name, const DicomSlice& slice) const {
        return write("series/" + name, slice.bytes());
    }
    /// Four slices, whose names are not in the order of their positions.
    void addCounting() const {
        const char* const names[] = {"c.dcm", "a.dcm", "d", "b.dcm"};
        for (int z = 0; z < 4; ++z) add(names[z], countingSlice(z));
    }
    static SparseField read(const std::string& path, Parameters more = {}) {
        more.insert(more.begin(), {"file", path});
        return make("scan", more);
    }
    std::string refused(const std::string& name = "") const {
        return reason("scan", {{"file", name.empty() ? folder() : folder() + "/" + name}});
    }
    static void expectCounting(const SparseField& f, int slices = 4, float more = 0) {
        for (int z = 0; z < slices; ++z)
            for (int y = 0; y < 3; ++y)
                for (int x = 0; x < 2; ++x) EXPECT_EQ(valueAt(f, Int3(x, y, z)), float(1 + x + 2 * y + 6 * z) + more);
    }
};

TEST_F(ScanDicom, ASeriesIsSortedByPositionAndPlacedByItsHeaders) {
    addCounting();
    write("series/notes.txt", "not a slice");
    for (const std::string& path : {folder(), folder() + "/", folder() + "/a.dcm"}) {
        const SparseField f = read(path);
        expectCounting(f);
        EXPECT_EQ(transformPoint(f.wsFromIs, Vec3(0)), Vec3(10, 20, 30)) << path;
        EXPECT_EQ(transformPoint(f.wsFromIs, Vec3(1, 1, 1)), Vec3(10.25, 20.5, 32.5)) << path;
    }
}

TEST_F(ScanDicom, SlicesMayBeCompressed) {
    for (int z = 0; z < 4; ++z) {
        DicomSlice slice = countingSlice(z);
        slice.syntax = DicomSlice::kRle;
        add(std::to_string(z), slice);
    }
    expectCounting(read(folder()));
    DicomSlice slice = countingSlice(4);
    slice.syntax = DicomSlice::kRle;
    const std::string cut = slice.bytes();
    write("series/4", cut.substr(0, cut.size() - 20));
    EXPECT_NE(refused(), "");
}

TEST_F(ScanDicom, DirectionsTurnItAndATiltedGantryShearsIt) {
    for (int z = 0; z < 3; ++z) {
        DicomSlice slice = countingSlice(z);
        slice.directions = "0\\1\\0\\0\\0\\-1";  // columns to the back, rows downwards; the normal is -x
        slice.position = fmt::format("{}\\0\\{}", 7 - 2 * z, 0.5 * z);
        add(std::to_string(z), slice);
    }
    const SparseField f = read(folder());
    expectCounting(f, 3);
    EXPECT_EQ(transformPoint(f.wsFromIs, Vec3(0)), Vec3(7, 0, 0));
    EXPECT_EQ(transformVector(f.wsFromIs, Vec3(1, 0, 0)), Vec3(0, 0.25, 0));
    EXPECT_EQ(transformVector(f.wsFromIs, Vec3(0, 1, 0)), Vec3(0, 0, -0.5));
    EXPECT_EQ(transformVector(f.wsFromIs, Vec3(0, 0, 1)), Vec3(-2, 0, 0.5));
}

TEST_F(ScanDicom, SamplesAreHounsfieldUnitsBySlopeAndIntercept) {
    DicomSlice slice = countingSlice(0);
    slice.slope = "2";
    slice.intercept = "-1000";
    slice.samples = {500, 501, -1, 700, 0, 12};
    const std::string path = add("a.dcm", slice);
    const SparseField plain = read(path, {{"units", "scan"}});
    EXPECT_EQ(valueAt(plain, Int3(1, 0, 0)), 2);
    EXPECT_EQ(valueAt(plain, Int3(1, 1, 0)), 400);
    // The slice's thickness is the step to the next one, which is not there.
    EXPECT_EQ(transformVector(plain.wsFromIs, Vec3(0, 0, 1)), Vec3(0, 0, 2));
    const SparseField units = read(path, {{"units", "hounsfield"}});
    EXPECT_EQ(valueAt(units, Int3(1, 1, 0)), 400 + 1024);
    EXPECT_EQ(valueAt(units, Int3(0, 2, 0)), 24) << "air";
    EXPECT_EQ(valueAt(units, Int3(0, 1, 0)), 22) << "a sign";
}

TEST_F(ScanDicom, BitsThatAreNotStoredDoNotCount) {
    DicomSlice slice = countingSlice(0);
    slice.bitsStored = 12;
    slice.intercept = "0";
    slice.samples = {0x7ff, 0x1001, 0x0fff, 0, 1, 2};  // in 12 bits with a sign: 2047, 1, -1
    const std::string path = add("a.dcm", slice);
    const SparseField f = read(path, {{"units", "hounsfield"}});
    EXPECT_EQ(valueAt(f, Int3(0, 0, 0)), 2047 + 1024);
    EXPECT_EQ(valueAt(f, Int3(1, 0, 0)), 1 + 1024);
    EXPECT_EQ(valueAt(f, Int3(0, 1, 0)), -1 + 1024);
    slice.isSigned = 0;
    add("a.dcm", slice);
    EXPECT_EQ(valueAt(read(path, {{"units", "hounsfield"}}), Int3(0, 1, 0)), 4095 + 1024);
}

TEST_F(ScanDicom, AMissingSliceIsNamedByItsNeighbours) {
    for (const int z : {0, 1, 2, 4, 5}) add(fmt::format("{}.dcm", z), countingSlice(z));
    EXPECT_EQ(refused(),
              folder() + ": a slice is missing between '2.dcm' and '4.dcm': they are 5 mm apart, others 2.5");
}

TEST_F(ScanDicom, OneOfTwoSeriesIsChosenByAFileOfIt) {
    addCounting();
    for (int z = 0; z < 2; ++z) {
        DicomSlice other = countingSlice(z + 100);
        other.series = "1.2.3.2";
        add(fmt::format("x{}.dcm", z), other);
    }
    EXPECT_EQ(refused(), folder() +
                             ": the folder holds 2 series: 4 from 'a.dcm' on (1.2.3.1), 2 from 'x0.dcm' on "
                             "(1.2.3.2); expected one, or one of its files in place of the folder");
    expectCounting(read(folder() + "/b.dcm"));
    EXPECT_EQ(valueAt(read(folder() + "/x1.dcm"), Int3(0, 0, 1)), 1 + 6 * 101);
}

TEST_F(ScanDicom, WhatIsNoStackIsRefused) {
    addCounting();
    DicomSlice twice = countingSlice(1);
    add("e.dcm", twice);
    EXPECT_EQ(refused(), folder() +
                             ": 'a.dcm' and 'e.dcm' are at the same place; expected a series with one volume, "
                             "not several phases or echoes");
    twice.directions = "0\\1\\0\\-1\\0\\0";
    add("e.dcm", twice);
    EXPECT_EQ(refused(), folder() + ": 'e.dcm' is turned against 'a.dcm'; expected parallel slices");
    twice.position = "";
    add("e.dcm", twice);
    EXPECT_EQ(refused(), folder() +
                             ": 'e.dcm' has no position (ImagePositionPatient and ImageOrientationPatient), "
                             "without which slices cannot be sorted");
    twice = countingSlice(4);
    twice.rows = 2;
    twice.columns = 3;
    add("e.dcm", twice);
    EXPECT_EQ(refused(), folder() +
                             ": 'e.dcm' has 3 x 2 samples of 0.25 x 0.5 mm, 'a.dcm' has 2 x 3 of 0.25 x 0.5; "
                             "expected equal slices");
    twice = countingSlice(4);
    twice.position = "10\\20\\40.8";
    add("e.dcm", twice);
    EXPECT_EQ(refused(), folder() + ": 'b.dcm' and 'e.dcm' are 3.3 mm apart, others 2.5; expected even steps");
    twice = countingSlice(4);
    twice.samplesPerPixel = 3;
    add("e.dcm", twice);
    EXPECT_EQ(refused(), folder() + ": 'e.dcm' holds colours, expected one value for each sample");
}

TEST_F(ScanDicom, SamplesThatCannotBeReadAreRefused) {
    DicomSlice slice = countingSlice(0);
    slice.samples.resize(2);
    add("a.dcm", slice);
    EXPECT_EQ(refused(), folder() + ": the samples of 'a.dcm' are damaged or incomplete");
    slice.syntax = "1.2.840.10008.1.2.4.102";  // MPEG-4
    add("a.dcm", slice);
    EXPECT_EQ(refused(), folder() +
                             ": the samples of 'a.dcm' are compressed in a form that is not read (transfer "
                             "syntax 1.2.840.10008.1.2.4.102), or damaged; decompress them (gdcmconv --raw "
                             "does)");
}

TEST_F(ScanDicom, FoldersAndFilesWithoutPicturesAreRefused) {
    EXPECT_EQ(refused(), folder() + ": no file in the folder holds a DICOM picture");
    write("series/a.dcm", "nothing");
    EXPECT_EQ(refused("a.dcm"), folder() + "/a.dcm: is not a DICOM file, or holds no picture");
    EXPECT_EQ(refused("b.dcm"), folder() + "/b.dcm: there is no such file");
}

}  // namespace
}  // namespace scrim::test
