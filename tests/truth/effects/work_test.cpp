// SPDX-License-Identifier: Apache-2.0
// An effect that is absent does no work: counters of a scene whose effect is off are those of a scene that never heard
// of it, to the last one; and an effect that is on adds its own work and leaves all other work alone.
#include "scenes.h"
#include "support/verified.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

// All counters by name.
std::map<std::string, std::uint64_t> counters(const RenderWork& w) {
    return {{"voxels fed", w.voxelsFed},
            {"footprints", w.footprints},
            {"texels", w.texelsShaded},
            {"light samples", w.lightSamples},
            {"pixel sheets", w.pixelSheets},
            {"layer samples", w.layerSamples},
            {"solid rays", w.solidRays},
            {"caught rays", w.caughtRays},
            {"directions of cells", w.cellDirections},
            {"deep samples", w.deepSamples},
            {"sheets", w.sheets},
            {"samples", w.shade.samples},
            {"light lookups", w.shade.lightLookups},
            {"slide lookups", w.shade.slideLookups},
            {"phases", w.shade.phases},
            {"octaves", w.shade.octaves},
            {"gradients", w.shade.gradients},
            {"emissions", w.shade.emissions},
            {"ambients", w.shade.ambients},
            {"exponentials", w.shade.exponentials},
            {"bytes of fields", w.bytes.fields},
            {"bytes of shadows", w.bytes.shadows},
            {"bytes of shaded sheets", w.bytes.shaded},
            {"bytes of the picture", w.bytes.picture},
            {"bytes of the deep picture", w.bytes.deep}};
}

std::set<std::string> differing(const RenderWork& a, const RenderWork& b) {
    std::set<std::string> names;
    const auto before = counters(a), after = counters(b);
    for (const auto& [name, value] : before)
        if (after.at(name) != value) names.insert(name);
    return names;
}

// Ways to name an effect without having it.
struct Off {
    std::string name;
    std::function<void(ViewScene&)> mention;
};
const std::vector<Off>& offs() {
    static const std::vector<Off> all{
        {"white tint", [](ViewScene& s) { s.volumes[0].medium.extinctionTint = Rgb(1); }},
        {"one octave",
         [](ViewScene& s) {
             s.volumes[0].medium.octaves = {1, 0.3, 0.2, 0.1};
         }},
        {"two lobes of none",
         [](ViewScene& s) {
             s.volumes[0].medium.phase = {0, PhaseType::twoLobe, 0, 0.3};
         }},
        {"rayleigh of nothing",
         [](ViewScene& s) {
             s.volumes[0].medium.phase = {0, PhaseType::rayleigh, 0, 0.5, 0};
         }},
        {"empty emission",
         [](ViewScene& s) {
             s.volumes[0].emission = {{{std::make_shared<SparseField>(), Mat4(1.0)}, Rgb(1)}};
         }},
        {"all lights linked",
         [](ViewScene& s) {
             s.volumes[0].lights = {true, true};
         }},
        {"black ambient", [](ViewScene& s) { s.ambient = Rgb(0); }},
        {"black light",
         [](ViewScene& s) {
             s.lights.push_back(distantLight({1, 0, 0}, 0));
             s.lights.back().name = "dark";
         }},
        {"light linked to nothing",
         [](ViewScene& s) {
             s.lights.push_back(distantLight({1, 0, 0}, 3));
             s.volumes[0].lights = {true, true, false};
         }},
        {"spot that looks away",
         [](ViewScene& s) {
             s.lights.push_back(lamp({60, 0, 0}, 1e4));
             s.lights.back().kind = Light::Spot{};
             s.lights.back().wsDirection = {1, 0, 0};
         }},
        {"suns of no angle",
         [](ViewScene& s) {
             for (Light& light : s.lights) {
                 light.kind = Light::Distant(0);
                 light.samples = 50;
             }
         }},
        {"black dome",
         [](ViewScene& s) {
             s.lights.emplace_back().kind = Light::Dome();
             s.lights.back().intensity = Rgb(0);
         }},
        {"sky linked to nothing",
         [](ViewScene& s) {
             s.lights.emplace_back().kind = Light::Dome();
             s.volumes[0].lights = {true, true, false};
         }},
        {"rectangle that faces away",
         [](ViewScene& s) {
             s.lights.emplace_back().kind = Light::Area{AreaShape::rectangle, 9, 9};
             s.lights.back().wsPosition = {60, 0, 0};
             s.lights.back().wsDirection = {1, 0, 0};
         }},
        {"no antialiasing", [](ViewScene& s) { s.dials.antialias = 1; }}};
    return all;
}

class AbsentEffects : public testing::TestWithParam<bool> {};

TEST_P(AbsentEffects, DoNoWorkAtAll) {
    ViewScene plain = plainScene();
    plain.dials.shade = GetParam() ? ShadeMode::pixel : ShadeMode::texel;
    const Frame expected = renderScene(plain);
    for (const Off& off : offs()) {
        ViewScene scene = plain;
        off.mention(scene);
        const Frame frame = renderScene(scene);
        EXPECT_EQ(frame.work, expected.work) << off.name;
        EXPECT_EQ(frame.image.rgba, expected.image.rgba) << off.name;
    }
}

TEST_P(AbsentEffects, AreNotCounted) {
    ViewScene plain = plainScene();
    plain.dials.shade = GetParam() ? ShadeMode::pixel : ShadeMode::texel;
    const auto work = counters(renderScene(plain).work);
    for (const char* name :
         {"layer samples", "slide lookups", "phases", "octaves", "gradients", "emissions", "ambients"})
        EXPECT_EQ(work.at(name), 0u) << name;
}
INSTANTIATE_TEST_SUITE_P(TexelsAndPixels, AbsentEffects, testing::Bool());

// What an effect may add to, and what it must.
struct Added {
    std::string effect;
    std::set<std::string> must, may;
};

class PresentEffects : public testing::TestWithParam<Added> {};

TEST_P(PresentEffects, AddTheirOwnWorkAndNoOther) {
    ViewScene plain = plainScene(), scene = sceneWith(GetParam().effect);
    plain.dials.shade = scene.dials.shade = ShadeMode::texel;
    const std::set<std::string> added = differing(renderScene(plain).work, renderScene(scene).work);
    for (const std::string& name : GetParam().must) EXPECT_TRUE(added.contains(name)) << name;
    for (const std::string& name : added)
        EXPECT_TRUE(GetParam().must.contains(name) || GetParam().may.contains(name)) << name;
}
INSTANTIATE_TEST_SUITE_P(
    Each, PresentEffects,
    testing::Values(Added{"coloured extinction",
                          {"exponentials", "layer samples", "bytes of shaded sheets", "bytes of the picture"},
                          {}},
                    Added{"albedo grid", {"voxels fed", "bytes of fields"}, {}},
                    Added{
                        "emission",
                        {"voxels fed", "footprints", "bytes of fields", "emissions", "exponentials"},
                        // It may show where there is no density, and the sweep with it then is the one that takes most.
                        {"texels", "samples", "light samples", "light lookups", "pixel sheets",
                         "bytes of shaded sheets", "bytes of shadows"}},
                    Added{"two-lobe phase", {"phases"}, {}}, Added{"rayleigh phase", {"phases"}, {}},
                    Added{"octaves", {"phases", "octaves", "exponentials"}, {}},
                    Added{"ambient", {"ambients", "exponentials"}, {}}),
    [](const auto& test) {
        std::string name = test.param.effect;
        std::replace_if(
            name.begin(), name.end(), [](unsigned char c) { return !std::isalnum(c); }, '_');
        return name;
    });

// Shadow buffers of one tint are no dearer than grey ones; of two there are two, and so on up to three.
TEST(ColouredExtinctionWork, IsARowOfShadowsATint) {
    const auto shadows = [](const ViewScene& scene) { return renderScene(scene).work.lightSamples; };
    ViewScene two = sceneWith("two tints"), grey = two;
    for (ViewVolume& volume : grey.volumes) volume.medium.extinctionTint = Rgb(1);
    EXPECT_EQ(shadows(sceneWith("coloured extinction")), shadows(plainScene()));
    EXPECT_GT(shadows(two), shadows(grey));
    EXPECT_LE(shadows(two), 2 * shadows(grey));
    ViewScene four = sceneWith("four tints"), fourGrey = four;
    for (ViewVolume& volume : fourGrey.volumes) volume.medium.extinctionTint = Rgb(1);
    EXPECT_LE(shadows(four), 3 * shadows(fourGrey));
}

// A layer costs what is composited for it, and nothing in front of that.
TEST(LayerWork, IsCompositingOnly) {
    ViewScene scene = plainScene();
    scene.dials.shade = ShadeMode::texel;
    scene.lights[1].wsDirection = glm::normalize(Vec3(-0.8, -1, -0.7));  // shares the key's sweep
    const RenderWork plain = renderScene(scene).work;
    scene.layers = {Layer::light};
    const RenderWork work = renderScene(scene).work;
    EXPECT_EQ(differing(plain, work),
              (std::set<std::string>{"layer samples", "bytes of shaded sheets", "bytes of the picture"}));
    EXPECT_EQ(work.layerSamples, work.pixelSheets);  // two pictures instead of one: the beauty is their sum
    scene.layers = {Layer::light, Layer::albedo};
    EXPECT_EQ(renderScene(scene).work.layerSamples, 2 * work.pixelSheets);
    scene.layers = {Layer::ambient, Layer::transmittance};  // there is no ambient light, and opacity is there anyway
    EXPECT_EQ(renderScene(scene).work, plain);
}

// The layer of a light that is alone in its sweep is that sweep's beauty: it costs nothing at all.
TEST(LayerWork, OfLightsOnTheirOwnIsNone) {
    ViewScene scene = plainScene();
    ASSERT_EQ(makePlan(scene, 2).groups.size(), 2u);
    const RenderWork plain = renderScene(scene).work;
    scene.layers = {Layer::light};
    EXPECT_EQ(renderScene(scene).work, plain);
}

// Of two groups each composites the layers of its own lights only.
TEST(LayerWork, IsDoneByTheGroupThatOwnsTheLight) {
    ViewScene scene = plainScene();
    scene.lights[0].wsDirection = {0, 0, -1};
    scene.lights[1].wsDirection = {0, 0, 1};
    scene.dials.crossFade = 0;  // else both own depth and albedo, since both are as near to the eye's axis
    scene.layers = {Layer::light, Layer::depth, Layer::albedo};
    const Plan plan = makePlan(scene, 2);
    ASSERT_EQ(plan.groups.size(), 2u);
    EXPECT_EQ(plan.groups[0].outputs.list.size(), 3u);
    EXPECT_EQ(plan.groups[1].outputs.list.size(), 1u);
}

// Thirty placements of one asset, and the same with media that differ by next to nothing, which therefore have planes
// of their own.
TEST(Instances, ShareTheirPlanes) {
    ViewScene apart = plainScene();
    apart.camera.height = 120;
    for (int i = 1; i < 30; ++i) {
        apart.volumes.push_back(apart.volumes.front());
        apart.volumes.back().wsFromIs[3] = {13 * (i % 6) - 33, 11 * (i / 6) - 22, 3 * (i % 4), 1};
        apart.volumes.back().medium.albedo.x += 1e-9 * i;
    }
    ViewScene alike = apart;
    for (ViewVolume& volume : alike.volumes) volume.medium = alike.volumes.front().medium;
    const Frame a = renderScene(apart), b = renderScene(alike);
    EXPECT_EQ(a.work.footprints, b.work.footprints);
    EXPECT_EQ(a.work.voxelsFed, b.work.voxelsFed);
    EXPECT_LT(2 * b.work.bytes.fields, a.work.bytes.fields);
    // Making up for look-ups' blur is limited where sheets have edges, which sums of volumes have in other places.
    double difference = 0, sum = 0;
    for (std::size_t i = 0; i < a.image.rgba.size(); ++i) {
        difference += std::pow(double(a.image.rgba[i]) - double(b.image.rgba[i]), 2);
        sum += std::pow(double(a.image.rgba[i]), 2);
    }
    EXPECT_LT(std::sqrt(difference / sum), 2e-3);
    expectConvergence(alike, 40, 1, 0.003);
}

}  // namespace
}  // namespace scrim::test
