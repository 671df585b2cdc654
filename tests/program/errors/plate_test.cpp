// SPDX-License-Identifier: Apache-2.0
// A scene that takes its camera from pictures.
#include "support/program_test.h"

#include <scrim/geometry/camera.h>
#include <scrim/image/exr.h>
#include <scrim/image/exr_read.h>

#include <gtest/gtest.h>

#include <string>

#include <glm/matrix.hpp>

namespace scrim::test {
namespace {

class Plate : public ProgramTest {
  protected:
    /// A scene whose camera is of that picture.
    std::string sceneOf(const std::string& picture, const std::string& more = "") const {
        write("plate.toml", "[camera]\nexr = \"" + picture + "\"\n" + more + kVolume + kLight);
        return "plate.toml";
    }
};

TEST_F(Plate, GivesTheSamePicture) {
    write("orbit.toml",
          "[camera]\norbit = { radius = 40, azimuth = { keys = [[1, 0], [9, 90]] } }\nfov = 35\nshift = [0.1, 0.05]\n"
          "resolution = [32, 24]\n[render]\ntexel = 1\nsheet_thickness = 1\n" +
              kVolume + kLight);
    runWell({"render", "orbit.toml", "-o", "a.####.exr", "--frames", "4"});
    runWell({"render", sceneOf("a.####.exr", "[render]\ntexel = 1\nsheet_thickness = 1\n"), "-o", "b.####.exr",
             "--frames", "4"});
    EXPECT_EQ(readExr(file("b.0004.exr")).rgba, readExr(file("a.0004.exr")).rgba);
    EXPECT_EQ(readExrAttributes(file("b.0004.exr")).at("scrim:camera"),
              readExrAttributes(file("a.0004.exr")).at("scrim:camera"));
}

TEST_F(Plate, OfAnotherRendererIsRead) {
    Camera camera;
    camera.wsPosition = {0, 0, 40};
    camera.resolution = {32, 24};
    // As OpenEXR's documents have it: looking along +z, 0..1 with y down.
    glm::dmat4 flipZ(1.0), unit(1.0);
    flipZ[2][2] = -1;
    unit[0][0] = 0.5;
    unit[1][1] = -0.5;
    unit[3] = {0.5, 0.5, 0, 1};
    Image image = emptyImage({0, 0, 32, 24});
    ExrOptions options;
    options.displayWindow = {0, 0, 32, 24};
    writeExr(file("plate.exr"), image, options,
             {{"worldToCamera", flipZ * worldToCamera(camera)}, {"worldToNDC", unit * worldToNdc(camera)}});
    runWell({"render", "scene.toml", "-o", "a.exr"});
    runWell({"render", sceneOf("plate.exr"), "-o", "b.exr"});
    const Image a = readExr(file("a.exr")), b = readExr(file("b.exr"));
    ASSERT_EQ(a.rgba.size(), b.rgba.size());
    for (std::size_t i = 0; i < a.rgba.size(); ++i) EXPECT_NEAR(b.rgba[i], a.rgba[i], 2e-3f * (1 + a.rgba[i]));
    // A resolution of one's own.
    runWell({"render", sceneOf("plate.exr", "resolution = [64, 48]\n"), "-o", "c.exr"});
    EXPECT_EQ(readExrAttributes(file("c.exr")).at("displayWindow"), "0 0 64 48");
}

TEST_F(Plate, ThatHasNoCameraIsAnError) {
    const std::string place = "plate.toml:2:7: the camera of 'none.exr': ";
    expectFailure({"render", sceneOf("none.exr"), "-o", "x.exr"}, 3, place + "there is no such file");
    write("plain.exr", "nothing");
    const ProgramResult damaged = run({"render", sceneOf("plain.exr"), "-o", "x.exr"});
    EXPECT_EQ(damaged.status, 3);
    EXPECT_NE(damaged.err.find("plate.toml:2:7: the camera of 'plain.exr': "), std::string::npos) << damaged.err;
    runWell({"render", "scene.toml", "-o", "own.exr", "--preview", "own.png"});
    const ProgramResult png = run({"render", sceneOf("own.png"), "-o", "x.exr"});
    EXPECT_EQ(png.lastErrorLine(),
              "scrim: error: plate.toml:2:7: the camera of 'own.png': its header has no worldToCamera");
}

}  // namespace
}  // namespace scrim::test
