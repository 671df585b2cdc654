// SPDX-License-Identifier: Apache-2.0
// Wide light on surfaces, kept on cells: what classified volumes reflect of skies and of lights with a surface.
#include "soft_lights.h"
#include "support/fields.h"

#include <scrim/engine/passes/light_cells.h>
#include <scrim/engine/plan/make_plan.h>
#include <scrim/engine/plan/transport_plan.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

Classified look(double extinction, double specular) {
    Classified look;
    look.transfer = {{0.2, Rgb(0.9, 0.6, 0.4), 0}, {0.8, Rgb(0.9, 0.6, 0.4), extinction}};
    look.ambient = 0;
    look.diffuse = 0.9;
    look.specular = specular;
    return look;
}

// A ball with a soft rim, and a small one in front of it.
double twoBalls(const Vec3& p) {
    const auto ball = [&](const Vec3& centre, double radius) {
        return std::clamp(0.5 + (radius - glm::distance(p, centre)) / 4, 0.0, 1.0);
    };
    return std::max(ball({-2, -1, -2}, 7), ball({4, 5, 5}, 3));
}

ViewScene scanOf(const Classified& classified) {
    ViewScene scene = orthographicScene(makeField(Int3(-12), Int3(12), 1, twoBalls), {}, 26, 36);
    scene.volumes[0].classified = std::make_shared<const Classified>(classified);
    scene.dials.texel = scene.dials.sheetThickness = 0.5;
    return scene;
}

const std::vector<std::pair<std::string, Light>>& wideLights() {
    static const std::vector<std::pair<std::string, Light>> all{
        {"dome", domeLight(24)}, {"rectangle", areaLight(AreaShape::rectangle, {25, 18, 22}, 9, 9, Rgb(9, 5, 2))}};
    return all;
}

Image renderedOn(ViewScene scene, ShadowMethod method) {
    for (Light& light : scene.lights) light.shadow = method;
    EXPECT_EQ(makePlan(scene, 1).cellLights.lights.empty(), method == ShadowMethod::buffers);
    return renderScene(scene).image;
}

// By RMS over that of `b`.
double difference(const Image& a, const Image& b) {
    double squares = 0, all = 0;
    for (std::size_t i = 0; i < a.rgba.size(); ++i) {
        if (i % 4 == 3) continue;
        squares += std::pow(double(a.rgba[i]) - double(b.rgba[i]), 2);
        all += std::pow(double(b.rgba[i]), 2);
    }
    return std::sqrt(squares / all);
}

// Light on surfaces that the eye does not see is not kept. That nothing seen is missing, brute force says above.
TEST(SurfacesOnCells, AreKeptWhereTheEyeSeesThem) {
    for (const bool perspective : {false, true}) {
        ViewScene scene = scanOf(look(6, 0.3));
        scene.lights = {domeLight(24)};
        if (perspective) {
            scene.camera.type = CameraType::perspective;
            scene.camera.wsPosition = {0, 0, 60};
        }
        CellLightWork work;
        const std::vector<CellLight> kept = lightOnCells(
            scene, {0}, 1.0 / 3, {}, [] {}, work);
        ASSERT_EQ(kept.size(), 2u);  // diffuse and mirrored
        const Vec3 toEye = -viewingAxis(scene.camera), large(-2, -1, -2);
        for (const CellLight& light : kept) {
            Real seen[3], hidden[3];
            light.ofVolume.front()->sample(large + 7.0 * toEye, seen);
            light.ofVolume.front()->sample(large - 7.0 * toEye, hidden);
            EXPECT_EQ(hidden[1], 0);
            if (light.as == ShownAs::diffuse) {
                EXPECT_GT(seen[1], 0.01);
            }
        }
    }
}

// A scan whose cells take too much memory has larger ones, and says what error they leave.
TEST(SurfacesOnCells, OfLargeScansAreCoarserAndSaySo) {
    ViewScene scene = scanOf(look(6, 0.3));
    scene.lights = {domeLight(24)};
    scene.lights.front().shadow = ShadowMethod::cells;
    const CellLightPlan enough = planCellLights(scene);
    EXPECT_EQ(enough.coarser(), 1);
    EXPECT_EQ(errorOfLargeCells(scene, enough), 0);
    scene.memoryLimit = enough.bytes;  // half of it is for cells
    const CellLightPlan large = planCellLights(scene);
    ASSERT_EQ(large.lights.size(), 1u);
    EXPECT_GT(large.coarser(), 1.1);
    EXPECT_LE(large.bytes, scene.memoryLimit / 2);
    EXPECT_GT(errorOfLargeCells(scene, large), 0.01);
    scene.volumes.push_back(orthographicScene(makeField(Int3(-12), Int3(12), 1, twoBalls), {}, 26, 36).volumes[0]);
    // Beside smoke, too; that has cells of its own.
    const CellLightPlan beside = planCellLights(scene);
    ASSERT_EQ(beside.levels.size(), 2u);
    EXPECT_GT(beside.levels[1].coarser, 1.1);
    EXPECT_GT(errorOfLargeCells(scene, beside), 0.01);
}

// Fine shadow buffers of the same directions, which agree with brute force for suns in these directions (0.04 %; the
// whole sky, which the reference integrates, is 3.7 % from 24 directions). Sheets count as the halves that the surface
// fills: as wholes, what begins within them would be 2 to 3 % too bright.
TEST(SurfacesOnCells, AreNearToFineShadowBuffers) {
    const auto apart = [](double extinction, double specular, const Light& light) {
        ViewScene scene = scanOf(look(extinction, specular));
        scene.lights = {light};
        scene.dials.lightCell = 1.0 / 3;
        const Image cells = renderedOn(scene, ShadowMethod::cells);
        scene.dials.texel = scene.dials.sheetThickness = 0.3;
        return difference(cells, renderedOn(scene, ShadowMethod::buffers));
    };
    for (const auto& [name, light] : wideLights()) {
        EXPECT_LT(apart(0.5, 0, light), 0.006) << name;
        EXPECT_LT(apart(1.5, 0.4, light), 0.01) << name;
        EXPECT_LT(apart(4, 0, light), 0.02) << name;
    }
}

// Lamps beside a scan and within the box around it: a point, whose shadows cells blur, and a sphere, which is points.
TEST(SurfacesOnCells, ShowLampsAsShadowBuffersDo) {
    const std::vector<std::tuple<std::string, Light, double>> lamps{
        {"point", lamp({5, 9, 9}, 900), 0.03},
        {"sphere", areaLight(AreaShape::sphere, {12, 9, 9}, 1.5, 0, Rgb(90, 50, 20)), 0.02}};
    for (const auto& [name, light, tolerance] : lamps) {
        ViewScene scene = scanOf(look(1.5, 0.4));
        scene.lights = {light};
        scene.dials.lightCell = 1.0 / 3;
        const Image cells = renderedOn(scene, ShadowMethod::cells);
        scene.lights[0].samples = light.extended() ? 64 : 0;  // elements all over the sphere
        EXPECT_LT(difference(cells, renderedOn(scene, ShadowMethod::buffers)), tolerance) << name;
    }
}

// By itself, a lamp in a scan no longer takes windows of directions with a sweep each.
TEST(SurfacesOnCells, KeepLampsAmongThem) {
    ViewScene scene = scanOf(look(1.5, 0.4));
    scene.lights = {lamp({5, 9, 9}, 900), areaLight(AreaShape::sphere, {12, 9, 9}, 1.5, 0, Rgb(90))};
    EXPECT_EQ(planCellLights(scene).lights, (std::vector<int>{0, 1}));
}

// Whatever else a surface has: cuts, extinction by gradients, light from behind, smoke and another surface beside it,
// and links. Without the field's values, which several volumes do not share, cells of half a voxel leave 2 to 3 %.
TEST(SurfacesOnCells, GiveThePictureOfShadowBuffers) {
    std::vector<std::pair<std::string, ViewScene>> scenes;
    const auto add = [&](const std::string& name) -> ViewScene& {
        return scenes.emplace_back(name, scanOf(look(1, 0.3))).second;
    };
    const auto reshape = [](ViewVolume& volume, auto change) {
        Classified changed = *volume.classified;
        change(changed);
        volume.classified = std::make_shared<const Classified>(changed);
    };
    add("alone");
    add("cut").volumes[0].wsClip = {{glm::normalize(Vec3(0, -1, -0.4)), 3}};
    reshape(add("gradients").volumes[0], [](Classified& c) { c.gradientRamp = {{0.05, 0}, {0.2, 1}}; });
    reshape(add("two-sided").volumes[0], [](Classified& c) { c.twoSided = true; });
    ViewScene& smoke = add("smoke");
    smoke.volumes.push_back(orthographicScene(smokeField(16), {0.08, Rgb(0.9), Phase{0.3}}, 26, 36).volumes[0]);
    smoke.volumes[1].name = "smoke";
    ViewScene& linked = add("linked");
    linked.volumes.push_back(linked.volumes[0]);
    linked.volumes[1].name = "other";
    linked.volumes[1].wsFromIs[3] += glm::dvec4(9, 2, 3, 0);
    linked.volumes[1].shadows = {false};
    for (auto& [name, scene] : scenes)
        for (const auto& [kind, light] : wideLights()) {
            scene.lights = {light};
            scene.dials.lightCell = 1.0 / 3;
            EXPECT_LT(difference(renderedOn(scene, ShadowMethod::cells), renderedOn(scene, ShadowMethod::buffers)),
                      0.025)
                << kind << ", " << name;
        }
}

// A wall of two opaque voxels between light and ball leaves the ball as dark as buffers do.
TEST(SurfacesOnCells, AreDarkBehindThinWalls) {
    Classified opaque = look(6, 0);
    ViewScene scene = orthographicScene(makeField(Int3(-14), Int3(14), 1,
                                                  [](const Vec3& p) {
                                                      const double wall = p.y > 8 && p.y < 11 ? 1 : 0;
                                                      return std::max(wall, std::clamp(5 - glm::length(p), 0.0, 1.0));
                                                  }),
                                        {}, 24, 32);
    scene.volumes[0].classified = std::make_shared<const Classified>(opaque);
    scene.lights = {areaLight(AreaShape::rectangle, {0, 40, 1}, 3, 9, Rgb(9))};
    scene.dials.lightCell = 0.5;
    const auto ofBall = [&](ShadowMethod method, bool shadows) {
        scene.lights[0].shadows = shadows;
        const Image image = renderedOn(scene, method);
        double sum = 0;
        for (int y = image.window.y0; y < image.window.y1; ++y)
            for (int x = image.window.x0; x < image.window.x1; ++x)
                if (std::hypot(x + 0.5 - 16, y + 0.5 - 16) < 5) sum += double(image.rgba[image.indexOf(x, y)]);
        return sum;
    };
    const double open = ofBall(ShadowMethod::buffers, false);
    ASSERT_GT(open, 0);
    EXPECT_LT(ofBall(ShadowMethod::cells, true), 1e-3 * open);
}

// Cells are chosen where they keep the promise, and for whoever asks for them.
TEST(SurfacesOnCells, AreChosenWhereTheyAreExactEnough) {
    const auto plan = [](double extinction, ShadowMethod method, double lightError) {
        ViewScene scene = scanOf(look(extinction, 0));
        scene.lights = {domeLight(24)};
        scene.lights[0].shadow = method;
        scene.dials.lightError = lightError;
        return makePlan(scene, 1).cellLights;
    };
    ASSERT_EQ(plan(0.5, ShadowMethod::automatic, 0.005).lights.size(), 1);
    EXPECT_DOUBLE_EQ(plan(0.5, ShadowMethod::automatic, 0.005).edge(0), 0.5);
    ASSERT_EQ(plan(1.5, ShadowMethod::automatic, 0.005).lights.size(), 1);
    EXPECT_DOUBLE_EQ(plan(1.5, ShadowMethod::automatic, 0.005).edge(0), 1.0 / 3);
    EXPECT_TRUE(plan(12, ShadowMethod::automatic, 0.005).lights.empty());
    EXPECT_FALSE(plan(12, ShadowMethod::automatic, 0.05).lights.empty());
    EXPECT_FALSE(plan(12, ShadowMethod::cells, 0.005).lights.empty());
}

}  // namespace
}  // namespace scrim::test
