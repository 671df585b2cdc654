// SPDX-License-Identifier: Apache-2.0
// Lights on cells: closed forms in a uniform cube, and shadow buffers of the same lights in smoke.
#include "soft_lights.h"
#include "support/fields.h"
#include "support/meshes.h"
#include "support/slides.h"
#include "support/verified.h"

#include <scrim/base/parallel.h>
#include <scrim/engine/model/sub_lights.h>
#include <scrim/engine/plan/make_plan.h>
#include <scrim/engine/plan/transport_plan.h>
#include <scrim/engine/passes/light_cells.h>
#include <scrim/image/sky_parts.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace scrim::test {
namespace {

constexpr double kSphere = 4 * std::numbers::pi;
constexpr double kSigma = 0.1;  // per world unit, and per voxel
const Rgb kWarm(9, 5, 2);
constexpr double kHalf = 10;  // of the uniform cube's edge, world units

ViewScene uniformCube() {
    return orthographicScene(boxField(Int3(-10), Int3(9)), {kSigma, Rgb(1), {}}, 24, 24);
}

// The light on cells of one voxel at a point.
double lightAt(const ViewScene& scene, const Vec3& ws, double edge = 1) {
    CellLightWork work;
    std::vector<int> all(scene.lights.size());
    std::iota(all.begin(), all.end(), 0);
    const std::vector<CellLight> lights = lightOnCells(
        scene, all, edge, {}, [] {}, work);
    EXPECT_EQ(lights.size(), 1u);
    Real rgb[3];
    lights.front().ofVolume.front()->sample(ws, rgb);
    return double(rgb[1]);
}

// The way from `ws` back along `travel` to where it leaves the cube. Voxels are centred on whole numbers.
double wayInCube(const Vec3& ws, const Vec3& travel) {
    double way = 1e9;
    for (int axis = 0; axis < 3; ++axis) {
        const double face = (travel[axis] > 0 ? -kHalf : kHalf) - 0.5;
        if (travel[axis] != 0) way = std::min(way, (ws[axis] - face) / travel[axis]);
    }
    return way;
}

// Along all axes as the main one, both ways. At the centres of cells nothing is interpolated in a slice of uniform
// extinction; a ray that enters through the side of the cube may miss a part of a slice there.
TEST(LightOnCells, OfOneDirectionIsAttenuatedByBeerAndLambert) {
    for (const Vec3& way : {Vec3(0.2, -0.3, 1), Vec3(0.1, 1, 0.4), Vec3(-1, 0.2, 0.1), Vec3(0.3, 0.2, -1)}) {
        ViewScene scene = uniformCube();
        Light sun = distantLight(way, 3);
        sun.kind = Light::Distant(0.01);
        sun.samples = 1;
        scene.lights = {sun};
        const Vec3 travel = glm::normalize(way);
        for (const Vec3& ws : {Vec3(0), Vec3(3, -4, 5), Vec3(-5, 2, -1)}) {
            const double expected = 3 / kSphere * std::exp(-kSigma * wayInCube(ws, travel));
            EXPECT_NEAR(lightAt(scene, ws), expected, 0.01 * expected)
                << way.x << " " << way.y << " " << way.z << " at " << ws.x << " " << ws.y << " " << ws.z;
        }
    }
}

// Linear interpolation of e^(-s x) between values at a distance of 1 is s^2 / 12 too much in the mean, 2 % here along
// the ray alone; what is left is of fourth order, and across the ray a part of that term.
TEST(LightOnCells, IsRightInTheMeanBetweenTheCentresOfCells) {
    constexpr double kDense = 0.5;
    ViewScene scene = orthographicScene(boxField(Int3(-10), Int3(9)), {kDense, Rgb(1), {}}, 24, 24);
    for (const Vec3& way : {Vec3(0, 0, 1), Vec3(0.2, -0.3, 1), Vec3(0.5, 1, -0.4)}) {
        Light sun = distantLight(way, 3);
        sun.kind = Light::Distant(0.01);
        sun.samples = 1;
        scene.lights = {sun};
        double sum = 0, expected = 0;
        for (int i = 0; i < 64; ++i) {
            const Vec3 ws = (Vec3(i % 4, i / 4 % 4, i / 16) + 0.5) / 4.0 - Vec3(2, -1, 3);
            sum += lightAt(scene, ws);
            expected += 3 / kSphere * std::exp(-kDense * wayInCube(ws, glm::normalize(way)));
        }
        EXPECT_NEAR(sum, expected, 0.008 * expected) << way.x << " " << way.y << " " << way.z;
    }
}

// A layer of voxels is a tent of extinction: of rays along it, those beside its middle meet as much less. Light changes
// so little from ray to ray that it is straight between the centres of cells, to half a hundredth.
TEST(LightOnCells, OfHalfAVoxelHoldsTheInterpolatedField) {
    constexpr double kThin = 0.015, kLayers = 19.5;
    ViewScene scene = orthographicScene(boxField({0, -10, -10}, {0, 9, 9}), {kThin, Rgb(1), {}}, 24, 24);
    Light sun = distantLight({0, 0, 1}, 3);
    sun.kind = Light::Distant(0.01);
    sun.samples = 1;
    scene.lights = {sun};
    for (const double beside : {-0.75, -0.25, 0.0, 0.25, 0.5, 0.75}) {
        const double expected = 3 / kSphere * std::exp(-kThin * kLayers * (1 - std::abs(beside)));
        EXPECT_NEAR(lightAt(scene, {beside, 0, 9}, 0.5), expected, 0.015 * expected) << beside;
    }
}

// An area light far away has the irradiance L A cos / r^2.
TEST(LightOnCells, OfASmallSurfaceFallsOffWithItsDistanceAndItsExtinction) {
    for (const Vec3& from : {Vec3(0, 0, 40), Vec3(30, 20, 0), Vec3(-5, -50, 8)}) {
        ViewScene scene = uniformCube();
        Light box;
        Light::Area area;
        area.width = area.height = 0.5;
        box.kind = area;
        box.wsPosition = from;
        box.wsDirection = glm::normalize(-from);
        box.intensity = Rgb(100);
        box.samples = 1;
        scene.lights = {box};
        for (const Vec3& ws : {Vec3(0), Vec3(3, -4, 5)}) {
            const Vec3 travel = glm::normalize(ws - from);
            const double expected = 100 * 0.25 * glm::dot(travel, box.wsDirection) / glm::dot(ws - from, ws - from) /
                                    kSphere * std::exp(-kSigma * wayInCube(ws, travel));
            EXPECT_NEAR(lightAt(scene, ws), expected, 0.015 * expected) << from.x << " at " << ws.x;
        }
    }
}

// Ten at one place share cells: within 6 voxels they have their own, too.
TEST(LightOnCells, OfALampInTheCubeIsItsTransmittanceOverTheSquareOfTheDistance) {
    ViewScene scene = uniformCube();
    for (const std::size_t count : {std::size_t(1), std::size_t(10)})
        for (const Vec3& ws :
             {Vec3(2, 0, 0), Vec3(-3, 1, 2), Vec3(0, -6, 1), Vec3(1, 1, 8), Vec3(-4, -4, -4), Vec3(-7, 8, 6)}) {
            scene.lights.assign(count, lamp({0.3, -0.2, 0.4}, 7 / double(count)));
            EXPECT_EQ(lampsShareCells(scene), count > 1);
            const double r = glm::distance(ws, scene.lights[0].wsPosition);
            const double expected = 7 / kSphere * std::exp(-kSigma * r) / (r * r);
            EXPECT_NEAR(lightAt(scene, ws, 0.5), expected, 0.01 * expected) << ws.x << " " << ws.y << " " << ws.z;
        }
}

ViewScene smokeScene(const Phase& phase = {}) {
    ViewScene scene = orthographicScene(smokeField(16), {0.15, Rgb(0.9), phase}, 36, 36);
    scene.dials.texel = 0.5;
    scene.dials.sheetThickness = 1;
    return scene;
}
ViewScene perspectiveSmoke(const Phase& phase) {
    ViewScene scene = smokeScene(phase);
    scene.camera.type = CameraType::perspective;
    scene.camera.wsPosition = {10, 15, 60};
    scene.camera.wsFromCamera = lookAt(scene.camera.wsPosition, Vec3(0), {0, 1, 0});
    scene.camera.fov = 36;
    return scene;
}

// Relative RMSE of the colours of `scene` on cells against the same lights' shadow buffers.
double errorOnCells(ViewScene scene) {
    for (Light& light : scene.lights) light.shadow = ShadowMethod::cells;
    EXPECT_EQ(makePlan(scene, 1).cellLights.lights.size(), scene.lights.size());
    const Image cells = renderScene(scene).image;
    for (Light& light : scene.lights) light.shadow = ShadowMethod::buffers;
    EXPECT_TRUE(makePlan(scene, 1).cellLights.lights.empty());
    const Image buffers = renderScene(scene).image;
    double squares = 0, all = 0;
    for (std::size_t i = 0; i < cells.rgba.size(); ++i) {
        if (i % 4 == 3) {
            EXPECT_NEAR(cells.rgba[i], buffers.rgba[i], 0.01);  // the axes of their sheets differ
            continue;
        }
        squares += std::pow(double(cells.rgba[i]) - double(buffers.rgba[i]), 2);
        all += std::pow(double(buffers.rgba[i]), 2);
    }
    EXPECT_GT(all, 0);
    return std::sqrt(squares / all);
}

// The two ways share nothing but the sub-lights. Each has an error of its own below the percent of `standard`.
constexpr double kTwoWays = 0.015;

TEST(LightOnCells, GivesThePictureOfShadowBuffers) {
    const Phase forward{0.6}, backward{-0.4};
    Phase two{0.7, PhaseType::twoLobe, -0.3, 0.4}, rayleigh{0, PhaseType::rayleigh};
    int number = 0;
    for (const Phase& phase : {Phase(), forward, backward, two, rayleigh, drainePhase(0.4, 6)})
        for (const bool perspective : {false, true}) {
            ViewScene scene = perspective ? perspectiveSmoke(phase) : smokeScene(phase);
            const int kind = number++ % 3;
            scene.lights = {kind == 0   ? domeLight(24)
                            : kind == 1 ? areaLight(AreaShape::rectangle, {25, 18, 12}, 6, 9, kWarm)
                                        : areaLight(AreaShape::disk, {-20, 5, -22}, 5, 9, kWarm)};
            EXPECT_LT(errorOnCells(scene), kTwoWays) << number << " kind " << kind;
        }
}

TEST(LightOnCells, GivesThePictureOfShadowBuffersForColouredExtinction) {
    ViewScene scene = smokeScene({0.3});
    scene.volumes[0].medium.extinctionTint = {1, 0.6, 0.3};
    scene.lights = {areaLight(AreaShape::rectangle, {25, 18, 12}, 6, 9, kWarm)};
    EXPECT_LT(errorOnCells(scene), kTwoWays);
}

TEST(LightOnCells, IsNearerToBruteForceThanWindowsForALampInSmoke) {
    ViewScene scene = smokeScene();
    scene.lights = {lamp({3.3, -2.2, 1.7}, 50)};
    scene.lights[0].shadow = ShadowMethod::cells;
    const double cells = errorOf(scene, 300);
    scene.lights[0].shadow = ShadowMethod::buffers;
    EXPECT_LT(cells, errorOf(scene, 300));
    EXPECT_LT(cells, 0.03);
}

// What turned or stretched voxels hold is not in boxes along the cells: put there, it was 8.4, 1.5 and 4.2 % off.
TEST(LightOnCells, OfTurnedAndStretchedVolumesIsNearBruteForce) {
    ViewScene scene = orthographicScene(
        makeField(Int3(-8), Int3(8), 1, [](const Vec3& is) { return std::max(1 - glm::length(is) / 8, 0.0); }),
        {1.6, Rgb(0.8), {}}, 20, 32);
    scene.lights = {lamp({-4, 3, 3}, 50)};
    scene.lights.front().shadow = ShadowMethod::cells;
    scene.dials.texel = scene.dials.sheetThickness = 0.3;
    scene.dials.lightCell = 0.25;
    const Mat4 straight = scene.volumes[0].wsFromIs, turned = glm::rotate(straight, 0.6, Vec3(1, 0.7, 0.4));
    const auto errorAs = [&](const Mat4& wsFromIs) {
        scene.volumes[0].wsFromIs = wsFromIs;
        return errorOf(scene, 60);
    };
    EXPECT_LT(errorAs(turned), 0.01);
    EXPECT_LT(errorAs(glm::scale(turned, Vec3(0.5, 1, 0.7))), 0.008);
    EXPECT_LT(errorAs(glm::scale(straight, Vec3(0.5, 1, 0.5))), 0.018);
}

// Without shadows, a lamp in a cube so thin that the eye sees through it sends I / r^2 everywhere, whatever the cube
// would hold back; a wall does not stop it either.
TEST(LightOnCells, OfALampWithoutShadowsIsNotAttenuated) {
    ViewScene scene = uniformCube();
    scene.lights = {lamp({1.3, -2.2, 0.7}, 50)};
    scene.lights[0].shadows = false;
    scene.solids = oneSolid(squareMesh({3, -2, 1}, {1, 0, 0}, 8), false);
    EXPECT_EQ(planCellLights(scene).lights.size(), 1u);
    for (const Vec3& ws : {Vec3(0), Vec3(6, -4, 5), Vec3(-5, 2, -1)}) {
        const Vec3 way = ws - scene.lights[0].wsPosition;
        const double expected = 50 / (kSphere * glm::dot(way, way));
        EXPECT_NEAR(lightAt(scene, ws), expected, 1e-4 * expected) << ws.x << " " << ws.y << " " << ws.z;
    }
}

// Dense voxels fade light within a sheet as an exponential: with sheets of 1.3 optical depths, halves of them that
// count apart leave less than a third of the error that one place in the middle has.
TEST(LightOnCells, InThickSheetsIsNearlyThatInThinOnes) {
    ViewScene scene = smokeScene();
    scene.volumes[0].medium.densityScale = 1;
    scene.lights = {areaLight(AreaShape::rectangle, {25, 18, 12}, 6, 9, kWarm)};
    scene.lights[0].shadow = ShadowMethod::cells;
    scene.dials.lightCell = 0.5;
    const auto pictureOf = [&](double thickness) {
        scene.dials.sheetThickness = thickness;
        return renderScene(scene).image.rgba;
    };
    const std::vector<float> thin = pictureOf(0.15), thick = pictureOf(0.8);
    double squares = 0, all = 0;
    for (std::size_t i = 0; i < thin.size(); ++i) {
        if (i % 4 == 3) continue;
        squares += std::pow(double(thick[i]) - double(thin[i]), 2);
        all += std::pow(double(thin[i]), 2);
    }
    std::printf("thick %.5f\n", std::sqrt(squares / all));
    EXPECT_LT(std::sqrt(squares / all), 0.02);
}

// The light of a sphere of radiance 7 at a distance r of its centre: in a uniform medium the integral over the cone
// that it fills.
double lightOfSphere(double radius, double r, double sigma) {
    const double least = std::sqrt(1 - std::pow(radius / r, 2));
    double sum = 0;
    constexpr int kSteps = 2000;
    for (int i = 0; i < kSteps; ++i) {
        const double mu = least + (1 - least) * (i + 0.5) / kSteps;
        sum += std::exp(-sigma * (r * mu - std::sqrt(std::pow(r * mu, 2) - r * r + radius * radius)));
    }
    return 7 / kSphere * 2 * std::numbers::pi * (1 - least) / kSteps * sum;
}

// At the surface light comes from all of a half-space. Where voxels are dense, cells that know it from a few points
// within the sphere are off by up to a third there.
TEST(LightOnCells, OfASphereInADenseCubeIsRightAtItsSurface) {
    constexpr double kDense = 1;
    ViewScene scene = orthographicScene(boxField(Int3(-10), Int3(9)), {kDense, Rgb(1), {}}, 24, 24);
    scene.lights = {areaLight(AreaShape::sphere, {0.3, -0.2, 0.4}, 2, 0, kWarm)};
    scene.lights[0].intensity = Rgb(7);
    for (const double edge : {0.5, 1.0})
        for (const double beyond : {0.05, 0.25, 0.5, 1.0, 1.5})
            for (const Vec3& way : {Vec3(1, 0, 0), Vec3(0, -0.6, 0.8), Vec3(-0.48, 0.64, 0.6)}) {
                const Vec3 ws = scene.lights[0].wsPosition + (2 + beyond) * way;
                const double expected = lightOfSphere(2, 2 + beyond, kDense);
                EXPECT_NEAR(lightAt(scene, ws, edge), expected, 0.03 * expected)
                    << beyond << " beyond, cells of " << edge << ", way " << way.x << " " << way.y;
            }
}

// A sphere counts as a lamp. Cells that spheres share interpolate what 12 points know to about 1 %; in the middle
// between them they are the mean of eight.
TEST(LightOnCells, OfASphereInTheCubeIsTheIntegralOverItsSolidAngle) {
    ViewScene scene = uniformCube();
    for (const double radius : {0.3, 0.8, 2.0}) {
        scene.lights.assign(5, areaLight(AreaShape::sphere, {0.3, -0.2, 0.4}, radius, 0, kWarm));
        for (Light& light : scene.lights) light.intensity = Rgb(1.4);
        const ViewScene alone = [&] {
            ViewScene one = scene;
            one.lights.resize(1);
            one.lights[0].intensity = Rgb(7);
            return one;
        }();
        ASSERT_TRUE(lampsShareCells(scene));
        for (const Vec3& cell : {Vec3(2.5, 0, 0), Vec3(-3, 1, 2), Vec3(0, -6, 1), Vec3(1, 1, 8), Vec3(-4, -4, -4)}) {
            const Vec3 ws = cell + 0.25;
            const double r = glm::distance(ws, scene.lights[0].wsPosition);
            const double expected = lightOfSphere(radius, r, kSigma);
            EXPECT_NEAR(lightAt(alone, ws, 0.5), expected, 0.003 * expected) << radius << " at " << r;
            EXPECT_NEAR(lightAt(scene, ws, 0.5), expected, 0.015 * expected) << radius << " at " << r << ", shared";
        }
    }
}

// Its points are few, the reference adds up many elements of its surface. Where the sphere is seen in the smoke, pixels
// at its rim, 10 times as bright as the mean, are 4 % off.
TEST(LightOnCells, OfASphereIsThatOfItsManyPoints) {
    const struct {
        Vec3 from;
        double radius, g, most;
    } kCases[] = {{{17, 6, 5}, 3, 0, 0.015},
                  {{20, 10, 7}, 7, 0.6, 0.015},
                  {{17, 6, 5}, 2, 0.6, 0.015},
                  {{3.3, -2.2, 1.7}, 0.4, 0.6, 0.02},
                  {{3.3, -2.2, 1.7}, 3, 0.6, 0.13}};
    for (const auto& c : kCases) {
        ViewScene scene = perspectiveSmoke({c.g});
        scene.lights = {areaLight(AreaShape::sphere, c.from, c.radius, 0, kWarm)};
        EXPECT_EQ(pointsOnCells(scene, scene.lights[0]), c.radius > 6 ? 26 : 12);
        const Image image = renderScene(scene).image;
        scene.lights[0].samples = 400;
        EXPECT_LT(summarise(samplePixels(scene, image, 60, 7)).error, c.most)
            << "radius " << c.radius << ", g " << c.g << ", at " << c.from.x;
    }
}

// Layers keep each lamp alone, with the mean extinction from it; the picture has all of them on the same cells, but for
// the light near each. The fields share only the passes. Cells of half a voxel, so that most of the smoke is far.
TEST(LightOnCells, OfLampsTogetherIsTheSumOfTheirLayers) {
    ViewScene scene = perspectiveSmoke({0.4});
    scene.dials.lightCell = 0.5;
    ViewVolume beside = scene.volumes[0];
    beside.name = "beside";
    beside.wsFromIs[3] = {9, 4, -6, 1};
    beside.medium.phase = {-0.2};
    beside.lights = {true, false, true, true, true};
    scene.volumes.push_back(beside);
    for (const bool coloured : {false, true}) {
        scene.volumes[0].medium.extinctionTint = coloured ? Rgb(1, 0.6, 0.4) : Rgb(1);
        scene.lights = {lamp({-9, 2, 4}, 30), lamp({7, -6, -3}, 20), lamp({2, 12, 9}, 10),
                        areaLight(AreaShape::sphere, {3, 3, 14}, 0.8, 0, kWarm), lamp({-3, -12, 1}, 15)};
        scene.lights[1].intensity = coloured ? Rgb(5, 20, 9) : Rgb(20);
        if (!coloured) scene.lights[3].intensity = Rgb(4);
        scene.layers = {};
        ASSERT_TRUE(lampsShareCells(scene));
        const Image together = renderScene(scene).image;
        scene.layers = {Layer::light};
        ASSERT_FALSE(lampsShareCells(scene));
        const Frame apart = renderScene(scene);
        ASSERT_EQ(apart.layers.size(), scene.lights.size());
        double squares = 0, all = 0;
        for (std::size_t i = 0; i < together.rgba.size(); ++i) {
            if (i % 4 == 3) continue;
            double sum = 0;
            for (const auto& layer : apart.layers) sum += double(layer.data[i / 4 * 3 + i % 4]);
            squares += std::pow(double(together.rgba[i]) - sum, 2);
            all += sum * sum;
        }
        EXPECT_GT(all, 0);
        EXPECT_LT(std::sqrt(squares / all), 0.005) << "coloured " << coloured;
    }
}

TEST(LightOnCells, BelongsToItsLayerAndToTheVolumesThatItLights) {
    ViewScene scene = smokeScene({0.2});
    ViewVolume beside = scene.volumes[0];
    beside.name = "beside";
    beside.wsFromIs[3] = {9, 4, -6, 1};
    beside.medium.phase = {-0.2};
    scene.volumes.push_back(beside);
    scene.lights = {domeLight(16), areaLight(AreaShape::rectangle, {25, 18, 12}, 6, 9, kWarm)};
    scene.volumes[0].lights = {true, false};
    scene.volumes[1].lights = {true, true};
    EXPECT_LT(errorOnCells(scene), kTwoWays);
    scene.layers = {Layer::light};
    const Frame frame = renderScene(scene);
    ASSERT_EQ(frame.layers.size(), 2u);
    for (std::size_t i = 0; i < frame.image.rgba.size(); ++i)
        if (i % 4 != 3) {
            const std::size_t at = i / 4 * 3 + i % 4;
            EXPECT_NEAR(double(frame.layers[0].data[at]) + double(frame.layers[1].data[at]), frame.image.rgba[i],
                        1e-5 * std::max(1.0, double(frame.image.rgba[i])));
        }
}

TEST(LightOnCells, GivesThePictureOfShadowBuffersForSurfacesOfAllKinds) {
    ViewScene scene = perspectiveSmoke({0.4});
    Light narrow = areaLight(AreaShape::rectangle, {25, 18, 12}, 6, 9, kWarm);
    std::get<Light::Area>(narrow.kind).spread = 60;
    const Light wide = areaLight(AreaShape::sphere, {-35, 20, 30}, 10, 24, kWarm);  // too wide to be a lamp
    ASSERT_FALSE(isLampOnCells(scene, wide));
    for (const Light& light : {narrow, areaLight(AreaShape::cylinder, {-20, 12, 10}, 4, 24, kWarm), wide}) {
        scene.lights = {light};
        EXPECT_LT(errorOnCells(scene), kTwoWays);
        scene.lights[0].samples = 0;
        EXPECT_LT(errorOf(scene, 80), 0.02);  // the reference knows no points
    }
}

// A picture of a sky is a sum of directions with colours of their own.
TEST(LightOnCells, GivesThePictureOfShadowBuffersForAPicture) {
    ViewScene scene = smokeScene();
    Light sky = domeLight(32);
    sky.slide.emplace();
    sky.slide->image = makeTexture(16, 8, [](int x, int y) { return Rgb(0.1 + x, 2 + y, 16 - x); });
    scene.lights = {sky};
    EXPECT_LT(errorOnCells(scene), kTwoWays);
}

// A floor and a block in the smoke: hidden surfaces, dark sides, and shadows that cross the smoke.
ViewScene smokeWithSolids(bool holdout) {
    ViewScene scene = perspectiveSmoke({0.3});
    std::vector<Solid> solids;
    const auto add = [&](std::shared_ptr<const TriangleMesh> mesh) {
        solids.push_back(oneSolid(std::move(mesh), holdout)->all().front());
    };
    add(ballMesh({-1, 2, -1}, 4, 48));
    add(squareMesh({0, -9, 0}, {0, 1, 0}, 40));
    scene.solids = std::make_shared<const Solids>(std::move(solids));
    return scene;
}

// Shadow buffers of the same sub-lights cut the shadows of solids along the eye's rays; cells are as wide as voxels,
// and leave up to twice the error.
TEST(LightOnCells, AreBlockedBySolids) {
    for (const bool holdout : {false, true}) {
        ViewScene scene = smokeWithSolids(holdout);
        scene.lights = {holdout ? domeLight(30) : areaLight(AreaShape::rectangle, {25, 18, 12}, 6, 12, kWarm)};
        scene.lights[0].shadow = ShadowMethod::cells;
        PixelSample sample = samplePixels(scene, renderScene(scene).image, 80, 7);
        const double cells = summarise(sample).error;
        scene.lights[0].shadow = ShadowMethod::buffers;
        setRendered(sample.pixels, renderScene(scene).image);
        EXPECT_LT(cells, 2 * summarise(sample).error + 0.003) << "holdout " << holdout;
        EXPECT_LT(cells, 0.08);
        scene.solids.reset();
        setRendered(sample.pixels, renderScene(scene).image);
        EXPECT_GT(summarise(sample).error, 3 * cells) << "solids hold little light back";
    }
}

TEST(LightOnCells, OfLampsAreBlockedBySolids) {
    for (const bool holdout : {false, true}) {
        ViewScene scene = smokeWithSolids(holdout);
        scene.lights = {holdout ? areaLight(AreaShape::sphere, {9, 7, 8}, 1, 0, kWarm) : lamp({5, 3, 4}, 50)};
        const Image image = renderScene(scene).image;
        EXPECT_EQ(planCellLights(scene).lights.size(), 1u);
        scene.lights[0].samples = 200;
        const PixelSample sample = samplePixels(scene, image, 80, 7);
        EXPECT_LT(summarise(sample).error, holdout ? 0.05 : 0.03) << "holdout " << holdout;
    }
}

// A picture of a sky that is brighter above, and in it, if asked for, a sun of 0.53 degrees with as much light.
constexpr double kSunU = 0.31, kSunV = 0.28, kSunAngle = 0.53, kSunLight = 4 * std::numbers::pi;
Light skyLight(bool sun) {
    Light sky = domeLight(0);
    constexpr int kWidth = 2048, kHeight = 1024;
    const Vec3 to = domeDirection(sky, kSunU, kSunV);
    const double cosine = std::cos(kSunAngle * std::numbers::pi / 360);
    const double radiance = sun ? kSunLight / (2 * std::numbers::pi * (1 - cosine)) : 0;
    sky.slide.emplace();
    sky.slide->image = makeTexture(kWidth, kHeight, [&](int x, int y) {
        double part = 0;
        for (int k = 0; sun && k < 16; ++k)
            if (glm::dot(domeDirection(sky, (x + (k % 4 + 0.5) / 4) / kWidth, (y + (k / 4 + 0.5) / 4) / kHeight), to) >
                cosine)
                part += 1.0 / 16;
        return Rgb(1 + 0.5 * std::cos(std::numbers::pi * (y + 0.5) / kHeight)) + part * radiance * Rgb(1, 0.9, 0.7);
    });
    sky.slide->parts = std::make_shared<const SkyParts>(skyParts(*sky.slide->image));
    return sky;
}
// Relative RMSE of colours.
double difference(const Image& a, const Image& b) {
    double squares = 0, all = 0;
    for (std::size_t i = 0; i < a.rgba.size(); ++i)
        if (i % 4 != 3) {
            squares += std::pow(double(a.rgba[i]) - double(b.rgba[i]), 2);
            all += std::pow(double(b.rgba[i]), 2);
        }
    return std::sqrt(squares / all);
}

TEST(SkyWithASun, LightsAsThatSunAndTheRestDo) {
    for (const Scattering scattering : {Scattering::single, Scattering::full}) {
        ViewScene scene = perspectiveSmoke({0.5});
        scene.volumes[0].medium.scattering = scattering;
        scene.lights = {skyLight(true)};
        const Frame one = renderScene(scene);
        ViewScene two = scene;
        Light sun = distantLight(-domeDirection(scene.lights[0], kSunU, kSunV));
        sun.name = "sun";
        sun.kind = Light::Distant(kSunAngle);
        sun.intensity = kSunLight * Rgb(1, 0.9, 0.7);
        two.lights = {skyLight(false), sun};
        EXPECT_LT(difference(one.image, renderScene(two).image), 0.005);
        two.lights.pop_back();
        EXPECT_GT(difference(one.image, renderScene(two).image), 0.2) << "the sun gives no light";
        scene.layers = {Layer::light};
        const Frame layered = renderScene(scene);
        ASSERT_EQ(layered.layers.size(), 1u);
        EXPECT_LT(difference(layered.image, one.image), 1e-5);
    }
}

TEST(SkyWithASun, AgreesWithTheReferenceOfItsPicture) {
    ViewScene scene = perspectiveSmoke({0.5});
    scene.lights = {skyLight(true)};
    EXPECT_LT(errorOf(scene, 80), 0.01);
}

// A sky that is ten times as bright behind the smoke as 25 degrees beside it.
Light skyBehind(const Camera& camera) {
    Light sky = domeLight(0);
    const Vec3 behind = glm::normalize(viewingAxis(camera) + Vec3(0, 0.15, 0));
    sky.slide.emplace();
    sky.slide->image = makeTexture(256, 128, [&](int x, int y) {
        const double cosine = glm::dot(domeDirection(sky, (x + 0.5) / 256, (y + 0.5) / 128), behind);
        return Rgb(std::pow(10, -glm::degrees(std::acos(std::clamp(cosine, -1.0, 1.0))) / 25));
    });
    sky.slide->parts = std::make_shared<const SkyParts>(skyParts(*sky.slide->image));
    return sky;
}

// Lobes show it as it is. Directions with caps as wide as if they were even left 2.1 %.
TEST(LightOnCells, OfASkyThatIsBrightBehindTheSmokeIsNearBruteForceInALobe) {
    ViewScene scene = perspectiveSmoke({0.8});
    scene.lights = {skyBehind(scene.camera)};
    EXPECT_LT(errorOf(scene, 16), 0.01);
}

TEST(LightOnCells, DoesNotDependOnThreads) {
    ViewScene scene = perspectiveSmoke({0.5});
    scene.lights = {domeLight(40), areaLight(AreaShape::sphere, {5, 3, 2}, 2, 12, kWarm), lamp({-3, 2, 1}, 20)};
    const auto render1 = [&](int threads) { return render(scene, makePlan(scene, threads)).image.rgba; };
    const auto one = render1(1);
    for (const int threads : {2, 3, 8}) EXPECT_EQ(render1(threads), one) << threads;
}

TEST(LightOnCells, OfACropIsThatOfThePicture) {
    ViewScene scene = smokeScene();
    scene.lights = {domeLight(16)};
    scene.picture = scene.region;
    const Frame whole = renderScene(scene);
    scene.region = {9, 11, 27, 30};
    EXPECT_EQ(renderScene(scene).image.rgba, reframed(whole.image, scene.region).rgba);
}

// Lamps have fields of their own, and two each where solids block them.
TEST(LightOnCells, TakesAboutTheMemoryThatThePlanSays) {
    for (const int lamps : {1, 12})
        for (const bool solids : {false, true}) {
            ViewScene scene = solids ? smokeWithSolids(true) : smokeScene();
            for (int i = 0; i < lamps; ++i) scene.lights.push_back(lamp({0.5 * i - 3, 1, 2}, 1));
            const CellLightPlan plan = planCellLights(scene);
            ASSERT_EQ(plan.lights.size(), std::size_t(lamps));
            CellLightWork work;
            lightOnCells(
                scene, plan.lights, plan.edge(0), {}, [] {}, work);
            EXPECT_LT(double(work.bytes), 1.6 * double(plan.bytes)) << lamps << " lamps, solids " << solids;
            EXPECT_GT(double(work.bytes), 0.4 * double(plan.bytes)) << lamps << " lamps, solids " << solids;
        }
}

TEST(LightOnCells, IsChosenForWhatShinesFromManyPlacesOrFromWithin) {
    ViewScene scene = smokeScene();
    Light sun = distantLight({0, -1, 0});
    sun.kind = Light::Distant(2);
    scene.lights = {domeLight(0), sun, lamp({1, 1, 1}, 1), lamp({100, 0, 0}, 1),
                    areaLight(AreaShape::rectangle, {25, 18, 12}, 6, 0, kWarm)};
    scene.lights.push_back(scene.lights[0]);
    scene.lights.back().shadow = ShadowMethod::buffers;
    EXPECT_EQ(planCellLights(scene).lights, (std::vector<int>{0, 2, 4}));
    scene.volumes[0].medium.scattering = Scattering::octaves;
    scene.volumes[0].medium.octaves.count = 3;
    EXPECT_EQ(planCellLights(scene).lights, (std::vector<int>{0, 2, 4}));
}

// Dense voxels cast shadows with edges of a voxel, which cells blur; a thin medium has none.
// What is empty between two cubes does not make cells larger, unless there is very much of it.
TEST(LightOnCells, HaveTheSizeThatPartsFarApartAskFor) {
    ViewScene scene = uniformCube();
    scene.lights = {domeLight(24)};
    const auto edge = [&] { return planCellLights(scene).levels.at(0).smallest(); };
    const double alone = edge();
    scene.volumes.push_back(scene.volumes.front());
    scene.volumes.back().place = 1;
    for (const double apart : {30.0, 100.0, 200.0}) {
        scene.volumes.back().wsFromIs = scene.volumes.front().wsFromIs;
        scene.volumes.back().wsFromIs[3].x += apart;
        EXPECT_LE(edge(), 2 * alone) << apart;
        EXPECT_NEAR(wsOccupiedSize(scene).x, apart == 30 ? 63 : 66, 1) << apart;  // blocks
    }
    scene.volumes.back().wsFromIs[3].x += 1e4;
    EXPECT_EQ(planCellLights(scene).levels.size(), 2U);
    EXPECT_EQ(edge(), alone);
    scene.lights.push_back(areaLight(AreaShape::disk, {60, 40, 30}, 3, 64, kWarm));
    EXPECT_EQ(planCellLights(scene).levels.size(), 1U);
    EXPECT_GE(edge(), 0.69 * 4);  // 0.7 for area lights; passes must cross what is empty, too
}

TEST(LightOnCells, AreLeftToShadowBuffersWhereAFewPointsLightOpaqueVoxels) {
    ViewScene scene = uniformCube();
    scene.lights = {areaLight(AreaShape::disk, {60, 40, 30}, 3, 0, kWarm)};
    const int points = subLightCount(scene, scene.lights[0]);
    ASSERT_GE(points, 4);
    ASSERT_LT(points, 16);
    const auto onCells = [&](double depth) {
        scene.volumes[0].medium.densityScale = depth / double(scene.volumes[0].field->maxValue);
        return !planCellLights(scene).lights.empty();
    };
    EXPECT_TRUE(onCells(0.25));
    EXPECT_FALSE(onCells(0.35));  // of a small picture, for which buffers cost less
    scene.camera.resolution = {640, 640};
    EXPECT_TRUE(onCells(2.9));
    EXPECT_FALSE(onCells(3.1));
    scene.lights[0] = areaLight(AreaShape::disk, {60, 40, 30}, 30, 0, kWarm);
    ASSERT_GE(subLightCount(scene, scene.lights[0]), 16);
    ASSERT_LT(subLightCount(scene, scene.lights[0]), 64);
    EXPECT_TRUE(onCells(2.9));
    EXPECT_FALSE(onCells(3.1));
    scene.lights[0].wsPosition = {2, 1, 0};  // among the voxels buffers would take windows of directions
    EXPECT_TRUE(onCells(3.1));
}

}  // namespace
}  // namespace scrim::test
