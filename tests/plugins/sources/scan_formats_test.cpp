// SPDX-License-Identifier: Apache-2.0
// Scans of other fields: MetaImage, NumPy, MRC, VTK; and volumes of four dimensions. Files "by" a program are what that
// program wrote, byte by byte; the places that are expected are those that it tells itself.
#include "plugins/sources/generated.h"

#include <cstring>
#include <numeric>

#include <zlib.h>

namespace scrim::test {
namespace {

class ScanFormats : public ScanSource {
  protected:
    /// 2 x 3 x 4 samples: 1 + x + 2 y + 6 z.
    static void expectCounting(const SparseField& f, const std::string& what, float more = 0) {
        for (int z = 0; z < 4; ++z)
            for (int y = 0; y < 3; ++y)
                for (int x = 0; x < 2; ++x)
                    EXPECT_EQ(valueAt(f, Int3(x, y, z)), float(1 + x + 2 * y + 6 * z) + more) << what;
    }
    static void expectPlace(const SparseField& f, const Vec3& is, const Vec3& ws, const std::string& what) {
        const Vec3 at = transformPoint(f.wsFromIs, is);
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(at[k], ws[k], 1e-5) << what;
    }
    /// `count` whole numbers from `first` on, as so many bytes each, or as floats.
    template <typename Number>
    static std::string numbers(int first, int count, bool swapped = false) {
        std::string out;
        for (int i = 0; i < count; ++i) {
            const auto number = static_cast<Number>(first + i);
            std::string bytes(sizeof number, '\0');
            std::memcpy(bytes.data(), &number, sizeof number);
            if (swapped) std::reverse(bytes.begin(), bytes.end());
            out += bytes;
        }
        return out;
    }
};

/// By SimpleITK 2: spacing 2, 3, 4, direction (0 0 1; 1 0 0; 0 1 0), origin 10, 20, 30.
const std::string kMeta =
    "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = "
    "False\nTransformMatrix = 0 1 0 0 0 1 1 0 0\nOffset = 10 20 30\nCenterOfRotation = 0 0 0\nAnatomicalOrientation = "
    "AIR\nElementSpacing = 2 3 4\nDimSize = 2 3 4\nElementType = MET_SHORT\nElementDataFile = LOCAL\n";
const char kDeflated[] =
    "x^\005\301\011\002@ "
    "\000\000\260QT\256\344\376\377Km\235^\020\015FIVLf\213\325\246\3325\207\323\345\366x}~\024\200\001-";

TEST_F(ScanFormats, MetaImageIsReadAndPlacedAsItkDoes) {
    const std::string plain = kMeta + numbers<std::int16_t>(1, 24);
    std::string deflated = kMeta + std::string(kDeflated, sizeof kDeflated - 1);
    deflated.replace(deflated.find("Data = False"), 12, "Data = True\nCompressedDataSize = 44");
    std::string apart = kMeta;
    apart.replace(apart.find("LOCAL"), 5, "sub/a.raw");
    std::filesystem::create_directories(file("sub"));
    write("sub/a.raw", numbers<std::int16_t>(1, 24));
    for (const std::string& path :
         {write("plain.mha", plain), write("deflated.mha", deflated), write("apart.mhd", apart)}) {
        const SparseField f = read(path);
        expectCounting(f, path);
        expectPlace(f, Vec3(1, 0, 0), Vec3(10, 22, 30), path);
        expectPlace(f, Vec3(1, 1, 1), Vec3(14, 22, 33), path);
        expectPlace(read(path, {{"space", "RAS"}}), Vec3(1, 1, 1), Vec3(-14, -22, 33), path);
    }
}

TEST_F(ScanFormats, MetaImageOfEveryTypeIsRead) {
    const auto head = [](const std::string& type, bool big) {
        return "NDims = 3\nElementByteOrderMSB = " + std::string(big ? "True" : "False") +
               "\nDimSize = 2 3 4\nElementType = MET_" + type + "\nElementDataFile = LOCAL\n";
    };
    for (const bool big : {false, true}) {
        const std::vector<std::pair<std::string, std::string>> types{
            {"UCHAR", numbers<std::uint8_t>(1, 24, big)},    {"CHAR", numbers<std::int8_t>(1, 24, big)},
            {"USHORT", numbers<std::uint16_t>(1, 24, big)},  {"SHORT", numbers<std::int16_t>(1, 24, big)},
            {"UINT", numbers<std::uint32_t>(1, 24, big)},    {"INT", numbers<std::int32_t>(1, 24, big)},
            {"FLOAT", numbers<float>(1, 24, big)},           {"DOUBLE", numbers<double>(1, 24, big)},
            {"LONG_LONG", numbers<std::int64_t>(1, 24, big)}};
        for (const auto& [type, bytes] : types) {
            const SparseField f = read(write("a.mha", head(type, big) + bytes));
            expectCounting(f, type);
            expectPlace(f, Vec3(1, 1, 1), Vec3(1), type);
        }
    }
    EXPECT_EQ(refused(write("a.mha", head("STRING", false))),
              file("a.mha") +
                  ": holds samples of type 'MET_STRING', expected MET_UCHAR, MET_SHORT, MET_FLOAT or another "
                  "number");
    EXPECT_EQ(refused(write("a.mha", head("UCHAR", false) + "few")),
              file("a.mha") + ": has 105 bytes, expected 126 bytes (2 x 3 x 4 of uint8 after 102 bytes of header)");
    EXPECT_EQ(refused(write("a.mha", "nothing")),
              file("a.mha") + ": is not MetaImage: its header has no 'ElementDataFile'");
    for (const std::string elsewhere : {"../a.raw", "/etc/passwd"}) {
        std::string text = head("UCHAR", false);
        text.replace(text.find("LOCAL"), 5, elsewhere);
        EXPECT_EQ(refused(write("a.mhd", text)), file("a.mhd") + ": its samples are in '" + elsewhere +
                                                     "', expected a file in its own folder or below");
    }
}

TEST_F(ScanFormats, NumPysArraysAreThoseOfFields) {
    // By NumPy 1.24: an array in Fortran's order, big endian.
    static const char kHead[] =
        "\223NUMPY\001\000v\000{'descr': '>i4', 'fortran_order': True, 'shape': (2, 3, 4), }                           "
        "                             \n";
    const std::string fortran = std::string(kHead, 128) + numbers<std::int32_t>(1, 24, true);
    std::string text = "{'descr': '<f2', 'fortran_order': False, 'shape': (2, 3, 4), }\n";
    const auto array = [&](const std::string& bytes) {
        return std::string("\x93NUMPY\1\0", 8) + std::string{static_cast<char>(text.size()), 0} + text + bytes;
    };
    expectCounting(read(write("f.npy", fortran)), "Fortran");
    // Halves of 1 to 24, with the last index fastest: (x, y, z) holds 1 + 12 x + 4 y + z.
    std::string halves;
    for (int i = 1; i <= 24; ++i) {
        const int exponent = static_cast<int>(std::log2(i));
        const int bits = (exponent + 15) << 10 | ((i << 10 >> exponent) & 0x3ff);
        halves += {static_cast<char>(bits & 0xff), static_cast<char>(bits >> 8)};
    }
    const SparseField c = read(write("c.npy", array(halves)));
    for (int x = 0; x < 2; ++x)
        for (int y = 0; y < 3; ++y)
            for (int z = 0; z < 4; ++z) EXPECT_EQ(valueAt(c, Int3(x, y, z)), float(1 + 12 * x + 4 * y + z));
    expectPlace(read(file("c.npy"), {{"spacing", "0.5, 0.5, 2"}}), Vec3(1, 1, 1), Vec3(0.5, 0.5, 2), "spacing");
    text.replace(text.find("(2, 3, 4)"), 9, "(2, 3)");
    EXPECT_EQ(
        refused(write("flat.npy", array(halves))),
        file("flat.npy") + ": its array is of shape (2, 3), expected (nx, ny, nz), or (nx, ny, nz, 3) for colours");
    text.replace(text.find("<f2"), 3, "|O");
    EXPECT_EQ(refused(write("odd.npy", array(halves))),
              file("odd.npy") + ": its array holds '|O', expected whole or real numbers");
    EXPECT_EQ(refused(write("junk.npy", "nothing, but long enough")),
              file("junk.npy") + ": is not a NumPy file (.npy)");
}

/// The words of an MRC header that mrcfile 1.5 writes for 2 x 3 x 4 samples.
std::string mrcHead(int mode, bool big, const std::array<int, 3>& axes = {1, 2, 3}) {
    std::string head(1024, '\0');
    const auto put = [&](int word, auto value) {
        std::string bytes(sizeof value, '\0');
        std::memcpy(bytes.data(), &value, sizeof value);
        if (big) std::reverse(bytes.begin(), bytes.end());
        head.replace(std::size_t(4 * (word - 1)), bytes.size(), bytes);
    };
    const int words[]{2, 3, 4, mode, 1, 2, 3, 2, 3, 4};
    for (int i = 0; i < 10; ++i) put(i + 1, words[i]);
    for (int k = 0; k < 3; ++k) {
        put(11 + k, 1.5f * float(words[7 + k]));
        put(14 + k, 90.0f);
        put(17 + k, axes[std::size_t(k)]);
    }
    head.replace(208, 4, "MAP ");
    head.replace(212, 2, big ? "\x11\x11" : "DD");
    return head;
}

TEST_F(ScanFormats, MrcMapsAreReadInTheirOrderOfAxes) {
    for (const bool big : {false, true}) {
        for (const auto& [mode, bytes] :
             std::vector<std::pair<int, std::string>>{{0, numbers<std::int8_t>(1, 24)},
                                                      {1, numbers<std::int16_t>(1, 24, big)},
                                                      {2, numbers<float>(1, 24, big)},
                                                      {6, numbers<std::uint16_t>(1, 24, big)}}) {
            const SparseField f = read(write("a.mrc", mrcHead(mode, big) + bytes));
            expectCounting(f, "mode " + std::to_string(mode));
            expectPlace(f, Vec3(1, 1, 1), Vec3(3, 4.5, 6), "1.5 A from 1, 2, 3 on");
        }
    }
    const SparseField turned = read(write("a.mrc", mrcHead(2, false, {3, 1, 2}) + numbers<float>(1, 24)));
    expectCounting(turned, "turned");
    // Columns run along z, whose cell of 6 has 4 intervals; rows along x, sections along y.
    expectPlace(turned, Vec3(1, 0, 0), Vec3(3, 4.5, 3), "columns");
    EXPECT_EQ(refused(write("a.mrc", mrcHead(4, false))),
              file("a.mrc") + ": holds samples of mode 4, expected 0, 1, 2, 6 or 12 (real numbers)");
    EXPECT_EQ(refused(write("a.mrc", "short")), file("a.mrc") + ": is not an MRC map: it is too short");
    EXPECT_EQ(refused(write("a.mrc", std::string(2000, 'x'))), file("a.mrc") + ": is not an MRC map");
}

/// By VTK 9: Int16 samples of an extent from 2, 0, -1 on, with the place of kMeta.
std::string vti(const std::string& more, const std::string& array, const std::string& behind = "") {
    return "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\"" + more +
           ">\n  <ImageData WholeExtent=\"2 3 0 2 -1 2\" Origin=\"10 20 30\" Spacing=\"2 3 4\" Direction=\"0 0 1 1 0 0 "
           "0 1 "
           "0\">\n  <Piece Extent=\"2 3 0 2 -1 2\">\n    <PointData Scalars=\"ct\">\n      <DataArray type=\"Int16\" "
           "Name=\"ct\" " +
           array + "\n    </PointData>\n    <CellData>\n    </CellData>\n  </Piece>\n  </ImageData>\n" + behind +
           "</VTKFile>\n";
}
const std::string kZlib = " compressor=\"vtkZLibDataCompressor\"";
const std::string kPacked =
    "AgAAAAAAAAAgAAAAAAAAABAAAAAAAAAAIgAAAAAAAAAYAAAAAAAAAA==eF4FwYUBwCAAACDs3vz/"
    "WiGIkqyomm6Ylu34/K4HBoAAiXheE2QQYhBmEGEQZRBjEGeQYAAABYAApQ==";

TEST_F(ScanFormats, VtkImageDataIsReadAndPlacedAsVtkDoes) {
    const std::string text =
        "1 2 3 4 5 6\n        7 8 9 10 11 12\n        13 14 15 16 17 18\n        19 20 21 22 23 24\n      </DataArray>";
    const std::string raw = std::string("0\0\0\0\0\0\0\0", 8) + numbers<std::int16_t>(1, 24);
    const std::vector<std::pair<std::string, std::string>> files{
        {"text", vti("", "format=\"ascii\" RangeMin=\"1\" RangeMax=\"24\">\n        " + text)},
        {"base64",
         vti(kZlib, "format=\"binary\" RangeMin=\"1\" RangeMax=\"24\">\n        " + kPacked + "\n      </DataArray>")},
        {"appended", vti("", "format=\"appended\" RangeMin=\"1\" RangeMax=\"24\" offset=\"0\" />",
                         "  <AppendedData encoding=\"raw\">\n   _" + raw + "\n  </AppendedData>\n")},
        {"appended base64", vti(kZlib, "format=\"appended\" offset=\"0\" />",
                                "  <AppendedData encoding=\"base64\">\n   _" + kPacked + "\n  </AppendedData>\n")}};
    for (const auto& [what, bytes] : files) {
        const SparseField f = read(write("a.vti", bytes));
        expectCounting(f, what);
        // What vtkImageData.TransformIndexToPhysicalPoint says of (2, 0, -1) and (3, 2, 2).
        expectPlace(f, Vec3(0), Vec3(6, 24, 30), what);
        expectPlace(f, Vec3(1, 2, 3), Vec3(18, 26, 36), what);
    }
}

TEST_F(ScanFormats, OtherVtkFilesAreRefusedWithTheReason) {
    const auto of = [&](const std::string& bytes) {
        return refused(write("a.vti", bytes)).substr(file("a.vti").size());
    };
    EXPECT_EQ(of("nothing"), ": is not a file of VTK");
    EXPECT_EQ(of("<VTKFile type=\"PolyData\">"), ": holds VTK's PolyData, expected ImageData");
    EXPECT_EQ(of(vti("", "format=\"ascii\">1 2 3</DataArray>")), ": is cut off: it has 3 samples, expected 24");
    EXPECT_EQ(of(vti(" compressor=\"vtkLZ4DataCompressor\"", "format=\"binary\">AgAA</DataArray>")),
              ": is compressed by 'vtkLZ4DataCompressor', expected vtkZLibDataCompressor, or none");
    EXPECT_EQ(of(vti(kZlib, "format=\"binary\">AgAA</DataArray>")), ": is cut off: its samples end too early");
    EXPECT_EQ(of(vti("", "NumberOfComponents=\"3\" format=\"ascii\">1</DataArray>")),
              ": has 3 numbers a sample, expected 1");
    EXPECT_EQ(of(vti("", "format=\"appended\" offset=\"0\" />")), ": is cut off: its appended data is missing");
    std::string huge = vti("", "format=\"ascii\">1</DataArray>");
    huge.replace(huge.find("2 3 0 2 -1 2"), 12, "0 999 0 999 0 999");
    EXPECT_EQ(of(huge), ": declares 2000000000 bytes of samples, more than its 413 compressed bytes can hold");
}

TEST_F(ScanFormats, OneVolumeOfFourDimensionsIsTakenByNumber) {
    const std::string space = "space: left-posterior-superior\nspace origin: (10,20,30)\nencoding: raw\n";
    const auto nrrd = [&](const std::string& name, const std::string& fields, const std::string& bytes) {
        return write(name, "NRRD0005\ntype: uint8\ndimension: 4\n" + space + fields + "\n" + bytes);
    };
    // As pynrrd 1.1 writes them: the list is the last axis, or the first one.
    const std::string last = nrrd("last.nrrd",
                                  "sizes: 2 3 4 2\nkinds: domain domain domain list\n"
                                  "space directions: (2,0,0) (0,3,0) (0,0,4) none\n",
                                  numbers<std::uint8_t>(1, 48));
    std::string mixed;
    for (int i = 0; i < 24; ++i) mixed += {static_cast<char>(1 + i), static_cast<char>(25 + i)};
    const std::string first = nrrd("first.nrrd",
                                   "sizes: 2 2 3 4\nkinds: vector domain domain domain\n"
                                   "space directions: none (2,0,0) (0,3,0) (0,0,4)\n",
                                   mixed);
    for (const std::string& path : {last, first}) {
        for (int k = 0; k < 2; ++k) {
            const SparseField f = read(path, {{"component", std::to_string(k)}});
            expectCounting(f, path, float(24 * k));
            expectPlace(f, Vec3(1, 1, 1), Vec3(12, 23, 34), path);
        }
        EXPECT_EQ(refused(path), path + ": holds 2 volumes, expected one; component = 0 to 1 takes one of them");
        EXPECT_EQ(refused(path, {{"component", "2"}}), path + ": holds 2 volumes, and no component 2");
    }
    EXPECT_EQ(refused(write("a.npy", "x"), {{"component", "0"}}),
              file("a.npy") + ": 'component' is for NRRD, NIfTI and TIFF files only");
}

/// The parts of the colours that expectColours() wants, the parts first or last.
std::string colourBytes(bool partsFirst) {
    std::string bytes;
    for (int k = 0; k < 72; ++k) {
        const int n = partsFirst ? 1 + k / 3 : 1 + k % 24, part = partsFirst ? k % 3 : k / 24;
        bytes += static_cast<char>(part == 0 ? n : part == 1 ? 2 * n : 255 - n);
    }
    return bytes;
}

TEST_F(ScanFormats, ColoursOfNrrdAreGridsBesideTheirLuma) {
    const std::string head = "NRRD0005\ntype: uint8\ndimension: 4\nencoding: raw\n";
    const std::string directions = "space: left-posterior-superior\nspace directions: ";
    const auto nrrd = [&](const std::string& name, const std::string& fields, bool partsFirst) {
        return write(name, head + fields + "\n" + colourBytes(partsFirst));
    };
    expectColours(nrrd("kind.nrrd", "sizes: 3 2 3 4\nkinds: RGB-color domain domain domain\n", true), 255,
                  "RGB of uint8");
    expectColours(nrrd("bare.nrrd", "sizes: 3 2 3 4\n", true), 255, "RGB of uint8");
    expectColours(nrrd("space.nrrd", "sizes: 3 2 3 4\n" + directions + "none (2,0,0) (0,3,0) (0,0,4)\n", true), 255,
                  "RGB of uint8");
    const std::string last = nrrd("last.nrrd", "sizes: 2 3 4 3\nkinds: domain domain domain RGB-color\n", false);
    expectColours(last, 255, "RGB of uint8");
    // One of its parts alone is a volume as any other. And what is a vector, or a list, is no colour.
    expectCounting(read(last, {{"component", "0"}}), "component");
    for (const std::string kind : {"vector", "3-vector", "list"}) {
        const std::string path = nrrd("other.nrrd", "sizes: 3 2 3 4\nkinds: " + kind + " domain domain domain\n", true);
        EXPECT_EQ(refused(path), path + ": holds 3 volumes, expected one; component = 0 to 2 takes one of them")
            << kind;
    }
}

TEST_F(ScanFormats, ColoursOfNumPyAreGridsBesideTheirLuma) {
    const auto array = [&](const std::string& name, bool fortran, const std::string& bytes) {
        const std::string text = std::string("{'descr': '|u1', 'fortran_order': ") + (fortran ? "True" : "False") +
                                 ", 'shape': (2, 3, 4, 3), }\n";
        return write(name,
                     std::string("\x93NUMPY\1\0", 8) + std::string{static_cast<char>(text.size()), 0} + text + bytes);
    };
    std::string c;
    for (int x = 0; x < 2; ++x)
        for (int y = 0; y < 3; ++y)
            for (int z = 0; z < 4; ++z) c += colourBytes(true).substr(std::size_t(3 * (x + 2 * y + 6 * z)), 3);
    expectColours(array("c.npy", false, c), 255, "RGB of uint8");
    expectColours(array("f.npy", true, colourBytes(false)), 255, "RGB of uint8");
}

TEST_F(ScanFormats, ScansOfOnePatientLieTogetherInOneSpace) {
    const auto nrrd = [&](const std::string& space) {
        return write("a.nrrd", "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 2 3 4\nspace: " + space +
                                   "\nspace directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (10,20,30)\n"
                                   "encoding: raw\n\n" +
                                   numbers<std::uint8_t>(1, 24));
    };
    // What SimpleITK, whose space is LPS, says of voxel (1, 1, 1).
    for (const auto& [space, lps] : std::vector<std::pair<std::string, Vec3>>{
             {"LPS", {12, 23, 34}}, {"RAS", {-12, -23, 34}}, {"LAS", {12, -23, 34}}}) {
        expectPlace(read(nrrd(space), {{"space", "LPS"}}), Vec3(1, 1, 1), lps, space);
        expectPlace(read(nrrd(space), {{"space", "RAS"}}), Vec3(1, 1, 1), Vec3(-lps.x, -lps.y, lps.z), space);
    }
    EXPECT_EQ(refused(nrrd("3D-right-handed"), {{"space", "LPS"}}),
              "'space' is LPS, but the file does not say where left and front are");
}

}  // namespace
}  // namespace scrim::test
