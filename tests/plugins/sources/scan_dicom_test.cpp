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

// The values that pydicom writes with HighBit 15 and BitsStored 12.
TEST_F(ScanDicom, SamplesMayLieInTheHighBits) {
    DicomSlice slice = countingSlice(0);
    slice.bitsStored = 12;
    slice.highBit = 15;
    slice.intercept = "0";
    slice.samples = {0x7ff0, -1, -0x8000, 0x10, 0x5f, 0x60};  // bits 0 to 3 belong to something else
    const std::string path = add("a.dcm", slice);
    const SparseField f = read(path, {{"units", "hounsfield"}, {"threshold", "-1024"}});
    EXPECT_EQ(valueAt(f, Int3(0, 0, 0)), 2047 + 1024);
    EXPECT_EQ(valueAt(f, Int3(1, 0, 0)), -1 + 1024);
    EXPECT_EQ(valueAt(f, Int3(0, 1, 0)), 0) << "-2048";
    EXPECT_EQ(valueAt(f, Int3(1, 1, 0)), 1 + 1024);
    EXPECT_EQ(valueAt(f, Int3(0, 2, 0)), 5 + 1024);
    slice.isSigned = 0;
    add("a.dcm", slice);
    EXPECT_EQ(valueAt(read(path), Int3(1, 0, 0)), 4095);
    slice.syntax = DicomSlice::kRle;
    add("a.dcm", slice);
    EXPECT_EQ(valueAt(read(path), Int3(1, 0, 0)), 4095);
}

TEST_F(ScanDicom, FramesOfOneFileFollowEachOtherBySpacing) {
    DicomSlice file = countingFrames();
    const auto stepOf = [&] {
        const SparseField f = read(add("a.dcm", file));
        expectCounting(f);
        EXPECT_EQ(transformPoint(f.wsFromIs, Vec3(0)), Vec3(10, 20, 30));
        EXPECT_EQ(transformVector(f.wsFromIs, Vec3(1, 1, 0)), Vec3(0.25, 0.5, 0));
        return transformVector(f.wsFromIs, Vec3(0, 0, 1));
    };
    EXPECT_EQ(stepOf(), Vec3(0, 0, 2)) << "the thickness of a slice, where nothing else is known";
    file.between = "3";
    EXPECT_EQ(stepOf(), Vec3(0, 0, 3));
    file.modality = DicomSlice::kNuclear;  // where the frames may go against the normal
    file.between = "-3";
    const SparseField f = read(add("a.dcm", file));
    EXPECT_EQ(transformVector(f.wsFromIs, Vec3(0, 0, 1)), Vec3(0, 0, 3));
    EXPECT_EQ(valueAt(f, Int3(0, 0, 0)), 1024 + 1 + 6 * 3) << "nuclear medicine counts; its samples have no units";
}

TEST_F(ScanDicom, FramesOfOneFileAreSortedByTheirOwnPositions) {
    DicomSlice file = countingFrames({1, 0, 3, 2});
    file.modality = DicomSlice::kEnhancedCt;
    file.position = "";
    file.framePositions = {"10\\20\\33", "10\\20\\30", "10\\20\\39", "10\\20\\36"};
    const SparseField f = read(add("a.dcm", file));
    expectCounting(f);
    EXPECT_EQ(transformPoint(f.wsFromIs, Vec3(0)), Vec3(10, 20, 30));
    EXPECT_EQ(transformVector(f.wsFromIs, Vec3(1, 1, 1)), Vec3(0.25, 0.5, 3));
    // Each frame may have a slope of its own, as PET has: those of slices 1, 0, 3, 2.
    file.intercept = "0";
    file.frameSlopes = {"2", "1", "4", "3"};
    const SparseField own = read(add("a.dcm", file));
    for (int z = 0; z < 4; ++z) EXPECT_EQ(valueAt(own, Int3(1, 2, z)), float((z + 1) * (1024 + 6 + 6 * z))) << z;
    file.framePositions[0] = file.framePositions[1];
    add("a.dcm", file);
    EXPECT_EQ(refused(), folder() +
                             ": 'frame 1' and 'frame 2' are at the same place; expected a series with one volume, "
                             "not several phases or echoes");
}

TEST_F(ScanDicom, UnevenSlicesAreResampledWithAWord) {
    const double heights[] = {0, 5, 10, 12.5, 15, 17.5};
    for (int i = 0; i < 6; ++i) {
        DicomSlice slice = countingSlice(0);
        slice.position = fmt::format("0\\{}\\{}", 0.1 * heights[i], heights[i]);  // the gantry is tilted
        slice.samples.assign(6, static_cast<std::int16_t>(1024 + 100 + 2 * heights[i]));
        add(std::to_string(i), slice);
    }
    std::vector<std::string> said;
    const auto hear = [&](Severity, const std::string& text) { said.push_back(text); };
    const SparseField f = generate("scan", {{"file", folder()}}, hear).at(0);
    ASSERT_EQ(said.size(), 1u);
    EXPECT_EQ(said[0],
              "source 'scan': " + folder() + ": its 6 slices are 2.5 to 5 mm apart: resampled to 8, 2.5 mm apart");
    const Vec3 step = transformVector(f.wsFromIs, Vec3(0, 0, 1));
    EXPECT_NEAR(step.y, 0.25, 1e-12);
    EXPECT_NEAR(step.z, 2.5, 1e-12);
    for (int z = 0; z < 8; ++z) EXPECT_FLOAT_EQ(valueAt(f, Int3(1, 2, z)), float(100 + 5 * z)) << z;
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
