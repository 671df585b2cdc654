// SPDX-License-Identifier: Apache-2.0
// Every effect against brute force, in all ways a picture may be made, and against closed forms of slabs.
#include "scenes.h"
#include "support/verified.h"

#include <scrim/scene/medium.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include <glm/exponential.hpp>

namespace scrim::test {
namespace {

const double kPi = std::acos(-1.0);

enum class Way { texels, pixels, perView, backToFront, perspective };

struct Case {
    std::string effect;
    Way way;
};

std::string nameOf(const testing::TestParamInfo<Case>& info) {
    static const char* const kWays[] = {"Texels", "Pixels", "PerView", "BackToFront", "Perspective"};
    std::string name = info.param.effect;
    for (char& c : name)
        if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
    return name + "_" + kWays[static_cast<int>(info.param.way)];
}

class Effects : public testing::TestWithParam<Case> {};

TEST_P(Effects, AgreeWithBruteForce) {
    ViewScene scene = sceneWith(GetParam().effect);
    scene.dials.texel = scene.dials.sheetThickness = 0.7;
    scene.dials.shade = GetParam().way == Way::pixels ? ShadeMode::pixel : ShadeMode::texel;
    if (GetParam().way == Way::perView) {
        scene.dials.splat = SplatMode::perView;
        scene.camera.resolution = {80, 80};  // the raster of its sheets
        scene.region = {0, 0, 80, 80};
    }
    if (GetParam().way == Way::backToFront)
        for (Light& light : scene.lights) light.wsDirection.z = std::abs(light.wsDirection.z);
    if (GetParam().way == Way::perspective) {
        scene.camera.type = CameraType::perspective;
        scene.camera.fov = 30;
    }
    // Per view only the sheets get finer, not the raster.
    expectConvergence(scene, 40, GetParam().way == Way::perView ? 0.25 : 1, 0.004);
}

std::vector<Case> allCases() {
    std::vector<Case> cases;
    for (const EffectCase& effect : effectCases()) {
        for (const Way way : {Way::texels, Way::pixels}) cases.push_back({effect.name, way});
        if (effect.name == "all at once")
            for (const Way way : {Way::perView, Way::backToFront, Way::perspective})
                cases.push_back({effect.name, way});
    }
    return cases;
}
INSTANTIATE_TEST_SUITE_P(Each, Effects, testing::ValuesIn(allCases()), nameOf);

TEST(Interpolation, OfAVolumeIsThatOfTheDial) {
    ViewScene own = sceneWith("emission"), dial = own;
    own.volumes.front().kernel = own.volumes.front().emission.front().field.kernel = Kernel::bspline;
    dial.dials.kernel = Kernel::bspline;
    const Frame linear = renderScene(sceneWith("emission"));
    EXPECT_EQ(renderScene(own).image.rgba, renderScene(dial).image.rgba);
    EXPECT_NE(renderScene(own).image.rgba, linear.image.rgba);
    // What the volume says counts, not the dial.
    dial.volumes.front().kernel = dial.volumes.front().emission.front().field.kernel = Kernel::linear;
    EXPECT_EQ(renderScene(dial).image.rgba, linear.image.rgba);
}

// A slab 20 thick across the view, all of it 1.
ViewScene slab(const Medium& medium) {
    return orthographicScene(boxField({-40, -40, -10}, {39, 39, 9}), medium, 20, 9);
}

TEST(ColouredExtinction, TakesEveryChannelByItsOwnTau) {
    Medium medium;
    medium.densityScale = 0.05;
    medium.extinctionTint = {1, 3, 0};
    ViewScene scene = slab(medium);
    scene.layers = {Layer::transmittance};
    const Frame frame = renderScene(scene);
    const float* t = frame.layers.at(0).data.data() + 3 * (4 * 9 + 4);
    EXPECT_NEAR(t[0], std::exp(-1.0), 1e-4);
    EXPECT_NEAR(t[1], std::exp(-3.0), 1e-4);
    EXPECT_NEAR(t[2], 1, 1e-6);
    EXPECT_NEAR(pixelOf(frame, 4, 4)[3], 1 - (std::exp(-1.0) + std::exp(-3.0) + 1) / 3, 1e-4);
}

// L = E rho / (8 pi) (1 - e^-2tau), lit along the view: for each channel by itself.
TEST(ColouredExtinction, LightsEveryChannelByItsOwnTau) {
    Medium medium;
    medium.densityScale = 0.05;
    medium.extinctionTint = {1, 3, 0.2};
    medium.albedo = {0.9, 0.5, 1};
    ViewScene scene = slab(medium);
    scene.lights = {distantLight({0, 0, -1}, 2)};
    const auto pixel = pixelOf(renderScene(scene), 4, 4);
    for (int c = 0; c < 3; ++c) {
        const double expected = 2 * medium.albedo[c] / (8 * kPi) * (1 - std::exp(-2 * medium.extinctionTint[c]));
        EXPECT_NEAR(pixel[static_cast<std::size_t>(c)], expected, 2e-3 * expected) << c;
    }
}

// j (1 - e^-tau) / sigma, and j times the length where nothing is in the way.
TEST(Emission, OfASlabIsItsClosedForm) {
    for (const double sigma : {0.0, 0.01, 0.2, 2.0}) {
        Medium medium;
        medium.densityScale = sigma;
        ViewScene scene = slab(medium);
        scene.volumes[0].emission = {{{scene.volumes[0].field, Mat4(1.0)}, {3, 2, 0.5}}};
        const auto pixel = pixelOf(renderScene(scene), 4, 4);
        const double length = sigma > 0 ? -std::expm1(-20 * sigma) / sigma : 20;
        EXPECT_NEAR(pixel[0], 3 * length, 1e-3 * 3 * length) << sigma;
        EXPECT_NEAR(pixel[2], 0.5 * length, 1e-3 * 0.5 * length) << sigma;
    }
}

TEST(Emission, ShowsWhereThereIsNoDensity) {
    ViewScene scene = plainScene();
    scene.lights.clear();
    scene.volumes[0].field = std::make_shared<SparseField>();
    scene.volumes[0].emission = {{flameField(), {1, 0.5, 0.1}}};
    const Frame frame = renderScene(scene);
    EXPECT_GT(pixelOf(frame, 24, 26)[0], 1);
    EXPECT_EQ(pixelOf(frame, 24, 26)[3], 0);
    EXPECT_NEAR(pixelOf(frame, 24, 26)[1], 0.5 * pixelOf(frame, 24, 26)[0], 1e-4);
}

TEST(Phases, IntegrateToOne) {
    for (const Phase& phase : {Phase{0.3}, Phase{0.7, PhaseType::twoLobe, -0.4, 0.3}, Phase{0, PhaseType::rayleigh},
                               flattened({0, PhaseType::rayleigh}, 0.5), drainePhase(0.7, 30), drainePhase(-0.2, 1),
                               dropletPhase(0.05), dropletPhase(1), dropletPhase(3), dropletPhase(5)}) {
        double sum = 0;
        constexpr int kSteps = 200000;
        for (int i = 0; i < kSteps; ++i) {
            const double angle = kPi * (i + 0.5) / kSteps;
            sum += 2 * kPi * std::sin(angle) * phaseValue(phase, std::cos(angle)) * kPi / kSteps;
        }
        EXPECT_NEAR(sum, 1, 1e-6);
    }
    EXPECT_NEAR(phaseValue({0, PhaseType::rayleigh}, 1), 3 / (8 * kPi), 1e-12);
    EXPECT_NEAR(phaseValue({0, PhaseType::rayleigh}, 0), 3 / (16 * kPi), 1e-12);
    for (const double cosine : {-1.0, -0.3, 0.4, 1.0}) {
        EXPECT_NEAR(phaseValue(drainePhase(0, 1), cosine), phaseValue({0, PhaseType::rayleigh}, cosine), 1e-12);
        EXPECT_NEAR(phaseValue(drainePhase(0.6, 0), cosine), phaseValue({0.6}, cosine), 1e-12);
    }
}

// An octave of weight 0 is nothing, and one that nothing is taken from is single scattering without shadow.
TEST(Octaves, AddSingleScatteringInThinnerMedia) {
    Medium medium;
    medium.densityScale = 0.1;
    medium.albedo = Rgb(1);
    medium.octaves = {2, 0.5, 0.25, 1};
    ViewScene scene = slab(medium);
    scene.lights = {distantLight({0, 0, -1}, 1)};
    // Eye and light from the same side: the integral over x of e^-x (e^-x + b e^-ax), x to tau = 2.
    const double tau = 2, a = 0.5, b = 0.25;
    const double expected = ((1 - std::exp(-2 * tau)) / 2 + b * (1 - std::exp(-(1 + a) * tau)) / (1 + a)) / (4 * kPi);
    EXPECT_NEAR(pixelOf(renderScene(scene), 4, 4)[0], expected, 2e-3 * expected);
    scene.volumes[0].medium.octaves.contribution = 0;
    ViewScene single = scene;
    single.volumes[0].medium.octaves.count = 1;
    EXPECT_EQ(renderScene(scene).image.rgba, renderScene(single).image.rgba);
}

// A thick white slab, lit and seen head-on: pi L / E is the sum over octaves of b^n / (4 (1 + a^n)).
TEST(Octaves, OfAThickSlabAddUpToTheirSeries) {
    for (const auto& [a, b] : {std::pair{0.5, 0.5}, {0.66, 0.66}, {0.9, 0.5}}) {
        Medium medium;
        medium.densityScale = 2;
        medium.albedo = Rgb(1);
        medium.octaves = {6, a, b, 0.5};
        ViewScene scene = slab(medium);
        scene.lights = {distantLight({0, 0, -1}, 1)};
        double expected = 0;
        for (int n = 0; n < 6; ++n) expected += std::pow(b, n) / (4 * (1 + std::pow(a, n)));
        EXPECT_NEAR(kPi * pixelOf(renderScene(scene), 4, 4)[0], expected, 2e-3 * expected);
        EXPECT_LT(expected, 1);
    }
}

TEST(LightLinking, LeavesALightWithoutAVolumeItsShadow) {
    // What is not lit by a light still stands in its way.
    ViewScene scene = plainScene();
    scene.lights.resize(1);
    scene.volumes[0].lights = {false};
    EXPECT_EQ(pixelOf(renderScene(scene), 24, 24)[0], 0);
    scene.volumes.push_back(scene.volumes[0]);
    scene.volumes[1].lights = {true};
    scene.volumes[0].wsFromIs[3] = {25, 25, 12, 1};
    const Frame shaded = renderScene(scene);
    scene.lights[0].shadows = false;
    const Frame unshaded = renderScene(scene);
    EXPECT_LT(pixelOf(shaded, 24, 24)[0], 0.9 * pixelOf(unshaded, 24, 24)[0]);
}

TEST(ShadowLinking, ToNoLightIsALightWithoutShadows) {
    for (const ShadeMode shade : {ShadeMode::texel, ShadeMode::pixel}) {
        ViewScene scene = sceneWith("light linking"), plain = scene;
        scene.dials.shade = plain.dials.shade = shade;
        for (ViewVolume& volume : scene.volumes) volume.shadows = {false, true};
        plain.lights[0].shadows = false;
        const Frame linked = renderScene(scene), unshadowed = renderScene(plain);
        for (std::size_t i = 0; i < linked.image.rgba.size(); ++i)
            ASSERT_NEAR(linked.image.rgba[i], unshadowed.image.rgba[i], 2e-5) << i;
    }
}

TEST(ShadowLinking, HoldsForVolumesThatAreHeldOut) {
    ViewScene scene = sceneWith("shadow linking of two tints");
    scene.volumes[1].holdout = true;
    scene.dials.texel = scene.dials.sheetThickness = 0.7;
    expectConvergence(scene, 40, 1, 0.01);
}

// As sub-lights, which inherit the links; on cells see linked_cells_test.cpp.
TEST(ShadowLinking, HoldsForExtendedLights) {
    ViewScene scene = sceneWith("shadow linking");
    scene.lights[0].kind = Light::Area{AreaShape::rectangle, 12, 12};
    scene.lights[0].wsPosition = -60.0 * scene.lights[0].wsDirection;
    scene.lights[0].intensity *= 25.0;
    scene.lights[0].samples = 16;
    scene.lights[0].shadow = ShadowMethod::buffers;
    scene.dials.texel = scene.dials.sheetThickness = 0.7;
    expectConvergence(scene, 12, 1, 0.01);
}

}  // namespace
}  // namespace scrim::test
