// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/scene_reader.h>

#include "unit/scene/read_scene.h"

#include <gtest/gtest.h>

namespace scrim {
namespace {

using test::kCamera;
using test::kVolume;
using test::read;

// [camera] is at line 1, the first [[volume]] at line 4, what follows it at line 6.
const std::string kScene = kCamera + kVolume +
                           "density = { scale = 2 }\n"
                           "[volume.medium]\n"
                           "phase = { type = \"hg\", g = 0.5 }\n"
                           "[[volume]]\n"
                           "name = \"plume\"\n"
                           "file = \"b.vdb\"\n"
                           "[volume.classified]\n"
                           "transfer = [ { value = 1, extinction = 0 },\n"
                           "             { value = 2, extinction = 3 } ]\n"
                           "[[light]]\n"
                           "name = \"key\"\n"
                           "type = \"point\"\n"
                           "position = { keys = [[1, [0, 0, 5]], [2, [0, 0, 6]]] }\n"
                           "[[light]]\n"
                           "type = \"point\"\n"
                           "position = [0, 5, 5]\n"
                           "  shadows = false\n"
                           "[ambient]\n"
                           "color = [1, 1, 1]\n"
                           "[render]\n"
                           "lod = 0.5\n";

TEST(SceneLines, KnowKeysOfTables) {
    const auto lines = read(kScene).lines;
    ASSERT_NE(lines, nullptr);
    EXPECT_EQ(lines->of("camera"), "scene.toml:1:1");
    EXPECT_EQ(lines->of("camera.target"), "scene.toml:3:10");
    EXPECT_EQ(lines->of("ambient.color"), "scene.toml:24:9");
    EXPECT_EQ(lines->of("render.lod"), "scene.toml:26:7");
}

TEST(SceneLines, KnowVolumesAndLightsByTheirNames) {
    const auto lines = read(kScene).lines;
    EXPECT_EQ(lines->of("volume.volume1"), "scene.toml:4:1");
    EXPECT_EQ(lines->of("volume.volume1.file"), "scene.toml:5:8");
    EXPECT_EQ(lines->of("volume.plume.file"), "scene.toml:11:8");
    EXPECT_EQ(lines->of("volume.volume2.file"), "") << "it has a name";
    EXPECT_EQ(lines->of("light.key"), "scene.toml:15:1");
    EXPECT_EQ(lines->of("light.key.type"), "scene.toml:17:8");
    EXPECT_EQ(lines->of("light.light2.shadows"), "scene.toml:22:13");
}

TEST(SceneLines, KnowInlineTablesAndTablesInLists) {
    const auto lines = read(kScene).lines;
    EXPECT_EQ(lines->of("volume.volume1.density.scale"), "scene.toml:6:21");
    EXPECT_EQ(lines->of("volume.volume1.medium"), "scene.toml:7:1");
    EXPECT_EQ(lines->of("volume.volume1.medium.phase"), "scene.toml:8:9");
    EXPECT_EQ(lines->of("volume.volume1.medium.phase.g"), "scene.toml:8:28");
    EXPECT_EQ(lines->of("volume.plume.classified.transfer.transfer2.extinction"), "scene.toml:14:40");
    EXPECT_EQ(lines->of("light.key.position.keys"), "scene.toml:18:21");
}

TEST(SceneLines, KnowOverrides) {
    const auto lines =
        read(kScene, {"light.key.shadows=false", "light[1].radius=2", "output.file=a.exr", "render.lod=1"}).lines;
    EXPECT_EQ(lines->of("light.key.shadows"), "--set light.key.shadows");
    EXPECT_EQ(lines->of("light.light2.radius"), "--set light[1].radius");
    EXPECT_EQ(lines->of("output.file"), "--set output.file");
    EXPECT_EQ(lines->of("render.lod"), "--set render.lod");
    EXPECT_EQ(lines->of("light.key.type"), "scene.toml:17:8");
}

TEST(SceneLines, LeaveOutNamesOfAnyLength) {
    const std::string book(100000, 'x');
    const auto lines = read(kScene, {"volume.plume.name=" + book}).lines;
    EXPECT_EQ(lines->of("volume." + book + ".file"), "");
    EXPECT_EQ(lines->of("volume.volume1.file"), "scene.toml:5:8");
}

TEST(SceneLines, SayNothingOfWhatTheTextDoesNotSay) {
    const auto lines = read(kScene).lines;
    EXPECT_EQ(lines->of("camera.fov"), "");
    EXPECT_EQ(lines->of("light.key.shadows"), "");
    EXPECT_EQ(lines->of(""), "");
    EXPECT_EQ(SceneLines().of("camera"), "");
}

}  // namespace
}  // namespace scrim
