// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/scene_reader.h>
#include <scrim/volume/grid_edit.h>

#include "unit/scene/read_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include <glm/geometric.hpp>

namespace scrim {
namespace {

using test::errorOf;
using test::kCamera;
using test::read;

/// A scene whose [[volume]] is at line 4 and whose `lines` begin at line 5.
std::string sceneWith(const std::string& lines) {
    return kCamera + "[[volume]]\n" + lines;
}
SceneVolume volume(const std::string& lines, double frame = 1) {
    return read(sceneWith(lines), {}, frame).volumes.at(0);
}
/// `lines` begin at line 6.
std::string volumeError(const std::string& lines) {
    return errorOf(sceneWith("file = \"a.vdb\"\n" + lines));
}
Mat4 transform(const std::string& text, double frame = 1) {
    return volume("file = \"a.vdb\"\ntransform = " + text + "\n", frame).wsFromAsset;
}

void expectNear(const Vec3& a, const Vec3& b) {
    EXPECT_LT(glm::length(a - b), 1e-12) << a.x << " " << a.y << " " << a.z;
}

TEST(SceneVolume, HasDefaults) {
    const SceneVolume v = volume("file = \"a.vdb\"\n");
    EXPECT_EQ(v.name, "volume1");
    EXPECT_EQ(v.file, "/shots/a.vdb");
    EXPECT_EQ(v.where, "scene.toml:5:8");
    EXPECT_EQ(v.frame, 1);
    EXPECT_EQ(v.outside, OutsidePolicy::error);
    EXPECT_EQ(v.wsFromAsset, Mat4(1.0));
    EXPECT_EQ(v.densityGrid, "");
    EXPECT_EQ(v.densityScale, 1);
    EXPECT_TRUE(v.ramp.empty());
    EXPECT_TRUE(v.medium.phase.isotropic());
    EXPECT_EQ(v.medium.albedo, Rgb(0.9));
}

TEST(SceneVolume, IsPutTogetherFromGridsOfSeveralFiles) {
    const SceneVolume v = volume(
        "frame = { offset = -10 }\n"
        "grids = { density = { max = ['a.####.vdb', 'b.vdb:smoke', 'a.####.vdb:heat'] }, temperature = 'b.vdb', fuel = "
        "'c.gz:fuel[1]' }\n",
        12);
    ASSERT_TRUE(v.edit);
    using Part = CombinedGrid::Part;
    const std::vector<CombinedGrid> expected{
        {"density",
         CombinedGrid::How::max,
         {Part{0, "", "scene.toml:6:30"}, Part{1, "smoke", "scene.toml:6:44"}, Part{0, "heat", "scene.toml:6:59"}}},
        {"temperature", CombinedGrid::How::copied, {Part{1, "", "scene.toml:6:95"}}},
        {"fuel", CombinedGrid::How::copied, {Part{2, "fuel[1]", "scene.toml:6:111"}}}};
    EXPECT_EQ(v.edit->files, (std::vector<std::string>{"/shots/a.0002.vdb", "/shots/b.vdb", "/shots/c.gz"}));
    GridEdit edit;
    edit.grids = expected;
    edit.files = v.edit->files;
    edit.where = "scene.toml:6:9";
    EXPECT_EQ(toText(*v.edit), toText(edit));
    EXPECT_EQ(v.file, "/shots/a.0002.vdb");
    EXPECT_EQ(v.where, "scene.toml:6:9");
    EXPECT_EQ(v.sequences.size(), 3u);
}

TEST(SceneVolume, SaysWhatIsWrongWithGridsOfSeveralFiles) {
    const auto error = [](const std::string& grids) { return errorOf(sceneWith("grids = " + grids + "\n")); };
    EXPECT_EQ(
        error("{ density = 3 }"),
        "scene.toml:5:21: 'density' is 3; expected \"FILE:GRID\", or { max = [...] }, { add = [...] } or { multiply "
        "= [...] }");
    EXPECT_EQ(error("{ density = { } }"),
              "scene.toml:5:21: 'density' is a table; expected \"FILE:GRID\", or { max = [...] }, { add = [...] } or { "
              "multiply = [...] }");
    EXPECT_EQ(error("{ density = { max = ['a.vdb'] } }"),
              "scene.toml:5:29: 'max' is a list of 1; expected a list of at least two \"FILE:GRID\"");
    EXPECT_EQ(error("{ density = { max = ['a.vdb', 'b.vdb'], add = ['c.vdb', 'd.vdb'] } }"),
              "scene.toml:5:55: 'density' of grids has both 'max' and 'add'; expected one of them");
    EXPECT_EQ(error("{ density = { min = ['a.vdb', 'b.vdb'] } }"),
              "scene.toml:5:23: 'min' is not known here ('density' of grids); allowed: 'max', 'add' "
              "or 'multiply'");
    EXPECT_EQ(error("{ density = 'a.vdb:' }"),
              "scene.toml:5:21: 'density' is the string \"a.vdb:\"; expected \"FILE\" or \"FILE:GRID\"");
    EXPECT_EQ(error("{ }"), "scene.toml:5:9: 'grids' is a table; expected at least one grid");
    EXPECT_EQ(error("'a.vdb'"),
              "scene.toml:5:9: 'grids' is the string \"a.vdb\"; expected a table of { NAME = \"FILE:GRID\" }");
    EXPECT_EQ(volumeError("grids = { density = 'a.vdb' }"),
              "scene.toml:6:9: [[volume]] has both 'file' and 'grids'; expected one of them");
    std::string many;
    for (int i = 0; i <= 32; ++i) many += "g" + std::to_string(i) + " = 'f" + std::to_string(i) + ".vdb', ";
    EXPECT_NE(error("{ " + many + "z = 'z.vdb' }").find("there are more than 32 files; expected fewer"),
              std::string::npos);
}

TEST(SceneVolume, LooksAtPointsAsItSays) {
    EXPECT_EQ(volume("file = 'a.vdb'\npoints = {}\n").edit, nullptr);
    const auto edit =
        volume("file = 'a.vdb'\npoints = { radius = 0.5, scale = 2, voxel = 0.1, weight = 'disc' }\n").edit;
    ASSERT_NE(edit, nullptr);
    EXPECT_EQ(edit->points, (PointLook{.radius = 0.5, .scale = 2, .voxel = 0.1, .discs = true}));
    EXPECT_FALSE(edit->editsGrids());
    EXPECT_EQ(volume("file = 'a.vdb'\npoints = { sharp = false }\n").edit->points, (PointLook{.sharp = false}));
    EXPECT_EQ(volumeError("points = { sharp = 'auto' }\n"),
              "scene.toml:6:20: 'sharp' is the string \"auto\"; expected true or false");
    EXPECT_EQ(
        volumeError("points = { voxel = 0 }\n"),
        "scene.toml:6:20: 'voxel' is 0; expected a number greater than 0 and of at most 1e+12 world units of the file");
    EXPECT_EQ(errorOf(sceneWith("source = 'noise'\npoints = { voxel = 1 }\n")).substr(0, 14), "scene.toml:6:1");
}

TEST(SceneVolume, KnowsTheVelocitiesOfPointsWhereTheyPass) {
    const std::string moving = "[[volume]]\nfile = 'a.ply'\nvelocity = { grid = 'v', scale = 2 }\n";
    const auto lookOf = [](const std::string& text) {
        const auto edit = read(text).volumes.at(0).edit;
        return edit ? edit->points : PointLook();
    };
    EXPECT_EQ(lookOf(kCamera + moving), PointLook()) << "nothing is blurred";
    const std::string camera = kCamera + "shutter = [-0.25, 0.5]\n";
    // 24 frames a second.
    const PointLook blurred = lookOf(camera + moving);
    EXPECT_DOUBLE_EQ(blurred.open, -0.25 * 2 / 24);
    EXPECT_DOUBLE_EQ(blurred.close, 0.5 * 2 / 24);
    const PointLook carried = lookOf(kCamera + moving + "frame = { speed = 0.5, between = 'advect' }\n");
    EXPECT_DOUBLE_EQ(carried.open, -2.0 / 24);
    EXPECT_DOUBLE_EQ(carried.close, 2.0 / 24);
}

TEST(SceneVolume, FindsItsFileAtTheFrame) {
    const SceneVolume v = volume("file = \"smoke.####.vdb\"\nframe = { offset = -10, outside = \"hold\" }\n", 12);
    EXPECT_EQ(v.file, "/shots/smoke.0002.vdb");
    EXPECT_EQ(v.frame, 2);
    EXPECT_EQ(v.outside, OutsidePolicy::hold);
    EXPECT_TRUE(v.sequence.hasFrame());
    EXPECT_EQ(volume("file = \"a.%d.vdb\"\n", 12.75).file, "/shots/a.13.vdb");
    EXPECT_EQ(volume("file = \"/cache/a.$F4.vdb\"\nframe = { outside = \"black\" }\n", -3).file, "/cache/a.-003.vdb");
}

TEST(SceneVolume, ExpandsVariablesOfTheSceneBeforeTheEnvironment) {
    ::setenv("SCRIM_TEST_A", "environment", 1);
    ::setenv("SCRIM_TEST_B", "environment", 1);
    const Scene scene = read("[variables]\nSCRIM_TEST_A = \"scene\"\nversion = 12\n" +
                             sceneWith("file = \"${SCRIM_TEST_A}/${SCRIM_TEST_B}/v${version}.vdb\"\n"));
    EXPECT_EQ(scene.volumes[0].file, "/shots/scene/environment/v12.vdb");
    EXPECT_EQ(errorOf(sceneWith("file = \"${SCRIM_NONE}.vdb\"\n")),
              "scene.toml:5:8: the path '${SCRIM_NONE}.vdb' names the variable 'SCRIM_NONE', which is neither in "
              "[variables] nor in the environment");
    EXPECT_EQ(errorOf("[variables]\nA = [1]\n" + sceneWith("file = \"a.vdb\"\n")),
              "scene.toml:2:5: 'A' is a list of 1; expected a string or a number");
}

TEST(SceneVolume, PassesParametersToItsSourceInOrder) {
    const SceneVolume v = volume(
        "source = \"noise\"\nparameters = { octaves = 5, gain = 0.5, centre = [0, 1.5, 0], seed = \"abc\", "
        "soft = true }\n");
    EXPECT_EQ(v.source, "noise");
    EXPECT_EQ(v.file, "");
    EXPECT_EQ(v.where, "scene.toml:5:10");
    const std::vector<std::pair<std::string, std::string>> expected{
        {"octaves", "5"}, {"gain", "0.5"}, {"centre", "0, 1.5, 0"}, {"seed", "abc"}, {"soft", "true"}};
    EXPECT_EQ(v.parameters, expected);
    EXPECT_EQ(errorOf(sceneWith("source = \"noise\"\nparameters = { a = nan }\n")),
              "scene.toml:6:20: 'a' is nan; expected a number");
    EXPECT_EQ(errorOf(sceneWith("source = \"noise\"\nparameters = { a = {} }\n")),
              "scene.toml:6:20: 'a' is a table; expected a number, a string, true or false, or three numbers");
}

TEST(SceneVolume, FileOfItsSourceIsAPathOfTheScene) {
    const auto file = [](const std::string& path, double frame) {
        const SceneVolume v = volume("source = \"scan\"\nparameters = { file = \"" + path + "\" }\n", frame);
        EXPECT_EQ(v.parameters.at(0).first, "file");
        return v.parameters.at(0).second;
    };
    EXPECT_EQ(file("ct/head.nrrd", 1), "/shots/ct/head.nrrd");
    EXPECT_EQ(file("/ct/head.nrrd", 1), "/ct/head.nrrd");
    EXPECT_EQ(file("head.####.nrrd", 12), "/shots/head.0012.nrrd");
    const Scene scene = read("[variables]\nCT = \"/scans\"\n" +
                             sceneWith("source = \"scan\"\nparameters = { file = \"${CT}/head.nrrd\" }\n"));
    EXPECT_EQ(scene.volumes.at(0).parameters.at(0).second, "/scans/head.nrrd");
    EXPECT_EQ(errorOf(sceneWith("source = \"scan\"\nparameters = { file = \"${SCRIM_NONE}.nrrd\" }\n")),
              "scene.toml:6:23: the path '${SCRIM_NONE}.nrrd' names the variable 'SCRIM_NONE', which is neither in "
              "[variables] nor in the environment");
}

TEST(SceneVolume, IsAFileOrASource) {
    EXPECT_EQ(errorOf(sceneWith("name = \"plume\"\n")),
              "scene.toml:4:1: [[volume]] 'plume' lacks 'file'; expected a .vdb file, or 'source', the name of a "
              "volume source");
    EXPECT_EQ(volumeError("source = \"noise\"\n"),
              "scene.toml:6:10: [[volume]] has both 'file' and 'source'; expected one of them");
    EXPECT_EQ(volumeError("parameters = {}\n").substr(0, 73),
              "scene.toml:6:1: 'parameters' is not known here ([[volume]] 'volume1' with");
    EXPECT_EQ(errorOf(sceneWith("source = \"noise\"\nframe = {}\n")),
              "scene.toml:6:9: [[volume]] has both 'source' and 'frame'; expected one of them");
}

TEST(SceneVolume, NamesAreUnique) {
    EXPECT_EQ(errorOf(kCamera + "[[volume]]\nfile = \"a\"\n[[volume]]\nname = \"volume1\"\nfile = \"a\"\n"),
              "scene.toml:6:1: [[volume]] number 2 is called 'volume1', and so is number 1; expected "
              "different names");
}

TEST(SceneVolume, NamesTheLightsThatLightIt) {
    const std::string lights =
        "[[light]]\nname = \"key\"\ntype = \"point\"\nposition = [0, 0, 5]\n"
        "[[light]]\ntype = \"point\"\nposition = [0, 5, 5]\n";
    const auto named = [&](const std::string& names) {
        return read(sceneWith("file = \"a.vdb\"\nlights = " + names + "\n" + lights)).volumes.at(0).lights;
    };
    EXPECT_EQ(volume("file = \"a.vdb\"\n").lights, std::nullopt) << "all";
    EXPECT_EQ(named("[\"light2\", \"key\"]"), (std::vector<std::string>{"light2", "key"}));
    EXPECT_EQ(named("[]"), std::vector<std::string>{}) << "none";
    const auto namedError = [&](const std::string& names) { return volumeError("lights = " + names + "\n" + lights); };
    EXPECT_EQ(namedError("[\"key\", \"kye\"]"),
              "scene.toml:6:18: there is no light 'kye'; did you mean 'key'?; expected 'key' or 'light2'");
    EXPECT_EQ(namedError("[\"rim\"]"), "scene.toml:6:11: there is no light 'rim'; expected 'key' or 'light2'");
    EXPECT_EQ(namedError("[\"key\", \"key\"]"), "scene.toml:6:18: 'key' is named twice; expected each light once");
    EXPECT_EQ(namedError("[1]"), "scene.toml:6:11: 'lights[0]' is 1; expected a string that is not empty");
    EXPECT_EQ(namedError("\"key\""),
              "scene.toml:6:10: 'lights' is the string \"key\"; expected a list of names of "
              "lights");
    EXPECT_EQ(volumeError("lights = [\"key\"]\n"), "scene.toml:6:11: there is no light 'key'; expected none");
}

TEST(SceneVolume, NamesTheLightsInWhichItCastsShadows) {
    const std::string light = "[[light]]\nname = \"key\"\ntype = \"point\"\nposition = [0, 0, 5]\n";
    const auto shadows = [&](const std::string& value) {
        return read(sceneWith("file = \"a.vdb\"\nshadows = " + value + "\n" + light)).volumes.at(0).shadows;
    };
    EXPECT_EQ(volume("file = \"a.vdb\"\n").shadows, std::nullopt) << "all";
    EXPECT_EQ(shadows("true"), std::nullopt) << "all";
    EXPECT_EQ(shadows("false"), std::vector<std::string>{});
    EXPECT_EQ(shadows("[\"key\"]"), std::vector<std::string>{"key"});
    EXPECT_EQ(volumeError("shadows = [\"kye\"]\n" + light),
              "scene.toml:6:12: there is no light 'kye'; did you mean 'key'?; expected 'key'");
    EXPECT_EQ(volumeError("shadows = 1\n" + light),
              "scene.toml:6:11: 'shadows' is 1; expected true, false or a list of names of lights");
}

TEST(SceneVolume, TranslateComesAfterRotateAfterScale) {
    const Mat4 m = transform("{ translate = [10, 20, 30], rotate = [90, 0, 90], scale = [1, 2, 3] }");
    // Scale (1, 2, 3); about x takes y to z and z to -y; about z takes x to y and y to -x.
    expectNear(transformPoint(m, {0, 0, 0}), {10, 20, 30});
    expectNear(transformVector(m, {1, 0, 0}), {0, 1, 0});
    expectNear(transformVector(m, {0, 1, 0}), {0, 0, 2});
    expectNear(transformVector(m, {0, 0, 1}), {3, 0, 0});
    EXPECT_EQ(transform("{ scale = 2 }"), Mat4(2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1));
}

TEST(SceneVolume, RotationsAreRightHandedAndInTheOrderXYZ) {
    const double c = std::cos(std::acos(-1.0) / 6), s = 0.5;
    expectNear(transformVector(transform("{ rotate = [30, 0, 0] }"), {0, 1, 0}), {0, c, s});
    expectNear(transformVector(transform("{ rotate = [0, 30, 0] }"), {0, 0, 1}), {s, 0, c});
    expectNear(transformVector(transform("{ rotate = [0, 0, 30] }"), {1, 0, 0}), {c, s, 0});
    const Mat4 x = transform("{ rotate = [11, 0, 0] }"), y = transform("{ rotate = [0, 22, 0] }"),
               z = transform("{ rotate = [0, 0, 33] }"), all = transform("{ rotate = [11, 22, 33] }");
    const Vec3 p(0.3, -0.7, 2);
    expectNear(transformPoint(all, p), transformPoint(z, transformPoint(y, transformPoint(x, p))));
}

TEST(SceneVolume, RightAnglesAreExact) {
    EXPECT_EQ(transformVector(transform("{ rotate = [0, 90, 0] }"), {0, 0, 5}), Vec3(5, 0, 0));
    EXPECT_EQ(transformVector(transform("{ rotate = [0, 540, 0] }"), {0, 0, 5}), Vec3(0, 0, -5));
    EXPECT_EQ(transform("{ rotate = [360, -720, 0] }"), Mat4(1.0));
}

TEST(SceneVolume, MatrixRowsActOnColumnVectors) {
    const Mat4 m = transform("{ matrix = [[1, 2, 0, 10], [0, 1, 0, 20], [0, 0, 1, 30], [0, 0, 0, 1]] }");
    EXPECT_EQ(transformPoint(m, {0, 0, 0}), Vec3(10, 20, 30));
    EXPECT_EQ(transformVector(m, {0, 1, 0}), Vec3(2, 1, 0));
}

TEST(SceneVolume, TransformsAreChecked) {
    EXPECT_EQ(volumeError("transform = { matrix = [[1,0,0,0],[0,1,0,0],[0,0,1,0],[5,6,7,1]] }\n"),
              "scene.toml:6:55: the last row of 'matrix' is not 0, 0, 0, 1; expected an affine matrix that acts on "
              "column vectors, with the translation in its last column");
    EXPECT_EQ(volumeError("transform = { matrix = [[1,0,0,0],[1,0,0,0],[0,0,1,0],[0,0,0,1]] }\n"),
              "scene.toml:6:24: 'matrix' is singular; expected an invertible matrix");
    EXPECT_EQ(volumeError("transform = { matrix = [1,0,0,0] }\n"),
              "scene.toml:6:25: 'matrix[0]' is 1; expected four rows of four numbers");
    EXPECT_EQ(
        volumeError("transform = { matrix = [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]], scale = 2 }\n"),
        "scene.toml:6:75: 'transform' of [[volume]] 'volume1' has both 'matrix' and 'scale'; expected one of them");
    EXPECT_EQ(volumeError("transform = { scale = [1, 0, 1] }\n"),
              "scene.toml:6:23: 'scale' is 0 at frame 1; expected a number or three numbers, none of them 0");
    EXPECT_EQ(volumeError("transform = 3\n"), "scene.toml:6:13: 'transform' is 3; expected a table");
}

TEST(SceneVolume, TransformsMayBeKeyed) {
    const std::string text =
        "{ translate = { keys = [[1, [0, 0, 0]], [5, [4, 0, 0]]] }, scale = { keys = [[1, 1], [5, [3, 3, "
        "3]]] } }";
    const Mat4 m = transform(text, 2);
    EXPECT_EQ(transformPoint(m, {0, 0, 0}), Vec3(1, 0, 0));
    EXPECT_EQ(transformVector(m, {1, 0, 0}), Vec3(1.5, 0, 0));
}

TEST(SceneVolume, ReadsDensityAndMedium) {
    const SceneVolume v = volume(
        "file = \"a.vdb\"\ndensity = { grid = \"density[1]\", scale = 4, ramp = [[0, 0], [0.1, 1]] }\n"
        "[volume.medium]\nalbedo = [1, 0.5, 0]\nphase = { type = \"hg\", g = -0.4 }\n");
    EXPECT_EQ(v.densityGrid, "density[1]");
    EXPECT_EQ(v.densityScale, 4);
    EXPECT_EQ(v.ramp, (std::vector<std::pair<double, double>>{{0, 0}, {0.1, 1}}));
    EXPECT_EQ(v.medium.albedo, Rgb(1, 0.5, 0));
    EXPECT_EQ(v.medium.phase.g, -0.4);
}

TEST(SceneVolume, DensityAndMediumAreChecked) {
    EXPECT_EQ(volumeError("density = { scale = -1 }\n"),
              "scene.toml:6:21: 'scale' is -1; expected a number from 0 to 1e+30 per world unit");
    EXPECT_EQ(volumeError("density = { scael = 1 }\n"),
              "scene.toml:6:13: 'scael' is not known here ('density' of [[volume]] 'volume1'); did you mean 'scale'?; "
              "allowed: 'grid', 'scale', 'ramp', 'remap', 'edge', 'mask', 'noise' or 'noise_mode'");
    EXPECT_EQ(volumeError("[volume.medium]\nalbedo = [0.5, 1.5, 0]\n"),
              "scene.toml:7:10: 'albedo' is 0.5, 1.5, 0 in the working space; expected numbers from 0 to 1");
    EXPECT_EQ(volumeError("[volume.medium]\nphase = { type = \"hg\", g = 1 }\n"),
              "scene.toml:7:28: 'g' is 1; expected a number greater than -1 and less than 1");
    EXPECT_EQ(volumeError("[volume.medium]\nphase = { type = \"isotropic\", g = 0.5 }\n"),
              "scene.toml:7:31: 'g' is not known here ('phase' of [volume.medium] of [[volume]] 'volume1' of type "
              "'isotropic'); allowed: 'type'");
}

TEST(SceneVolume, RampsKeepEmptySpaceEmpty) {
    const auto rampError = [](const std::string& ramp) { return volumeError("density = { ramp = " + ramp + " }\n"); };
    const std::string zero =
        "scene.toml:6:20: 'ramp' is above 0 at grid value 0; expected 0 there, because empty space is skipped";
    EXPECT_EQ(rampError("[[0, 0.1], [1, 1]]"), zero);
    EXPECT_EQ(rampError("[[-1, 0], [1, 1]]"), zero);
    EXPECT_EQ(rampError("[[0.5, 1], [1, 0]]"), zero);
    EXPECT_EQ(rampError("[[-2, 0], [-1, 1]]"), zero);
    EXPECT_EQ(rampError("[[0.5, 0], [1, 1]]"), "no error");
    EXPECT_EQ(rampError("[[-1, 1], [0, 0], [1, 1]]"), "no error");
    EXPECT_EQ(rampError("[[-2, 1], [-1, 0]]"), "no error");
    EXPECT_EQ(rampError("[[0, 0], [0, 1]]"),
              "scene.toml:6:30: 'ramp': 0 does not come after 0; expected ascending values");
    EXPECT_EQ(rampError("[[0, 0]]"),
              "scene.toml:6:20: 'ramp' is a list of 1; expected at least two [grid value, value]");
    EXPECT_EQ(rampError("[[0, 0], [1, -1]]"), "scene.toml:6:33: 'ramp[1][1]' is -1; expected a number of at least 0");
}

}  // namespace
}  // namespace scrim
