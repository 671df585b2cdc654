// SPDX-License-Identifier: Apache-2.0
// Scattered light on cells of several sizes, one domain inside of another.
#include "scenes.h"
#include "support/fields.h"
#include "support/meshes.h"

#include <scrim/engine/cells/cell_levels.h>
#include <scrim/engine/model/sub_lights.h>
#include <scrim/engine/plan/effects.h>
#include <scrim/engine/plan/make_plan.h>
#include <scrim/engine/plan/transport_plan.h>
#include <scrim/engine/solve/scatter_domains.h>
#include <scrim/engine/solve/scattered_light.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <glm/ext/matrix_transform.hpp>

namespace scrim::test {
namespace {

struct Cube {
    double sigma, voxel;
    int half;  // voxels
    Vec3 center;
};
// Each inside of the one before, and beside its middle.
const std::vector<Cube> kNested = {
    {0.02, 8, 5, Vec3(0)}, {0.15, 0.8, 10, {9, 3, -6}}, {1.5, 0.08, 10, {11.3, 4.2, -5.1}}};

ViewScene cubes(const std::vector<Cube>& all, double albedo, double g) {
    ViewScene scene = orthographicScene(boxField(Int3(-5), Int3(4)), {1, Rgb(albedo), {}}, 90, 24);
    const ViewVolume first = scene.volumes.front();
    scene.volumes.assign(all.size(), first);
    for (std::size_t v = 0; v < all.size(); ++v) {
        ViewVolume& volume = scene.volumes[v];
        volume.field = boxField(Int3(-all[v].half), Int3(all[v].half - 1));
        volume.wsFromIs = glm::translate(Mat4(1.0), all[v].center) * Mat4(Mat3(all[v].voxel));
        volume.medium.densityScale = all[v].sigma;
        volume.medium.phase.g = g;
        volume.medium.scattering = Scattering::full;
        volume.name = "cube " + std::to_string(v);
    }
    return scene;
}

struct Solution {
    std::vector<CellLight> lights;
    Solved solved;
};
Solution solve(const ViewScene& scene, const TransportPlan& plan) {
    Solution out;
    std::size_t bytes = 0;
    out.lights = scatteredLight(
        scene, plan, {}, [] {}, out.solved, bytes);
    return out;
}
// What an eye sees at a place in a volume, per unit of scattering coefficient.
double seenAt(const Solution& solution, std::size_t volume, const Vec3& ws) {
    double sum = 0;
    for (const CellLight& light : solution.lights) {
        Real rgb[3];
        light.ofVolume[volume]->sample(ws, rgb);
        sum += double(rgb[1]);
    }
    return sum;
}
// A place in a volume, from -1 to 1 along its edges.
Vec3 placeIn(const Cube& cube, const Vec3& at) {
    return cube.center + cube.voxel * (double(cube.half) * at - 0.5);
}
const Vec3 kPlaces[] = {{0, 0, 0}, {0.8, 0.1, -0.3}, {-0.7, 0.6, 0.7}, {0.1, -0.85, 0.4}, {-0.4, 0.3, -0.9}};

// Smoke that absorbs nothing, under a sky of the same radiance all round, cannot be told from its sky.
TEST(ScatterDomains, UniformLightStaysUniformThroughAllBorders) {
    for (const double g : {0.0, 0.6}) {
        ViewScene scene = cubes(kNested, 1, g);
        scene.ambient = Rgb(1);
        scene.dials.scatterError = 2e-4;
        const TransportPlan plan = planTransport(scene);
        ASSERT_EQ(plan.domains.size(), 3u);
        const Solution solution = solve(scene, plan);
        for (std::size_t v = 0; v < kNested.size(); ++v)
            for (const Vec3& at : kPlaces)
                EXPECT_NEAR(seenAt(solution, v, placeIn(kNested[v], at)), 1, 0.002) << "cube " << v << ", g = " << g;
    }
}

// The light of a sun, of a lamp beside all and of glowing smoke, beside one solve on the smallest cells.
TEST(ScatterDomains, AgreeWithOneSolveOnTheSmallestCells) {
    const std::vector<Cube> two = {{0.02, 4, 8, Vec3(0)}, {0.15, 0.8, 10, {9, 3, -6}}};
    for (const std::string kind : {"sun", "lamp", "glow", "once"}) {
        ViewScene scene = cubes(two, 0.95, kind == "sun" ? 0.5 : 0);
        if (kind == "sun" || kind == "once") scene.lights = {distantLight({-0.5, -1, 0.3})};
        if (kind == "once") scene.volumes[1].medium.scattering = Scattering::single;
        if (kind == "lamp") scene.lights = {lamp({70, 30, -20}, 1e4)};
        if (kind == "glow")
            scene.volumes[1].emission.push_back({{scene.volumes[1].field, scene.volumes[1].wsFromIs}, Rgb(0.1)});
        scene.dials.scatterCell = 1;
        TransportPlan plan = planTransport(scene);
        ASSERT_EQ(plan.domains.size(), 2u);
        const Solution nested = solve(scene, plan);
        plan.domains = wholeScene(scene, 1);
        const Solution whole = solve(scene, plan);
        for (std::size_t v = 0; v < two.size(); ++v) {
            double off = 0, all = 0;
            for (const Vec3& at : kPlaces) {
                const double truth = seenAt(whole, v, placeIn(two[v], at));
                off += std::abs(seenAt(nested, v, placeIn(two[v], at)) - truth);
                all += truth;
            }
            // Large cells hold the mean of what is in them, and those beside the small cube also see its glow.
            EXPECT_LT(off / all, v == 1 ? 0.02 : kind == "glow" ? 0.1 : 0.04) << kind << ", cube " << v;
        }
    }
}

// A mesh that stops light leaves one domain with the smallest cells, which may take many times as long: the plan tells.
TEST(ScatterDomains, AreOneBesideSolidsAndThePlanSaysSo) {
    const std::vector<Cube> two = {{0.02, 4, 8, Vec3(0)}, {0.15, 0.8, 10, {9, 3, -6}}};
    const auto reasonOf = [](const ViewScene& scene) {
        for (const Effect& effect : effectsOf(scene, makePlan(scene, 1)))
            if (effect.name == "multiple scattering") return effect.reason;
        return std::string();
    };
    const std::string lost = "2 parts of space would have their own without them";
    ViewScene scene = cubes(two, 0.95, 0);
    scene.lights = {distantLight({-0.5, -1, 0.3})};
    EXPECT_EQ(reasonOf(scene).find(lost), std::string::npos);
    scene.solids = oneSolid(squareMesh({-20, 0, 0}, {0, 0, 1}, 1));
    EXPECT_EQ(planTransport(scene).domains.size(), 1u);
    EXPECT_NE(reasonOf(scene).find(lost), std::string::npos);
    scene.volumes.resize(1);
    EXPECT_EQ(reasonOf(scene).find("parts of space"), std::string::npos);
}

// What is in a domain is not around it as well: a thick cube inside of cells as large as itself is not in its own
// light.
TEST(ScatterDomains, DoNotShadeThemselvesThroughTheCellsAround) {
    const std::vector<Cube> cube = {{1e-6, 20, 5, Vec3(0)}, {0.3, 0.8, 10, {3, 2, 1}}};
    ViewScene both = cubes(cube, 0.9, 0), alone = cubes({cube[1]}, 0.9, 0);
    for (ViewScene* scene : {&both, &alone}) {
        scene->lights = {distantLight({-0.5, -1, 0.3})};
        scene->ambient = Rgb(0.2);
    }
    ASSERT_EQ(planTransport(both).domains.size(), 2u);
    const Solution inside = solve(both, planTransport(both)), truth = solve(alone, planTransport(alone));
    for (const Vec3& at : kPlaces) {
        const double light = seenAt(truth, 0, placeIn(cube[1], at));
        EXPECT_NEAR(seenAt(inside, 1, placeIn(cube[1], at)), light, 0.005 * light);
    }
}

// Cubes that only absorb leave the sun's light the same but for its power, through all borders on its way. The smallest
// is so small that what scatters inside of it passes hardly anything else.
TEST(ScatterDomains, AreDarkenedByAllThatLiesAround) {
    const std::vector<Cube> three = {{0.04, 8, 5, Vec3(0)}, {0.002, 0.8, 10, {9, 3, -6}}, {6, 0.02, 10, {11, 4, -5}}};
    ViewScene scene = cubes(three, 0.9, 0);
    scene.lights = {distantLight({0, -1, 0})};
    scene.volumes[0].medium.albedo = scene.volumes[1].medium.albedo = Rgb(0);
    ASSERT_EQ(planTransport(scene).domains[2].parent, 1);
    const Solution inside = solve(scene, planTransport(scene));
    ViewScene alone = scene;
    alone.volumes.erase(alone.volumes.begin(), alone.volumes.begin() + 2);
    const Solution truth = solve(alone, planTransport(alone));
    double depth = 0;  // to the middle of the smallest
    for (std::size_t v = 0; v < 2; ++v) depth += three[v].sigma * (placeIn(three[v], Vec3(1)).y - three[2].center.y);
    ASSERT_GT(depth, 1);
    const double light = std::exp(-depth) * seenAt(truth, 0, three[2].center);
    EXPECT_NEAR(seenAt(inside, 2, three[2].center), light, 0.02 * light);
}

TEST(ScatterDomains, TakeTheWorkOfTheirParts) {
    const auto work = [](const ViewScene& scene) {
        return double(solve(scene, planTransport(scene)).solved.cellDirections);
    };
    const auto lit = [](const std::vector<Cube>& all) {
        ViewScene scene = cubes(all, 0.95, 0);
        scene.lights = {distantLight({-0.5, -1, 0.3})};
        return scene;
    };
    double parts = 0;
    for (const Cube& cube : kNested) parts += work(lit({cube}));
    EXPECT_LT(work(lit(kNested)), 2 * parts);
}

// Instances are splatted together if they look alike, but not if they find their light in different cells.
TEST(ScatterDomains, LightEachInstanceInItsOwnCells) {
    ViewScene scene = cubes({{0.05, 2, 8, {-20, 0, 0}}, {0.4, 0.4, 10, {25, 0, 0}}}, 0.9, 0);
    scene.lights = {distantLight({-0.2, -1, -0.4})};
    for (ViewVolume& volume : scene.volumes) volume.medium.densityScale = 0.2;
    ASSERT_EQ(planTransport(scene).domains.size(), 2u);
    const Image alike = renderScene(scene).image;
    scene.volumes[1].medium.albedo = Rgb(0.9 - 1e-7);
    const Image unlike = renderScene(scene).image;
    for (std::size_t i = 0; i < alike.rgba.size(); ++i) ASSERT_NEAR(alike.rgba[i], unlike.rgba[i], 1e-5);
    ViewScene dark = scene;
    for (ViewVolume& volume : dark.volumes) volume.medium.scattering = Scattering::single;
    const auto sum = [](const Image& image) {
        double all = 0;
        for (std::size_t i = 0; i < image.rgba.size(); i += 4) all += double(image.rgba[i]);
        return all;
    };
    EXPECT_GT(sum(alike), 1.2 * sum(renderScene(dark).image));
}

TEST(ScatterDomains, AreForVoxelsOfLikeSizeThatLieTogether) {
    const auto domains = [](const std::vector<Cube>& all) { return scatterDomains(cubes(all, 1, 0), 2); };
    EXPECT_EQ(domains({{1, 1, 5, Vec3(0)}, {1, 1.9, 5, Vec3(40)}}).size(), 1u);
    const std::vector<ScatterDomain> nested = domains(kNested);
    ASSERT_EQ(nested.size(), 3u);
    EXPECT_EQ(nested[1].parent, 0);
    EXPECT_EQ(nested[2].parent, 1);
    EXPECT_EQ(nested[2].held, (std::vector<bool>{false, false, true}));
    EXPECT_EQ(nested[2].larger, (std::vector<bool>{true, true, false}));
    EXPECT_DOUBLE_EQ(nested[1].edge, 1.6);
    // Two small cubes far apart, and two that touch.
    const Cube large{0.01, 20, 5, Vec3(0)}, small{1, 0.5, 5, Vec3(-30)};
    EXPECT_EQ(domains({large, small, {1, 0.5, 5, Vec3(30)}}).size(), 3u);
    EXPECT_EQ(domains({large, small, {1, 0.5, 5, {-25, -30, -30}}}).size(), 2u);
}

}  // namespace
}  // namespace scrim::test
