// SPDX-License-Identifier: Apache-2.0
// Every light on every medium, beside every other medium: each volume receives each light once, whoever brings it.
#include "soft_lights.h"
#include "support/fields.h"

#include <scrim/engine/model/served_lights.h>
#include <scrim/engine/plan/make_plan.h>
#include <scrim/image/sky_parts.h>

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

using Named = std::pair<std::string, std::function<void(ViewVolume&)>>;

const std::vector<Named>& media() {
    static const auto classify = [](ViewVolume& volume, bool full) {
        Classified look;
        look.transfer = {{0.2, Rgb(0.9), 0}, {0.8, Rgb(0.9), 0.4}};
        volume.medium.scattering = full ? Scattering::full : Scattering::single;
        volume.classified = std::make_shared<const Classified>(look);
    };
    static const std::vector<Named> all{
        {"single", [](ViewVolume&) {}},
        {"octaves",
         [](ViewVolume& volume) {
             volume.medium.scattering = Scattering::octaves;
             volume.medium.octaves.count = 2;
         }},
        {"full", [](ViewVolume& volume) { volume.medium.scattering = Scattering::full; }},
        {"classified", [](ViewVolume& volume) { classify(volume, false); }},
    };
    return all;
}

// A blue sky with a sun in it.
Light skyWithSun() {
    constexpr int kWidth = 64, kHeight = 32;
    Image picture = emptyImage({0, 0, kWidth, kHeight});
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            for (int c = 0; c < 4; ++c) {
                const float sky[4] = {0.2f, 0.4f, 1, 1};
                picture.rgba[picture.indexOf(x, y) + std::size_t(c)] = x == 20 && y == 8 && c < 3 ? 400.0f : sky[c];
            }
    Light sky = domeLight(16);
    sky.slide.emplace();
    sky.slide->image = std::make_shared<const Texture>(picture);
    sky.slide->parts = std::make_shared<const SkyParts>(skyParts(*sky.slide->image));
    return sky;
}

std::vector<std::pair<std::string, Light>> lights() {
    Light sun = distantLight({-1, -0.7, -0.4}, 2), disk = sun, spot = lamp({-14, 9, 12}, 900);
    disk.kind = Light::Distant(8);
    disk.samples = 7;
    // Without a radius, the pixels beside the lamp would have all of the error.
    Light inside = lamp({0.3, 1.2, 0.4}, 60);
    Light::Point large;
    large.radius = 1.5;
    inside.kind = large;
    Light::Spot cone;
    cone.coneAngle = 70;
    spot.kind = cone;
    spot.wsDirection = glm::normalize(Vec3(14, -9, -12));
    return {{"sun", sun},
            {"wide sun", disk},
            {"lamp inside", inside},
            {"lamp beside", lamp({9, 9, 5}, 300)},
            {"spot", spot},
            {"rectangle", areaLight(AreaShape::rectangle, {10, 8, 9}, 3, 9, Rgb(4))},
            {"sphere", areaLight(AreaShape::sphere, {10, -8, 9}, 3, 9, Rgb(4))},
            {"dome", domeLight(16)},
            {"sky with a sun", skyWithSun()}};
}

ViewScene sceneOf(const Named& medium, const Light& light) {
    ViewScene scene = orthographicScene(
        makeField(Int3(-5), Int3(5), 1, [](const Vec3& p) { return std::max(1 - glm::dot(p, p) / 25, 0.0); }),
        {0.3, Rgb(0.9), Phase{0.2}}, 14, 16);
    scene.dials.lightError = 0.02;
    scene.volumes[0].name = medium.first;
    medium.second(scene.volumes[0]);
    scene.lights = {light};
    return scene;
}

double meanOf(const ViewScene& scene) {
    const Image image = renderScene(scene).image;
    double sum = 0;
    for (std::size_t i = 0; i < image.rgba.size(); ++i) sum += i % 4 == 3 ? 0 : double(image.rgba[i]);
    return sum;
}

// Beside others, lights may go another way, which has another error. A light that came twice, or not at all, would be
// 20 to 100 % off.
TEST(ServedLights, ReachEveryMediumOnceBesideEveryOther) {
    constexpr double kTwoWays = 0.1;
    for (const auto& [name, light] : lights())
        for (const Named& medium : media()) {
            const ViewScene alone = sceneOf(medium, light);
            const double expected = meanOf(alone);
            EXPECT_GT(expected, 0) << name << " on " << medium.first;
            for (const Named& other : media()) {
                ViewScene beside = sceneOf(other, light);
                ViewVolume& weightless = beside.volumes.emplace_back(beside.volumes[0]);
                beside.volumes[0] = alone.volumes[0];
                weightless.name = "beside";
                weightless.medium.densityScale = 1e-7;
                if (weightless.classified) {
                    Classified none = *weightless.classified;
                    for (auto& point : none.transfer) point.extinction = 0;
                    weightless.classified = std::make_shared<const Classified>(none);
                }
                EXPECT_NEAR(meanOf(beside) / expected, 1, kTwoWays)
                    << name << " on " << medium.first << " beside " << other.first;
            }
        }
}

// Skies that came in at the border of a solve lit all that was there: five and eight times the light of the sun alone.
// A light that lights nothing may still turn the sheets a little.
TEST(ServedLights, DoNotReachMediaThatAreLinkedToOthers) {
    for (const auto& [name, light] : lights())
        for (const Named& medium : media()) {
            ViewScene scene = sceneOf(medium, distantLight({-1, -0.7, -0.4}, 2));
            const double alone = meanOf(scene);
            scene.lights.push_back(light);
            scene.volumes[0].lights = {true, false};
            EXPECT_NEAR(meanOf(scene), alone, 0.02 * alone) << name << ", " << medium.first;
        }
}

// The decision itself: for each volume one server, and none where the light is not linked.
TEST(ServedLights, AreServedByOne) {
    const std::vector<Named>& all = media();
    for (const auto& [name, light] : lights())
        for (const bool linked : {true, false})
            for (const bool cells : {true, false}) {
                ViewScene scene = sceneOf(all[0], light);
                scene.volumes.push_back(sceneOf(all[2], light).volumes[0]);
                if (!linked) scene.volumes[0].lights = {false};
                const ServedLight served =
                    servedLights(scene, cells ? std::vector<int>{0} : std::vector<int>{}).front();
                const Server once = cells ? Server::cells : Server::buffers;
                EXPECT_EQ(served.volumes[0], linked ? once : Server::none) << name;
                EXPECT_EQ(served.volumes[1], light.dome() && linked ? Server::border : once) << name;
                EXPECT_EQ(served.inSweeps, !cells) << name;
                scene.volumes.erase(scene.volumes.begin());
                EXPECT_EQ(servedLights(scene).front().inSweeps, !light.dome()) << name;
            }
}

}  // namespace
}  // namespace scrim::test
