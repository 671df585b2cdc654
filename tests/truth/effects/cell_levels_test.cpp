// SPDX-License-Identifier: Apache-2.0
// Light on cells of several sizes: what volumes of large and of small voxels hold back of each other's light. Closed
// forms in uniform cubes, one inside the other.
#include "scenes.h"
#include "soft_lights.h"
#include "support/fields.h"
#include "support/verified.h"

#include <scrim/engine/model/sub_lights.h>
#include <scrim/engine/passes/light_cells.h>
#include <scrim/engine/plan/make_plan.h>
#include <scrim/engine/plan/transport_plan.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

constexpr double kSphere = 4 * std::numbers::pi;

struct Cube {
    double sigma, voxel;
    int half;  // voxels
    double lower() const { return (-half - 0.5) * voxel; }
    double upper() const { return (half - 0.5) * voxel; }
};
// Large voxels around small ones.
constexpr Cube kCubes[2] = {{0.02, 8, 5}, {0.1, 0.5, 10}};

ViewScene cubeInCube() {
    ViewScene scene = orthographicScene(boxField(Int3(-5), Int3(4)), {kCubes[0].sigma, Rgb(1), {}}, 90, 24);
    scene.volumes.push_back(scene.volumes[0]);
    for (std::size_t v = 0; v < 2; ++v) {
        ViewVolume& volume = scene.volumes[v];
        const Cube& cube = kCubes[v];
        volume.field = boxField(Int3(-cube.half), Int3(cube.half - 1));
        volume.wsFromIs = Mat4(Mat3(cube.voxel));
        volume.medium.densityScale = cube.sigma;
        volume.name = v == 0 ? "large" : "small";
    }
    return scene;
}

// All light that the plan keeps on cells, of one volume.
Rgb lightAt(const ViewScene& scene, const Vec3& ws, std::size_t volume) {
    const CellLightPlan plan = planCellLights(scene);
    Rgb sum(0);
    CellLightWork work;
    for (std::size_t l = 0; l < plan.levels.size(); ++l)
        for (const CellLight& light : lightOnCells(
                 LevelScene(scene, plan, l), plan.lights, plan.levels[l].smallest(), {}, [] {}, work)) {
            if (!light.ofVolume[volume]) continue;
            Real rgb[3];
            light.ofVolume[volume]->sample(ws, rgb);
            sum += Rgb(rgb[0], rgb[1], rgb[2]);
        }
    return sum;
}

// The optical depth from `ws` to `from`, through those of the cubes that count.
double depthTo(const Vec3& ws, const Vec3& from, const std::vector<bool>& casts) {
    double depth = 0;
    for (std::size_t v = 0; v < 2; ++v) {
        double enter = 0, leave = 1;
        for (int axis = 0; axis < 3; ++axis) {
            const double step = from[axis] - ws[axis];
            const double a = (kCubes[v].lower() - ws[axis]) / step, b = (kCubes[v].upper() - ws[axis]) / step;
            enter = std::max(enter, std::min(a, b));
            leave = std::min(leave, std::max(a, b));
        }
        if (casts[v] && leave > enter) depth += kCubes[v].sigma * (leave - enter) * glm::distance(ws, from);
    }
    return depth;
}

double closedForm(const ViewScene& scene, const Light& light, const Vec3& ws, const std::vector<bool>& casts) {
    const auto of = [&](const Vec3& from, double irradiance) {
        return irradiance / kSphere * std::exp(-depthTo(ws, from, casts));
    };
    const double r = glm::distance(ws, light.wsPosition);
    if (!light.extended()) return of(light.wsPosition, light.intensity.x / (r * r));
    if (light.area() && light.area()->shape == AreaShape::sphere) {
        const double radius = light.area()->radius, cosine = std::sqrt(1 - std::pow(radius / r, 2));
        return of(light.wsPosition, light.intensity.x * 2 * std::numbers::pi * (1 - cosine));
    }
    ViewScene alone = scene;
    alone.lights = {light};
    double sum = 0;
    for (const Light& part : subLights(alone).lights) {
        const double distance = glm::distance(ws, part.wsPosition);
        if (part.distant())
            sum += of(ws - 1e4 * part.wsDirection, part.intensity.x);
        else
            sum += of(part.wsPosition,
                      part.intensity.x * std::max(glm::dot((ws - part.wsPosition) / distance, part.wsDirection), 0.0) /
                          (distance * distance));
    }
    return sum;
}

// A cube in one that is 27 or 2 times as large, by volume, and can do with cells 2.5 or 2 times as large.
TEST(LevelsOfCells, AreApartWhereOneSizeWouldCostMore) {
    const auto levelsWith = [](int half, double voxel) {
        ViewScene scene = cubeInCube();
        scene.volumes[0].field = boxField(Int3(-half), Int3(half - 1));
        scene.volumes[0].wsFromIs = Mat4(Mat3(voxel));
        scene.lights = {domeLight(24)};
        return planCellLights(scene).levels.size();
    };
    EXPECT_EQ(levelsWith(12, 1.25), 2u);
    EXPECT_EQ(levelsWith(6, 1), 1u);
}

// Beside the large cube, in it, and in it beside the small one; a sky; points in the small one are near some of them.
std::vector<Light> lights() {
    std::vector<Light> all{domeLight(40), areaLight(AreaShape::rectangle, {60, 20, 45}, 10, 40, Rgb(9)),
                           areaLight(AreaShape::sphere, {-20, 5, 3}, 2, 0, Rgb(9)), lamp({1.3, -7.2, 9.4}, 50)};
    for (Light& light : all) light.shadow = ShadowMethod::cells;
    all[1].samples = 24;  // of which each level would need another number
    return all;
}
// In the small cube, and in the large one: near, and behind the small one seen from the point.
const std::vector<Vec3> kInSmall{{1.25, 0.5, -0.75}, {-2.25, 3.25, 2.5}, {3.75, -3.5, 0.25}};
const std::vector<Vec3> kInLarge{{-24.25, 17, 12}, {21, -26, -19}, {15, 26, 9}};

TEST(LevelsOfCells, HoldBackEachOthersLight) {
    for (const Light& light : lights()) {
        ViewScene scene = cubeInCube();
        scene.lights = {light};
        const CellLightPlan plan = planCellLights(scene);
        ASSERT_EQ(plan.levels.size(), 2u) << light.name;
        EXPECT_GT(plan.levels[0].edges[0], 3 * plan.levels[1].edges[0]);
        const auto expectIn = [&](std::size_t volume, const std::vector<Vec3>& places, double tolerance) {
            for (const Vec3& ws : places) {
                const double expected = closedForm(scene, light, ws, {true, true});
                EXPECT_NEAR(lightAt(scene, ws, volume).x, expected, tolerance * expected)
                    << "light " << int(light.kind.index()) << " at " << ws.x << ", " << ws.y << ", " << ws.z;
            }
        };
        expectIn(1, kInSmall, 0.02);
        // A cell as large as the small cube averages it with what is beside it.
        expectIn(0, kInLarge, 0.06);
    }
}

// Two cubes of small voxels in a sky.
ViewScene cubesApart(double distance) {
    ViewScene scene = cubeInCube();
    scene.volumes[0] = scene.volumes[1];
    scene.volumes[0].name = "first";
    scene.volumes[1].wsFromIs[3].x = distance;
    scene.lights = {domeLight(128)};
    return scene;
}

CellLightWork workOn(const ViewScene& scene) {
    const CellLightPlan plan = planCellLights(scene);
    CellLightWork work;
    for (std::size_t l = 0; l < plan.levels.size(); ++l)
        lightOnCells(
            LevelScene(scene, plan, l), plan.lights, plan.levels[l].smallest(), {}, [] {}, work);
    return work;
}

// What one cube hides of the other's sky is (10 / 600)^2 / (4 pi) at most.
TEST(LevelsOfCells, FarApartTakeWhatEachTakesAlone) {
    constexpr double kHidden = 3e-5;
    const ViewScene scene = cubesApart(600);
    ViewScene alone = scene;
    alone.volumes.resize(1);
    const CellLightPlan plan = planCellLights(scene);
    ASSERT_EQ(plan.levels.size(), 2U);
    EXPECT_EQ(plan.levels[0].around, (std::vector<bool>{true, false}));
    EXPECT_EQ(plan.levels[1].around, (std::vector<bool>{false, true}));
    EXPECT_EQ(planCellLights(cubesApart(150)).levels.size(), 1U);
    const CellLightWork both = workOn(scene), one = workOn(alone);
    EXPECT_LE(both.bytes, 2.1 * double(one.bytes));
    EXPECT_LE(both.directions, 2.1 * double(one.directions));
    for (const Vec3& ws : {Vec3(0), Vec3(4, -3, 2)}) {
        const double first = lightAt(alone, ws, 0).x;
        ASSERT_GT(first, 0);
        EXPECT_NEAR(lightAt(scene, ws, 0).x, first, kHidden * first);
        EXPECT_NEAR(lightAt(scene, ws + Vec3(600, 0, 0), 1).x, first, kHidden * first);
    }
}

TEST(LevelsOfCells, FarApartHaveTheShadowsOfLampsBehindEachOther) {
    const ViewScene scene = cubesApart(600);
    const std::vector<bool> first{true, false}, all{true, true};
    EXPECT_EQ(around(scene, first, 12, {}), first);
    EXPECT_EQ(around(scene, first, 12, {Vec3(0, 700, 0)}), first);
    EXPECT_EQ(around(scene, first, 12, {Vec3(0, 700, 0), Vec3(700, 0, 0)}), all);
    EXPECT_EQ(around(scene, first, 60, {}), all);
}

TEST(LevelsOfCells, LinkShadows) {
    for (const Light& light : lights()) {
        ViewScene scene = cubeInCube();
        scene.lights = {light};
        for (const bool large : {true, false}) {
            scene.volumes[0].shadows = {large};
            scene.volumes[1].shadows = {!large};
            for (const Vec3& ws : kInSmall) {
                const double expected = closedForm(scene, light, ws, {large, !large});
                EXPECT_NEAR(lightAt(scene, ws, 1).x, expected, 0.02 * expected);
            }
        }
    }
}

// What the large cube takes of a colour is missing in the small, grey one.
TEST(LevelsOfCells, TakeColoursOfEachOthersLight) {
    ViewScene scene = cubeInCube();
    scene.lights = {domeLight(24)};
    scene.volumes[0].medium.extinctionTint = Rgb(1, 0.5, 0);
    const Rgb light = lightAt(scene, kInSmall[0], 1);
    const double all = closedForm(scene, scene.lights[0], kInSmall[0], {true, true});
    const double own = closedForm(scene, scene.lights[0], kInSmall[0], {false, true});
    EXPECT_NEAR(light.x, all, 0.02 * all);
    EXPECT_NEAR(light.z, own, 0.02 * own);
    EXPECT_GT(light.y, 1.05 * light.x);
}

// The picture, by shadow buffers of the same directions.
TEST(LevelsOfCells, ShowWhatBuffersShow) {
    ViewScene scene = cubeInCube();
    scene.camera.height = 40;
    scene.lights = {domeLight(24)};
    scene.lights[0].shadow = ShadowMethod::cells;
    ASSERT_EQ(makePlan(scene, 2).cellLights.levels.size(), 2u);
    const Image cells = renderScene(scene).image;
    scene.lights[0].shadow = ShadowMethod::buffers;
    const Image buffers = renderScene(scene).image;
    double sum = 0, squares = 0;
    for (std::size_t i = 0; i < cells.rgba.size(); i += 4) {
        sum += double(buffers.rgba[i]);
        squares += std::pow(double(cells.rgba[i]) - double(buffers.rgba[i]), 2);
    }
    const double count = double(cells.rgba.size()) / 4;
    EXPECT_LT(std::sqrt(squares / count), 0.01 * sum / count);
}

// A scan in haze has cells of its own, which are as small and as many as without the haze.
TEST(LevelsOfCells, OfAScanDoNotFillTheHazeAroundIt) {
    ViewScene scene = cubeInCube();
    Classified look;
    look.transfer = {{0.1, Rgb(1), 0}, {0.9, Rgb(1), 1}};
    scene.volumes[1].classified = std::make_shared<const Classified>(look);
    scene.lights = {domeLight(24)};
    scene.lights[0].shadow = ShadowMethod::cells;
    const CellLightPlan together = planCellLights(scene);
    ASSERT_EQ(together.levels.size(), 2u);
    EXPECT_EQ(together.levels[1].volumes, (std::vector<bool>{false, true}));
    scene.volumes.erase(scene.volumes.begin());
    const CellLightPlan alone = planCellLights(scene);
    EXPECT_EQ(together.levels[1].edges, alone.levels[0].edges);
    EXPECT_LT(together.bytes, 2 * alone.bytes);
}

}  // namespace
}  // namespace scrim::test
