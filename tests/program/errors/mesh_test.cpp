// SPDX-License-Identifier: Apache-2.0
// Solids of files: what the program does with meshes, sound and damaged.
#include "support/program_test.h"

#include <scrim/image/exr_read.h>

#include <gtest/gtest.h>

#include <cstdint>
#include <string>

namespace scrim::test {
namespace {

const std::string kCard = "v -40 -40 10\nv 0 -40 10\nv 0 40 10\nv -40 40 10\nf 1 2 3 4\n";  // the left half

class SolidFiles : public ProgramTest {
  protected:
    void SetUp() override {
        ProgramTest::SetUp();
        write("card.obj", kCard);
    }
    std::string sceneOf(const std::string& mesh, const std::string& more = "") const {
        write("mesh.toml", kCamera + kVolume + kLight + "[[mesh]]\nname = \"card\"\nfile = \"" + mesh + "\"\n" + more);
        return "mesh.toml";
    }
};

TEST_F(SolidFiles, HideAndCatch) {
    runWell({"render", "scene.toml", "-o", "plain.exr"});
    runWell({"render", sceneOf("card.obj", "shadows = false\n"), "-o", "held.exr"});
    const Image plain = readExr(file("plain.exr")), held = readExr(file("held.exr"));
    const auto alphaOf = [](const Image& image, int x, int y) {
        return image.window.contains(x, y) ? image.rgba[image.indexOf(x, y) + 3] : 0.0f;
    };
    EXPECT_GT(alphaOf(plain, 12, 12), 0.1f);
    EXPECT_EQ(alphaOf(held, 12, 12), 0);
    EXPECT_GT(alphaOf(held, 20, 12), 0.1f);
    // A sequence that moves, behind the volume, and what it catches.
    write("floor.0007.obj", "v -40 -40 -20\nv 40 -40 -20\nv 40 40 -20\nv -40 40 -20\nf 1 2 3 4\n");
    runWell({"render",
             sceneOf("floor.####.obj", "catch = true\nholdout = false\ntransform = { translate = [0, 0, 1] }\n"), "-o",
             "c.####.exr", "--frames", "7"});
    EXPECT_TRUE(readExrAttributes(file("c.0007.exr")).at("channels").find("shadow.key.R") != std::string::npos);
}

// The plan says what meshes do to light that has scattered, where there is such light.
TEST_F(SolidFiles, AreWallsForScatteredLight) {
    const auto planOf = [&](const std::string& more, const std::string& scattering) {
        return runWell({"plan", sceneOf("card.obj", more), "--set", "volume.volume1.medium.scattering=" + scattering})
            .out;
    };
    EXPECT_NE(planOf("", "full").find("; mesh 'card' stops this light ("), std::string::npos);
    EXPECT_NE(
        planOf("albedo = [0.8, 0.7, 0]\n", "full").find("; mesh 'card' stops this light and sends part of it back ("),
        std::string::npos);
    EXPECT_EQ(planOf("shadows = false\n", "full").find("stops this light"), std::string::npos);
    EXPECT_EQ(planOf("", "single").find("stops this light"), std::string::npos);
    expectFailure({"plan", sceneOf("card.obj", "albedo = [0.8, 2, 0]\n")}, 3,
                  "mesh.toml:15:10: 'albedo' is 0.8, 2, 0 in the working space; expected numbers from 0 to 1");
}

TEST_F(SolidFiles, ThatAreDamagedAreLocatedErrors) {
    const std::string place = "mesh.toml:14:8: mesh 'card': ";
    expectFailure({"render", sceneOf("none.obj"), "-o", "x.exr"}, 3, place + "none.obj: there is no such file");
    expectFailure({"render", sceneOf("smoke.vdb"), "-o", "x.exr"}, 3,
                  place + "smoke.vdb: expected a file that ends in .obj or .ply");
    write("empty.obj", "");
    expectFailure({"render", sceneOf("empty.obj"), "-o", "x.exr"}, 3, place + "empty.obj: is empty");
    write("points.obj", "v 0 0 0\nv 1 0 0\n");
    const ProgramResult points = run({"render", sceneOf("points.obj"), "-o", "x.exr"});
    EXPECT_EQ(points.status, 3);
    EXPECT_NE(points.err.find(place + "points.obj: "), std::string::npos) << points.err;
    write("far.ply",
          "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face "
          "4000000000\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    const ProgramResult far = run({"render", sceneOf("far.ply"), "-o", "x.exr"});
    EXPECT_EQ(far.status, 3);
    EXPECT_NE(far.err.find(place + "far.ply: declares more of 'face'"), std::string::npos) << far.err;
    EXPECT_FALSE(exists("x.exr"));
}

// Whatever becomes of a file, the program renders it or says where the scene names it.
TEST_F(SolidFiles, ThatAreDamagedByLotNeverCrashTheProgram) {
    std::uint32_t state = 7;
    const auto below = [&state](std::size_t n) {
        state = state * 1664525U + 1013904223U;
        return std::size_t(state >> 8) % n;
    };
    for (int i = 0; i < 12; ++i) {
        std::string bytes = kCard;
        for (int k = 0; k < 3; ++k) bytes[below(bytes.size())] = static_cast<char>(below(256));
        write("damaged.obj", bytes);
        const ProgramResult result = run({"plan", sceneOf("damaged.obj")});
        EXPECT_TRUE(result.status == 0 || result.status == 3) << result.status << ": " << result.err;
        EXPECT_TRUE(result.status == 0 || result.err.find("mesh.toml:14:8: mesh 'card': ") != std::string::npos)
            << result.err;
    }
}

}  // namespace
}  // namespace scrim::test
