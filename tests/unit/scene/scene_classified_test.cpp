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
