// SPDX-License-Identifier: Apache-2.0
// What neither eye nor light needs is left out, and the picture does not change.
#include "scenes.h"
#include "support/verified.h"

#include <scrim/engine/plan/effects.h>
#include <scrim/engine/plan/culling.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

const Effect& effectOf(const std::vector<Effect>& effects, const std::string& name) {
    return *std::find_if(effects.begin(), effects.end(), [&](const Effect& e) { return e.name == name; });
}

class Crops : public testing::TestWithParam<bool> {};

TEST_P(Crops, SplatAndShadeLessAndShowTheSame) {
    ViewScene scene = plainScene();
    scene.dials.shade = GetParam() ? ShadeMode::pixel : ShadeMode::texel;
    scene.dials.texel = 0.5;  // tiles of 8 voxels, as blocks are
    scene.volumes[0].field = smokeField(48);
    scene.camera.height = 100;
    scene.camera.resolution = {96, 96};
    scene.camera.wsPosition.z = 150;
    scene.region = {0, 0, 96, 96};
    scene.lights = {distantLight({0.2, -0.1, -1}), lamp({5, 10, 190}, 3000)};
    const Frame whole = renderScene(scene);
    scene.picture = scene.region;
    scene.region = {44, 30, 52, 38};
    const Frame crop = renderScene(scene);
    EXPECT_EQ(crop.image.rgba, reframed(whole.image, scene.region).rgba);
    EXPECT_LT(crop.work.footprints, 0.6 * static_cast<double>(whole.work.footprints));
    EXPECT_LT(crop.work.lightSamples, 0.6 * static_cast<double>(whole.work.lightSamples));
    EXPECT_LT(crop.work.pixelSheets, 0.2 * static_cast<double>(whole.work.pixelSheets));
    EXPECT_TRUE(effectOf(effectsOf(scene, makePlan(scene, 2)), "tiles culled").on);
}
INSTANTIATE_TEST_SUITE_P(TexelsAndPixels, Crops, testing::Bool());

TEST(Sheets, BehindTheLastThingSeenAreNotSplatted) {
    // The camera stands within the smoke and looks out of it; one light comes from behind it, one across.
    ViewScene scene = plainScene();
    scene.camera.type = CameraType::perspective;
    scene.camera.fov = 40;
    scene.camera.wsPosition = {0, 0, -8};
    scene.lights.resize(1);
    scene.lights[0].shadows = false;
    const Plan plan = makePlan(scene, 2);
    const GroupPlan& group = plan.groups.front();
    EXPECT_LT(group.needed.last - group.needed.first, 0.8 * group.sheets.count);
    EXPECT_LT(group.needed.share(group.sheets), 0.5);
    EXPECT_GT(group.needed.first + group.sheets.count - group.needed.last, 0);
    expectConvergence(scene, 40, 1, 0.008);
}

// A part of a slab in the middle of a long row of them: sheets begin in the middle of what would be a batch.
TEST(Sheets, BeforeTheFirstThingSeenAreNotSplatted) {
    ViewScene scene = plainScene();
    scene.camera.wsFromCamera = lookAt({0, 0, 0}, {-1, 0.2, -0.1}, {0, 1, 0});
    scene.camera.type = CameraType::perspective;
    scene.camera.fov = 30;
    scene.camera.wsPosition = {-5, 0, 0};
    scene.lights.clear();
    scene.ambient = Rgb(1);
    const Plan plan = makePlan(scene, 2);
    ASSERT_GT(plan.groups.front().needed.first, 8);
    expectConvergence(scene, 40, 1, 0.005);
}

std::vector<Vec3> cornersOf(const Bounds& box) {
    const auto corners = box.corners();
    return {corners.begin(), corners.end()};
}

TEST(ViewFrustums, HoldEveryPointThatAPixelSees) {
    std::mt19937 random(3);
    const auto in = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
    for (int i = 0; i < 200; ++i) {
        Camera camera;
        camera.type = i % 2 ? CameraType::perspective : CameraType::orthographic;
        camera.fov = in(20, 120);
        camera.height = in(2, 20);
        camera.resolution = {60, 40};
        camera.near = i % 3 ? 0 : in(0, 2);
        camera.wsPosition = {in(-9, 9), in(-9, 9), in(-9, 9)};
        camera.wsFromCamera = lookAt(camera.wsPosition, {in(-3, 3), in(-3, 3), in(-3, 3)}, {0, 1, 0});
        const PixelWindow window{10, 5, 40, 30};
        const Bounds box{{-4, -3, -2}, {3, 4, 5}};
        Bounds visible;
        for (const Vec3& p : visibleParts(camera, window, cornersOf(box))) visible.include(p);
        const RayFamily rays = wsRays(camera);
        for (int k = 0; k < 200; ++k) {
            const double x = in(10, 40), y = in(5, 30);
            const Vec3 p = rays.origin(x, y) + (rays.near + in(0, 30)) * rays.direction(x, y);
            if (!box.contains(p)) continue;
            visible.lower -= 1e-9;
            visible.upper += 1e-9;
            EXPECT_TRUE(visible.contains(p));
        }
    }
}

TEST(ViewFrustums, ShowNothingOfWhatLiesBehindThem) {
    Camera camera;
    camera.resolution = {40, 40};
    camera.wsPosition = {0, 0, 0};
    const auto visible = [&](const Bounds& box) { return visibleParts(camera, {0, 0, 40, 40}, cornersOf(box)); };
    EXPECT_TRUE(visible({{-1, -1, 2}, {1, 1, 4}}).empty());
    EXPECT_FALSE(visible({{-1, -1, -4}, {1, 1, -2}}).empty());
    EXPECT_FALSE(visible({{-1, -1, -1}, {1, 1, 1}}).empty());
    EXPECT_TRUE(visible({{30, -1, -4}, {32, 1, -2}}).empty());
}

VolumeBox boxAt(const Vec3& center) {
    const auto corners = Bounds{center - 1.0, center + 1.0}.corners();
    return {std::vector<Vec3>(corners.begin(), corners.end()), {}, {}};
}

TEST(UselessVolumes, AreOutOfViewAndThrowNoShadowIntoIt) {
    Camera camera;
    camera.resolution = {40, 40};
    camera.fov = 30;
    camera.wsPosition = {0, 0, 10};
    const PixelWindow picture{0, 0, 40, 40};
    const std::vector<VolumeBox> volumes{boxAt({0, 0, 0}), boxAt({0, 20, 0}), boxAt({20, 0, 0}), boxAt({0, 0, 30})};
    const auto useless = [&](const std::vector<Light>& lights) {
        std::vector<bool> out;
        for (const std::string& reason : culledVolumes(camera, picture, lights, volumes))
            out.push_back(!reason.empty());
        return out;
    };
    EXPECT_EQ(useless({}), (std::vector<bool>{false, true, true, true}));
    // Light from above passes the second on its way to the first.
    EXPECT_EQ(useless({distantLight({0, -1, 0})}), (std::vector<bool>{false, false, true, true}));
    EXPECT_EQ(useless({distantLight({0, 1, 0})}), (std::vector<bool>{false, true, true, true}));
    EXPECT_EQ(useless({lamp({40, 0, 0}, 1)}), (std::vector<bool>{false, true, false, true}));
    EXPECT_EQ(useless({lamp({10, 0, 0}, 1)}), (std::vector<bool>{false, true, true, true}));
    Light shadowless = distantLight({0, -1, 0});
    shadowless.shadows = false;
    EXPECT_EQ(useless({shadowless}), (std::vector<bool>{false, true, true, true}));
}

TEST(UselessVolumes, StayWhereTheyMightShadeOneOfUnknownPlace) {
    Camera camera;
    camera.resolution = {40, 40};
    camera.wsPosition = {0, 0, 10};
    const std::vector<VolumeBox> volumes{{}, boxAt({0, 0, 50})};
    EXPECT_EQ(culledVolumes(camera, {0, 0, 40, 40}, {distantLight({0, -1, 0})}, volumes)[1], "");
    EXPECT_NE(culledVolumes(camera, {0, 0, 40, 40}, {}, volumes)[1], "");
    EXPECT_EQ(culledVolumes(camera, {0, 0, 40, 40}, {}, volumes)[0], "");
}

TEST(UselessLights, AreNamedWithTheirReasons) {
    ViewScene scene = plainScene();
    scene.volumes.push_back(scene.volumes[0]);
    scene.volumes[1].wsFromIs[3] = {500, 0, 0, 1};
    scene.lights.resize(5, scene.lights[0]);
    scene.lights[1].intensity = Rgb(0);
    scene.lights[4] = lamp({60, 0, 0}, 1e4);
    scene.lights[4].kind = Light::Spot{};
    scene.lights[4].wsDirection = {1, 0, 0};
    scene.volumes[0].lights = {true, true, false, false, true};
    scene.volumes[1].lights = {false, false, false, true, false};
    const std::vector<std::string> reasons = culledLights(scene, subLights(scene));
    EXPECT_EQ(reasons[0], "");
    EXPECT_EQ(reasons[1], "it is black");
    EXPECT_EQ(reasons[2], "no volume is linked to it");
    EXPECT_EQ(reasons[3], "it lights nothing in view");
    EXPECT_EQ(reasons[4], "its beam misses every volume in view");
    for (ViewVolume& volume : scene.volumes) volume.medium.albedo = Rgb(0);
    EXPECT_EQ(culledLights(scene, subLights(scene))[0], "no volume scatters light");
    const std::vector<Effect> effects = effectsOf(scene, makePlan(scene, 2));
    EXPECT_TRUE(effectOf(effects, "lights culled").on);
    EXPECT_NE(effectOf(effects, "lights culled").reason.find("'key': no volume scatters light"), std::string::npos);
}

// Every effect of the list can be on, and then says so; and off, and then says why.
TEST(Effects, AreOnAndOffWithReasons) {
    const std::vector<std::pair<std::string, std::string>> cases{{"coloured extinction", "coloured extinction"},
                                                                 {"albedo grid", "albedo grids"},
                                                                 {"emission", "emission"},
                                                                 {"two-lobe phase", "directional scattering"},
                                                                 {"octaves", "octaves"},
                                                                 {"light linking", "light linking"},
                                                                 {"shadow linking", "shadow linking"},
                                                                 {"ambient", "ambient light"}};
    ViewScene plain = plainScene();
    const std::vector<Effect> without = effectsOf(plain, makePlan(plain, 2));
    for (const auto& [effect, name] : cases) {
        EXPECT_FALSE(effectOf(without, name).on) << name;
        EXPECT_FALSE(effectOf(without, name).reason.empty()) << name;
        const ViewScene scene = sceneWith(effect);
        EXPECT_TRUE(effectOf(effectsOf(scene, makePlan(scene, 2)), name).on) << name;
    }
}

TEST(Effects, SayWhereTheSceneBroughtThemAbout) {
    ViewScene scene = plainScene();
    scene.lights[1].shadows = false;
    scene.lines = std::make_shared<SceneLines>(std::map<std::string, std::string>{
        {"light.key", "s.toml:4:1"}, {"light.fill.shadows", "s.toml:12:1"}, {"ambient", "s.toml:20:1"}});
    const std::vector<Effect> effects = effectsOf(scene, makePlan(scene, 2));
    EXPECT_EQ(effectOf(effects, "shadows").where, std::vector<std::string>{"s.toml:12:1"});
    EXPECT_EQ(effectOf(effects, "shadows").reason, "of 'key'; not of 'fill': shadows = false");
    EXPECT_EQ(effectOf(effects, "ambient light").where, std::vector<std::string>{"s.toml:20:1"});
}

}  // namespace
}  // namespace scrim::test
