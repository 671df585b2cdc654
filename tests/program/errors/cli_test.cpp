// SPDX-License-Identifier: Apache-2.0
// Bad input of every kind: each gives its exit status and one line that says where, what was found and what
// there is to choose from, and leaves no file behind.
#include "support/program_test.h"

#include <scrim/image/exr_read.h>

#include <algorithm>
#include <thread>

#include <linux/capability.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace scrim::test {
namespace {

constexpr int kUsage = 2, kInput = 3, kOutput = 4, kMemory = 33;

using CliErrors = ProgramTest;

// ---- assets

TEST_F(CliErrors, MissingAssetIsNamed) {
    expectFailure({"render", "nothere.vdb"}, kInput, "nothere.vdb: no such file");
}

TEST_F(CliErrors, MissingAssetOfInfoIsNamed) {
    expectFailure({"info", "nothere.vdb"}, kInput, "nothere.vdb: no such file");
}

TEST_F(CliErrors, MissingSceneIsNamed) {
    expectFailure({"render", "nothere.toml"}, kInput, "nothere.toml: there is no such scene file");
}

TEST_F(CliErrors, FileThatIsNoVdbIsRefused) {
    write("text.vdb", "this is a letter, and not a volume\n");
    expectFailure({"render", "text.vdb"}, kInput, "text.vdb: not a VDB file (starts with 'this is ')");
}

TEST_F(CliErrors, FolderInPlaceOfAnAssetIsRefused) {
    std::filesystem::create_directory(file("folder.vdb"));
    expectFailure({"render", "folder.vdb"}, kInput, "folder.vdb: is a folder, not a VDB file");
}

TEST_F(CliErrors, PipeInPlaceOfAnAssetIsRefused) {
    ASSERT_EQ(::mkfifo(file("pipe.vdb").c_str(), 0600), 0);
    expectFailure({"render", "pipe.vdb"}, kInput, "pipe.vdb: is not a regular file");
}

TEST_F(CliErrors, TruncatedVdbIsRefused) {
    const std::string bytes = readBytes(file("smoke.vdb"));
    write("cut.vdb", bytes.substr(0, bytes.size() * 2 / 3));
    const ProgramResult result = run({"render", "cut.vdb"});
    EXPECT_EQ(result.status, kInput) << result.err;
    EXPECT_EQ(result.err.rfind("scrim: error: cut.vdb: truncated or damaged: ", 0), 0u) << result.err;
    EXPECT_FALSE(exists("cut.exr"));
}

TEST_F(CliErrors, UnknownGridListsThoseThereAre) {
    makeVdb(file("two.vdb"), {{.name = "fuel", .voxels = {{{0, 0, 0}, 1}}},
                              {.name = "speed", .type = "vec3s", .voxels = {{{0, 0, 0}, 1}}}});
    write("grid.toml", kCamera + "[[volume]]\nfile = \"two.vdb\"\ndensity = { grid = \"smoke\" }\n");
    expectFailure({"render", "grid.toml"}, kInput,
                  "grid.toml:8:20: two.vdb: no grid 'smoke'; it holds 'fuel' (float), 'speed' (vec3s)");
    expectFailure({"render", "two.vdb", "-q", "--set", "volume.two.density.grid=smoke"}, kInput,
                  "--set volume.two.density.grid: two.vdb: no grid 'smoke'; it holds 'fuel' (float), 'speed' "
                  "(vec3s)");
}

/// A grid of a type that is no density.
void expectTypeRefused(const std::string& folder, const std::string& type, const std::string& valueType) {
    makeVdb(folder + "/odd.vdb", {{.name = "odd", .type = type, .voxels = {{{0, 0, 0}, 1}}}});
    const ProgramResult result = runProgram(folder, {"render", "odd.vdb"});
    EXPECT_EQ(result.status, kInput);
    EXPECT_EQ(result.err, "scrim: error: odd.vdb: holds no scalar grid, only 'odd' (" + valueType + ")\n");
    EXPECT_FALSE(std::filesystem::exists(folder + "/odd.exr"));
}

TEST_F(CliErrors, VectorGridIsRefused) {
    expectTypeRefused(m_folder.path(), "vec3s", "vec3s");
}
TEST_F(CliErrors, GridOfIntegerVectorsIsRefused) {
    expectTypeRefused(m_folder.path(), "vec3i", "vec3i");
}

TEST_F(CliErrors, NamedGridOfAnotherTypeIsRefusedWithTheUsableOnes) {
    makeVdb(file("two.vdb"), {{.name = "fuel", .voxels = {{{0, 0, 0}, 1}}},
                              {.name = "id", .type = "vec3i", .voxels = {{{0, 0, 0}, 1}}}});
    write("grid.toml", kCamera + "[[volume]]\nfile = \"two.vdb\"\ndensity = { grid = \"id\" }\n");
    expectFailure({"render", "grid.toml"}, kInput,
                  "grid.toml:8:20: two.vdb: grid 'id' holds vec3i values, where a scalar grid is expected; of those "
                  "there is 'fuel'");
}

TEST_F(CliErrors, EmptyGridGivesABlackFrameAndAWarning) {
    makeVdb(file("empty.vdb"), {MadeGrid{}});
    const ProgramResult result = runWell({"render", "empty.vdb", "--res", "20x10", "-q"});
    const std::string said =
        "nothing to render: grid 'density' has no active voxels with values above 0 (below 1.2e-38 they count as 0)\n";
    EXPECT_EQ(result.err, "scrim: warning: empty.vdb: " + said);
    const Image picture = readExr(file("empty.exr"));
    EXPECT_EQ(picture.rgba, std::vector<float>(4, 0.0f));  // one pixel: EXR cannot say "nothing"
    EXPECT_EQ(readExrAttributes(file("empty.exr")).at("displayWindow"), "0 0 20 10");
    makeVdb(file("zeros.vdb"), {{.voxels = box({0, 0, 0}, {7, 7, 7}, 0)}});
    EXPECT_EQ(runWell({"render", "zeros.vdb", "--res", "20x10", "-q"}).err, "scrim: warning: zeros.vdb: " + said);
}

// Means of values near the smallest that a float holds count as 0: the coarser field would be empty, and so out of
// view.
TEST_F(CliErrors, TheSmallestValuesAreInView) {
    makeVdb(file("least.vdb"), {{.voxels = box({0, 0, 0}, {7, 7, 7}, 2e-38)}});
    write("least.toml", kCamera + "[[volume]]\nfile = \"least.vdb\"\n" + kLight);
    EXPECT_EQ(runWell({"render", "least.toml", "-o", "least.exr", "-q", "--set", "camera.position=[0,0,900]"}).err, "");
}

TEST_F(CliErrors, UnknownSourceOfASceneIsLocated) {
    write("source.toml", kCamera + "[[volume]]\nsource = \"nois\"\n");
    const ProgramResult result = run({"render", "source.toml"});
    EXPECT_EQ(result.status, kInput);
    EXPECT_EQ(result.err.rfind("scrim: error: source.toml:7:10: no volume source 'nois' in ", 0), 0u) << result.err;
}

// ---- scenes

TEST_F(CliErrors, MalformedTomlIsLocated) {
    write("bad.toml", kCamera + "[[volume]\n");
    const ProgramResult result = run({"render", "bad.toml"});
    EXPECT_EQ(result.status, kInput);
    EXPECT_EQ(result.err.rfind("scrim: error: bad.toml:6:", 0), 0u) << result.err;
    EXPECT_NE(result.err.find("malformed TOML"), std::string::npos) << result.err;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1);
}

TEST_F(CliErrors, UnknownKeyIsLocatedAndTheNearestOneNamed) {
    write("bad.toml", "[camera]\nposition = [0, 0, 40]\ntarget = [0, 0, 0]\nfow = 35\n" + kVolume);
    const ProgramResult result = run({"render", "bad.toml"});
    EXPECT_EQ(result.status, kInput);
    EXPECT_EQ(result.err.rfind("scrim: error: bad.toml:4:", 0), 0u) << result.err;
    EXPECT_NE(result.err.find("'fow'"), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("did you mean 'fov'?"), std::string::npos) << result.err;
}

TEST_F(CliErrors, WrongTypeIsLocated) {
    write("bad.toml", "[camera]\nposition = [0, 0, 40]\ntarget = [0, 0, 0]\nfov = \"wide\"\n" + kVolume);
    const ProgramResult result = run({"render", "bad.toml"});
    EXPECT_EQ(result.status, kInput);
    EXPECT_EQ(result.err.rfind("scrim: error: bad.toml:4:7: 'fov' is ", 0), 0u) << result.err;
    EXPECT_NE(result.err.find("expected a number"), std::string::npos) << result.err;
}

TEST_F(CliErrors, ValueOutOfRangeIsLocated) {
    write("bad.toml", "[camera]\nposition = [0, 0, 40]\ntarget = [0, 0, 0]\nfov = 180\n" + kVolume);
    expectFailure({"render", "bad.toml"}, kInput,
                  "bad.toml:4:7: 'fov' is 180; expected a number greater than 0 and less than 180 degrees");
}

TEST_F(CliErrors, OverrideOutOfRangeNamesTheOption) {
    expectFailure({"render", "scene.toml", "--set", "camera.fov=180"}, kInput,
                  "--set camera.fov: 'fov' is 180; expected a number greater than 0 and less than 180 degrees");
}

TEST_F(CliErrors, CameraAtItsOwnTargetIsLocated) {
    write("bad.toml", "[camera]\nposition = [0, 0, 40]\ntarget = [0, 0, 40]\n" + kVolume);
    const ProgramResult result = run({"render", "bad.toml"});
    EXPECT_EQ(result.status, kInput);
    EXPECT_EQ(result.err.rfind("scrim: error: bad.toml:3:10: the camera is at the same point as its 'target'", 0), 0u)
        << result.err;
}

TEST_F(CliErrors, ZeroResolutionOfASceneIsLocated) {
    write("bad.toml", "[camera]\nposition = [0, 0, 40]\ntarget = [0, 0, 0]\nresolution = [0, 24]\n" + kVolume);
    const ProgramResult result = run({"render", "bad.toml"});
    EXPECT_EQ(result.status, kInput);
    EXPECT_EQ(result.err.rfind("scrim: error: bad.toml:4:15: 'resolution[0]' is 0; expected ", 0), 0u) << result.err;
}

TEST_F(CliErrors, ZeroResolutionOfTheCommandLineIsUsage) {
    expectFailure({"render", "scene.toml", "--res", "0x24"}, kUsage,
                  "--res 0x24: expected WIDTHxHEIGHT, each from 1 to 65536 pixels");
    expectFailure({"render", "scene.toml", "--res", "\u00b2x1"}, kUsage,
                  "--res \u00b2x1: expected WIDTHxHEIGHT, each from 1 to 65536 pixels");
}

TEST_F(CliErrors, TextThatIsNotUtf8IsLocated) {
    write("s.toml", kCamera + "[[volume]]\nname = \"caf\xe9\"\nfile = \"smoke.vdb\"\n" + kLight);
    expectFailure({"render", "s.toml"}, kInput, "s.toml:7:12: the byte 0xe9 is not UTF-8; scenes must be UTF-8 text");
    expectFailure({"render", "scene.toml", "--set", "volume[0].file=caf\xe9.vdb"}, kInput,
                  "--set volume[0].file: it is not UTF-8; scenes must be UTF-8 text");
    std::filesystem::copy_file(file("smoke.vdb"), file("caf\xe9.vdb"));
    expectFailure({"render", "caf\xe9.vdb", "--print-scene"}, kUsage,
                  "caf\xe9.vdb: the name is not UTF-8, so no scene can name it; rename it, or make a link to it");
}

// ---- output

TEST_F(CliErrors, OutputFolderThatCannotBeMadeIsNamed) {
    expectFailure({"render", "scene.toml", "-o", "/proc/no/x.exr"}, kOutput,
                  "cannot write '/proc/no/x.exr': cannot make the folder '/proc/no': No such file or directory");
    expectFailure({"render", "scene.toml", "-o", "smoke.vdb/x.exr"}, kOutput,
                  "cannot write 'smoke.vdb/x.exr': 'smoke.vdb' is not a folder");
}

TEST_F(CliErrors, OutputThatIsAFolderIsRefused) {
    std::filesystem::create_directory(file("x.exr"));
    expectFailure({"render", "scene.toml", "-o", "x.exr"}, kOutput, "cannot write 'x.exr': it is a folder");
}

TEST_F(CliErrors, FolderWithoutPermissionIsRefused) {
    std::filesystem::create_directory(file("sealed"));
    std::filesystem::permissions(file("sealed"),
                                 std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
    // Root may write everywhere, unless a thread and what it starts are forbidden to.
    std::thread([&] {
        if (::geteuid() == 0) {
            ASSERT_EQ(::prctl(PR_CAPBSET_DROP, CAP_DAC_OVERRIDE, 0, 0, 0), 0);
        }
        expectFailure({"render", "scene.toml", "-o", "sealed/x.exr"}, kOutput,
                      "cannot write 'sealed/x.exr': Permission denied");
    }).join();
}

TEST_F(CliErrors, UnwritableStatsAreFoundBeforeTheRender) {
    expectFailure({"render", "scene.toml", "--stats", "smoke.vdb/s.json"}, kOutput,
                  "cannot write 'smoke.vdb/s.json': 'smoke.vdb' is not a folder");
}

TEST_F(CliErrors, OutputOfAnotherKindIsUsage) {
    expectFailure({"render", "scene.toml", "-o", "x.png"}, kUsage,
                  "the output 'x.png' does not end in '.exr'; --preview writes other kinds of pictures");
}

TEST_F(CliErrors, ManyFramesInOneFileAreRefused) {
    expectFailure({"render", "scene.toml", "-o", "x.exr", "--frames", "1-3"}, kUsage,
                  "all 3 frames would be written to 'x.exr'; put the frame into its name: x.####.exr");
}

TEST_F(CliErrors, TwoInputsInOneFileAreRefused) {
    expectFailure({"render", "scene.toml", "smoke.vdb", "-o", "x.exr"}, kUsage,
                  "'x.exr' would be written twice, for the picture of scene.toml and for the picture of smoke.vdb");
}

// ---- colour and memory

TEST_F(CliErrors, UnreadableOcioConfigIsNamed) {
    const ProgramResult result = run({"render", "scene.toml", "--ocio", "no.ocio"});
    EXPECT_EQ(result.status, kInput);
    EXPECT_EQ(result.err.rfind("scrim: error: cannot read the OpenColorIO config 'no.ocio': ", 0), 0u) << result.err;
    EXPECT_FALSE(exists("scene.exr"));
}

TEST_F(CliErrors, OcioConfigThatRefersToItselfIsRefusedBeforeTheRender) {
    write("ring.ocio",
          "ocio_profile_version: 1\nroles: {scene_linear: lin, default: lin}\n"
          "displays:\n  d: [!<View> {name: v, colorspace: a}]\n"
          "colorspaces:\n  - !<ColorSpace> {name: lin}\n"
          "  - !<ColorSpace> {name: a, from_reference: !<ColorSpaceTransform> {src: lin, dst: a}}\n");
    const std::string ring = "in the OpenColorIO config 'ring.ocio' the colour space 'a' refers to itself";
    expectFailure({"render", "scene.toml", "--ocio", "ring.ocio", "--preview", "p.png"}, kInput,
                  "cannot make the view 'v' of display 'd': " + ring);
    expectFailure({"render", "scene.toml", "--ocio", "ring.ocio", "--set", "output.colorspace=a"}, kInput,
                  "--set output.colorspace: 'colorspace': cannot convert from 'lin' to 'a': " + ring);
}

TEST_F(CliErrors, UnreadableOcioConfigOfTheEnvironmentIsNoSilentFallback) {
    write("bad.ocio", "nonsense");
    const ProgramResult result = run({"render", "scene.toml"}, {.environment = {{"OCIO", file("bad.ocio")}}});
    EXPECT_EQ(result.status, kInput);
    EXPECT_NE(result.err.find("bad.ocio"), std::string::npos) << result.err;
    EXPECT_FALSE(exists("scene.exr"));
}

TEST_F(CliErrors, MemoryLimitBelowTheVolumesSaysWhatTheyTake) {
    expectFailure({"render", "scene.toml", "--memory", "10K"}, kMemory,
                  "the volumes take 16.1 KB, which uses up the memory limit of 10.0 KB (--memory)");
}

TEST_F(CliErrors, MemoryLimitBelowOneSheetIsRefused) {
    const ProgramResult result = run({"render", "scene.toml", "--res", "2048x2048", "--memory", "1M"});
    EXPECT_EQ(result.status, kMemory);
    EXPECT_EQ(result.err.rfind("scrim: error: one sheet at a time needs ", 0), 0u) << result.err;
    EXPECT_FALSE(exists("scene.exr"));
}

// ---- the command line

TEST_F(CliErrors, ColonInAFrameRangeIsRefused) {
    expectFailure(
        {"render", "scene.toml", "--frames", "1:5"}, kUsage,
        "frame range '1:5': ':' is not supported, because farm managers interpret it differently; write 1-48x2 for "
        "every second frame");
}

TEST_F(CliErrors, UnknownOptionIsNamedWithTheNearest) {
    expectFailure({"render", "scene.toml", "--prevew", "x.png"}, kUsage,
                  "The following argument was not expected: --prevew; did you mean '--preview'?");
}

TEST_F(CliErrors, UnknownCommandListsTheCommands) {
    expectFailure({"rendr", "scene.toml"}, kUsage,
                  "unknown command 'rendr'; expected 'render', 'plan', 'study', 'bake', 'info', 'make', 'merge', "
                  "'view' or 'help'");
}

TEST_F(CliErrors, UnknownQualityListsThePresets) {
    expectFailure({"render", "scene.toml", "--quality", "best"}, kUsage,
                  "--quality 'best': expected 'draft', 'standard', 'high' or 'ultra'");
}

TEST_F(CliErrors, UnknownKindOfInputIsUsage) {
    expectFailure(
        {"render", "smoke.png"}, kUsage,
        "smoke.png: expected a scene (.toml), an asset (.vdb, .nvdb, .ply) or a scan (.nrrd, .nhdr, .nii, .nii.gz, "
        ".hdr, .mha, .mhd, .npy, .mrc, .vti, .tif, .dcm, or a folder of DICOM or TIFF slices)");
}

TEST_F(CliErrors, NoInputIsUsage) {
    expectFailure({"render"}, kUsage, "render: expected one or more SCENE.toml or ASSET.vdb; see scrim render --help");
}

TEST_F(CliErrors, CropOutsideThePictureIsUsage) {
    expectFailure({"render", "scene.toml", "--crop", "40,0,50,10"}, kUsage,
                  "the crop 40,0,50,10 holds no pixel of the picture, which is 0,0,32,24");
}

TEST_F(CliErrors, CropThatIsNoneIsUsage) {
    expectFailure({"render", "scene.toml", "--crop", "10,10,5,20"}, kUsage,
                  "--crop 10,10,5,20: expected X0,Y0,X1,Y1 in pixels with X0 < X1 and Y0 < Y1");
}

TEST_F(CliErrors, MemoryThatIsNoSizeIsUsage) {
    for (const std::string text : {"8X", "G", "", " ", "-1", "0", "1.5G", "\u00b2G", "nan", "99999999999999999999G"})
        expectFailure({"render", "scene.toml", "--memory", text}, kUsage,
                      "--memory " + text + ": expected a size such as 8G, 512M, 64K, or a number of bytes");
}

TEST_F(CliErrors, UnknownParameterOfASourceListsThem) {
    const ProgramResult result = run({"make", "noise", "resolutoin=32", "-o", "x.vdb"});
    EXPECT_EQ(result.status, kInput);
    EXPECT_EQ(result.err.rfind("scrim: error: source 'noise': unknown parameter 'resolutoin', expected ", 0), 0u)
        << result.err;
    EXPECT_FALSE(exists("x.vdb"));
}

// ---- missing frames

class CliMissingFrame : public ProgramTest {
  protected:
    void SetUp() override {
        ProgramTest::SetUp();
        for (const char* name : {"s.0001.vdb", "s.0003.vdb"}) std::filesystem::copy_file(file("smoke.vdb"), file(name));
        write("seq.toml", kCamera + "[[volume]]\nname = \"fog\"\nfile = \"s.####.vdb\"\n" + kLight);
    }
    const std::string m_problem =
        "seq.toml:8:8: volume 'fog': there is no file 's.0002.vdb' for frame 2; the sequence "
        "has frames 1 to 3";
};

TEST_F(CliMissingFrame, IsAnErrorByDefault) {
    expectFailure({"render", "seq.toml", "--frames", "2"}, kInput, m_problem);
}

TEST_F(CliMissingFrame, StopsAfterTheFramesBeforeIt) {
    const ProgramResult result = run({"render", "seq.toml", "--frames", "1-3", "-o", "o.#.exr"});
    EXPECT_EQ(result.status, kInput);
    EXPECT_EQ(result.lastErrorLine(), "scrim: error: " + m_problem);
    EXPECT_TRUE(exists("o.1.exr"));
    EXPECT_FALSE(exists("o.2.exr") || exists("o.3.exr"));
}

TEST_F(CliMissingFrame, IsBlackWhereAllowed) {
    const ProgramResult result = runWell({"render", "seq.toml", "--frames", "2", "--missing", "black", "-q"});
    EXPECT_EQ(result.err, "scrim: warning: frame 2: black instead: " + m_problem + "\n");
    EXPECT_EQ(readExr(file("seq.exr")).rgba, std::vector<float>(4, 0.0f));
}

TEST_F(CliMissingFrame, IsSkippedWhereAllowed) {
    const ProgramResult result =
        runWell({"render", "seq.toml", "--frames", "1-3", "--missing", "skip", "-o", "o.#.exr", "-q"});
    EXPECT_EQ(result.err, "scrim: warning: frame 2 is skipped: " + m_problem + "\n");
    EXPECT_TRUE(exists("o.1.exr") && exists("o.3.exr"));
    EXPECT_FALSE(exists("o.2.exr"));
}

TEST_F(CliMissingFrame, SequenceDemandsFrames) {
    expectFailure({"render", "seq.toml"}, kUsage,
                  "seq.toml: 's.####.vdb' is a sequence; give the frames with --frames (files exist for 1 to 3)");
}

}  // namespace
}  // namespace scrim::test
