// SPDX-License-Identifier: Apache-2.0
// Lights on cells among volumes with shadow linking: closed forms in uniform cubes, shadow buffers of the same lights,
// and brute force.
#include "scenes.h"
#include "soft_lights.h"
#include "support/fields.h"
#include "support/verified.h"

#include <scrim/engine/model/sub_lights.h>
#include <scrim/engine/plan/effects.h>
#include <scrim/engine/plan/make_plan.h>
#include <scrim/engine/plan/transport_plan.h>
#include <scrim/engine/passes/light_cells.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

constexpr double kSphere = 4 * std::numbers::pi;
constexpr double kHalf = 10;  // of the cubes' edge, world units

// Two uniform cubes in one place.
constexpr double kSigma[2] = {0.1, 0.06};
ViewScene twoCubes() {
    ViewScene scene = orthographicScene(boxField(Int3(-10), Int3(9)), {kSigma[0], Rgb(1), {}}, 24, 24);
    scene.volumes.push_back(scene.volumes[0]);
    scene.volumes[1].name = "other";
    scene.volumes[1].medium.densityScale = kSigma[1];
    return scene;
}

// Has the volumes cast shadows in each of the lights: bit v of sets[i] for volume v in light i.
void link(ViewScene& scene, const std::vector<int>& sets) {
    for (std::size_t v = 0; v < scene.volumes.size(); ++v) {
        scene.volumes[v].shadows.clear();
        for (const int set : sets) scene.volumes[v].shadows.push_back((set >> v & 1) != 0);
    }
}
double sigmaOf(int set) {
    return ((set & 1) != 0 ? kSigma[0] : 0) + ((set & 2) != 0 ? kSigma[1] : 0);
}

// All light on cells of half a voxel at a point, of one volume.
Rgb lightAt(const ViewScene& scene, const Vec3& ws, std::size_t volume = 0) {
    CellLightWork work;
    std::vector<int> all(scene.lights.size());
    std::iota(all.begin(), all.end(), 0);
    Rgb sum(0);
    for (const CellLight& light : lightOnCells(
             scene, all, 0.5, {}, [] {}, work)) {
        if (!light.ofVolume[volume]) continue;
        Real rgb[3];
        light.ofVolume[volume]->sample(ws, rgb);
        sum += Rgb(rgb[0], rgb[1], rgb[2]);
    }
    return sum;
}

// The part of the way from `ws` to `from` that is in the cube, whose voxels are centred on whole numbers.
double wayInCube(const Vec3& ws, const Vec3& towards, double distance) {
    double way = distance;
    for (int axis = 0; axis < 3; ++axis) {
        const double face = (towards[axis] > 0 ? kHalf : -kHalf) - 0.5;
        if (towards[axis] != 0) way = std::min(way, (face - ws[axis]) / towards[axis]);
    }
    return way;
}

// The light of sub-lights, or of a lamp or a small sphere, through an extinction that fills the cube.
double closedForm(const ViewScene& scene, const Light& light, const Vec3& ws, double sigma) {
    const auto of = [&](const Vec3& from, double irradiance) {
        const double r = glm::distance(ws, from);
        return irradiance / kSphere * std::exp(-sigma * wayInCube(ws, (from - ws) / r, r));
    };
    const double r = glm::distance(ws, light.wsPosition);
    if (isLampOnCells(scene, light)) {
        if (!light.area()) return of(light.wsPosition, light.intensity[1] / (r * r));
        const double radius = light.area()->radius, cosine = std::sqrt(1 - std::pow(radius / r, 2));
        return of(light.wsPosition, light.intensity[1] * 2 * std::numbers::pi * (1 - cosine));
    }
    ViewScene alone = scene;
    alone.lights = {light};
    double sum = 0;
    const SubLights parts = subLights(alone);
    for (const Light& part : parts.lights) {
        const double distance = glm::distance(ws, part.wsPosition);
        if (part.distant())
            sum += of(ws - 1e3 * part.wsDirection, part.intensity[1]);
        else
            sum += of(part.wsPosition,
                      part.intensity[1] * std::max(glm::dot((ws - part.wsPosition) / distance, part.wsDirection), 0.0) /
                          (distance * distance));
    }
    return sum;
}

std::vector<Light> lightsOfAllShapes() {
    return {domeLight(40), areaLight(AreaShape::rectangle, {22, 14, 25}, 3, 9, Rgb(9)),
            areaLight(AreaShape::sphere, {3, -2, 24}, 0.5, 0, Rgb(9)), lamp({0.3, -0.2, 0.4}, 50)};
}
const std::vector<Vec3> kPlaces{{2.25, 0.25, -0.75}, {-3.75, 4.25, 5.25}, {5.25, -6.25, 1.25}};

// As exact as it is without linking: the tests of light_cells_test.cpp allow 1 to 1.5 % at the extinction of the first
// cube alone. What cells leave is an error of the depth, which is proportional to the extinction.
TEST(LinkedCells, LightIsHeldBackByVolumesThatCastShadowsInIt) {
    for (const Light& light : lightsOfAllShapes())
        for (const int set : {0, 1, 2, 3}) {
            ViewScene scene = twoCubes();
            scene.lights = {light};
            link(scene, {set});
            for (const Vec3& ws : kPlaces)
                for (const std::size_t volume : {0u, 1u}) {
                    const double expected = closedForm(scene, light, ws, sigmaOf(set));
                    const double part = 0.015 * std::max(sigmaOf(set) / kSigma[0], 1.0);
                    EXPECT_NEAR(lightAt(scene, ws, volume)[1], expected, part * expected)
                        << light.name << (light.dome() ? " dome" : "") << ", set " << set << " at " << ws.x;
                }
        }
}

TEST(LinkedCells, LightsOfOneSceneHaveSetsOfTheirOwn) {
    for (const bool layers : {false, true}) {
        ViewScene scene = twoCubes();
        scene.lights = lightsOfAllShapes();
        if (layers) scene.layers = {Layer::light};
        for (const std::vector<int>& sets :
             {std::vector<int>{1, 2, 3, 0}, std::vector<int>{0, 1, 2, 3}, std::vector<int>{2, 0, 1, 1}}) {
            link(scene, sets);
            for (const Vec3& ws : kPlaces) {
                double expected = 0;
                for (std::size_t i = 0; i < sets.size(); ++i)
                    expected += closedForm(scene, scene.lights[i], ws, sigmaOf(sets[i]));
                EXPECT_NEAR(lightAt(scene, ws)[1], expected, 0.015 * expected) << "layers " << layers;
            }
        }
    }
}

// Ten at one place share cells.
TEST(LinkedCells, LampsThatShareCellsHaveSetsOfTheirOwn) {
    ViewScene scene = twoCubes();
    scene.lights.assign(10, lamp({0.3, -0.2, 0.4}, 5));
    ASSERT_TRUE(lampsShareCells(scene));
    std::vector<int> sets;
    for (int i = 0; i < 10; ++i) sets.push_back(i % 4);
    link(scene, sets);
    for (const Vec3& ws : kPlaces) {
        double expected = 0;
        for (const int set : sets) expected += closedForm(scene, scene.lights[0], ws, sigmaOf(set));
        EXPECT_NEAR(lightAt(scene, ws)[1], expected, 0.015 * expected) << ws.x;
    }
}

// Each colour has the extinction of its own.
TEST(LinkedCells, HoldsForColouredExtinction) {
    const Rgb tints[2] = {{1, 0.6, 0.3}, {0.2, 0.5, 1}};
    for (const Light& light : lightsOfAllShapes())
        for (const int set : {1, 2}) {
            ViewScene scene = twoCubes();
            for (std::size_t v = 0; v < 2; ++v) scene.volumes[v].medium.extinctionTint = tints[v];
            scene.lights = {light};
            link(scene, {set});
            const Rgb found = lightAt(scene, kPlaces[1]);
            for (int c = 0; c < 3; ++c) {
                const double expected = closedForm(scene, light, kPlaces[1], sigmaOf(set) * tints[set - 1][c]);
                EXPECT_NEAR(found[c], expected, 0.015 * expected) << light.name << ", set " << set << ", colour " << c;
            }
        }
}

// Three volumes of smoke, beside and in each other, of two tints.
ViewScene linkedSmoke(bool coloured) {
    ViewScene scene = orthographicScene(smokeField(16), {0.15, Rgb(0.9), {0.3}}, 36, 36);
    scene.dials.texel = 0.5;
    scene.dials.sheetThickness = 1;
    scene.volumes.push_back(scene.volumes[0]);
    scene.volumes[1].wsFromIs[3] = {7, -5, 4, 1};
    scene.volumes[1].medium.densityScale = 0.1;
    if (coloured) scene.volumes[1].medium.extinctionTint = {1, 0.6, 0.3};
    scene.volumes.push_back(scene.volumes[0]);
    scene.volumes[2].wsFromIs[3] = {-8, 6, 9, 1};
    scene.lights = {domeLight(24), areaLight(AreaShape::rectangle, {25, 18, 12}, 6, 9, Rgb(9)),
                    areaLight(AreaShape::sphere, {-16, 14, 22}, 1, 0, Rgb(9)), lamp({3.3, -2.2, 1.7}, 120)};
    link(scene, {1, 2, 6, 3});
    return scene;
}

// The two ways share nothing but the sub-lights; each has an error of its own below the percent of `standard`.
TEST(LinkedCells, GiveThePictureOfShadowBuffers) {
    for (const bool coloured : {false, true})
        for (const std::size_t alone : {0u, 1u, 4u}) {  // 4: all but the lamps, for which buffers are less exact
            ViewScene scene = linkedSmoke(coloured);
            scene.lights.resize(2);
            link(scene, {1, 2});
            if (alone < 2) scene.lights[1 - alone].intensity = Rgb(0);
            const auto rendered = [&](ShadowMethod method) {
                for (Light& light : scene.lights) light.shadow = method;
                EXPECT_EQ(makePlan(scene, 1).cellLights.lights.empty(), method == ShadowMethod::buffers);
                return renderScene(scene).image.rgba;
            };
            const std::vector<float> cells = rendered(ShadowMethod::cells), buffers = rendered(ShadowMethod::buffers);
            double squares = 0, all = 0;
            for (std::size_t i = 0; i < cells.size(); ++i) {
                if (i % 4 == 3) continue;
                squares += std::pow(double(cells[i]) - double(buffers[i]), 2);
                all += std::pow(double(buffers[i]), 2);
            }
            EXPECT_LT(std::sqrt(squares / all), 0.015) << "coloured " << coloured << ", light " << alone;
        }
}

// The reference marches to each light through the volumes that cast shadows in it.
TEST(LinkedCells, AgreeWithBruteForce) {
    for (const bool coloured : {false, true}) {
        ViewScene scene = linkedSmoke(coloured);
        EXPECT_EQ(makePlan(scene, 1).cellLights.lights.size(), 4u);
        EXPECT_LT(errorOf(scene, 16), 0.02) << "coloured " << coloured;
        // Without the links the picture is another one.
        const Image linked = renderScene(scene).image;
        for (ViewVolume& volume : scene.volumes) volume.shadows.clear();
        EXPECT_GT(summarise(samplePixels(scene, linked, 8, 7)).error, 0.1);
    }
}

TEST(LinkedCells, LayersAddUpToThePicture) {
    ViewScene scene = linkedSmoke(false);
    scene.lights[0].group = scene.lights[1].group = "soft";  // of two sets
    scene.layers = {Layer::light};
    const Frame frame = renderScene(scene);
    ASSERT_EQ(frame.layers.size(), 3u);
    scene.layers.clear();
    const Image plain = renderScene(scene).image;
    for (std::size_t i = 0; i < plain.rgba.size(); ++i) {
        if (i % 4 == 3) continue;
        double sum = 0;
        for (const FrameLayer& layer : frame.layers) sum += double(layer.data[i / 4 * 3 + i % 4]);
        ASSERT_NEAR(sum, plain.rgba[i], 1e-5 * std::max(1.0, double(plain.rgba[i]))) << i;
    }
}

TEST(LinkedCells, DoNotDependOnThreads) {
    const ViewScene scene = linkedSmoke(true);
    const auto one = render(scene, makePlan(scene, 1)).image.rgba;
    for (const int threads : {2, 3}) EXPECT_EQ(render(scene, makePlan(scene, threads)).image.rgba, one) << threads;
}

// A dome in which no volume casts shadows stays on cells, where it is not held back and needs no media; so does one
// that casts none itself.
TEST(LinkedCells, NeedNoMediaForLightsInWhichNothingCastsShadows) {
    ViewScene scene = linkedSmoke(false);
    link(scene, {0, 0, 0, 0});
    EXPECT_EQ(planCellLights(scene).lights, (std::vector<int>{0, 1, 2, 3}));
    EXPECT_EQ(planCellLights(scene).unfit, "");
    EXPECT_EQ(setsText(scene, planCellLights(scene)), "");
    EXPECT_LT(errorOf(scene, 40), 0.01);
    link(scene, {0, 4, 0, 0});
    EXPECT_EQ(setsText(scene, planCellLights(scene)),
              "; 2 sets of media, since some volumes cast shadows in some lights only");
    scene.lights[0].shadows = false;
    EXPECT_EQ(planCellLights(scene).lights, (std::vector<int>{0, 1, 2, 3}));
}

// What casts shadows in lights on cells alone needs no channels of shadow buffers.
TEST(LinkedCells, TakeNoChannelsOfShadowBuffers) {
    ViewScene scene = linkedSmoke(false);
    EXPECT_EQ(makePlan(scene, 1).extinction.count(), 1);
    EXPECT_FALSE(makePlan(scene, 1).extinction.coloured);
    scene.lights.push_back(distantLight({0, -1, 0}));
    link(scene, {1, 2, 6, 3, 5});
    EXPECT_EQ(makePlan(scene, 1).extinction.count(), 2);
}

TEST(LinkedCells, ThePlanSaysWhatTheyTake) {
    const auto reason = [](const ViewScene& scene) {
        for (const Effect& effect : effectsOf(scene, makePlan(scene, 1)))
            if (effect.name == "lights on cells") return effect.reason;
        return std::string();
    };
    ViewScene scene = linkedSmoke(false);
    EXPECT_NE(reason(scene).find("; 5 sets of media, since some volumes cast shadows in some lights only; about "),
              std::string::npos)
        << reason(scene);
    const CellLightPlan linked = planCellLights(scene);
    CellLightWork work;
    for (const double edge : {linked.edge(0)})
        lightOnCells(
            scene, linked.lights, edge, {}, [] {}, work);
    EXPECT_LT(double(work.bytes), 1.6 * double(linked.bytes));
    EXPECT_GT(double(work.bytes), 0.4 * double(linked.bytes));
    for (ViewVolume& volume : scene.volumes) volume.shadows.clear();
    EXPECT_EQ(reason(scene).find("media"), std::string::npos) << reason(scene);
    EXPECT_LT(planCellLights(scene).bytes, linked.bytes);
}

}  // namespace
}  // namespace scrim::test
