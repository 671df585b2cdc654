// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/scene_reader.h>

#include "unit/scene/read_scene.h"

#include <gtest/gtest.h>

namespace scrim {
namespace {

using test::errorOf;
using test::kCamera;
using test::read;

// The scene's [[volume]] is at line 4, its [volume.classified] at line 6, `lines` begin at line 7.
std::string sceneWith(const std::string& lines, const std::string& volume = "file = \"a.vdb\"\n") {
    return kCamera + "[[volume]]\n" + volume + "[volume.classified]\n" + lines;
}

TEST(SceneClassified, HasDefaults) {
    const auto look = read(sceneWith("transfer = [{value = 1, extinction = 0}, {value = 2, extinction = 3}]\n"))
                          .volumes.at(0)
                          .classified;
    ASSERT_NE(look, nullptr);
    EXPECT_EQ(look->transfer.size(), 2U);
    EXPECT_EQ(look->transfer[1].value, 2);
    EXPECT_EQ(look->transfer[1].extinction, 3);
    EXPECT_EQ(look->transfer[1].color, Rgb(1));
    EXPECT_EQ(look->ambient, 0.2);
    EXPECT_EQ(look->diffuse, 0.7);
    EXPECT_EQ(look->specular, 0.3);
    EXPECT_EQ(look->exponent, 20);
    EXPECT_FALSE(look->twoSided);
    EXPECT_FALSE(look->scatters);
    EXPECT_EQ(look->albedo, Rgb(0.9));
}

TEST(SceneClassified, ScattersWhereItSaysSo) {
    const std::string transfer =
        "transfer = [{value = 1, color = [1, 0.5, 0.25], extinction = 0}, {value = 2, extinction = 3}]\n";
    const auto look = [&](const std::string& lines) {
        return *read(sceneWith(transfer + lines)).volumes.at(0).classified;
    };
    EXPECT_FALSE(look("scattering = \"single\"\n").scatters);
    EXPECT_TRUE(look("scattering = \"full\"\n").scatters);
    EXPECT_NEAR(look("scattering = \"full\"\nalbedo = [0.5, 0.25, 1]\n").albedo.y, 0.25, 1e-6);
    EXPECT_TRUE(read(sceneWith(transfer + "scattering = \"full\"\n")).volumes.at(0).scattersFully());
    EXPECT_EQ(errorOf(sceneWith(transfer + "scattering = \"octaves\"\n")),
              "scene.toml:8:14: 'scattering' is the string \"octaves\"; expected 'single' or 'full'");
    EXPECT_EQ(errorOf(sceneWith(transfer + "albedo = [1, 1, 1]\n")),
              "scene.toml:8:10: [volume.classified] of [[volume]] 'volume1' has 'albedo' without scattering = "
              "\"full\"; expected both, or none");
    EXPECT_EQ(errorOf(sceneWith(transfer + "scattering = \"full\"\nalbedo = [1, 1, 2]\n")),
              "scene.toml:9:10: 'albedo' is 1, 1, 2 in the working space; expected numbers from 0 to 1");
    EXPECT_EQ(
        errorOf(sceneWith("transfer = [{value = 1, color = [1, 2, 1], extinction = 0}, {value = 2, extinction = 3}]\n"
                          "scattering = \"full\"\n")),
        "scene.toml:8:14: [volume.classified] of [[volume]] 'volume1' has scattering = \"full\", and 'albedo' "
        "times a colour is 1.8; expected at most 1, since more light would be scattered than there is");
}

TEST(SceneClassified, ReadsEverything) {
    const auto look = read(sceneWith("transfer = [{value = 1, color = [1, 0.5, 0.25], extinction = 0},\n"
                                     "{value = 2, extinction = 3}]\nambient = 0.1\ndiffuse = 0.5\nspecular = 0.4\n"
                                     "exponent = 7\ntwo_sided = true\n",
                                     "density = {scale = 4}\nfile = \"a.vdb\"\n"))
                          .volumes.at(0)
                          .classified;
    EXPECT_NEAR(look->transfer[0].color.y, 0.5, 1e-6);
    EXPECT_EQ(look->ambient, 0.1);
    EXPECT_EQ(look->diffuse, 0.5);
    EXPECT_EQ(look->specular, 0.4);
    EXPECT_EQ(look->exponent, 7);
    EXPECT_TRUE(look->twoSided);
}

TEST(SceneClassified, AWindowIsATransferFunctionByItsNameOrItsRange) {
    const auto look = [](const std::string& lines) { return *read(sceneWith(lines)).volumes.at(0).classified; };
    for (const char* name : {"bone", "soft tissue", "lung", "vessels"}) {
        const Classified own = look("window = \"" + std::string(name) + "\"\n");
        EXPECT_TRUE(own.perVoxel);
        EXPECT_EQ(classify(own, 24).extinction, 0) << name << ": air";
    }
    const auto extinction = [&](const char* name, double hounsfield) {
        return classify(look("window = \"" + std::string(name) + "\"\n"), hounsfield + 1024).extinction;
    };
    // Half of a voxel's light is lost where matter counts as opaque.
    EXPECT_EQ(extinction("bone", 60), 0) << "flesh";
    EXPECT_GT(extinction("bone", 400), 0.7);
    EXPECT_GT(extinction("soft tissue", 60), 0.7);
    EXPECT_EQ(extinction("soft tissue", -700), 0) << "lung";
    EXPECT_EQ(extinction("lung", 60), 0);
    EXPECT_GT(extinction("lung", -700), 0);
    EXPECT_EQ(extinction("vessels", 60), 0);
    EXPECT_GT(extinction("vessels", 250), 0.7);
    const Rgb red = classify(look("window = \"vessels\"\n"), 250 + 1024).color;
    EXPECT_GT(red.x, 4 * red.y);

    const Classified range = look("window = [40, 400]\n");
    EXPECT_EQ(classify(range, 1024 - 160).extinction, 0);
    EXPECT_EQ(classify(range, 1024 + 40).color, Rgb(0.5));
    EXPECT_NEAR(classify(range, 1024 + 40).extinction, 0.5 * classify(range, 1024 + 240).extinction, 1e-12);
    EXPECT_EQ(look("window = [40, 20]\nwindow_zero = 0\n").transfer[0].value, 30);
    // One that begins below all grid values is the same line from there on.
    const Classified wide = look("window = [-600, 1500]\n");
    EXPECT_EQ(classify(wide, 0).extinction, 0);
    EXPECT_NEAR(classify(wide, 1).color.x, (1350 - 1023) / 1500.0, 1e-12);
}

TEST(SceneClassified, WindowsThatShowNothingOrThatHaveARivalAreRefused) {
    EXPECT_EQ(errorOf(sceneWith("window = \"bones\"\n")),
              "scene.toml:7:10: 'window' is the string \"bones\"; expected 'bone', 'soft tissue', 'lung' or 'vessels'");
    EXPECT_EQ(errorOf(sceneWith("window = [40, 0]\n")),
              "scene.toml:7:10: 'window' is a list of 2; expected [centre, width] with a width above 0");
    EXPECT_EQ(errorOf(sceneWith("window = [-2000, 100]\n")),
              "scene.toml:7:10: 'window' ends at -1950; expected an end above -1024, because grid values below 0 are "
              "empty");
    EXPECT_NE(errorOf(sceneWith("window = \"bone\"\ntransfer = []\n")).find("; expected one of them"),
              std::string::npos);
}

TEST(SceneClassified, OpacityByTheGradientIsARampOfFactors) {
    const std::string transfer = "transfer = [{value = 1, extinction = 0}, {value = 2, extinction = 3}]\n";
    const auto look = read(sceneWith(transfer + "gradient = [[5, 0.25], [15, 1]]\n")).volumes.at(0).classified;
    EXPECT_EQ(gradientFactor(*look, 0), 0.25);
    EXPECT_EQ(gradientFactor(*look, 10), 0.625);
    EXPECT_EQ(gradientFactor(*look, 99), 1);
    EXPECT_EQ(gradientFactor(Classified(), 3), 1) << "none";
    EXPECT_NE(errorOf(sceneWith(transfer + "gradient = [[5, 0], [15, 2]]\n")).find("scene.toml:8:26"),
              std::string::npos);
    EXPECT_NE(errorOf(sceneWith(transfer + "gradient = [[5, 0], [5, 1]]\n")).find("expected ascending values"),
              std::string::npos);
}

TEST(SceneClassified, ErrorsAreLocated) {
    EXPECT_NE(errorOf(sceneWith("")).find("scene.toml:6:"), std::string::npos);
    EXPECT_NE(errorOf(sceneWith("transfer = [{value = 1, extinction = 0}]\n")).find("at least two points"),
              std::string::npos);
    const std::string order =
        errorOf(sceneWith("transfer = [{value = 2, extinction = 0}, {value = 1, extinction = 3}]\n"));
    EXPECT_NE(order.find("scene.toml:7:"), std::string::npos) << order;
    EXPECT_NE(order.find("1 comes after 2; expected ascending values"), std::string::npos) << order;
    EXPECT_NE(errorOf(sceneWith("transfer = [{value = 1, extinction = 2}, {value = 2, extinction = 3}]\n"))
                  .find("'transfer' has extinction above 0 at value 0"),
              std::string::npos);
    EXPECT_NE(errorOf(sceneWith("transfer = [{value = -2, extinction = 0}, {value = -1, extinction = 0}]\n"))
                  .find("ends at a value of 0 or less"),
              std::string::npos);
    EXPECT_NE(errorOf(sceneWith("transfer = [{value = 1, extinction = -1}, {value = 2, extinction = 3}]\n"))
                  .find("'extinction' is -1"),
              std::string::npos);
    EXPECT_NE(errorOf(sceneWith("transfer = [{value = 1, extinktion = 1}, {value = 2, extinction = 3}]\n"))
                  .find("extinction"),
              std::string::npos);
    EXPECT_NE(errorOf(sceneWith("transfer = [{value = 1, extinction = 0}, {value = 2, extinction = 3}]\nshine = 3\n"))
                  .find("'shine'"),
              std::string::npos);
}

TEST(SceneClassified, AVolumeIsEitherAMediumOrClassified) {
    EXPECT_NE(errorOf(kCamera + "[[volume]]\nfile = \"a.vdb\"\n[volume.medium]\n[volume.classified]\n"
                                "transfer = [{value = 1, extinction = 0}, {value = 2, extinction = 3}]\n")
                  .find("has both 'medium' and 'classified'; expected one of them"),
              std::string::npos);
}

}  // namespace
}  // namespace scrim
