// SPDX-License-Identifier: Apache-2.0
// Every kind of light on every medium, and either beside every other feature: together they cost little more than the
// dearer one does alone. Work is counted, not timed; `tests/tools/bench/pairs.py` times the same on larger volumes.
#include "soft_lights.h"
#include "support/fields.h"
#include "support/meshes.h"

#include <scrim/geometry/camera.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

// Nanoseconds of one core, so that work of unlike kinds can be added up. A cell and direction is 1 (a dome over 72^3
// voxels) to 3 (a point in them), one of a solve 10; the others are those of `scrim_stages`.
double costOf(const RenderWork& w) {
    return 8.0 * double(w.footprints) + 10.0 * double(w.shade.samples) + 5.0 * double(w.shade.lightLookups) +
           1.5 * double(w.lightSamples) + 3.0 * double(w.pixelSheets + w.layerSamples) + 20.0 * double(w.deepSamples) +
           2.0 * double(w.cellDirections) + 10.0 * double(w.scatterDirections) + 150.0 * double(w.solidRays) +
           2000.0 * double(w.caughtRays);
}

using Change = std::function<void(ViewScene&)>;
using Named = std::pair<std::string, Change>;

ViewVolume volumeOf(std::shared_ptr<const SparseField> field, double density, const Vec3& at, const std::string& name) {
    ViewVolume volume = orthographicScene(std::move(field), {density, Rgb(0.9), {}}, 30, 32).volumes.front();
    volume.wsFromIs[3] += glm::dvec4(at, 0);
    volume.name = name;
    return volume;
}

ViewScene smoke() {
    ViewScene scene = orthographicScene(smokeField(12), {0.15, Rgb(0.9), {}}, 40, 40);
    scene.camera.type = CameraType::perspective;
    scene.camera.wsPosition = {12, 9, 50};
    scene.camera.wsFromCamera = lookAt(scene.camera.wsPosition, Vec3(0), {0, 1, 0});
    scene.dials.texel = scene.dials.sheetThickness = 0.7;
    return scene;
}

Named only(const std::string& name, Light light) {
    light.name = "light";
    return {name, [light](ViewScene& scene) { scene.lights = {light}; }};
}

const Vec3 kBeside(22, 18, 14), kInside(2, 1.5, -2);

std::vector<Named> allLights() {
    Light wide = distantLight({-1, -1, -0.5}, 5), spot = lamp(kBeside, 3000);
    wide.kind = Light::Distant(10);
    spot.kind = Light::Spot{};
    spot.wsDirection = -glm::normalize(kBeside);
    Light sky = domeLight(0);
    return {only("sun", distantLight({-1, -1, -0.5}, 5)),
            only("wide sun", wide),
            only("sky", sky),
            only("point beside", lamp(kBeside, 3000)),
            only("point inside", lamp(kInside, 100, 0.3)),
            only("spot", spot),
            only("rectangle", areaLight(AreaShape::rectangle, kBeside, 8, 0, Rgb(8))),
            only("sphere beside", areaLight(AreaShape::sphere, kBeside, 1, 0, Rgb(600))),
            only("sphere inside", areaLight(AreaShape::sphere, kInside, 1, 0, Rgb(20)))};
}

Classified scanLook() {
    Classified look;
    look.transfer = {{0.2, Rgb(0.8), 0}, {0.6, Rgb(0.8), 1.2}};
    return look;
}

std::vector<Named> allMedia() {
    const auto medium = [](auto change) { return [change](ViewScene& scene) { change(scene.volumes[0].medium); }; };
    return {{"smoke", [](ViewScene&) {}},
            {"coloured", medium([](Medium& m) {
                 m.extinctionTint = {1, 0.8, 0.6};
             })},
            {"forward", medium([](Medium& m) { m.phase = Phase{0.7}; })},
            {"dense", medium([](Medium& m) { m.densityScale = 0.6; })},
            {"octaves", medium([](Medium& m) {
                 m.octaves = {8, 0.5, 0.5, 0.5};
             })},
            {"full", medium([](Medium& m) { m.scattering = Scattering::full; })},
            {"scan",
             [](ViewScene& scene) { scene.volumes[0].classified = std::make_shared<const Classified>(scanLook()); }}};
}

std::vector<Named> allFeatures() {
    const auto beside = [](ViewVolume volume) {
        return [volume](ViewScene& scene) { scene.volumes.push_back(volume); };
    };
    const ViewVolume small = volumeOf(smokeField(4), 0.15, {-9, 0, 9}, "small");
    ViewVolume scan = small, full = small, haze = volumeOf(boxField(Int3(-6), Int3(5)), 0.004, Vec3(0), "haze");
    scan.classified = std::make_shared<const Classified>(scanLook());
    full.medium.scattering = Scattering::full;
    haze.wsFromIs = Mat4(Mat3(8.0));
    const auto solid = [](bool shadows, bool catches) {
        return [=](ViewScene& scene) {
            scene.solids = oneSolid(ballMesh({-8, -2, 10}, 3, 16), true, shadows, catches);
            if (catches) scene.layers.push_back(Layer::shadow);
        };
    };
    return {{"haze", beside(haze)},
            {"fine ball", beside(volumeOf(smokeField(2, 0.25), 1, {-7, 2, 10}, "ball"))},
            {"scan beside", beside(scan)},
            {"full beside", beside(full)},
            {"one without shadow",
             [small](ViewScene& scene) {
                 scene.volumes.push_back(small);
                 scene.volumes[1].shadows = {false};
             }},
            {"solid", solid(true, false)},
            {"caught", solid(false, true)},
            {"layers",
             [](ViewScene& scene) {
                 scene.layers = {Layer::light, Layer::depth, Layer::volume};
             }},
            {"deep", [](ViewScene& scene) { scene.deep = ViewDeep{}; }},
            {"eye inside",
             [](ViewScene& scene) {
                 scene.camera.wsPosition = {4, 3, 7};
                 scene.camera.wsFromCamera = lookAt(scene.camera.wsPosition, Vec3(0), {0, 1, 0});
             }},
            {"per view", [](ViewScene& scene) { scene.dials.splat = SplatMode::perView; }}};
}

// Renders each scene once.
class Costs {
  public:
    double operator()(const Named& light, const Named& medium, const Named& feature) {
        const std::string name = light.first + ", " + medium.first + ", " + feature.first;
        const auto known = m_known.find(name);
        if (known != m_known.end()) return known->second;
        ViewScene scene = smoke();
        light.second(scene);
        medium.second(scene);
        feature.second(scene);
        return m_known[name] = costOf(renderScene(scene).work);
    }

  private:
    std::map<std::string, double> m_known;
};

// What costs more, and how many times as much as the dearer part.
const std::map<std::string, double>& dearer() {
    static const std::map<std::string, double> all{
        // Eight passes over the cells: one for each octave.
        {"sky, octaves, alone", 8.5},
        {"rectangle, octaves, alone", 8.5},
        // Cells as small as dense voxels need, where few points have shadow buffers in thin smoke.
        {"sphere beside, dense, alone", 12},
        {"sphere inside, dense, alone", 12},
        // Rays from the solid to each of its points, none of which has a shadow buffer.
        {"sphere inside, smoke, caught", 19}};
    return all;
}

TEST(PairsOfFeatures, CostLittleMoreThanTheDearerOne) {
    constexpr double kMost = 5;
    const std::vector<Named> lights = allLights(), media = allMedia(), features = allFeatures();
    const Named& sun = lights.front();
    const Named& plain = media.front();
    const Named none{"alone", [](ViewScene&) {}};
    Costs cost;
    const auto expectCheap = [&](const Named& light, const Named& medium, const Named& feature) {
        const double parts = std::max({cost(light, plain, none), cost(sun, medium, none), cost(sun, plain, feature)});
        const std::string name = light.first + ", " + medium.first + ", " + feature.first;
        const auto known = dearer().find(name);
        const double ratio = cost(light, medium, feature) / parts,
                     most = known == dearer().end() ? kMost : known->second;
        EXPECT_LE(ratio, most) << name;
        if (known != dearer().end()) {
            EXPECT_GT(ratio, kMost) << name << " need not be listed";
        }
    };
    for (const Named& light : lights) {
        for (const Named& medium : media) expectCheap(light, medium, none);
        for (const Named& feature : features) expectCheap(light, plain, feature);
    }
    for (const Named& medium : media)
        for (const Named& feature : features) expectCheap(sun, medium, feature);
}

}  // namespace
}  // namespace scrim::test
