// SPDX-License-Identifier: Apache-2.0
// The choice of cells and directions by a pilot.
#include "full_smoke.h"
#include "support/fields.h"

#include <scrim/scene/quality.h>
#include <scrim/verify/promise.h>
#include <scrim/verify/scatter_pilot.h>

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include <glm/ext/matrix_transform.hpp>

namespace scrim::test {
namespace {

ViewScene smoke(double sigma, double g) {
    return fullSmoke(20, 44, 32, sigma, g);
}

TEST(ScatterPilot, IsNoneWhereLightScattersOnce) {
    ViewScene scene = smoke(0.3, 0);
    scene.volumes[0].medium.scattering = Scattering::single;
    EXPECT_FALSE(scatterPilot(scene));
}

TEST(ScatterPilot, SeesThatDenseSmokeNeedsFinerCells) {
    const auto thin = scatterPilot(smoke(0.1, 0)), dense = scatterPilot(smoke(1.5, 0));
    ASSERT_TRUE(thin && dense);
    EXPECT_GT(dense->difference, 1.5 * thin->difference);
    EXPECT_GT(dense->share, thin->share);
    EXPECT_LT(chooseScattering(*dense, {}, 0.02).cell, chooseScattering(*thin, {}, 0.02).cell);
}

// Only some of many lights are looked at. They are not those that shine elsewhere, however bright, and those that are
// alike stand for all.
TEST(ScatterPilot, LooksAtTheBrightestOfManyLights) {
    const ViewScene one = smoke(0.6, 0);
    ViewScene many = one;
    for (int i = 0; i < 40; ++i) many.lights.push_back(one.lights[0]);
    Light away = one.lights[0];
    away.kind = Light::Spot();
    away.wsPosition = {0, 0, 500};
    away.wsDirection = {0, 0, 1};
    away.intensity = Rgb(1e12);
    for (int i = 0; i < 40; ++i) many.lights.push_back(away);
    const auto of = scatterPilot(one), ofMany = scatterPilot(many);
    ASSERT_TRUE(of && ofMany);
    EXPECT_NEAR(ofMany->difference, of->difference, 1e-4 * of->difference);
    EXPECT_NEAR(ofMany->share, of->share, 1e-4 * of->share);
}

// Opaque smoke looks alike with all cells that are too large for its shadows, and finer ones tell more; a limit that
// leaves them no room is told of.
TEST(ScatterPilot, TellsThatTheMemoryLimitHidesFinerCells) {
    ViewScene scene = fullSmoke(26, 56, 32, 100, 0);
    const auto free = scatterPilot(scene);
    scene.memoryLimit = 1'000'000;
    const auto limited = scatterPilot(scene);
    ASSERT_TRUE(free && limited);
    EXPECT_FALSE(free->limited);
    EXPECT_TRUE(limited->limited);
    EXPECT_GT(limited->edge, free->edge);
    EXPECT_TRUE(chooseScattering(*limited, {}, 0.02).limited);
    Dials stated;
    stated.scatterCell = 2;
    EXPECT_FALSE(chooseScattering(*limited, stated, 0.02).limited);
}

// Cells as thick as a layer all miss how light passes through it, and pilots' pairs of them hardly differ.
TEST(ScatterPilot, ResolvesThinLayersWhateverItsCellsShow) {
    ViewScene scene = smoke(0.6, 0);
    ViewVolume& layer = scene.volumes[0];
    layer.field = makeField({-24, -24, 1}, {24, 24, 4}, 1,
                            [](const Vec3& is) { return 1 + 0.5 * std::sin(0.7 * is.x) * std::sin(0.8 * is.y); });
    layer.wsFromIs = layer.field->wsFromIs;
    for (const double flat : {1.0, 0.3}) {
        layer.wsFromIs = glm::scale(Mat4(1), Vec3(1, 1, flat)) * layer.field->wsFromIs;
        layer.medium.densityScale = 0.6 / flat;
        const auto pilot = scatterPilot(scene);
        ASSERT_TRUE(pilot);
        EXPECT_NEAR(pilot->layers, 4, 0.01) << "four layers across blocks of eight";
        EXPECT_LE(chooseScattering(*pilot, {}, 0.02).cell, 1.1 * 4 / 5);
        EXPECT_GT(pilot->ofCells(2), 0.05);
        EXPECT_EQ(pilot->ofCells(0.5), pilot->byDifference(0.5));
    }
}

TEST(ScatterPilot, ChoosesTheSameWhateverIsHeldOut) {
    ViewScene scene = smoke(0.5, 0);
    ViewVolume other = scene.volumes[0];
    other.medium.densityScale = 0.1;
    scene.volumes.push_back(other);
    const auto seen = scatterPilot(scene);
    scene.volumes[0].holdout = true;
    const auto held = scatterPilot(scene);
    ASSERT_TRUE(seen && held);
    EXPECT_EQ(held->difference, seen->difference);
    EXPECT_EQ(held->rayEffects, seen->rayEffects);
}

TEST(ScatterPilot, IsThatOfTheWholePictureWhateverTheCropAndTheBrightness) {
    const ViewScene scene = smoke(0.5, 0.3);
    ViewScene other = scene;
    other.region = {3, 4, 9, 11};
    other.lights[0].intensity *= 7.0;
    EXPECT_NEAR(scatterPilot(other)->difference, scatterPilot(scene)->difference, 1e-5);
}

Light domeOf(double intensity) {
    Light dome;
    dome.kind = Light::Dome{};
    dome.intensity = Rgb(intensity);
    return dome;
}

// A dome of one colour enters the cells as ambient light does, alone, as two domes, and beside a sun that is faint.
TEST(ScatterPilot, SeesADomeAsAmbientLight) {
    ViewScene scene = smoke(1.5, 0.3);
    const Light sun = scene.lights[0];
    scene.lights.clear();
    scene.ambient = Rgb(1);
    const ScatterPilot ambient = *scatterPilot(scene);
    EXPECT_GT(ambient.difference, 0.001);
    EXPECT_DOUBLE_EQ(ambient.share, 1);
    EXPECT_DOUBLE_EQ(ambient.ofSkies, 1);
    scene.ambient = Rgb(0);
    Light faint = sun;
    faint.intensity = Rgb(1e-6);
    for (const std::vector<Light>& lights :
         {std::vector<Light>{domeOf(1)}, {domeOf(0.4), domeOf(0.6)}, {domeOf(1), faint}, {faint, domeOf(1)}}) {
        scene.lights = lights;
        const ScatterPilot pilot = *scatterPilot(scene);
        EXPECT_DOUBLE_EQ(pilot.edge, ambient.edge);
        EXPECT_NEAR(pilot.difference, ambient.difference, 2e-5);
        EXPECT_NEAR(pilot.ofEach, ambient.ofEach, 2e-5);
        EXPECT_NEAR(pilot.rayEffects, ambient.rayEffects, 2e-5);
        EXPECT_NEAR(pilot.share, 1, 1e-4);
        EXPECT_NEAR(pilot.ofSkies, 1, 1e-4);
    }
}

TEST(ScatterPilot, TellsTheLightOfSkiesFromThatOfSuns) {
    ViewScene scene = smoke(0.5, 0);
    EXPECT_EQ(scatterPilot(scene)->ofSkies, 0);
    scene.lights.push_back(domeOf(0.1));
    const ScatterPilot both = *scatterPilot(scene);
    EXPECT_GT(both.ofSkies, 0.1);
    EXPECT_LT(both.ofSkies, 0.9);
    EXPECT_LT(both.share, 0.99);
}

// Buffers bring the dome to a volume that scatters once, and the border to one beside it that scatters fully.
TEST(ScatterPilot, SeesADomeWhereVolumesScatterUnlike) {
    ViewScene scene = smoke(1.5, 0);
    scene.lights = {domeOf(1)};
    ViewVolume thin = scene.volumes[0];
    thin.medium.scattering = Scattering::single;
    thin.medium.densityScale = 1e-6;
    const ScatterPilot alone = *scatterPilot(scene);
    scene.volumes.push_back(thin);
    const ScatterPilot beside = *scatterPilot(scene);
    EXPECT_GT(beside.ofSkies, 0.99);
    EXPECT_NEAR(beside.difference, alone.difference, 0.05 * alone.difference);
    EXPECT_NEAR(beside.share, 1, 1e-3);
}

TEST(ScatterChoice, IsFinerForLessError) {
    const auto pilot = scatterPilot(smoke(0.6, 0.8));
    double cell = 100;
    int directions = 0;
    for (const double error : {0.05, 0.02, 0.01, 0.005}) {
        const ScatterChoice choice = chooseScattering(*pilot, {}, error);
        EXPECT_LE(choice.cell, cell);
        EXPECT_GE(choice.directions, directions);
        cell = choice.cell;
        directions = choice.directions;
    }
    EXPECT_LT(cell, 2);
}

TEST(ScatterChoice, TakesMoreDirectionsForNarrowerLobes) {
    EXPECT_EQ(chooseScattering(*scatterPilot(smoke(0.4, 0)), {}, 0.02).directions, 64);
    EXPECT_EQ(chooseScattering(*scatterPilot(smoke(0.4, 0.9)), {}, 0.02).directions, 256);
}

// The RMS difference of means over 4 x 4 pixels, relative to their mean.
double differenceOfSquares(const Image& a, const Image& b) {
    double squares = 0, mean = 0;
    const Int2 size = Int2(a.window.width(), a.window.height()) / 4;
    for (int i = 0; i < size.x * size.y; ++i) {
        double difference = 0;
        for (int k = 0; k < 16; ++k) {
            const std::size_t at = a.indexOf(i % size.x * 4 + k % 4, i / size.x * 4 + k / 4) + 1;
            difference += double(a.rgba[at] - b.rgba[at]) / 16;
            mean += double(b.rgba[at]) / 16;
        }
        squares += difference * difference;
    }
    return std::sqrt(squares * size.x * size.y) / mean;
}

// Isotropic smoke with a small lamp within, and the same smoke lit evenly from all sides. At the corner of eight cells
// of either size, where the lamp's light is spread most, a half is foreseen, and 1.2 to 2.1 times as much at three
// others.
TEST(ScatterPilot, ForeseesTheErrorOfFewDirections) {
    const auto bothOf = [](const ViewScene& scene) {
        const auto rendered = [&](int directions) {
            ViewScene with = scene;
            with.dials.scatterCell = 1;
            with.dials.scatterDirections = directions;
            return renderScene(with).image;
        };
        return std::pair(scatterPilot(scene)->ofDirections(0), differenceOfSquares(rendered(64), rendered(256)));
    };
    ViewScene scene = smoke(0.4, 0);
    scene.lights = {lamp({0.3, 0.1, 0.7}, 100)};
    const auto [foreseen, measured] = bothOf(scene);
    EXPECT_GT(measured, 0.004);
    EXPECT_GT(foreseen, measured / 2);
    EXPECT_LT(foreseen, measured * 4);
    scene.lights.clear();
    scene.ambient = Rgb(1);
    const auto [foreseenOfSky, measuredOfSky] = bothOf(scene);
    EXPECT_LT(measuredOfSky, 0.002);
    EXPECT_LT(foreseenOfSky, 0.002);
}

// A bright spot around a lamp has most of the error of cells. Where directions keep the promise, cells are as fine as
// the spot needs; where they cannot, cells are as fine as the rest does, and what is expected still tells of the spot.
TEST(ScatterChoice, RefinesCellsForABrightSpotOnlyWhereDirectionsKeepThePromise) {
    ViewScene scene = smoke(0.3, 0);
    Light lamp;
    lamp.kind = Light::Point{};
    lamp.wsPosition = Vec3(6, 3, 9);  // near the border of the smoke, towards the camera
    scene.lights = {lamp};
    ScatterPilot pilot = *scatterPilot(scene);
    EXPECT_LT(pilot.ofEach, 0.7 * pilot.difference);
    pilot.straight = {0, 0, 0};
    pilot.rayEffects = 0.001;
    const ScatterChoice kept = chooseScattering(pilot, {}, 0.02);
    pilot.rayEffects = 0.2;
    const ScatterChoice lost = chooseScattering(pilot, {}, 0.02);
    pilot.ofEach = pilot.difference;
    const ScatterChoice allAlike = chooseScattering(pilot, {}, 0.02);
    EXPECT_GT(lost.cell, 1.15 * allAlike.cell);
    EXPECT_LT(kept.cell, lost.cell);  // though cells have half of what is promised where it is lost
    EXPECT_GT(lost.expected, allAlike.expected);
}

TEST(ScatterChoice, KeepsWhatTheSceneStates) {
    ViewScene scene = smoke(0.4, 0.9);
    scene.dials.scatterCell = 3.5;
    const PromisedDials cells = promisedDials(scene, "high");
    ASSERT_TRUE(cells.scattering);
    EXPECT_EQ(*cells.dials.scatterCell, 3.5);
    EXPECT_EQ(*cells.dials.scatterDirections, 256);
    EXPECT_EQ(cells.scattering->promised, promisedScatteringError("high"));
    scene.dials.scatterCell.reset();
    scene.dials.scatterDirections = 64;
    const PromisedDials directions = promisedDials(scene, "high");
    ASSERT_TRUE(directions.scattering);
    EXPECT_EQ(*directions.dials.scatterDirections, 64);
    EXPECT_GT(directions.scattering->choice.expected, directions.scattering->promised);
}

TEST(ScatterChoice, NeedsNoPilotWhereTheSceneStatesAll) {
    ViewScene scene = smoke(0.4, 0.9);
    scene.dials.scatterCell = 3.5;
    scene.dials.scatterDirections = 64;
    EXPECT_FALSE(scatterPilot(scene));
    const PromisedDials promised = promisedDials(scene, "high");
    EXPECT_FALSE(promised.scattering);
    EXPECT_EQ(*promised.dials.scatterCell, 3.5);
    EXPECT_EQ(*promised.dials.scatterDirections, 64);
}

}  // namespace
}  // namespace scrim::test
