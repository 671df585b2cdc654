// SPDX-License-Identifier: Apache-2.0
// Shots: what the program does with a scene, a program of someone else's can do through the library, with the same
// pixels.
#include <scrim/scrim.h>

#include <scrim/image/exr_read.h>

#include "support/expect_error.h"
#include "support/run_program.h"
#include "support/temp_folder.h"
#include "support/vdb_make.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>
#include <thread>
#include <vector>

namespace scrim::test {
namespace {

const std::string kScene = R"(
[camera]
position = [0, 0, 40]
target = [0, 0, 0]
fov = 35
resolution = [32, 24]
[[volume]]
name = "smoke"
file = "smoke.vdb"
[volume.medium]
extinction_tint = [1, 0.8, 0.6]
[[light]]
name = "key"
type = "distant"
direction = [-1, -1, -1]
intensity = 3
[[light]]
name = "rim"
type = "point"
position = [20, 10, -15]
intensity = 900
[ambient]
color = [0.1, 0.1, 0.2]
[output]
file = "shot.####.exr"
type = "float"
layers = ["light", "ambient", "depth", "transmittance"]
)";

std::string bytesOf(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

class ShotTest : public ::testing::Test {
  protected:
    void SetUp() override {
        makeVdb(file("smoke.vdb"), {{.voxels = box({-6, -6, -6}, {6, 6, 6}, 0.2)}});
        writeBytes(file("shot.toml"), kScene);
    }

    std::string file(const std::string& name) const { return m_folder.file(name); }
    Shot open(const std::vector<std::string>& overrides = {}, const OpenOptions& options = {}) const {
        return Shot::open(file("shot.toml"), overrides, options);
    }
    /// The program's picture of the same frame.
    void runProgramOn(const std::vector<std::string>& arguments) const {
        std::vector<std::string> all{"render", file("shot.toml"), "-q"};
        all.insert(all.end(), arguments.begin(), arguments.end());
        const ProgramResult result = runProgram(m_folder.path(), all);
        ASSERT_EQ(result.status, 0) << result.err;
    }

  private:
    TempFolder m_folder;
};

TEST_F(ShotTest, HasThePixelsAndTheFileOfTheProgram) {
    runProgramOn({"--frames", "7", "--set", "camera.fov=30", "-o", "program.####.exr"});
    ShotFrame frame = open({"camera.fov=30"}).render(7);
    const Image picture = readExr(file("program.0007.exr"));
    EXPECT_EQ(reframed(frame.image(), picture.window).rgba, picture.rgba);
    EXPECT_EQ(frame.image().window, (PixelWindow{0, 0, 32, 24}));
    frame.write(file("library.####.exr"));
    EXPECT_EQ(frame.report().file, file("library.0007.exr"));
    EXPECT_EQ(bytesOf(file("library.0007.exr")), bytesOf(file("program.0007.exr")));
}

TEST_F(ShotTest, WritesWhereTheSceneSays) {
    ShotFrame frame = open({"output.preview={file=\"look.png\"}"}).render(3);
    frame.write();
    frame.preview();
    EXPECT_FALSE(bytesOf(file("shot.0003.exr")).empty());
    EXPECT_EQ(bytesOf(file("look.png")).substr(1, 3), "PNG");
    EXPECT_EQ(errorOf(ErrorKind::usage, [&] { frame.write("a.png"); }), "the picture 'a.png' does not end in '.exr'");
}

TEST_F(ShotTest, KeepsTheFramingAndVerificationOfTheProgram) {
    const ProgramResult result =
        runProgram(file("."), {"render", "smoke.vdb", "--res", "40x30", "--verify", "20", "-q", "-o", "program.exr"});
    ASSERT_EQ(result.status, 0) << result.err;
    OpenOptions opening;
    opening.resolution = Int2(40, 30);
    RenderOptions options;
    options.verify = 20;
    ShotFrame frame = Shot::open(file("smoke.vdb"), {}, opening).render(1, options);
    ASSERT_TRUE(frame.report().verification);
    EXPECT_GE(frame.report().verification->pixels, 20);
    EXPECT_LT(frame.report().verification->error, 0.1);
    const std::vector<ExaminedPixel>& examined = frame.report().verification->examined;
    ASSERT_EQ(int(examined.size()), frame.report().verification->pixels);
    double mean = 0;
    for (const ExaminedPixel& pixel : examined)
        for (std::size_t c = 0; c < 3; ++c) {
            EXPECT_FLOAT_EQ(float(pixel.rendered[c]), frame.image().rgba[frame.image().indexOf(pixel.x, pixel.y) + c]);
            mean += pixel.reference[c] / 3 / double(examined.size());
        }
    EXPECT_NEAR(frame.report().verification->mean, mean, 1e-12 * mean);
    EXPECT_FALSE(frame.report().tolerance);
    EXPECT_NE(frame.report().planJson.find("\"groups\""), std::string::npos);
    const Image picture = readExr(file("program.exr"));  // half
    const Image same = reframed(frame.image(), picture.window);
    for (std::size_t i = 0; i < picture.rgba.size(); ++i)
        ASSERT_NEAR(same.rgba[i], picture.rgba[i], 1e-3 * std::max(1.0f, picture.rgba[i]));
}

TEST_F(ShotTest, GivesLayersByName) {
    const ShotFrame frame = open().render(1);
    EXPECT_EQ(frame.layerNames(),
              (std::vector<std::string>{"light.key", "light.rim", "ambient", "depth", "transmittance"}));
    const std::vector<float>&key = frame.layer("light.key").data, &rim = frame.layer("light.rim").data,
          &ambient = frame.layer("ambient").data;
    ASSERT_EQ(key.size(), 3u * 32 * 24);
    const Image& image = frame.image();
    const std::size_t middle = image.indexOf(16, 12) / 4 * 3;
    for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(key[middle + c] + rim[middle + c] + ambient[middle + c], image.rgba[image.indexOf(16, 12) + c],
                    1e-6);
    EXPECT_GT(key[middle], 0);
    EXPECT_EQ(frame.layer("depth").channels, (std::vector<std::string>{"Z", "depth.mean"}));
    EXPECT_NEAR(frame.layer("depth").data[2 * (12 * 32 + 16)], 34, 1);
    EXPECT_EQ(frame.layer("transmittance").channels.front(), "transmittance.R");
    EXPECT_EQ(errorOf(ErrorKind::usage, [&] { frame.layer("light.fill"); }),
              "the frame has no layer 'light.fill'; expected 'light.key', 'light.rim', 'ambient', 'depth' or "
              "'transmittance'");
}

TEST_F(ShotTest, RefusesOverridesThatNobodyReads) {
    EXPECT_NE(errorOf(ErrorKind::input, [&] { open({"camera.fof=20"}); }).find("--set camera.fof"), std::string::npos);
    EXPECT_EQ(
        errorOf(ErrorKind::usage, [&] { Shot::open("shot.yaml"); }),
        "shot.yaml: expected a scene (.toml), an asset (.vdb, .nvdb, .ply) or a scan (.nrrd, .nhdr, .nii, .nii.gz, "
        ".hdr, .mha, .mhd, .npy, .mrc, .vti, .tif, .dcm, or a folder of DICOM or TIFF slices)");
}

TEST_F(ShotTest, TakesFurtherOverridesAndRefusesThoseThatAreWrong) {
    const std::vector<std::string> dark{"light.rim.intensity=0", "camera.fov=20"};
    Shot shot = open({"camera.fov=50"});
    shot.render(1);
    shot.set(dark);
    EXPECT_EQ(shot.opened().lights[1].intensity, Rgb(0));
    EXPECT_EQ(shot.render(1).image().rgba, open(dark).render(1).image().rgba);
    const std::string before = shot.toml();
    EXPECT_NE(before.find("fov = 20"), std::string::npos);
    EXPECT_NE(errorOf(ErrorKind::input,
                      [&] {
                          shot.set({"camera.fov=30", "camera.fof=1"});
                      })
                  .find("--set camera.fof"),
              std::string::npos);
    EXPECT_EQ(shot.toml(), before);
    Scene scene = open().opened();
    scene.file = "mine";
    EXPECT_EQ(errorOf(ErrorKind::usage, [&] { Shot::make(scene).set(dark); }), "mine: the scene was built in code");
}

TEST_F(ShotTest, StopsWhereProgressSaysSo) {
    Shot shot = open();
    std::vector<double> heard;
    RenderOptions options;
    options.progress = [&](double part) {
        heard.push_back(part);
        return part < 0.5;
    };
    EXPECT_EQ(errorOf(ErrorKind::interrupted, [&] { shot.render(1, options); }), "the render was interrupted");
    ASSERT_FALSE(heard.empty());
    EXPECT_GE(heard.back(), 0.5);
    EXPECT_TRUE(std::is_sorted(heard.begin(), heard.end()));
    options.progress = [](double) { return true; };
    EXPECT_FALSE(shot.render(1, options).image().rgba.empty());  // and it can go on
}

TEST_F(ShotTest, StopsALoadThatIsGuarded) {
    OpenOptions opening;
    opening.load = {VolumeLoading::guarded, ""};
    Shot shot = open({}, opening);
    RenderOptions options;
    options.progress = [](double) { return false; };
    EXPECT_EQ(errorOf(ErrorKind::interrupted, [&] { shot.render(1, options); }), "the render was interrupted");
    options.checkpoint = [] { throw Error(ErrorKind::interrupted, "enough"); };
    EXPECT_EQ(errorOf(ErrorKind::interrupted, [&] { shot.render(1, options); }), "enough");
}

TEST_F(ShotTest, LoadsPlainAndGuardedFieldsAlike) {
    OpenOptions opening;
    opening.load = {VolumeLoading::guarded, ""};
    EXPECT_EQ(open({}, opening).render(1).image().rgba, open().render(1).image().rgba);
    opening.load.loader = SCRIM_LOADER;
    EXPECT_EQ(open({}, opening).render(1).image().rgba, open().render(1).image().rgba);
    opening.load.loader = "/no/such/program";
    EXPECT_EQ(errorOf(ErrorKind::render, [&] { open({}, opening).render(1); }),
              "cannot start '/no/such/program' to read volumes: No such file or directory");
}

TEST_F(ShotTest, IsIndependentOfOtherShots) {
    Shot one = open(), other = open({"camera.fov=50", "light.key.intensity=9"});
    RenderOptions few, more;
    few.threads = 1;
    more.threads = 2;
    const std::vector<float> oneAlone = one.render(1).image().rgba, otherAlone = other.render(1).image().rgba;
    EXPECT_NE(oneAlone, otherAlone);
    for (int round = 0; round < 3; ++round) {
        Shot left = open(), right = open({"camera.fov=50", "light.key.intensity=9"});
        std::vector<float> leftPixels, rightPixels;
        std::thread leftThread([&] { leftPixels = left.render(1, few).image().rgba; });
        std::thread rightThread([&] { rightPixels = right.render(1, more).image().rgba; });
        leftThread.join();
        rightThread.join();
        EXPECT_EQ(leftPixels, oneAlone);
        EXPECT_EQ(rightPixels, otherAlone);
    }
}

TEST_F(ShotTest, DoesWithMissingFilesWhatItIsTold) {
    Shot shot = open({"volume.smoke.file=absent.vdb"});
    std::vector<std::string> heard;
    RenderOptions options;
    options.messages = [&](Severity severity, const std::string& text) {
        if (severity == Severity::warning) heard.push_back(text);
    };
    const std::string problem = errorOf(ErrorKind::input, [&] { shot.render(4, options); });
    EXPECT_NE(problem.find("absent.vdb"), std::string::npos);
    options.missing = MissingPolicy::skip;
    ShotFrame skipped = shot.render(4, options);
    EXPECT_TRUE(skipped.skipped());
    EXPECT_TRUE(skipped.image().rgba.empty());
    EXPECT_EQ(heard, std::vector{"frame 4 is skipped: " + problem});
    EXPECT_EQ(errorOf(ErrorKind::usage, [&] { skipped.write(file("a.exr")); }),
              "frame 4 was skipped: there is no picture");
    EXPECT_TRUE(shot.plan(4, options).skipped);
    heard.clear();
    options.missing = MissingPolicy::black;
    const Image black = shot.render(4, options).image();
    EXPECT_EQ(*std::max_element(black.rgba.begin(), black.rgba.end()), 0);
    EXPECT_EQ(heard, std::vector{"frame 4: black instead: " + problem});
}

TEST_F(ShotTest, NamesTheFramesOfItsSequences) {
    EXPECT_EQ(open().frames(), std::vector{1});
    for (const char* name : {"s.0003.vdb", "s.0005.vdb"})
        makeVdb(file(name), {{.voxels = box({0, 0, 0}, {1, 1, 1}, 1)}});
    EXPECT_EQ(open({"volume.smoke.file=s.####.vdb"}).frames(), (std::vector{3, 5}));
    EXPECT_EQ(open({"volume.smoke.file=s.####.vdb", "volume.smoke.frame.offset=2"}).frames(), (std::vector{1, 3}));
    EXPECT_EQ(Shot::open(file("s.####.vdb")).frames(), (std::vector{3, 5}));
}

TEST_F(ShotTest, RendersScenesThatAreChangedByHand) {
    Shot shot = open();
    Scene scene = shot.scene(2);
    scene.lights.pop_back();
    scene.lights[0].intensity *= 2.0;
    scene.volumes[0].densityScale *= 0.5;
    const ShotFrame byHand = shot.render(scene);
    EXPECT_EQ(byHand.report().frame, 2);
    EXPECT_EQ(byHand.layerNames().front(), "light.key");
    const std::string without =
        kScene.substr(0, kScene.find("[[light]]\nname = \"rim\"")) + kScene.substr(kScene.find("[ambient]"));
    writeBytes(file("shot.toml"), without);
    EXPECT_EQ(byHand.image().rgba,
              open({"light.key.intensity=6", "volume.smoke.density.scale=0.5"}).render(2).image().rgba);
}

TEST_F(ShotTest, ReadsASceneInMemoryWhoseVolumeIsMadeInCode) {
    const std::string text =
        "[camera]\nposition = [0, 0, 50]\ntarget = [0, 0, 0]\nresolution = [8, 8]\n[[volume]]\nname = 'fog'\n"
        "[[light]]\nname = 'key'\ntype = 'distant'\ndirection = [0, 0, -1]\n";
    EXPECT_EQ(errorOf(ErrorKind::input, [&] { Shot::parse(text, "mine", "", {"camera.fov=20"}); }).substr(0, 9),
              "mine:5:1:");
    OpenOptions options;
    options.gridsFromCode = true;
    Shot shot = Shot::parse(text, "mine", "/somewhere", {"camera.fov=20"}, options);
    EXPECT_EQ(shot.path(), "mine");
    EXPECT_EQ(shot.frames(), std::vector<int>{1});
    EXPECT_EQ(errorOf(ErrorKind::usage, [&] { shot.render(1); }),
              "mine:5:1: volume 'fog' has no file, no source and no grids");
    FieldBuilder builder("density", Mat4(1.0));
    builder.addBlock(Int3(0), std::vector<float>(kBlockVoxels, 1.0f).data());
    shot.setVolume("fog", {builder.finish()});
    EXPECT_GT(shot.render(1).image().rgba[3 + 4 * (3 * 8 + 4)], 0.0f);
    EXPECT_NE(shot.toml().find("fov = 20"), std::string::npos);
}

// Its pilots march through the field, of which nothing has to be read.
TEST_F(ShotTest, CountsThePilotsOfAPresetAsPlanning) {
    OpenOptions options;
    options.gridsFromCode = true;
    Shot shot = Shot::parse(
        "[camera]\nposition = [0, 0, 400]\ntarget = [0, 0, 0]\nresolution = [64, 64]\n[[volume]]\nname = \"fog\"\n"
        "[[light]]\nname = \"sun\"\ntype = \"distant\"\ndirection = [-1, -1, -1]\n",
        "mine", "/somewhere", {}, options);
    FieldBuilder builder("density", Mat4(1.0));
    const std::vector<float> values(kBlockVoxels, 0.01f);
    for (int i = 0; i < 4096; ++i) builder.addBlock(8 * Int3(i >> 8, i >> 4 & 15, i & 15) - 64, values.data());
    shot.setVolume("fog", {builder.finish()});
    const ShotFrame frame = shot.render(1);
    const ShotTimes& seconds = frame.report().seconds;
    EXPECT_GT(seconds.plan, 2 * seconds.load);
}

TEST_F(ShotTest, RendersGridsThatAreMadeInCode) {
    FieldBuilder builder("density", Mat4(1.0));
    const std::vector<float> ones(kBlockVoxels, 1.0f);
    for (int i = 0; i < 8; ++i) builder.addBlock(Int3(i >> 2 & 1, i >> 1 & 1, i & 1) * 8 - 8, ones.data());
    Scene scene;
    scene.camera.type = CameraType::orthographic;
    scene.camera.wsPosition = {0, 0, 50};
    scene.camera.height = 24;
    scene.camera.resolution = {32, 32};
    scene.volumes.resize(1);
    scene.volumes[0].name = "fog";
    scene.volumes[0].densityScale = 0.1;
    scene.lights.resize(1);
    Shot shot = Shot::make(scene);
    EXPECT_EQ(errorOf(ErrorKind::usage, [&] { shot.render(1); }), "volume 'fog' has no file, no source and no grids");
    shot.setVolume("fog", {builder.finish()});
    const ShotFrame frame = shot.render(1);
    // Straight through the middle: 16 voxels of extinction 0.1, lit from the front.
    const float* middle = frame.image().rgba.data() + frame.image().indexOf(16, 16);
    const double tau = 1.6, alpha = 1 - std::exp(-tau);
    EXPECT_NEAR(middle[3], alpha, 0.01 * alpha);
    EXPECT_NEAR(middle[0], 0.9 / (8 * std::acos(-1.0)) * (1 - std::exp(-2 * tau)), 1e-3);
    scene.volumes[0].densityGrid = "heat";
    EXPECT_EQ(errorOf(ErrorKind::input, [&] { shot.render(scene); }),
              "volume 'fog' has no grid 'heat'; there is 'density'");
    EXPECT_EQ(shot.toml(), "");
}

// The warnings of a pixel of a scene with some blocks of voxels, and its plan.
std::vector<std::string> warningsOf(const std::vector<Int3>& blocks, float density, const std::string& more,
                                    std::string& table) {
    FieldBuilder builder("density", Mat4(1.0));
    for (const Int3& at : blocks) builder.addBlock(at, std::vector<float>(kBlockVoxels, density).data());
    OpenOptions opening;
    opening.gridsFromCode = true;
    Shot shot = Shot::parse(
        "[camera]\nposition = [25, 20, 40]\ntarget = [4, 4, 4]\nfov = 20\nresolution = [32, 32]\n[[volume]]\n"
        "name = 'box'\n[[light]]\nname = 'sun'\ntype = 'distant'\ndirection = [-1, -0.3, -0.2]\n" +
            more,
        "mine", "", {}, opening);
    shot.setVolume("box", {builder.finish()});
    std::vector<std::string> heard;
    RenderOptions options;
    options.messages = [&](Severity severity, const std::string& text) {
        if (severity == Severity::warning) heard.push_back(text);
    };
    options.crop = PixelWindow{16, 16, 17, 17};
    table = shot.plan(1, options).table;
    shot.render(1, options);
    return heard;
}

TEST_F(ShotTest, WarnsOfThickVoxelsBeforeItRendersThem) {
    std::string table;
    const std::vector<std::string> heard = warningsOf({Int3(0)}, 100, "", table);
    ASSERT_EQ(heard.size(), 1u);
    const std::regex expected(
        "the preset 'standard' promises an error of 1 %, but [0-9]+ % are expected in this "
        "scene: voxels of an optical depth of [0-9]+ are seen, .*");
    EXPECT_TRUE(std::regex_match(heard[0], expected)) << heard[0];
    EXPECT_NE(table.find("% are expected: voxels of an optical depth of"), std::string::npos) << table;
}

TEST_F(ShotTest, WarnsOfShadowRastersThatAreCoarserThanTheirDial) {
    std::string table;
    const std::string dials = "[render]\ntexel = 0.05\nshadow_texel = 0.1\nsheet_thickness = 16\n";
    const std::vector<std::string> heard = warningsOf({Int3(0), Int3(48)}, 0.1f, dials, table);
    ASSERT_EQ(heard.size(), 1u);
    const std::regex expected(
        "shadow rasters have a largest size, so their cells are larger than shadow_texel says: "
        "'sun' [0-9.]+ times");
    EXPECT_TRUE(std::regex_match(heard[0], expected)) << heard[0];
    EXPECT_NE(table.find("cells of their rasters are larger than shadow_texel says: 'sun'"), std::string::npos)
        << table;
}

TEST_F(ShotTest, PlansWhatItRenders) {
    Shot shot = open();
    std::string planned;
    RenderOptions options;
    options.planned = [&](const ShotPlan& plan) { planned = plan.json; };
    const ShotPlan plan = shot.plan(1);
    EXPECT_EQ(shot.render(1, options).report().planJson, plan.json);
    EXPECT_EQ(planned, plan.json);
    EXPECT_NE(plan.table.find("shadows"), std::string::npos);
    EXPECT_GT(plan.fieldBytes, 0u);
}

TEST_F(ShotTest, KeepsToTolerancesAndLimits) {
    Shot shot = open();
    RenderOptions options;
    options.tolerance = 0.2;
    options.verify = 40;
    const ShotReport report = shot.render(1, options).report();
    ASSERT_TRUE(report.tolerance);
    EXPECT_TRUE(report.tolerance->met);
    EXPECT_LE(report.tolerance->bound, 0.2);
    options = {};
    options.memory = 1000;
    EXPECT_NE(errorOf(ErrorKind::memory, [&] { shot.render(1, options); }).find("uses up the memory limit"),
              std::string::npos);
    options = {};
    options.crop = PixelWindow{8, 8, 20, 16};
    EXPECT_EQ(shot.render(1, options).image().window, *options.crop);
}

TEST_F(ShotTest, SharesVolumesWhereAskedTo) {
    Shot one = open();
    OpenOptions opening;
    opening.shareWith = &one;
    Shot other = open({"camera.fov=50"}, opening);
    one.render(1);
    writeBytes(file("smoke.vdb"), "not read again");
    // The head of the file is looked at to tell whether the volume is in view; its grids are not read again.
    EXPECT_FALSE(other.render(1).image().rgba.empty());
}

}  // namespace
}  // namespace scrim::test
