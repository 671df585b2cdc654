// SPDX-License-Identifier: Apache-2.0
// What a scene says about shading arrives in its structs, and mistakes are named.
#include "read_scene.h"

#include <scrim/volume/grid_edit.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>

namespace scrim::test {
namespace {

SceneVolume volume(const std::string& keys, double frame = 1) {
    return read(kCamera + kVolume + keys, {}, frame).volumes.at(0);
}
std::string volumeError(const std::string& keys) {
    return errorOf(kCamera + kVolume + keys);
}

TEST(SceneShading, ArrivesInTheVolume) {
    const SceneVolume v = volume(
        "[volume.density]\nremap = { from = [0.1, 0.8], to = [0, 2], gamma = 0.5, contrast = 3 }\n"
        "edge = [0.02, 0.1]\nmask = { grid = \"heat\", to = [1, 0] }\nnoise_mode = \"erode\"\n"
        "noise = { amount = 0.7, frequency = 3, octaves = 5, roughness = 0.6, lacunarity = 2.5, seed = 4, "
        "space = \"world\", offset = [1, 2, 3], evolution = 0.5 }\n");
    const Noise noise{0.7, 3, 5, 0.6, 2.5, {1, 2, 3}, 0.5, 4, true, "scene.toml:11:9"};
    EXPECT_EQ(v.shading.remap, (Remap{{0.1, 0.8}, {0, 2}, 0.5, 3}));
    EXPECT_EQ(v.shading.edge, (std::array<double, 2>{0.02, 0.1}));
    EXPECT_EQ(v.shading.mask, (Mask{"heat", Remap{{0, 1}, {1, 0}}, "scene.toml:9:17"}));
    EXPECT_EQ(v.shading.noise, noise);
    EXPECT_EQ(v.shading.noiseMode, NoiseMode::erode);
    EXPECT_FALSE(v.displacement);
    EXPECT_FALSE(volume("").shading.any());
    EXPECT_EQ(volume("").edit, nullptr);
    const SceneVolume moved = volume("displacement = { amount = { keys = [[1, 0], [5, 2]] } }\n", 3);
    EXPECT_EQ(moved.displacement->amount, 1);
    EXPECT_EQ(moved.displacement->octaves, Noise().octaves);
}

TEST(SceneShading, OfAMediumHasRampsMasksAndTints) {
    const SceneVolume v = volume(
        "[volume.medium]\nalbedo = { grid = \"heat\", ramp = [[0, [1, 1, 1]], [2, [0.5, 0, 0]]] }\n"
        "emission = { grid = \"f\", mask = { grid = \"m\", from = [0.5, 2] } }\n"
        "blackbody = { grid = \"t\", tint = [1, 0.5, 0], mask = { grid = \"m\" } }\n");
    ASSERT_EQ(v.albedoGrid->ramp.size(), 2u);
    EXPECT_EQ(v.albedoGrid->ramp[1].second, Rgb(0.5, 0, 0));
    ASSERT_EQ(v.emission.size(), 2u);
    EXPECT_EQ(v.emission[0].mask->remap.from, (std::array<double, 2>{0.5, 2}));
    EXPECT_EQ(v.emission[1].mask->grid, "m");
    const SceneVolume plain = volume("[volume.medium]\nblackbody = { grid = \"t\" }\n");
    const Rgb tinted = v.emission[1].ramp.back().second, white = plain.emission[0].ramp.back().second;
    EXPECT_NEAR(tinted.x, white.x, 1e-12 * white.x);
    EXPECT_NEAR(tinted.y, white.y / 2, 1e-12 * white.y);
    EXPECT_EQ(tinted.z, 0);
}

TEST(SceneShading, RefusesWhatFillsEmptySpaceOrDescends) {
    EXPECT_EQ(volumeError("density = { remap = { to = [1, 2] } }\n"),
              "scene.toml:6:21: 'remap' of 'density' of [[volume]] 'volume1' maps 0 to 1; expected 0, because empty "
              "space is skipped");
    EXPECT_EQ(volumeError("density = { remap = { from = [1, 0] } }\n"),
              "scene.toml:6:30: 'from' is [1, 0]; expected ascending numbers");
    EXPECT_EQ(volumeError("density = { edge = [0.2, 0.1] }\n"),
              "scene.toml:6:20: 'edge' is [0.2, 0.1]; expected ascending numbers");
    EXPECT_NE(volumeError("density = { mask = {} }\n").find("lacks 'grid'"), std::string::npos);
    EXPECT_NE(volumeError("displacement = { octaves = 99 }\n").find("a whole number from 1 to 16"), std::string::npos);
}

TEST(SceneEdit, HoldsCodeItsPlaceAndItsVariables) {
    const SceneVolume v = volume(
        "clip = [[0, 0, 0], [1, 2, 3]]\nresample = 2\nax = '''\nf@a = $gain + $frame + $seed;\n'''\n"
        "parameters = { gain = { keys = [[1, 1], [5, 5]] } }\ndensity = { grid = \"d\" }\n",
        3);
    ASSERT_TRUE(v.edit);
    EXPECT_EQ(v.edit->clip, (Bounds{{0, 0, 0}, {1, 2, 3}}));
    EXPECT_EQ(v.edit->resample, 2);
    EXPECT_EQ(v.edit->density, "d");
    ASSERT_EQ(v.edit->programs.size(), 1u);
    EXPECT_EQ(v.edit->programs[0], (AxCode{"f@a = $gain + $frame + $seed;\n", "scene.toml:8:6", "scene.toml", 9, 1}));
    EXPECT_EQ(v.edit->variables, (std::vector<AxVariable>{{"frame", {3}}, {"gain", {3}}, {"seed", {0}}}));
    EXPECT_EQ(volume("ax = 'f@a = v$w;'\nparameters = { w = [1, 2, 3] }\n").edit->variables,
              (std::vector<AxVariable>{{"w", {1, 2, 3}}}));
}

TEST(SceneEdit, DividesVoxelsForShadingAlone) {
    const std::string noise = "density = { noise = { frequency = 3 } }\n";
    const SceneVolume v = volume("detail = 4\n" + noise);
    ASSERT_TRUE(v.edit);
    EXPECT_EQ(v.edit->detail, 4);
    EXPECT_FALSE(v.edit->changesGrids()) << "files are read as they are";
    EXPECT_EQ(volume("detail = \"auto\"\n" + noise).edit->detail, 0);
    EXPECT_EQ(volume("detail = 2\ndensity = { edge = [0.1, 0.2] }\n").edit->detail, 2);
    EXPECT_EQ(volume("detail = 2\ndisplacement = { amount = 2 }\n").edit->detail, 2);
    EXPECT_EQ(volume("detail = 1\n").edit, nullptr);
    for (const std::string wrong : {"3", "0", "16", "-2", "\"fine\"", "true"})
        EXPECT_NE(volumeError("detail = " + wrong + "\n" + noise).find("expected 1, 2, 4, 8 or \"auto\""),
                  std::string::npos)
            << volumeError("detail = " + wrong + "\n" + noise);
    EXPECT_EQ(volumeError("detail = 2\n"),
              "scene.toml:6:10: 'detail' needs shading, which it evaluates between voxels; expected 'displacement', or "
              "'noise', 'edge', 'remap', 'mask' or 'ramp' of 'density' beside it");
    EXPECT_EQ(
        volumeError("detail = \"auto\"\ndensity = { edge = [0.1, 0.2] }\n"),
        "scene.toml:6:10: 'detail' is \"auto\", and the volume has no noise to follow; expected 'displacement' or "
        "'noise' of 'density' beside it, or a number");
}

TEST(SceneEdit, ClipsWithABoxAndAPlane) {
    const SceneVolume v = volume("clip = [[0, 1, 2], [3, 4, 5]]\nclip_plane = [0, 0, 2, 6]\n");
    EXPECT_EQ(v.clip, (std::vector<HalfSpace>{{{1, 0, 0}, 0},
                                              {{-1, 0, 0}, 3},
                                              {{0, 1, 0}, -1},
                                              {{0, -1, 0}, 4},
                                              {{0, 0, 1}, -2},
                                              {{0, 0, -1}, 5},
                                              {{0, 0, -1}, 3}}));
    EXPECT_FALSE(volume("clip_plane = [0, 0, 2, 6]\n").edit) << "all voxels are needed";
    EXPECT_TRUE(volume("").clip.empty());
    EXPECT_NE(volumeError("clip_plane = [0, 0, 0, 6]\n").find("expected a normal [nx, ny, nz] that is not 0"),
              std::string::npos);
    EXPECT_NE(volumeError("clip_plane = [0, 0, 1]\n")
                  .find("scene.toml:6:14: 'clip_plane' is a list of 3; expected "
                        "four numbers [nx, ny, nz, d]"),
              std::string::npos);
}

TEST(SceneEdit, WhatMovesIntoTheBoxIsNotLeftOut) {
    EXPECT_TRUE(volume("clip = [[0, 1, 2], [3, 4, 5]]\n").edit);
    EXPECT_FALSE(volume("clip = [[0, 1, 2], [3, 4, 5]]\ndisplacement = { amount = 2 }\n").edit);
}

TEST(SceneEdit, SharesParametersWithASource) {
    const std::string source = kCamera + "[[volume]]\nsource = \"noise\"\n";
    const SceneVolume v = read(source + "ax = 'f@density *= $gain;'\nparameters = { size = 3, gain = 2 }\n").volumes[0];
    EXPECT_EQ(v.parameters, (std::vector<std::pair<std::string, std::string>>{{"size", "3"}}));
    EXPECT_EQ(v.edit->variables, (std::vector<AxVariable>{{"gain", {2}}}));
}

TEST(Looks, AreShortScenesThatNeedNoFiles) {
    int looks = 0;
    for (const auto& entry : std::filesystem::directory_iterator(SCRIM_SOURCE_DIR "/examples/looks")) {
        if (entry.path().extension() != ".toml") continue;
        ++looks;
        const SceneText text = loadSceneText(entry.path().string());
        EXPECT_LE(std::count(text.text.begin(), text.text.end(), '\n'), 40) << entry.path();
        for (const SceneVolume& v : readScene(text, 1, {}, ownColours()).volumes) {
            EXPECT_FALSE(v.source.empty()) << entry.path();
            EXPECT_TRUE(v.edit) << entry.path();
        }
    }
    EXPECT_EQ(looks, 8);
}

}  // namespace
}  // namespace scrim::test
