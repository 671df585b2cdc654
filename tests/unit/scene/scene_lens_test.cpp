// SPDX-License-Identifier: Apache-2.0
// Cameras as Maya, Houdini, Blender and USD have them: matrices, film backs, shifted lenses, orbits. Truth is where
// points of the world come to lie in the picture.
#include "read_scene.h"

#include <scrim/geometry/camera.h>
#include <scrim/scene/scene_reader.h>
#include <scrim/scene/volume_file.h>

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim::test {
namespace {

const double kPi = std::acos(-1.0);

Camera cameraOf(const std::string& keys, double frame = 1) {
    return read("[camera]\n" + keys + kVolume, {}, frame).camera;
}

Camera wide(const std::string& keys) {
    return cameraOf("position = [0, 0, 9]\ntarget = [0, 0, 0]\nresolution = [200, 100]\n" + keys);
}

/// Pixels from the picture's upper left corner.
Vec2 pixelOf(const Camera& camera, const Vec3& ws) {
    const glm::dvec4 h = worldToNdc(camera) * glm::dvec4(ws, 1);
    return {0.5 * (h.x / h.w + 1) * camera.resolution.x, 0.5 * (1 - h.y / h.w) * camera.resolution.y};
}

std::string errorIn(const std::string& keys) {
    return errorOf("[camera]\n" + keys + kVolume);
}

TEST(SceneLens, FieldOfViewIsAlongItsAxis) {
    const double tangent = std::tan(20 * kPi / 180);
    EXPECT_NEAR(std::tan(wide("fov = 40\n").fov * kPi / 360), tangent, 1e-14);
    EXPECT_NEAR(std::tan(wide("fov = 40\nfov_axis = \"vertical\"\n").fov * kPi / 360), 2 * tangent, 1e-14);
    // Of a picture 2 x 1 the half diagonal is sqrt(5) / 2 half widths.
    EXPECT_NEAR(std::tan(wide("fov = 40\nfov_axis = \"diagonal\"\n").fov * kPi / 360), tangent * 2 / std::sqrt(5.0),
                1e-14);
}

TEST(SceneLens, FilmFitsThePictureAsAsked) {
    // Film 36 x 24 behind 50 mm; the picture is 2 x 1, which is wider than the film.
    const std::string film = "focal_length = 50\naperture = [36, 24]\n";
    const auto halfWidth = [&](const std::string& fit) {
        return std::tan(wide(film + (fit.empty() ? "" : "fit = \"" + fit + "\"\n")).fov * kPi / 360);
    };
    EXPECT_NEAR(halfWidth(""), 18.0 / 50, 1e-14);
    EXPECT_NEAR(halfWidth("horizontal"), 18.0 / 50, 1e-14);
    EXPECT_NEAR(halfWidth("vertical"), 2 * 12.0 / 50, 1e-14);
    EXPECT_NEAR(halfWidth("fill"), 18.0 / 50, 1e-14);
    EXPECT_NEAR(halfWidth("overscan"), 2 * 12.0 / 50, 1e-14);
    const Camera high =
        cameraOf("position = [0, 0, 9]\ntarget = [0, 0, 0]\nresolution = [100, 200]\n" + film + "fit = \"fill\"\n");
    EXPECT_NEAR(std::tan(high.fov * kPi / 360), 0.5 * 12 / 50, 1e-14);
    EXPECT_EQ(errorIn("position = [0, 0, 9]\ntarget = [0, 0, 0]\nfocal_length = 50\naperture = 36\nfit = \"fill\"\n"),
              "scene.toml:6:7: 'fit' needs the height of the film; expected 'aperture' = [width, height]");
    EXPECT_EQ(errorIn("position = [0, 0, 9]\ntarget = [0, 0, 0]\naperture = 36\n"),
              "scene.toml:1:1: [camera] of type 'perspective' lacks 'focal_length'; expected a number greater than 0 "
              "and of at most 1000000 mm");
}

TEST(SceneLens, ShiftMovesThePictureByPartsOfItsWidth) {
    for (const std::string& type : {std::string("fov = 40\n"), std::string("type = \"orthographic\"\nheight = 4\n")}) {
        const Camera plain = wide(type), shifted = wide(type + "shift = [0.25, -0.125]\n");
        for (const Vec3& p : {Vec3(0, 0, 0), Vec3(1, -0.5, 2), Vec3(-2, 1, -3)}) {
            // What is seen moves the other way: left by 50 of 200 pixels, and up by 25.
            const Vec2 moved = pixelOf(shifted, p) - pixelOf(plain, p);
            EXPECT_NEAR(moved.x, -50, 1e-11);
            EXPECT_NEAR(moved.y, -25, 1e-11);
            // Rays go through the points that the matrix puts there.
            const Vec2 at = pixelOf(shifted, p);
            const RayFamily rays = wsRays(shifted);
            const Vec3 o = rays.origin(at.x, at.y), d = rays.direction(at.x, at.y);
            EXPECT_LT(glm::length(glm::cross(p - o, d)) / glm::length(d), 1e-12);
        }
    }
}

TEST(SceneLens, MatrixIsTheCamerasFrame) {
    const Camera looked = cameraOf("position = [3, 4, 9]\ntarget = [0, 1, 0]\nup = [0.1, 1, 0]\n");
    std::string rows;
    for (int row = 0; row < 3; ++row)
        rows += fmt::format("[{}, {}, {}, {}], ", 2.5 * looked.wsFromCamera[0][row], 2.5 * looked.wsFromCamera[1][row],
                            2.5 * looked.wsFromCamera[2][row], looked.wsPosition[row]);
    const Camera placed = cameraOf("matrix = [" + rows + "[0, 0, 0, 1]]\n");
    EXPECT_EQ(placed.wsPosition, looked.wsPosition);
    for (int i = 0; i < 3; ++i) EXPECT_LT(glm::distance(placed.wsFromCamera[i], looked.wsFromCamera[i]), 1e-14);
    // One key is as good as none.
    const Camera keyed = cameraOf("matrix = { keys = [[7, [" + rows + "[0, 0, 0, 1]]]] }\n");
    EXPECT_EQ(keyed.wsPosition, placed.wsPosition);
    EXPECT_EQ(keyed.wsFromCamera, placed.wsFromCamera);
    EXPECT_EQ(errorIn("matrix = [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n"),
              "scene.toml:2:10: 'matrix' is mirrored; expected a right-handed frame of a camera that looks along -z");
    EXPECT_EQ(errorIn("matrix = [[1, 0.1, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n"),
              "scene.toml:2:10: 'matrix' is sheared; expected perpendicular axes");
    EXPECT_EQ(
        errorIn("matrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [1, 2, 3, 1]]\n"),
        "scene.toml:2:53: the last row of 'matrix' is not 0, 0, 0, 1; expected an affine matrix that acts on column "
        "vectors, with the translation in its last column");
    EXPECT_EQ(errorIn("matrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\ntarget = [0, 0, 0]\n"),
              "scene.toml:3:10: [camera] has both 'matrix' and 'target'; expected one of them");
}

TEST(SceneLens, KeyedMatricesTurnAlongTheShorterArc) {
    // From looking along -z to looking along -x: a quarter about y.
    const std::string keyed =
        "matrix = { keys = [[1, [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]], [11, "
        "[[0,0,1,10],[0,1,0,0],[-1,0,0,0],[0,0,0,1]]]] }\n";
    for (int i = 0; i <= 10; ++i) {
        const Camera camera = cameraOf(keyed, 1 + i);
        const double angle = 9.0 * i * kPi / 180;
        EXPECT_LT(glm::distance(viewingAxis(camera), Vec3(-std::sin(angle), 0, -std::cos(angle))), 1e-14) << i;
        EXPECT_LT(glm::distance(camera.wsFromCamera[1], Vec3(0, 1, 0)), 1e-14);
        EXPECT_NEAR(camera.wsPosition.x, i, 1e-13);
    }
}

TEST(SceneLens, OrbitIsACircle) {
    const std::string orbit =
        "orbit = { center = [1, 2, 3], radius = 5, elevation = 30, azimuth = { keys = [[1, 0], [49, 360]] } }\n";
    for (int frame = 1; frame <= 49; ++frame) {
        const Camera camera = cameraOf(orbit, frame);
        const Vec3 from = camera.wsPosition - Vec3(1, 2, 3);
        EXPECT_NEAR(glm::length(from), 5, 1e-14);
        EXPECT_NEAR(from.y, 2.5, 1e-14);
        const double azimuth = (frame - 1) * 7.5 * kPi / 180;
        EXPECT_LT(
            glm::distance(Vec2(from.x, from.z), 5 * std::cos(kPi / 6) * Vec2(std::sin(azimuth), std::cos(azimuth))),
            1e-13);
        EXPECT_LT(glm::distance(viewingAxis(camera), -from / 5.0), 1e-14);
    }
    // Where z is up the front is -y.
    const Camera front = cameraOf("up = [0, 0, 1]\norbit = { radius = 2 }\n");
    EXPECT_LT(glm::distance(front.wsPosition, Vec3(0, -2, 0)), 1e-15);
    EXPECT_LT(
        glm::distance(cameraOf("up = [0, 0, 1]\norbit = { radius = 2, azimuth = 90 }\n").wsPosition, Vec3(2, 0, 0)),
        1e-15);
    // A target of its own.
    EXPECT_LT(glm::distance(viewingAxis(cameraOf("orbit = { radius = 2 }\ntarget = [0, 1, 2]\n")), Vec3(0, 1, 0)),
              1e-15);
    EXPECT_EQ(errorIn("orbit = { elevation = 30 }\n"),
              "scene.toml:2:9: 'orbit' of [camera] of type 'perspective' lacks 'radius'; expected a number greater "
              "than 0 and of at most 1e+15 world units");
}

TEST(SceneLens, LightsOrbitToo) {
    const auto light = [](const std::string& keys) { return read(kCamera + kVolume + "[[light]]\n" + keys).lights[0]; };
    const Light sun = light("type = \"distant\"\norbit = { elevation = 90 }\n");
    EXPECT_LT(glm::distance(sun.wsDirection, Vec3(0, -1, 0)), 1e-15);
    const Light lamp = light("type = \"spot\"\norbit = { center = [1, 1, 1], radius = 2, azimuth = 90 }\n");
    EXPECT_LT(glm::distance(lamp.wsPosition, Vec3(3, 1, 1)), 1e-15);
    EXPECT_LT(glm::distance(lamp.wsDirection, Vec3(-1, 0, 0)), 1e-15);
    EXPECT_EQ(
        errorOf(kCamera + kVolume +
                "[[light]]\ntype = \"distant\"\ndirection = [1, 0, 0]\norbit = { elevation = 90 }\n"),
        "scene.toml:8:13: [[light]] 'light1' of type 'distant' has both 'direction' and 'orbit'; expected one of them");
}

TEST(SceneOverride, TakesAwayWhatWouldContradictIt) {
    const std::string lens =
        "[camera]\nposition = [0, 0, 9]\ntarget = [0, 0, 0]\nfocal_length = 50\naperture = 36\n" + kVolume;
    EXPECT_EQ(read(lens, {"camera.fov=20"}).camera.fov, 20);
    const std::string fov = kCamera + "fov = 30\n" + kVolume;
    EXPECT_NEAR(read(fov, {"camera.focal_length=18", "camera.aperture=36"}).camera.fov, 90, 1e-12);
    EXPECT_EQ(read(fov, {"camera.orbit.radius=4"}).camera.wsPosition, Vec3(0, 0, 4));
    const std::string matrix = "camera.matrix=[[1,0,0,0],[0,1,0,0],[0,0,1,7],[0,0,0,1]]";
    EXPECT_EQ(read(fov, {matrix}).camera.wsPosition, Vec3(0, 0, 7));
    // The last one wins.
    EXPECT_EQ(read(fov, {matrix, "camera.position=[0, 0, 5]", "camera.target=[0, 0, 0]"}).camera.wsPosition,
              Vec3(0, 0, 5));
    const std::string fire =
        kCamera + kVolume + "[volume.medium.blackbody]\ngrid = \"t\"\nscale = 1500\noffset = 3\nnormalize = false\n";
    EXPECT_EQ(read(fire, {"volume.volume1.medium.blackbody.kelvin=[500, 1900]"}).volumes[0].emission[0].kelvinOffset,
              500);
    EXPECT_EQ(
        read(kCamera + "[[volume]]\nsource = \"noise\"\nparameters = { resolution = 8 }\n", {"volume[0].file=a.vdb"})
            .volumes[0]
            .file,
        "/shots/a.vdb");
}

int fileAt(const std::string& frame, double at) {
    return read(kCamera + kVolume + "frame = { " + frame + " }\n", {}, at).volumes[0].frame;
}

TEST(SceneRetiming, CountsFilesBySpeedOffsetAndKeys) {
    EXPECT_EQ(fileAt("offset = 10", 5), 15);
    EXPECT_EQ(fileAt("speed = 2", 5), 10);
    EXPECT_EQ(fileAt("speed = 0.5, offset = 3", 8), 7);
    EXPECT_EQ(fileAt("speed = -1, offset = 100", 30), 70);
    const std::string keys = "keys = [[1, 1], [11, 101], [21, 101]]";
    EXPECT_EQ(fileAt(keys, 0), 1);
    EXPECT_EQ(fileAt(keys, 3), 21);
    EXPECT_EQ(fileAt(keys, 15), 101);
    EXPECT_EQ(fileAt(keys + ", offset = -1", 99), 100);
    EXPECT_EQ(errorOf(kCamera + kVolume + "frame = { keys = [[1, 1]], speed = 2 }\n"),
              "scene.toml:6:36: 'frame' of [[volume]] 'volume1' with a file has both 'keys' and 'speed'; expected one "
              "of them");
    EXPECT_EQ(errorOf(kCamera + kVolume + "frame = { speed = 1e6 }\n", {}, 1e6),
              "scene.toml:6:9: 'frame' of [[volume]] 'volume1' with a file is file 1e+12 at frame 1000000; expected "
              "one of at most 2000000000");
}

TEST(SceneRetiming, KnowsBothFilesBetweenWhichANumberLies) {
    const auto volumeAt = [](const std::string& frame, double at) {
        return read(kCamera + kVolume + "frame = { " + frame + " }\n", {}, at).volumes[0];
    };
    const std::string half = "speed = 0.5, between = \"blend\"";
    EXPECT_EQ(volumeAt(half, 7).frame, 3);
    EXPECT_EQ(volumeAt(half, 7).beyond, 0.5);
    EXPECT_EQ(volumeAt(half, 8).frame, 4);
    EXPECT_EQ(volumeAt(half, 8).beyond, 0);
    EXPECT_EQ(volumeAt("speed = 0.5", 7).beyond, 0);
    EXPECT_EQ(volumeAt("speed = -0.5, offset = 9, between = \"blend\"", 3).frame, 7);
    EXPECT_EQ(volumeAt("speed = -0.5, offset = 9, between = \"blend\"", 3).beyond, 0.5);
    const SceneVolume below = volumeAt("speed = 0.25, offset = -2, between = \"blend\"", 3);
    EXPECT_EQ(below.frame, -2);
    EXPECT_EQ(below.beyond, 0.75);
    // Of tenths, the tenth is a whole number but for rounding.
    EXPECT_EQ(volumeAt("speed = 0.1, offset = 0.2, between = \"blend\"", 8).frame, 1);
    EXPECT_EQ(volumeAt("speed = 0.1, offset = 0.2, between = \"blend\"", 8).beyond, 0);
    const std::string keys = "keys = [[1, 1], [11, 6], [21, 6]], between = \"blend\"";
    EXPECT_EQ(volumeAt(keys, 4).frame, 2);
    EXPECT_EQ(volumeAt(keys, 4).beyond, 0.5);
    EXPECT_NEAR(filesWithin(volumeAt(keys, 4), {}, 4, 1), 0.5, 1e-12);
    EXPECT_NEAR(filesWithin(volumeAt(keys, 4), {}, 4, -0.5), -0.25, 1e-12);
    EXPECT_NEAR(filesWithin(volumeAt(keys, 11), {}, 11, 1), 0, 1e-12);
    EXPECT_NEAR(filesWithin(volumeAt(keys, 11), {}, 11, -1), -0.5, 1e-12);
    EXPECT_EQ(filesWithin(volumeAt("speed = 0.5", 7), {}, 7, 1), 1);
    EXPECT_EQ(errorOf(kCamera + kVolume + "frame = { speed = 0.5, between = \"advect\" }\n"),
              "scene.toml:6:9: 'between' carries grids by their velocity, and [[volume]] 'volume1' has no 'velocity'; "
              "expected one beside it");
}

TEST(SceneRetiming, CountsTheFilesThatGoByWhereASequenceEndsTurnsOrStartsAgain) {
    const auto within = [](OutsidePolicy outside, double frame, double t, double speed = 1,
                           BetweenFiles between = BetweenFiles::advect) {
        SceneVolume volume;
        volume.frameMap = FrameMap{speed, 0, {}, between};
        volume.outside = outside;
        return filesWithin(volume, FileEnds{1, 4}, frame, t);
    };
    // It goes to and fro: 1 2 3 4 3 2 1 2 from frame 1 on.
    constexpr auto kPingPong = OutsidePolicy::pingPong;
    EXPECT_EQ(within(kPingPong, 3, 1), 1);
    EXPECT_EQ(within(kPingPong, 4, 1), -1);
    EXPECT_EQ(within(kPingPong, 5.5, 1), -1);
    EXPECT_EQ(within(kPingPong, 5.5, -0.5), 0.5);
    EXPECT_EQ(within(kPingPong, 7, 1), 1);
    EXPECT_EQ(within(kPingPong, 0, 1), -1);
    EXPECT_EQ(within(kPingPong, 4, -0.5), -0.5);  // around a turn it is on the same side before and after it
    EXPECT_EQ(within(kPingPong, 4, 0.5), -0.5);
    EXPECT_EQ(within(kPingPong, 3.75, 1), -0.5);
    EXPECT_EQ(within(kPingPong, 10, 1, 0.5), -0.5);  // number 5
    EXPECT_EQ(within(kPingPong, -5, 1, -1), 1);      // from number 5 to 4, which are files 3 and 4
    EXPECT_EQ(within(kPingPong, -8, 1, -1), -1);
    EXPECT_EQ(within(OutsidePolicy::hold, 3.75, 1), 0.25);
    EXPECT_EQ(within(OutsidePolicy::hold, 4, 1), 0);
    EXPECT_EQ(within(OutsidePolicy::hold, 4, -1), -1);
    EXPECT_EQ(within(OutsidePolicy::hold, 0.5, 1), 0.5);
    EXPECT_EQ(within(OutsidePolicy::hold, -3, 1), 0);
    // The first file comes after the last one.
    EXPECT_EQ(within(OutsidePolicy::repeat, 4, 1), 1);
    EXPECT_EQ(within(OutsidePolicy::repeat, 9.5, 0.5), 0.5);
    EXPECT_EQ(within(kPingPong, 5, 1, 1, BetweenFiles::nearest), 1);
    SceneVolume one;
    one.frameMap.between = BetweenFiles::blend;
    for (const auto outside : {OutsidePolicy::hold, OutsidePolicy::repeat, kPingPong}) {
        one.outside = outside;
        EXPECT_EQ(filesWithin(one, FileEnds{3, 3}, 3, 1), 0) << "a single file stands still";
    }
}

TEST(SceneRetiming, KnowsAFrameThatShowsAFile) {
    for (const FrameMap& map : {FrameMap{1, 10, {}}, FrameMap{0.5, 3, {}}, FrameMap{-2, 7, {}}, FrameMap{0, 4, {}},
                                FrameMap{1, 0, {{{1, 1}, {11, 101}, {21, 60}}}}, FrameMap{1, 5, {{{1, 8}}}},
                                FrameMap{0.3, 1, {}, BetweenFiles::blend}})
        for (int frame = -30; frame <= 30; ++frame) {
            const int file = static_cast<int>(map.fileAt(frame));
            const auto known = map.frameOf(file);
            ASSERT_TRUE(known) << file;
            EXPECT_EQ(map.fileAt(*known), file);
        }
    // Twice as fast passes every other file by.
    EXPECT_FALSE((FrameMap{2, 0, {}}.frameOf(7)));
}

}  // namespace
}  // namespace scrim::test
