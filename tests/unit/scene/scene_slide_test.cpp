// SPDX-License-Identifier: Apache-2.0
// Slides and projectors as scenes state them. Reading a scene touches no slide's file.
#include <scrim/scene/scene_reader.h>

#include "unit/scene/read_scene.h"

#include <gtest/gtest.h>

namespace scrim::test {
namespace {

/// [[light]] is line 6, `lines` begin at line 7.
Light light(const std::string& lines, double frame = 1) {
    return read(kCamera + kVolume + "[[light]]\n" + lines, {}, frame).lights.at(0);
}
std::string lightError(const std::string& lines) {
    return errorOf(kCamera + kVolume + "[[light]]\n" + lines);
}
const std::string kProjector = "type = \"projector\"\nposition = [0, 5, 0]\ntarget = [3, 5, 0]\n";
const std::string kDistant = "type = \"distant\"\ndirection = [0, 0, -1]\nposition = [1, 2, 3]\n";

TEST(SceneSlide, ReadsEveryKeyOfAProjector) {
    const Light l =
        light(kProjector +
              "up = [0, 0, 2]\nradius = 0.5\ndecay = \"none\"\nintensity = 3\n"
              "slide = { file = \"rings.png\", colorspace = \"srgb\", fov = 50, roll = -20, outside = \"black\" }\n");
    EXPECT_FALSE(l.distant() || l.spot());
    EXPECT_EQ(l.wsPosition, Vec3(0, 5, 0));
    EXPECT_EQ(l.wsDirection, Vec3(1, 0, 0));
    EXPECT_EQ(l.wsUp, Vec3(0, 0, 1));
    EXPECT_EQ(l.point().radius, 0.5);
    EXPECT_FALSE(l.point().decay);
    EXPECT_EQ(l.intensity, Rgb(3));
    ASSERT_TRUE(l.slide);
    EXPECT_EQ(l.slide->file, "/shots/rings.png");
    EXPECT_EQ(l.slide->colorspace, test::ownColours().resolve("sRGB"));
    EXPECT_EQ(l.slide->fov, 50);
    EXPECT_EQ(l.slide->roll, -20);
    EXPECT_EQ(l.slide->outside, SlideOutside::black);
    EXPECT_EQ(l.slide->where, "scene.toml:14:18");
    EXPECT_FALSE(l.slide->image);
}

TEST(SceneSlide, OfADistantLightHasACentreAndAWidth) {
    const Light l = light(kDistant + "slide = { file = \"a.png\", width = 4 }\n");
    EXPECT_EQ(l.wsPosition, Vec3(1, 2, 3));
    EXPECT_EQ(l.slide->width, 4);
    EXPECT_EQ(l.slide->height, 0);  // by the picture's aspect
    EXPECT_EQ(l.wsUp, Vec3(0, 1, 0));
    EXPECT_EQ(l.slide->colorspace, "");  // by the kind of pixels
    EXPECT_EQ(
        light(kDistant + "slide = { file = \"a.png\", width = 4, height = 3, outside = \"repeat\" }\n").slide->height,
        3);
}

TEST(SceneSlide, OfPointsAndSpotsNeedAWayToLook) {
    const Light point = light(
        "type = \"point\"\nposition = [0, 0, 0]\ndirection = [0, -2, 0]\nslide = { file = \"a.png\", outside = "
        "\"clamp\" }\n");
    EXPECT_EQ(point.wsDirection, Vec3(0, -1, 0));
    EXPECT_EQ(point.slide->fov, 30);
    EXPECT_EQ(point.slide->outside, SlideOutside::clamp);
    const Light spot =
        light("type = \"spot\"\nposition = [0, 0, 0]\ntarget = [0, -2, 0]\ncone = 70\nslide = { file = \"a.png\" }\n");
    EXPECT_EQ(spot.slide->fov, 70);  // fills the cone
    EXPECT_EQ(lightError("type = \"point\"\nposition = [0, 0, 0]\nslide = { file = \"a.png\" }\n"),
              "scene.toml:6:1: [[light]] 'light1' of type 'point' lacks 'direction'; expected a direction [x, y, z], "
              "or 'target', a point [x, y, z]");
}

TEST(SceneSlide, MayBeKeyedAndASequence) {
    const Light l = light(
        "type = \"projector\"\nposition = [0, 5, 0]\ndirection = [1, 0, 0]\n"
        "up = { keys = [[1, [0, 1, 0]], [3, [0, 1, 2]]] }\n"
        "slide = { file = \"a.####.png\", fov = { keys = [[1, 20], [3, 40]] }, roll = { keys = [[1, 0], [3, 90]] } }\n",
        2);
    EXPECT_EQ(l.slide->file, "/shots/a.0002.png");
    EXPECT_EQ(l.slide->fov, 30);
    EXPECT_EQ(l.slide->roll, 45);
    EXPECT_NEAR(l.wsUp.y, l.wsUp.z, 1e-12);
    const Light v = read("[variables]\nART = \"/art\"\n" + kCamera + kVolume + "[[light]]\n" + kProjector +
                         "slide = { file = \"${ART}/a.png\" }\n")
                        .lights.at(0);
    EXPECT_EQ(v.slide->file, "/art/a.png");
}

TEST(SceneSlide, AProjectorIsNothingWithoutOne) {
    EXPECT_EQ(lightError(kProjector),
              "scene.toml:6:1: [[light]] 'light1' of type 'projector' lacks 'slide'; expected a table { file = "
              "\"...\" }: what it projects");
    EXPECT_EQ(lightError(kProjector + "slide = { file = \"a.png\", outside = \"clamp\" }\n"),
              "scene.toml:10:37: 'outside' is the string \"clamp\"; expected 'black'");
    EXPECT_EQ(lightError(kProjector + "slide = { file = \"a.png\", outside = 1 }\n"),
              "scene.toml:10:37: 'outside' is 1; expected 'black'");
}

TEST(SceneSlide, KeysAreChecked) {
    EXPECT_EQ(lightError(kProjector + "slide = { fov = 30 }\n"),
              "scene.toml:10:9: 'slide' of [[light]] 'light1' of type 'projector' lacks 'file'; expected the slide's "
              "picture");
    EXPECT_EQ(lightError(kProjector + "slide = \"a.png\"\n"),
              "scene.toml:10:9: 'slide' is the string \"a.png\"; expected a table");
    EXPECT_EQ(lightError(kProjector + "slide = { file = \"a.png\", fv = 30 }\n"),
              "scene.toml:10:27: 'fv' is not known here ('slide' of [[light]] 'light1' of type 'projector'); did you "
              "mean 'fov'?; allowed: 'file', 'colorspace', 'fov', 'width', 'height', 'roll' or 'outside'");
    EXPECT_EQ(lightError(kProjector + "slide = { file = \"a.png\", fov = 180 }\n"),
              "scene.toml:10:33: 'fov' is 180; expected a number greater than 0 and less than 180 degrees");
    EXPECT_EQ(lightError(kProjector + "slide = { file = \"a.png\", colorspace = \"no\" }\n").substr(0, 60),
              "scene.toml:10:40: unknown colour space 'no' in the OpenColor");
    EXPECT_EQ(lightError(kProjector + "slide = { file = \"${NO_SUCH_VARIABLE_9}.png\" }\n").substr(0, 18),
              "scene.toml:10:18: ");
    EXPECT_EQ(lightError(kProjector + "up = [0, 0, 0]\nslide = { file = \"a.png\" }\n"),
              "scene.toml:10:6: 'up' is 0, 0, 0 at frame 1; expected a direction");
}

TEST(SceneSlide, SizeIsAnAngleOrALengthAsTheLightHasIt) {
    EXPECT_EQ(lightError(kProjector + "slide = { file = \"a.png\", width = 3 }\n"),
              "scene.toml:10:35: 'slide' of [[light]] 'light1' of type 'projector' has 'width'; expected 'fov', since "
              "its light comes from a point");
    EXPECT_EQ(lightError(kProjector + "slide = { file = \"a.png\", fov = 20, height = 3 }\n"),
              "scene.toml:10:46: 'slide' of [[light]] 'light1' of type 'projector' has 'height'; expected 'fov', since "
              "its light comes from a point");
    EXPECT_EQ(lightError(kDistant + "slide = { file = \"a.png\", fov = 3 }\n"),
              "scene.toml:10:33: 'slide' of [[light]] 'light1' of type 'distant' has 'fov'; expected 'width' in world "
              "units, since its light is parallel");
    EXPECT_EQ(lightError(kDistant + "slide = { file = \"a.png\", fov = 3, width = 3 }\n").substr(0, 17),
              "scene.toml:10:33:");
    EXPECT_EQ(lightError(kDistant + "slide = { file = \"a.png\" }\n"),
              "scene.toml:10:9: 'slide' of [[light]] 'light1' of type 'distant' lacks 'width'; expected a number "
              "greater than 0 and of at most 1e+15 world units");
    EXPECT_EQ(lightError(kDistant + "slide = { file = \"a.png\", width = 0 }\n").substr(0, 38),
              "scene.toml:10:35: 'width' is 0; expect");
    EXPECT_EQ(lightError("type = \"distant\"\ndirection = [0, 0, -1]\nslide = { file = \"a.png\", width = 3 }\n"),
              "scene.toml:6:1: [[light]] 'light1' of type 'distant' lacks 'position'; expected a point [x, y, z]");
}

TEST(SceneSlide, KeysThatOnlySlidesUseNeedOne) {
    EXPECT_EQ(lightError("type = \"distant\"\ndirection = [0, 0, -1]\nup = [0, 1, 0]\n").substr(0, 38),
              "scene.toml:9:1: 'up' is not known here");
    EXPECT_EQ(lightError("type = \"point\"\nposition = [0, 0, 0]\ntarget = [0, 1, 0]\n").substr(0, 42),
              "scene.toml:9:1: 'target' is not known here");
}

}  // namespace
}  // namespace scrim::test
