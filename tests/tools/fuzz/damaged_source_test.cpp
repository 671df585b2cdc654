// SPDX-License-Identifier: Apache-2.0
// Damaged scans and meshes, as guarded loads let volume sources read them: whatever is wrong, the process that wants
// the volume goes on, and so does the program that reads it. SCRIM_FUZZ_FILES=N asks for N damaged files of each kind.
#include "support/program_test.h"
#include "tools/fuzz/damage.h"

#include <scrim/base/error.h>
#include <scrim/guard/load_fields.h>

#include "support/dicom_files.h"
#include "support/source_files.h"
#include "support/tiff_files.h"

#include <cmath>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

namespace scrim::test {
namespace {

struct Kind {
    const char* source;
    const char* name;  ///< of the file: its ending says how it is read
    std::string bytes;
    std::string beside;  ///< what lies in `samples.bin`, and is damaged as well
};

std::string samples() {
    std::string bytes;
    for (int i = 0; i < 12 * 12 * 12; ++i) bytes += static_cast<char>(i * 7919 >> 4);
    return bytes;
}

std::vector<Kind> kinds() {
    const std::string head = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 12 12 12\nspacings: 1 2 3\n";
    std::string text;
    for (const char c : samples()) text += std::to_string(static_cast<unsigned char>(c)) + " ";
    NiftiHeader nifti;
    nifti.dims[1] = nifti.dims[2] = nifti.dims[3] = 12;
    nifti.sform = true;
    const std::string packed = gzipped(samples());
    const std::string meta = "NDims = 3\nDimSize = 12 12 12\nElementType = MET_UCHAR\n";
    uLongf bytes = compressBound(samples().size());
    std::string deflated(bytes, '\0');
    compress(reinterpret_cast<Bytef*>(deflated.data()), &bytes, reinterpret_cast<const Bytef*>(samples().data()),
             samples().size());
    deflated.resize(bytes);
    const std::string array = "{'descr': '|u1', 'fortran_order': False, 'shape': (12, 12, 12), }\n";
    const std::string numpy = std::string("\x93NUMPY\1\0", 8) + std::string{static_cast<char>(array.size()), 0} + array;
    std::string map(1024, '\0');
    const std::int32_t words[]{12, 12, 12, 0, 0, 0, 0, 12, 12, 12};
    std::memcpy(map.data(), words, sizeof words);
    std::memcpy(map.data() + 208, "MAP DD", 6);
    const std::string vti =
        "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 11 0 11 0 11\"><PointData><DataArray type=\"UInt8\"";
    const std::string vtiEnd = "</DataArray></PointData></ImageData><AppendedData encoding=\"raw\">";
    DicomSlice frames = countingFrames();
    frames.modality = DicomSlice::kEnhancedCt;
    frames.framePositions = {"10\\20\\33", "10\\20\\30", "10\\20\\39", "10\\20\\36"};
    TiffPages plain;
    plain.columns = plain.rows = 12;
    plain.description = "ImageJ=1.54\nimages=12\nslices=12\nunit=um\nspacing=2\n";
    for (std::size_t z = 0; z < 12; ++z) plain.pages.push_back(samples().substr(144 * z, 144));
    const std::string tiffs = std::string(SCRIM_FUZZ_TIFFS) + "/";
    return {
        {"scan", "plain.tif", plain.bytes(), ""},
        {"scan", "lzw.tif", readBytes(tiffs + "pillow_lzw.tif"), ""},
        {"scan", "deflated.tif", readBytes(tiffs + "pillow_adobe_deflate.tif"), ""},
        {"scan", "floats.tif", readBytes(tiffs + "pillow_float_differences.tif"), ""},
        {"scan", "tiles.tif", readBytes(tiffs + "tiles.tif"), ""},
        {"scan", "ome.tif", readBytes(tiffs + "ome.tif"), ""},
        {"scan", "raw.nrrd", head + "encoding: raw\n\n" + samples(), ""},
        {"scan", "gzip.nrrd", head + "encoding: gzip\n\n" + packed, ""},
        {"scan", "text.nrrd", head + "encoding: ascii\n\n" + text, ""},
        {"scan", "apart.nhdr", head + "encoding: gzip\ndata file: samples.bin\n", packed},
        {"scan", "a.nii", nifti.bytes() + samples(), ""},
        {"scan", "a.nii.gz", gzipped(nifti.bytes() + samples()), ""},
        {"scan", "space.nrrd", "NRRD0004\nspace: LPI\n" + head.substr(9) + "encoding: raw\n\n" + samples(), ""},
        {"scan", "a.mha", meta + "CompressedData = True\nElementDataFile = LOCAL\n" + deflated, ""},
        {"scan", "a.mhd", meta + "ElementDataFile = samples.bin\n", samples()},
        {"scan", "a.npy", numpy + samples(), ""},
        {"scan", "a.mrc", map + samples(), ""},
        {"scan", "text.vti", vti + " format=\"ascii\">" + text + "</DataArray></PointData></ImageData>", ""},
        {"scan", "raw.vti",
         vti + " format=\"appended\" offset=\"0\"/>" + vtiEnd + "_" + std::string("\xc0\x06\0\0", 4) + samples(), ""},
        {"scan", "a.dcm", frames.bytes(), ""},
        {"mesh", "a.obj", std::string("mtllib samples.bin\n") + kCubeObj, "newmtl red\n"},
        {"mesh", "text.ply", cubePly("ascii"), ""},
        {"mesh", "binary.ply", cubePly("binary_little_endian"), ""},
    };
}

class DamagedSource : public ProgramTest {
  protected:
    void SetUp() override {
        ::setenv("SCRIM_PLUGIN_PATH", SCRIM_BUILT_SOURCES, 1);
        m_options.volumes = VolumeLoading::guarded;
        m_options.memory = std::size_t{1} << 30;
    }
    void TearDown() override { ::unsetenv("SCRIM_PLUGIN_PATH"); }

    std::vector<SparseField> read(const Kind& kind, const std::string& name) const {
        SourceParameters parameters{{"file", file(name)}};
        if (kind.source == std::string("mesh")) parameters.emplace_back("resolution", "12");
        return sourceFields(kind.source, parameters, m_options, {});
    }
    /// Reads the file, and holds what comes of it against what may come of it.
    void readDamaged(const Kind& kind, const std::string& name, Outcomes& outcomes) const {
        try {
            for (const SparseField& field : read(kind, name)) {
                for (std::size_t i = 0; i < field.blockCount(); ++i)
                    for (int n = 0; n < kBlockVoxels; ++n) ASSERT_TRUE(std::isfinite(field.block(i)[n]));
            }
            ++outcomes.read;
        } catch (const Error& error) {
            ++outcomes.refused;
            outcomes.expectTold(error, std::string("source '") + kind.source + "'");
            EXPECT_LT(std::string(error.what()).size(), 2500u) << error.what();
        }
    }

    LoadOptions m_options;
};

TEST_F(DamagedSource, OfEveryKindIsRefusedOrRead) {
    const int files = damagedFiles(60, 10);
    std::mt19937 random(11);
    for (const Kind& kind : kinds()) {
        const std::string good = std::string("good.") + kind.name, bad = std::string("bad.") + kind.name;
        Outcomes outcomes;
        for (int i = 0; i < files; ++i) {
            const bool besideIt = !kind.beside.empty() && i % 2 == 1;
            const std::string bytes = damaged(besideIt ? kind.beside : kind.bytes, random);
            write("samples.bin", besideIt ? bytes : kind.beside);
            write(bad, besideIt ? kind.bytes : bytes);
            readDamaged(kind, bad, outcomes);
            if (HasFailure()) return writeBytes(::testing::TempDir() + "/scrim_damaged." + kind.name, bytes);
        }
        outcomes.print(kind.name);
        write("samples.bin", kind.beside);
        std::filesystem::remove(file(bad));  // a DICOM file of the same series would be a part of it
        write(good, kind.bytes);
        EXPECT_GT(read(kind, good).at(0).activeVoxels, 0u) << kind.name;
        std::filesystem::remove(file(good));
    }
}

// Assimp knows sixty formats. What does not end as an OBJ or PLY file never comes near them.
TEST_F(DamagedSource, OfAKindThatIsNotReadIsRefusedByItsName) {
    for (const std::string& name :
         {std::string("a.stl"), std::string("a.gltf"), std::string("a.glb"), std::string("a.fbx")}) {
        write(name, name == "a.stl" ? "solid a\nendsolid a\n" : "glTF");
        try {
            read({"mesh", "", "", ""}, name);
            ADD_FAILURE() << name;
        } catch (const Error& error) {
            EXPECT_EQ(std::string(error.what()),
                      "source 'mesh': " + file(name) + ": expected a file that ends in .obj or .ply");
        }
    }
}

TEST_F(DamagedSource, IsAnErrorOfTheProgram) {
    write("scene.toml",
          kCamera + "[[volume]]\nsource = \"mesh\"\nparameters = { file = \"a.ply\", resolution = 12 }\n" + kLight);
    std::mt19937 random(13);
    for (int i = 0; i < 8; ++i) {
        write("a.ply", damaged(cubePly("binary_little_endian"), random));
        expectPlannedOrLocated(run({"plan", "scene.toml"}));
    }
}

}  // namespace
}  // namespace scrim::test
