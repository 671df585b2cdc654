// SPDX-License-Identifier: Apache-2.0
// Where sources look for their files: beside the scene in a scene, in the working folder from the command line.
#include "support/program_test.h"

namespace scrim::test {
namespace {

class SourcePaths : public ProgramTest {
  protected:
    void SetUp() override {
        ProgramTest::SetUp();
        std::filesystem::create_directories(file("shot/ct"));
        write("shot/ct/head.raw", std::string(16 * 16 * 16, '\1'));
        write("shot/scene.toml",
              kCamera +
                  "[[volume]]\nsource = \"scan\"\nparameters = { file = \"ct/head.raw\", size = [16, 16, 16], "
                  "center = true }\n" +
                  kLight);
    }
};

TEST_F(SourcePaths, AreRelativeToTheScene) {
    runWell({"render", "shot/scene.toml", "-o", "a.exr", "-q"});
    EXPECT_TRUE(exists("a.exr"));
}

TEST_F(SourcePaths, MissingFilesOfASceneAreLocated) {
    std::filesystem::remove(file("shot/ct/head.raw"));
    expectFailure({"render", "shot/scene.toml", "-o", "a.exr"}, 3,
                  "shot/scene.toml:7:10: source 'scan': shot/ct/head.raw: there is no such file");
}

TEST_F(SourcePaths, AreRelativeToTheWorkingFolderFromTheCommandLine) {
    runWell({"make", "scan", "file=shot/ct/head.raw", "size=16,16,16", "-o", "head.vdb", "-q"});
    EXPECT_TRUE(exists("head.vdb"));
    expectFailure({"make", "scan", "file=ct/head.raw", "size=16,16,16", "-o", "x.vdb"}, 3,
                  "source 'scan': ct/head.raw: there is no such file");
}

TEST_F(SourcePaths, ShapesOfASceneMayBeWrittenOverManyLines) {
    write("room.toml",
          kCamera +
              "[[volume]]\nsource = \"primitives\"\n[volume.parameters]\nresolution = 40\nshapes = \"\"\"\n"
              "box size=10,10,10  # the room\nsphere radius=7\n\"\"\"\n" +
              kLight);
    runWell({"render", "room.toml", "-o", "room.exr", "-q"});
    write("bad.toml", kCamera + "[[volume]]\nsource = \"primitives\"\nparameters = { shapes = \"cube\" }\n" + kLight);
    expectFailure({"render", "bad.toml", "-o", "x.exr"}, 3,
                  "bad.toml:7:10: source 'primitives': shape 1: unknown kind 'cube', expected 'box', 'sphere', "
                  "'ellipsoid', 'cylinder', 'capsule', 'torus' or 'plane'");
}

}  // namespace
}  // namespace scrim::test
