// SPDX-License-Identifier: Apache-2.0
// Octaves of light on cells: each is the same light, less attenuated, more evenly scattered and weaker.
#include "soft_lights.h"
#include "support/fields.h"
#include "support/verified.h"

#include <scrim/engine/plan/make_plan.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

const Rgb kWarm(9, 5, 2);

ViewScene cloud(double g = 0.6) {
    ViewScene scene = orthographicScene(smokeField(16), {0.15, Rgb(0.9), Phase{g}}, 36, 36);
    scene.dials.texel = 0.5;
    scene.dials.sheetThickness = 1;
    scene.volumes[0].medium.scattering = Scattering::octaves;
    scene.volumes[0].medium.octaves = {4, 0.45, 0.6, 0.3};
    return scene;
}

std::vector<std::pair<std::string, Light>> wideLights() {
    return {{"dome", domeLight(24)},
            {"rectangle", areaLight(AreaShape::rectangle, {25, 18, 12}, 6, 9, kWarm)},
            {"sphere beside", areaLight(AreaShape::sphere, {20, 10, 7}, 2, 9, kWarm)},
            {"sphere within", areaLight(AreaShape::sphere, {3.3, -2.2, 1.7}, 0.4, 0, kWarm)},
            {"lamp within", lamp({3.3, -2.2, 1.7}, 50)}};
}

Image renderedOn(ViewScene scene, ShadowMethod method) {
    for (Light& light : scene.lights) light.shadow = method;
    EXPECT_EQ(makePlan(scene, 1).cellLights.lights.empty(), method == ShadowMethod::buffers);
    return renderScene(scene).image;
}

// By RMS over that of `b`, in the colours of pixels of `channels`.
double difference(const std::vector<float>& a, const std::vector<float>& b, std::size_t channels = 4) {
    double squares = 0, all = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (i % channels == 3) continue;
        squares += std::pow(double(a[i]) - double(b[i]), 2);
        all += std::pow(double(b[i]), 2);
    }
    return std::sqrt(squares / all);
}

TEST(OctavesOnCells, GiveThePictureOfShadowBuffers) {
    for (const auto& [name, light] : wideLights()) {
        if (name.ends_with("within")) continue;  // windows of buffers are less exact there
        ViewScene scene = cloud();
        scene.lights = {light};
        EXPECT_LT(
            difference(renderedOn(scene, ShadowMethod::cells).rgba, renderedOn(scene, ShadowMethod::buffers).rgba),
            0.01)
            << name;
    }
}

double errorOnCells(ViewScene scene) {
    scene.lights[0].shadow = ShadowMethod::cells;
    const Image image = renderScene(scene).image;
    if (scene.lights[0].area()) scene.lights[0].samples = 200;
    return summarise(samplePixels(scene, image, 40, 7)).error;
}

// Brute force sees each octave, too: without those beyond the first, 30 to 60 % of the light are lost. Beside a lamp in
// the smoke the first has an error of its own.
TEST(OctavesOnCells, AreAsNearToBruteForceAsSingleScattering) {
    for (const auto& [name, light] : wideLights()) {
        ViewScene scene = cloud();
        scene.lights = {light};
        const double octaves = errorOnCells(scene);
        scene.volumes[0].medium.octaves.count = 1;
        EXPECT_LT(octaves, std::max(1.2 * errorOnCells(scene), 0.015)) << name;
    }
}

// Lamps that share cells keep their octaves there, and near themselves.
TEST(OctavesOnCells, OfLampsTogetherAreTheSumOfThoseOfEach) {
    ViewScene scene = cloud();
    std::vector<float> sum;
    std::vector<Light> lamps;
    for (int i = 0; i < 6; ++i) lamps.push_back(lamp({-10.0 + 4 * i, 5.0 - 2 * i, 3.0 * (i % 3) - 3}, 20));
    for (const Light& one : lamps) {
        scene.lights = {one};
        const std::vector<float> own = renderedOn(scene, ShadowMethod::cells).rgba;
        sum.resize(own.size());
        for (std::size_t k = 0; k < own.size(); ++k) sum[k] += own[k];
    }
    scene.lights = lamps;
    EXPECT_LT(difference(renderedOn(scene, ShadowMethod::cells).rgba, sum), 0.015);
}

// One octave of full extinction, weight and phase is the same light again.
TEST(OctavesOnCells, OfFullWeightDoubleTheLight) {
    for (const auto& [name, light] : wideLights()) {
        ViewScene scene = cloud();
        scene.lights = {light};
        scene.volumes[0].medium.octaves = {1, 1, 1, 1};
        const std::vector<float> once = renderedOn(scene, ShadowMethod::cells).rgba;
        scene.volumes[0].medium.octaves.count = 2;
        std::vector<float> twice = renderedOn(scene, ShadowMethod::cells).rgba;
        for (float& value : twice) value /= 2;
        EXPECT_LT(difference(twice, once), 1e-5) << name;
    }
}

// The layer `indirect` has the octaves beyond the first, and nothing of the first.
TEST(OctavesOnCells, BeyondTheFirstAreIndirectLight) {
    for (const auto& [name, light] : wideLights()) {
        ViewScene scene = cloud();
        scene.lights = {light};
        scene.layers = {Layer::indirect};
        const auto indirectOf = [&](ShadowMethod method) {
            for (Light& one : scene.lights) one.shadow = method;
            const Frame frame = renderScene(scene);
            for (const FrameLayer& layer : frame.layers)
                if (layer.layer == Layer::indirect) return layer.data;
            return std::vector<float>();
        };
        const std::vector<float> cells = indirectOf(ShadowMethod::cells);
        ASSERT_FALSE(cells.empty());
        if (!name.ends_with("within")) {
            EXPECT_LT(difference(cells, indirectOf(ShadowMethod::buffers), 3), 0.01) << name;
        }
        scene.volumes[0].medium.octaves.count = 1;
        for (const float value : indirectOf(ShadowMethod::cells)) ASSERT_EQ(value, 0) << name;
    }
}

// Two media with octaves of their own, and one without, in one sky.
TEST(OctavesOnCells, BelongToTheirMedium) {
    ViewScene scene = cloud();
    scene.lights = {domeLight(24)};
    ViewVolume other = scene.volumes[0];
    other.medium.octaves = {2, 0.7, 0.3, 0.5};
    other.wsFromIs[3].x += 12;
    scene.volumes.push_back(other);
    other.medium.scattering = Scattering::single;
    other.medium.octaves = {};
    other.wsFromIs[3].x -= 24;
    scene.volumes.push_back(other);
    EXPECT_LT(difference(renderedOn(scene, ShadowMethod::cells).rgba, renderedOn(scene, ShadowMethod::buffers).rgba),
              0.012);
}

}  // namespace
}  // namespace scrim::test
