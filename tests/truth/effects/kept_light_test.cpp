// SPDX-License-Identifier: Apache-2.0
// Light on cells that renders share which differ in the camera alone.
#include "soft_lights.h"
#include "support/fields.h"

#include <scrim/engine/kept_light.h>
#include <scrim/engine/plan/make_plan.h>
#include <scrim/engine/shared_light.h>
#include <scrim/engine/sweep.h>

#include <gtest/gtest.h>

#include <cmath>

namespace scrim::test {
namespace {

// A ball of smoke under a sky, seen from a place beside the axis.
ViewScene underSky(double aside, Scattering scattering) {
    Medium medium{0.5, Rgb(0.9), {}};
    medium.scattering = scattering;
    static const auto field = smokeField(8);
    ViewScene scene = orthographicScene(field, medium, 20, 24);
    scene.camera.type = CameraType::perspective;
    scene.camera.wsPosition.x += aside;
    scene.lights = {domeLight(24), distantLight({-1, -0.6, -0.5}, 3)};
    return scene;
}

bool serves(const ViewScene& a, const ViewScene& b) {
    return lightServes(a, makePlan(a, 1), b, makePlan(b, 1));
}

TEST(KeptLight, GivesOtherCamerasTheBitsOfTheirOwn) {
    for (const Scattering scattering : {Scattering::single, Scattering::octaves, Scattering::full}) {
        const ViewScene first = underSky(0, scattering), second = underSky(3, scattering);
        const Plan plan = makePlan(first, 2), secondPlan = makePlan(second, 2);
        ASSERT_TRUE(lightServes(first, plan, second, secondPlan));
        const KeptLight kept = keepLight(first, plan);
        ASSERT_FALSE(kept.light.empty());
        const Frame own = render(second, secondPlan), shared = render(second, secondPlan, {}, {}, &kept);
        EXPECT_EQ(own.image.rgba, shared.image.rgba);
        EXPECT_EQ(shared.work.cellDirections + kept.work.cellDirections, own.work.cellDirections);
        EXPECT_EQ(shared.work.cellDirections, 0u);
        EXPECT_EQ(kept.work.scatterSweeps > 0, scattering == Scattering::full);
        Frame accounted = shared;
        account(kept, accounted);
        EXPECT_EQ(accounted.work.scatterSweeps, own.work.scatterSweeps);
        EXPECT_EQ(accounted.scatterError, own.scatterError);
    }
}

TEST(KeptLight, ServesOnlyWhatIsTheSame) {
    const ViewScene scene = underSky(0, Scattering::single);
    const auto servesWith = [&](const auto& change) {
        ViewScene other = scene;
        change(other);
        return serves(scene, other);
    };
    EXPECT_TRUE(servesWith([](ViewScene&) {}));
    EXPECT_FALSE(servesWith([](ViewScene& s) { s.lights[1].wsDirection = {0, -1, 0}; }));
    EXPECT_FALSE(servesWith([](ViewScene& s) { s.lights[0].intensity *= 2.0; }));
    EXPECT_FALSE(servesWith([](ViewScene& s) { s.volumes[0].wsFromIs[3].x += 0.1; }));
    EXPECT_FALSE(servesWith([](ViewScene& s) { s.volumes[0].field = smokeField(8); }));
    EXPECT_FALSE(servesWith([](ViewScene& s) { s.volumes[0].medium.densityScale *= 2; }));
    EXPECT_FALSE(servesWith([](ViewScene& s) { s.volumes[0].shadows = {false, true}; }));
    EXPECT_FALSE(servesWith([](ViewScene& s) { s.volumes.push_back(s.volumes[0]); }));
    EXPECT_FALSE(servesWith([](ViewScene& s) { s.dials.lightCell = 2; }));
}

// Pilots of a lens, and those with thinner sheets, ask again and again.
TEST(SharedLight, IsComputedOnceForAllItServes) {
    const ViewScene fine = underSky(0, Scattering::single), aside = underSky(3, Scattering::single);
    ViewScene thick = fine, darker = fine;
    thick.dials.texel *= 1.5;
    thick.dials.sheetThickness *= 2;
    darker.lights[0].intensity *= 0.5;
    const Plan plan = makePlan(thick, 1), finePlan = makePlan(fine, 1);
    SharedLight light(thick, plan);
    EXPECT_EQ(light.servedTo(darker, makePlan(darker, 1)), nullptr);
    EXPECT_FALSE(light.kept());
    const KeptLight* served = light.servedTo(aside, makePlan(aside, 1));
    ASSERT_NE(served, nullptr);
    EXPECT_EQ(light.servedTo(fine, finePlan), served);
    const std::vector<float> shared = render(fine, finePlan, {}, {}, served).image.rgba,
                             own = render(fine, finePlan).image.rgba;
    ASSERT_EQ(shared.size(), own.size());
    for (std::size_t i = 0; i < own.size(); ++i) ASSERT_NEAR(shared[i], own[i], 1e-4) << i;
}

// The eye is 40 from the ball; a lobe of g = 0.9 is 0.1 wide, of which a tenth, 0.01, is 0.32 there.
TEST(KeptLight, OfNarrowLobesServesEyesThatAreNear) {
    const auto of = [](double aside) {
        ViewScene scene = underSky(aside, Scattering::single);
        scene.volumes[0].medium.phase.g = 0.9;
        return scene;
    };
    EXPECT_TRUE(serves(of(0), of(0.2)));
    EXPECT_FALSE(serves(of(0), of(0.5)));
    EXPECT_FALSE(serves(of(0), of(100)));
}

}  // namespace
}  // namespace scrim::test
