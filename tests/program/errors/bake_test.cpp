// SPDX-License-Identifier: Apache-2.0
// `scrim bake` as it is called: its files, and what it refuses.
#include "support/program_test.h"

#include <scrim/image/exr_read.h>
#include <scrim/volume/vdb_file.h>

#include <scrim/base/error.h>

#include <cmath>
#include <string>
#include <vector>

namespace scrim::test {
namespace {

constexpr int kUsage = 2, kInput = 3, kOutput = 4;

const std::string kWarm =
    "[[light]]\nname = \"warm one\"\ntype = \"distant\"\ndirection = [1, 0, 0]\ncolor = [1, 0.5, 0.2]\n";

class Bake : public ProgramTest {};

TEST_F(Bake, WritesAGridALightBesideTheAsset) {
    write("scene.toml",
          kCamera + kVolume + "transform = { translate = [1, 2, 3] }\n" + kLight + "intensity = 2\n" + kWarm);
    const ProgramResult result = runWell({"bake", "scene.toml", "-o", "light.vdb", "--emission"});
    EXPECT_NE(result.err.find("frame 1: light.vdb: 'key' (float), 'warm_one' (vec3s), 'emission' (vec3s), 'density' "
                              "(float); 8788 active voxels in all"),
              std::string::npos)
        << result.err;
    const VdbFile file = VdbFile::open(this->file("light.vdb"));
    ASSERT_EQ(file.info().grids.size(), 4u);
    EXPECT_EQ(file.info().grids[1].valueType, "vec3s");
    const SparseField key = file.field("key", {});
    EXPECT_EQ(key.activeVoxels, 13u * 13 * 13);
    EXPECT_EQ(transformPoint(key.wsFromIs, Vec3(0)), Vec3(1, 2, 3));
    EXPECT_LE(key.maxValue, 2.0f);
    // Before the corner that the light comes to the tent of its voxel falls as (1 - t)^3 along its diagonal.
    EXPECT_NEAR(key.maxValue, 2 * std::exp(-0.2 * std::sqrt(3.0) / 4), 0.03);
    EXPECT_NEAR(file.field("density", {}).maxValue, 0.2, 1e-6);
}

TEST_F(Bake, CallsGridsByTheirVolumesWhereThereAreSeveral) {
    write("scene.toml",
          kCamera + kVolume + "name = \"a\"\n" + kVolume + "name = \"b\"\nlights = [\"key\"]\n" + kLight + kWarm);
    const ProgramResult result = runWell({"bake", "scene.toml", "-o", "out/light.vdb"});
    EXPECT_NE(result.err.find("'a.key' (float), 'a.warm_one' (vec3s), 'b.key' (float); "), std::string::npos)
        << result.err;
    const ProgramResult one = runWell({"bake", "scene.toml", "-o", "light.vdb", "--light", "key"});
    EXPECT_NE(one.err.find("'a.key' (float), 'b.key' (float); "), std::string::npos) << one.err;
}

TEST_F(Bake, IsShownAsEmission) {
    write("scene.toml", kCamera + kVolume + kLight + "intensity = 4\n");
    write("shown.toml",
          kCamera +
              "[[volume]]\nfile = \"light.vdb\"\ndensity = { grid = \"density\" }\n[volume.medium]\nalbedo "
              "= [0, 0, 0]\nemission = { grid = \"emission\" }\n");
    // Fine enough that what differs is the light between voxels, which is baked at them: 1.83 %, and no less with
    // texels and sheets half as wide.
    const std::string texel = "render.texel=0.15", thickness = "render.sheet_thickness=0.1";
    runWell({"bake", "scene.toml", "-o", "light.vdb", "--emission", "--set", texel, "--set", thickness});
    for (const std::string name : {"shown", "scene"})
        runWell({"render", name + ".toml", "-o", name + ".exr", "--set", texel, "--set", thickness});
    const Image shown = readExr(file("shown.exr")), lit = readExr(file("scene.exr"));
    const auto mean = [](const Image& image, int x0, int y0) {
        double sum = 0;
        for (int y = y0; y < y0 + 8; ++y)
            for (int x = x0; x < x0 + 8; ++x)
                if (image.window.contains(x, y)) sum += image.rgba[image.indexOf(x, y)] / 64;
        return sum;
    };
    double square = 0, all = 0;
    for (int y = 0; y < 24; y += 8)
        for (int x = 0; x < 32; x += 8) {
            square += std::pow(mean(shown, x, y) - mean(lit, x, y), 2) / 12;
            all += mean(lit, x, y) / 12;
        }
    ASSERT_GT(all, 0.01);
    EXPECT_LT(std::sqrt(square), 0.02 * all);
}

TEST_F(Bake, WritesSequences) {
    runWell({"bake", "scene.toml", "-o", "light.##.vdb", "--frames", "1-2"});
    EXPECT_TRUE(exists("light.01.vdb") && exists("light.02.vdb"));
    expectFailure({"bake", "scene.toml", "-o", "light.vdb", "--frames", "1-2"}, kUsage,
                  "all 2 frames would be written to 'light.vdb'; put the frame into its name: light.####.vdb");
}

TEST_F(Bake, WritesWhatHasScatteredBefore) {
    const std::string full = kVolume + "[volume.medium]\nscattering = \"full\"\n";
    write("grey.toml", kCamera + full + kLight);
    const ProgramResult grey = runWell({"bake", "grey.toml", "-o", "light.vdb", "--indirect"});
    EXPECT_NE(grey.err.find(": 'key' (float), 'indirect' (float), 'indirect_flux' (vec3s); "), std::string::npos)
        << grey.err;
    EXPECT_GT(VdbFile::open(file("light.vdb")).field("indirect", {}).maxValue, 0);
    write("warm.toml", kCamera + full + kWarm);
    const ProgramResult warm = runWell({"bake", "warm.toml", "-o", "light.vdb", "--indirect"});
    EXPECT_NE(warm.err.find(": 'warm_one' (vec3s), 'indirect' (vec3s), 'indirect_flux_r' (vec3s), 'indirect_flux_g' "
                            "(vec3s), 'indirect_flux_b' (vec3s); "),
              std::string::npos)
        << warm.err;
}

TEST_F(Bake, WritesNoIndirectLightOfAHoldout) {
    const std::string full = "[volume.medium]\nscattering = \"full\"\n";
    write("scene.toml",
          kCamera + kVolume + "name = \"a\"\n" + full + kVolume + "name = \"b\"\nholdout = true\n" + full + kLight);
    const ProgramResult result = runWell({"bake", "scene.toml", "-o", "light.vdb", "--indirect"});
    EXPECT_NE(result.err.find(": 'a.key' (float), 'a.indirect' (float), 'a.indirect_flux' (vec3s), 'b.key' (float); "),
              std::string::npos)
        << result.err;
}

TEST_F(Bake, SaysOfWhichMediaEmissionIsNotAll) {
    write("scene.toml", kCamera + kVolume + "[volume.medium]\nphase = { type = \"hg\", g = 0.5 }\n" + kLight);
    const ProgramResult result = runWell({"bake", "scene.toml", "-o", "light.vdb", "--emission"});
    EXPECT_NE(result.err.find("scrim: warning: scene.toml:9:9: volume 'volume1' scatters anisotropically, but its "
                              "emission grid is that of isotropic scattering\n"),
              std::string::npos)
        << result.err;
    write("scene.toml",
          kCamera + kVolume +
              "[volume.classified]\ntransfer = [ { value = 0, color = [1,1,1], extinction = 0.0 }, { value "
              "= 1, color = [1,1,1], extinction = 1.0 } ]\n" +
              kLight);
    const ProgramResult classified = runWell({"bake", "scene.toml", "-o", "light.vdb", "--emission"});
    EXPECT_NE(classified.err.find("volume 'volume1' is classified: its reflection depends on the eye's position, so it "
                                  "has no emission grid\n"),
              std::string::npos)
        << classified.err;
}

TEST_F(Bake, RefusesWhatIsWrong) {
    expectFailure({"bake", "scene.toml"}, kUsage, "bake: expected -o LIGHT.vdb, the file to write");
    expectFailure({"bake", "scene.toml", "-o", "light.exr"}, kUsage, "the output 'light.exr' does not end in '.vdb'");
    expectFailure({"bake", "scene.toml", "smoke.vdb", "-o", "light.vdb"}, kUsage,
                  "bake: expected one scene, since there is one output");
    expectFailure({"bake", "scene.toml", "-o", "light.vdb", "--crop", "0,0,2,2"}, kUsage,
                  "--crop: light is baked at voxels, not at pixels; remove --crop");
    expectFailure({"bake", "scene.toml", "-o", "light.vdb", "--light", "kex"}, kUsage,
                  "there is no light 'kex' to bake; did you mean 'key'?; expected 'key'");
    expectFailure({"bake", "scene.toml", "-o", "smoke.vdb"}, kUsage,
                  "--output 'smoke.vdb' would overwrite the volume 'volume1', which is read; write to another file");
    write("dark.toml", kCamera + kVolume);
    expectFailure({"bake", "dark.toml", "-o", "light.vdb"}, kInput,
                  "dark.toml: there is no light to bake; add a [[light]] to the scene");
    write("same.toml",
          kCamera + kVolume + kWarm + "[[light]]\nname = \"warm-one\"\ntype = \"distant\"\ndirection = [1, 0, 0]\n");
    expectFailure({"bake", "same.toml", "-o", "light.vdb"}, kInput,
                  "same.toml: light 'warm one' and light 'warm-one' would both be the grid 'warm_one', whose name has "
                  "only letters, digits and underscores; expected different names");
    expectFailure(
        {"bake", "scene.toml", "-o", "light.vdb", "--indirect"}, kInput,
        "scene.toml: --indirect: light scatters once in all volumes; expected one with scattering = \"full\", "
        "for example by --set 'volume.volume1.medium.scattering=full'");
    write("file", "");
    expectFailure({"bake", "scene.toml", "-o", "file/light.vdb"}, kOutput,
                  "cannot write 'file/light.vdb': 'file' is not a folder");
    expectFailure({"bake", "scene.toml", "-o", "light.vdb", "--memory", "40K"}, 33,
                  "the baked grids take 48.0 KB, more than the 23.9 KB that the memory limit leaves");
    expectFailure({"bake", "scene.toml", "-o", "light.vdb", "--set", "output.colorspace=sRGB"}, kInput,
                  "--set output.colorspace: the colour space 'sRGB - Texture' is not linear; expected one that a "
                  "matrix takes to 'ACEScg'");
}

}  // namespace
}  // namespace scrim::test
