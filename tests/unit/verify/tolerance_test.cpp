// SPDX-License-Identifier: Apache-2.0
#include "support/fields.h"
#include "support/verified.h"

#include <scrim/verify/tolerance.h>

#include <gtest/gtest.h>

namespace scrim::test {
namespace {

ViewScene smokeScene() {
    ViewScene scene = orthographicScene(smokeField(12), {0.1, Rgb(0.9), {}}, 30, 40);
    scene.lights = {distantLight({1, -0.5, -0.6})};
    return scene;
}

TEST(ToleranceModel, GoesThroughItsPilots) {
    std::array<Pilot, 2> pilots{Pilot{1.2, 2.4, 0.03}, Pilot{1.2, 1.2, 0.02}};
    const ToleranceModel model = fitModel(pilots);
    for (const Pilot& p : pilots) EXPECT_NEAR(model.predict(p.texel, p.thickness), p.error, 1e-12);
    EXPECT_NEAR(scaled(model, 2).predict(1.2, 1.2), 0.04, 1e-12);
}

// Noise may make thin sheets look worse than thick ones; the model still must grow in both.
TEST(ToleranceModel, GrowsInBothDialsWhateverThePilotsSay) {
    for (const double thick : {0.005, 0.02, 0.5}) {
        const ToleranceModel model = fitModel({Pilot{1, 2, thick}, Pilot{1, 1, 0.02}});
        EXPECT_NEAR(model.predict(1, 1), 0.02, 1e-12);
        EXPECT_GT(model.predict(2, 1), 1.1 * model.predict(1, 1)) << thick;
        EXPECT_GT(model.predict(1, 4), 1.1 * model.predict(1, 1)) << thick;
    }
}

TEST(ToleranceChoice, IsFinerForLessToleranceAndPredictsToStayBelow) {
    const ViewScene scene = smokeScene();
    const ToleranceModel model{0.015, 0.004};
    ToleranceChoice before = chooseDials(scene, model, 0.1);
    for (const double tolerance : {0.05, 0.02, 0.01, 0.005, 0.002}) {
        const ToleranceChoice choice = chooseDials(scene, model, tolerance);
        EXPECT_TRUE(choice.reachable);
        EXPECT_LE(choice.predicted, tolerance);
        EXPECT_LE(choice.dials.opacityCutoff, tolerance / 10);
        EXPECT_TRUE(choice.dials.texel < before.dials.texel ||
                    choice.dials.sheetThickness < before.dials.sheetThickness)
            << tolerance;
        before = choice;
    }
}

TEST(ToleranceChoice, SaysWhereItCannotBeReached) {
    const ToleranceChoice choice = chooseDials(smokeScene(), {10, 10}, 0.001);
    EXPECT_FALSE(choice.reachable);
    EXPECT_GT(choice.predicted, 0.001);
    EXPECT_LT(choice.dials.texel, 0.2);  // the finest there is
}

TEST(Tolerance, OfSmokeIsMetByWhatThePilotsChoose) {
    ViewScene scene = smokeScene();
    for (const double tolerance : {0.02, 0.007}) {
        std::array<Pilot, 2> pilots = pilotsFor(tolerance);
        runPilots(pilots, scene, scene, 64, 9);
        for (const Pilot& p : pilots) EXPECT_GT(p.error, 0);
        scene.dials = chooseDials(scene, fitModel(pilots), tolerance).dials;
        EXPECT_LT(errorOf(scene, 64), tolerance)
            << "texel " << scene.dials.texel << " sheets " << scene.dials.sheetThickness;
    }
}

}  // namespace
}  // namespace scrim::test
