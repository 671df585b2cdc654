// SPDX-License-Identifier: Apache-2.0
// Light changes smoothly as things move: second differences in time are small.
#include "support/fields.h"

#include <scrim/geometry/camera.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

// Dense lumps with gaps between them, 0.6 of optical depth a voxel.
ViewScene lumps(double g) {
    const auto value = [](const Vec3& p) {
        const double lump = std::sin(0.55 * p.x + 1) * std::sin(0.6 * p.y) * std::sin(0.5 * p.z + 2);
        return glm::dot(p, p) < 18 * 18 && lump > 0.15 ? 1.0 : 0.0;
    };
    ViewScene scene =
        orthographicScene(makeField(Int3(-18), Int3(18), 1, value), {0.6, Rgb(0.99), Phase{g}, Rgb(1)}, 40, 40);
    scene.volumes[0].medium.scattering = Scattering::full;
    scene.dials.scatterCell = 1.5;
    scene.dials.scatterDirections = 64;
    scene.layers = {Layer::indirect};
    return scene;
}

// By RMS over that of the frames.
double secondDifference(const std::vector<std::vector<float>>& frames) {
    double squares = 0, all = 0;
    for (std::size_t i = 0; i < frames[0].size(); ++i)
        for (std::size_t n = 1; n + 1 < frames.size(); ++n) {
            squares += std::pow(double(frames[n - 1][i]) - 2 * double(frames[n][i]) + double(frames[n + 1][i]), 2);
            all += std::pow(double(frames[n][i]), 2);
        }
    return std::sqrt(squares / all);
}

// Of a sun behind the lumps that turns by half a degree a frame.
double secondDifference(ViewScene scene, int firstFrame) {
    constexpr int kFrames = 6;
    std::vector<std::vector<float>> frames;
    for (int i = 0; i < kFrames; ++i) {
        const double turn = 0.5 * (firstFrame + i) * std::numbers::pi / 180;
        scene.lights = {distantLight(glm::normalize(Vec3(std::sin(turn), -0.4, std::cos(turn))), 3)};
        frames.push_back(renderScene(scene).layers.front().data);
    }
    return secondDifference(frames);
}

// A cell that one ray reaches is lit through one row of cells until the ray leaves it at once.
TEST(ScatteredLight, IsSteadyWhileTheSunTurns) {
    // With one ray a cell: 0.018 and 0.021 from frame 0, in which rays lie along the cells.
    for (const double g : {0.0, 0.6})
        for (const int first : {0, 30}) {
            const double second = secondDifference(lumps(g), first);
            EXPECT_LT(second, 0.009) << g << ", from frame " << first;
        }
}

// A slab that fills the picture and moves aside shows no change at all, wherever its voxels come to lie among texels.
TEST(EvenSmoke, IsSteadyWhileItMovesAside) {
    ViewScene scene =
        orthographicScene(boxField(Int3(-16, -16, -2), Int3(15, 15, 1)), {0.05, Rgb(1), Phase{}, Rgb(1)}, 16, 48);
    scene.lights = {distantLight({0, 0, -1})};
    scene.dials.texel = 0.26;
    std::vector<std::vector<float>> frames;
    for (int i = 0; i < 6; ++i) {
        scene.volumes[0].wsFromIs[3].x = 0.07 * i;
        frames.push_back(renderScene(scene).image.rgba);
    }
    EXPECT_LT(secondDifference(frames), 0.003);  // with two steps a texel in tables of footprints: 0.006
}

}  // namespace
}  // namespace scrim::test
