// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/scene_reader.h>

#include "unit/scene/read_scene.h"

#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

Camera camera(const std::string& lines, double frame = 1) {
    return read(kCamera + lines + kVolume, {}, frame).camera;
}
std::string cameraError(const std::string& lines) {
    return errorOf(kCamera + lines + kVolume);
}

TEST(SceneCamera, HasDefaults) {
    const Camera c = camera("");
    EXPECT_EQ(c.type, CameraType::perspective);
    EXPECT_EQ(c.wsPosition, Vec3(0, 0, 9));
    EXPECT_EQ(c.wsFromCamera, Mat3(1.0));
    EXPECT_EQ(c.fov, 35);
    EXPECT_EQ(c.near, 0);
    EXPECT_EQ(c.resolution, Int2(512, 512));
    EXPECT_EQ(c.pixelAspect, 1);
}

TEST(SceneCamera, ReadsEveryKey) {
    const Scene scene = read(
        "[camera]\ntype = \"perspective\"\nposition = [1, 2, 3]\ntarget = [1, 2, 13]\nup = [0, -2, 0]\nfov = "
        "50\n"
        "near = 0.5\nresolution = [640, 480]\npixel_aspect = 2\noverscan = 16\n" +
        kVolume);
    EXPECT_EQ(scene.camera.wsPosition, Vec3(1, 2, 3));
    EXPECT_EQ(viewingAxis(scene.camera), Vec3(0, 0, 1));
    EXPECT_EQ(scene.camera.wsFromCamera[1], Vec3(0, -1, 0));
    EXPECT_EQ(scene.camera.fov, 50);
    EXPECT_EQ(scene.camera.near, 0.5);
    EXPECT_EQ(scene.camera.resolution, Int2(640, 480));
    EXPECT_EQ(scene.camera.pixelAspect, 2);
    EXPECT_EQ(scene.overscan, 16);
}

TEST(SceneCamera, OrthographicHasAHeightInsteadOfAFov) {
    const Camera c = camera("type = \"orthographic\"\nheight = 80\n");
    EXPECT_EQ(c.type, CameraType::orthographic);
    EXPECT_EQ(c.height, 80);
    EXPECT_EQ(cameraError("type = \"orthographic\"\n"),
              "scene.toml:1:1: [camera] of type 'orthographic' lacks 'height'; expected a number greater than 0 and of "
              "at most 1e+15 world units");
    EXPECT_EQ(cameraError("type = \"orthographic\"\nheight = 1\nfov = 30\n"),
              "scene.toml:6:1: 'fov' is not known here ([camera] of type 'orthographic'); allowed: 'type', 'position', "
              "'target', 'up', 'matrix', 'orbit', 'exr', 'height', 'shift', 'near', 'shutter', 'resolution', "
              "'pixel_aspect' or 'overscan'");
}

TEST(SceneCamera, AFovMayComeFromALens) {
    // Full frame at 18 mm sees 90 degrees across.
    EXPECT_NEAR(camera("focal_length = 18\naperture = 36\n").fov, 90, 1e-12);
    EXPECT_EQ(cameraError("focal_length = 18\n"),
              "scene.toml:1:1: [camera] of type 'perspective' lacks 'aperture'; expected the film's width, or [width, "
              "height], in mm");
    EXPECT_EQ(cameraError("focal_length = 18\naperture = 36\nfov = 3\n"),
              "scene.toml:6:7: [camera] has both 'focal_length' and 'fov'; expected one of them");
    EXPECT_EQ(cameraError("focal_length = 0\naperture = 36\n"),
              "scene.toml:4:16: 'focal_length' is 0; expected a number greater than 0 and of at most 1000000 mm");
}

TEST(SceneCamera, MayBeKeyed) {
    const std::string lines =
        "up = { keys = [[1, [0, 1, 0]], [3, [1, 0, 0]]] }\nfov = { keys = [[1, 20], [11, 40]] }\n";
    EXPECT_DOUBLE_EQ(camera(lines, 6).fov, 30);
    EXPECT_DOUBLE_EQ(camera(lines, 99).fov, 40);
    EXPECT_NEAR(camera(lines, 2).wsFromCamera[1].x, std::sqrt(0.5), 1e-12);
    EXPECT_EQ(camera("fov = { keys = [[1, 20], [11, 40]], interpolation = \"smooth\" }\n", 6).fov, 30);
}

TEST(SceneCamera, KeysAreChecked) {
    EXPECT_EQ(cameraError("fov = { keys = [[1, 20], [1, 40]] }\n"),
              "scene.toml:4:27: 'fov': frame 1 does not come after frame 1; expected ascending frames");
    EXPECT_EQ(cameraError("fov = { keys = [] }\n"),
              "scene.toml:4:16: 'keys' is a list of 0; expected at least one [frame, value]");
    EXPECT_EQ(cameraError("fov = { keys = [[1, 20], [2, 200]] }\n"),
              "scene.toml:4:30: 'keys[1][1]' is 200; expected a number greater than 0 and less than 180 degrees");
    EXPECT_EQ(cameraError("fov = { keys = [[1, 20, 3]] }\n"),
              "scene.toml:4:17: 'keys[0]' is a list of 3; expected [frame, value]");
    EXPECT_EQ(cameraError("fov = { keys = [[1, 20]], interpolation = \"cubic\" }\n"),
              "scene.toml:4:43: 'interpolation' is the string \"cubic\"; expected 'linear' or 'smooth'");
    EXPECT_EQ(cameraError("fov = { keys = [[1, 20]], ease = 1 }\n"),
              "scene.toml:4:27: 'ease' is not known here (the keyed 'fov'); allowed: 'keys' or 'interpolation'");
    EXPECT_EQ(cameraError("resolution = { keys = [[1, [9, 9]]] }\n"),
              "scene.toml:4:14: 'resolution' is a table; expected [width, height] in pixels");
}

TEST(SceneCamera, MustNotStandAtItsTarget) {
    EXPECT_EQ(errorOf("[camera]\nposition = [1, 2, 3]\ntarget = [1, 2, 3]\n" + kVolume),
              "scene.toml:3:10: the camera is at the same point as its 'target' at frame 1 (1, 2, 3)");
    EXPECT_EQ(cameraError("up = [0, 0, 0]\n"), "scene.toml:4:6: 'up' is 0, 0, 0 at frame 1; expected a direction");
}

TEST(SceneCamera, LooksAcrossVastAndTinyDistances) {
    for (const char* target : {"[0, 0, 1e-200]", "[0, 0, 1e15]"}) {
        const Scene scene = read("[camera]\nposition = [0, 0, 0]\ntarget = " + std::string(target) + "\n" + kVolume);
        EXPECT_EQ(viewingAxis(scene.camera), Vec3(0, 0, 1)) << target;
    }
}

TEST(SceneCamera, ResolutionIsLimited) {
    const std::string expected = "; expected a whole number from 1 to 65536 pixels";
    EXPECT_EQ(cameraError("resolution = [0, 10]\n"), "scene.toml:4:15: 'resolution[0]' is 0" + expected);
    EXPECT_EQ(cameraError("resolution = [10, 65537]\n"), "scene.toml:4:19: 'resolution[1]' is 65537" + expected);
    EXPECT_EQ(cameraError("resolution = [10, 9223372036854775807]\n"),
              "scene.toml:4:19: 'resolution[1]' is 9223372036854775807" + expected);
    EXPECT_EQ(cameraError("resolution = [10, 1.5]\n"), "scene.toml:4:19: 'resolution[1]' is 1.5" + expected);
    EXPECT_EQ(cameraError("resolution = [10]\n"),
              "scene.toml:4:14: 'resolution' is a list of 1; expected [width, height] in pixels");
}

TEST(SceneCamera, SaysWhatANumberMustBe) {
    const std::string fov = "; expected a number greater than 0 and less than 180 degrees";
    EXPECT_EQ(cameraError("fov = 180\n"), "scene.toml:4:7: 'fov' is 180" + fov);
    EXPECT_EQ(cameraError("fov = nan\n"), "scene.toml:4:7: 'fov' is nan" + fov);
    EXPECT_EQ(cameraError("fov = \"wide\"\n"), "scene.toml:4:7: 'fov' is the string \"wide\"" + fov);
    EXPECT_EQ(cameraError("fov = true\n"), "scene.toml:4:7: 'fov' is true" + fov);
    EXPECT_EQ(cameraError("fov = 1979-05-27\n"), "scene.toml:4:7: 'fov' is a date or time" + fov);
    EXPECT_EQ(cameraError("near = -1\n"),
              "scene.toml:4:8: 'near' is -1; expected a number from 0 to 1e+15 world units");
    EXPECT_EQ(cameraError("up = [0, inf, 0]\n"), "scene.toml:4:10: 'up[1]' is inf; expected a number");
    EXPECT_EQ(cameraError("up = [0, 1]\n"),
              "scene.toml:4:6: 'up' is a list of 2; expected three numbers [x, y, z], each finite");
    EXPECT_EQ(cameraError("type = \"fisheye\"\n"),
              "scene.toml:4:8: 'type' is the string \"fisheye\"; expected 'perspective' or 'orthographic'");
}

TEST(SceneCamera, UnknownKeysAreErrors) {
    EXPECT_EQ(cameraError("fvo = 20\n"),
              "scene.toml:4:1: 'fvo' is not known here ([camera] of type 'perspective'); did you mean 'fov'?; allowed: "
              "'type', 'position', 'target', 'up', 'matrix', 'orbit', 'exr', 'fov', 'fov_axis', 'focal_length', "
              "'aperture', 'fstop', 'world_unit', 'lens_radius', 'focus_distance', 'shift', 'near', 'shutter', "
              "'resolution', 'pixel_aspect' or 'overscan'");
    EXPECT_EQ(errorOf("[camera]\npositoin = [0, 0, 1]\ntarget = [0, 0, 0]\n" + kVolume),
              "scene.toml:2:1: 'positoin' is not known here ([camera] of type 'perspective'); did you mean "
              "'position'?");
    EXPECT_EQ(errorOf("[camera]\ntarget = [0, 0, 0]\n" + kVolume),
              "scene.toml:1:1: [camera] of type 'perspective' lacks 'position'; expected a point [x, y, z]");
}

}  // namespace
}  // namespace scrim::test
