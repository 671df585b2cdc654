// SPDX-License-Identifier: Apache-2.0
// What drawn scenes have found: each a law, in the plainest scene that once broke it.
#include "support/fields.h"
#include "support/meshes.h"
#include "support/slides.h"

#include <scrim/image/sky_parts.h>
#include <scrim/verify/verify.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

std::shared_ptr<SparseField> ball() {
    return makeField(Int3(-8), Int3(8), 1, [](const Vec3& p) { return std::max(1 - glm::dot(p, p) / 64, 0.0); });
}

ViewScene ballScene(double sigma, double albedo) {
    Medium medium;
    medium.densityScale = sigma;
    medium.albedo = Rgb(albedo);
    return orthographicScene(ball(), medium, 20, 40);
}

Light whiteDome() {
    Light dome;
    dome.name = "sky";
    dome.kind = Light::Dome();
    return dome;
}

// The largest difference between radiance and `factor` times alpha.
double farFromAlpha(const Image& image, double factor) {
    double most = 0;
    for (std::size_t i = 0; i < image.rgba.size(); i += 4)
        most = std::max(most, std::abs(double(image.rgba[i]) - factor * double(image.rgba[i + 3])));
    return most;
}

double furthest(const Image& a, const Image& b) {
    double most = 0, brightest = 0;
    for (std::size_t i = 0; i < a.rgba.size(); ++i) {
        if (!std::isfinite(a.rgba[i]) || !std::isfinite(b.rgba[i])) return std::numeric_limits<double>::infinity();
        most = std::max(most, std::abs(double(a.rgba[i]) - double(b.rgba[i])));
        brightest = std::max(brightest, double(b.rgba[i]));
    }
    return most / brightest;
}

// It was served twice: through the border of the solve, and on cells. In a white world radiance is alpha.
TEST(FoundByLaws, ASkyLightsWhatScattersFullyOnceBesideWhatScattersOnce) {
    ViewScene scene = ballScene(0.5, 1);
    scene.volumes[0].medium.scattering = Scattering::full;
    scene.lights = {whiteDome()};
    const double alone = farFromAlpha(renderScene(scene).image, 1);
    ViewVolume thin = scene.volumes[0];
    thin.medium = Medium();
    thin.medium.densityScale = 1e-9;
    scene.volumes.push_back(thin);
    const double beside = farFromAlpha(renderScene(scene).image, 1);
    EXPECT_LT(alone, 0.005);
    EXPECT_LT(beside, 0.005);  // scatter_error
}

ViewScene scan(const std::vector<Light>& lights, std::vector<bool> shadows) {
    ViewScene scene = ballScene(1, 0.9);
    Classified look;
    look.transfer = {{0.2, Rgb(1, 0.8, 0.6), 0}, {0.6, Rgb(1, 0.8, 0.6), 2}};
    scene.volumes[0].classified = std::make_shared<const Classified>(look);
    scene.lights = lights;
    scene.volumes[0].shadows = std::move(shadows);
    return scene;
}

std::vector<Light> allKinds() {
    Light spot = lamp({-14, 9, 12}, 900), box = lamp({5, 16, 9}, 1);
    Light::Spot cone;
    cone.coneAngle = 70;
    spot.kind = cone;
    spot.wsDirection = glm::normalize(Vec3(14, -9, -12));
    Light::Area area;
    area.width = area.height = 6;
    box.kind = area;
    box.wsDirection = glm::normalize(-box.wsPosition);
    box.samples = 5;
    return {distantLight({-1, -0.6, -0.7}, 2), lamp({12, 8, 9}, 600), spot, box};
}

// Rows of optical depths were never written, and shading read them.
TEST(FoundByLaws, ScansThatCastNoShadowInALightAreLitAsByOneWithoutShadows) {
    for (const Light& light : allKinds()) {
        Light open = light;
        open.shadows = false;
        const Image expected = renderScene(scan({open}, {})).image;
        const Image linked = renderScene(scan({light}, {false})).image;
        EXPECT_LT(furthest(linked, expected), 1e-5) << light.name << light.kind.index();
    }
}

TEST(FoundByLaws, ScansThatCastShadowsInSomeLightsAreTheSumOfBoth) {
    const std::vector<Light> kinds = allKinds();
    for (std::size_t i = 1; i < kinds.size(); ++i) {
        const Image both = renderScene(scan({kinds[0], kinds[i]}, {true, false})).image;
        Light open = kinds[i];
        open.shadows = false;
        const Image expected = renderScene(scan({kinds[0], open}, {})).image;
        EXPECT_LT(furthest(both, expected), 1e-5) << kinds[i].kind.index();
    }
}

// A solid still holds back a light in which the scan itself casts no shadow.
TEST(FoundByLaws, SolidsShadowScansThatCastNone) {
    ViewScene scene = scan({distantLight({0, -1, -0.2}, 2)}, {false});
    scene.solids = oneSolid(squareMesh({0, 14, 0}, {0, 1, 0}, 40), false);
    const Image image = renderScene(scene).image;
    double most = 0;
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) most = std::max(most, double(image.rgba[i]));
    EXPECT_EQ(most, 0);
}

// Directions of the sky were looked up in lobes that are narrower than the distance between them: droplets were 0.45 to
// 130 times too bright. Without shadows, all light of a white sky is scattered towards the eye.
TEST(FoundByLaws, AnUnshadowedWhiteSkyShowsTheAlbedoWhateverThePhaseFunction) {
    constexpr double kAlbedo = 0.9;
    for (const Phase& phase : {Phase{0.0}, Phase{0.6}, Phase{0.9}, Phase{0.98}, Phase{-0.8}, dropletPhase(1),
                               dropletPhase(5), dropletPhase(20), dropletPhase(50)}) {
        for (const bool perspective : {false, true}) {
            ViewScene scene = ballScene(0.3, kAlbedo);
            scene.volumes[0].medium.phase = phase;
            if (perspective) {
                scene.camera.type = CameraType::perspective;
                scene.camera.wsPosition = {14, 9, 20};
                scene.camera.wsFromCamera = lookAt(scene.camera.wsPosition, Vec3(0), {0, 1, 0});
                scene.camera.fov = 45;
            }
            Light sky = whiteDome();
            sky.shadows = false;
            scene.lights = {sky};
            EXPECT_LT(farFromAlpha(renderScene(scene).image, kAlbedo), 0.01 * kAlbedo)
                << "g " << phase.g << " " << phase.g2 << " perspective " << perspective;
        }
    }
}

// A tile of pixels went on until all of them were opaque: what a pixel showed depended on its neighbours in the tile.
TEST(FoundByLaws, CropsOfOpaqueVolumesHaveTheBitsOfTheWhole) {
    for (const ShadeMode shade : {ShadeMode::pixel, ShadeMode::texel})
        for (const int sheets : {0, 3}) {  // batches of few sheets end within blocks
            ViewScene scene = ballScene(8, 0.9);
            scene.lights = {distantLight({-1, -0.5, -0.7}, 2)};
            scene.dials.shade = shade;
            const Image whole = renderScene(scene).image;
            ViewScene part = scene;
            part.picture = scene.region;
            part.region = {5, 3, 34, 39};
            Plan plan = makePlan(part, 1);
            for (GroupPlan& group : plan.groups)
                if (sheets > 0) group.batchSheets = sheets;
            const Image crop = render(part, plan).image;
            for (int y = 3; y < 39; ++y)
                for (int x = 5; x < 34; ++x)
                    for (std::size_t c = 0; c < 4; ++c)
                        ASSERT_EQ(crop.rgba[crop.indexOf(x, y) + c], whole.rgba[whole.indexOf(x, y) + c])
                            << x << "," << y << " shade " << int(shade) << " batches of " << sheets;
        }
}

// The axis of sheets followed a crop of a picture with overscan, so that all of its pixels changed.
TEST(FoundByLaws, CropsOfPicturesWithOverscanHaveTheBitsOfTheWhole) {
    ViewScene scene = ballScene(0.5, 0.9);
    scene.camera.type = CameraType::perspective;
    scene.camera.wsPosition = {3, 4, 24};
    scene.camera.wsFromCamera = lookAt(scene.camera.wsPosition, Vec3(0), {0, 1, 0});
    scene.camera.fov = 30;
    scene.lights = {distantLight({-1, -0.5, -0.7}, 2)};
    const Int2 size = scene.camera.resolution;
    scene.region = scene.picture = {-6, -6, size.x + 6, size.y + 6};
    const Image whole = renderScene(scene).image;
    scene.region = {-6, 5, 30, size.y + 2};
    const Image crop = renderScene(scene).image;
    for (int y = scene.region.y0; y < scene.region.y1; ++y)
        for (int x = scene.region.x0; x < scene.region.x1; ++x)
            for (std::size_t c = 0; c < 4; ++c)
                ASSERT_EQ(crop.rgba[crop.indexOf(x, y) + c], whole.rgba[whole.indexOf(x, y) + c]) << x << "," << y;
}

// Suns in the picture of a sky take sweeps while the rest of it is on cells, and volumes held them back that cast no
// shadow in the sky.
TEST(FoundByLaws, VolumesThatCastNoShadowInASkyCastNoneInItsSuns) {
    ViewScene scene = ballScene(0.5, 0.9);
    Light sky = whiteDome();
    sky.shadow = ShadowMethod::cells;
    sky.slide.emplace();
    sky.slide->image = makeTexture(24, 12, [](int x, int y) { return Rgb(x == 8 && y == 3 ? 400 : 1); });
    sky.slide->parts = std::make_shared<const SkyParts>(skyParts(*sky.slide->image));
    ASSERT_EQ(sky.slide->parts->suns.size(), 1u);
    ViewScene open = scene;
    scene.lights = {sky};
    scene.volumes[0].shadows = {false};
    sky.shadows = false;
    open.lights = {sky};
    EXPECT_LT(furthest(renderScene(scene).image, renderScene(open).image), 1e-5);
}

// Solids blocked skies in which nothing casts a shadow.
TEST(FoundByLaws, SolidsBlockNoSkyWithoutShadows) {
    ViewScene scene = ballScene(0.5, 0.9);
    Light open = whiteDome();
    open.shadow = ShadowMethod::cells;
    open.shadows = false;
    scene.lights = {open};
    const Image without = renderScene(scene).image;
    ViewScene solid = scene;
    solid.solids = oneSolid(squareMesh({0, -4, 0}, {0, 1, 0}, 40), false);
    EXPECT_LT(furthest(renderScene(solid).image, without), 1e-5);
    // The volume casts no shadow in either light, so that solids alone tell them apart.
    Light blocked = open;
    blocked.shadows = true;
    solid.lights = {blocked};
    solid.volumes[0].shadows = {false};
    const Image dark = renderScene(solid).image;
    solid.lights = {blocked, open};
    solid.volumes[0].shadows = {false, true};
    Image sum = without;
    for (std::size_t i = 0; i < sum.rgba.size(); ++i)
        if (i % 4 != 3) sum.rgba[i] += dark.rgba[i];
    EXPECT_LT(furthest(renderScene(solid).image, sum), 1e-4);
    EXPECT_GT(furthest(dark, without), 0.1);
}

// A box behind smoke of a narrow phase function is seen through it with its edges; sub-lights showed as dots.
TEST(FoundByLaws, NarrowLobesShowWideLightsAsBruteForceDoes) {
    Light box = lamp({2, 3, -24}, 1);
    Light::Area area;
    area.width = area.height = 14;
    box.kind = area;
    box.wsDirection = glm::normalize(-box.wsPosition);
    for (const Light& light : {whiteDome(), box})
        for (const double g : {0.8, 0.95}) {
            ViewScene scene = ballScene(0.25, 0.9);
            scene.volumes[0].medium.phase.g = g;
            scene.lights = {light};
            const Image image = renderScene(scene).image;
            const Verification verified = summarise(samplePixels(scene, image, 60, 3));
            // A few rays find a sky's light in a peak. Points of the box blur its edges, more so in a narrower lobe, of
            // which a warning tells (PromisedDials::beyond). 40 and 100 % before.
            EXPECT_LT(verified.error, light.dome() ? 0.08 : 0.01 / (1 - g))
                << "g " << g << " light " << light.kind.index();
        }
}

// Cells were as fine as the densest volume needs, not the sum of those that overlap.
TEST(FoundByLaws, TwoHalvesAroundALampHaveTheCellsOfTheWhole) {
    ViewScene scene = ballScene(0.7, 0.9);
    scene.lights = {lamp({0.3, 0.2, 0.1}, 50)};
    ViewScene halves = scene;
    halves.volumes[0].medium.densityScale *= 0.5;
    halves.volumes.push_back(halves.volumes[0]);
    ASSERT_EQ(makePlan(halves, 1).cellLights.edge(0), makePlan(scene, 1).cellLights.edge(0));
    EXPECT_LT(furthest(renderScene(halves).image, renderScene(scene).image), 1e-4);
}

}  // namespace
}  // namespace scrim::test
