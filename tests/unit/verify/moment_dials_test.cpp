// SPDX-License-Identifier: Apache-2.0
// The dials of moments keep to the error that is allowed, and what pilots tell about it is near what the reference
// says.
#include "support/fields.h"
#include "support/verified.h"

#include <scrim/verify/moment_dials.h>

#include <gtest/gtest.h>

namespace scrim::test {
namespace {

ViewScene smokeScene() {
    ViewScene scene = orthographicScene(smokeField(12), {0.1, Rgb(0.9), {}}, 30, 40);
    scene.lights = {distantLight({1, -0.5, -0.6})};
    scene.dials.texel = 0.3;
    scene.dials.sheetThickness = 0.4;
    return scene;
}

TEST(MomentDials, KeepToTheAllowedErrorAndAreNeverFiner) {
    const ViewScene scene = smokeScene();
    const ToleranceModel model{0.015, 0.004};
    const double least = model.predict(scene.dials.texel, scene.dials.sheetThickness);
    double cells = 0;
    for (const double allowed : {0.1 * least, least, 2 * least, 4 * least, 100 * least}) {
        const Dials dials = momentDials(scene, model, allowed);
        EXPECT_GE(dials.texel, scene.dials.texel) << allowed;
        EXPECT_GE(dials.sheetThickness, scene.dials.sheetThickness) << allowed;
        EXPECT_LE(model.predict(dials.texel, dials.sheetThickness), std::max(allowed, 1.0001 * least)) << allowed;
        EXPECT_GE(dials.texel * dials.texel * dials.sheetThickness, cells) << allowed;
        cells = dials.texel * dials.texel * dials.sheetThickness;
    }
    EXPECT_GT(cells, 8 * 0.3 * 0.3 * 0.4);  // about three times as coarse each, where almost any error is allowed
}

TEST(MomentDials, AreNoCoarserThanThoseOfAnyStill) {
    ViewScene scene = smokeScene();
    scene.dials.texel = 1;
    scene.dials.sheetThickness = 5;  // as a scene may state it
    const Dials dials = momentDials(scene, {1e-6, 1e-6}, 0.03);
    EXPECT_EQ(dials.texel, 2);
    EXPECT_EQ(dials.sheetThickness, 5);
}

TEST(MomentDials, DoNotDependOnCropsOrMemory) {
    const ViewScene scene = smokeScene();
    ViewScene crop = scene;
    crop.picture = scene.region;
    crop.region = {0, 0, 3, 2};
    crop.memoryLimit = 4 << 20;
    const ToleranceModel of = momentModel(scene), ofCrop = momentModel(crop);
    EXPECT_EQ(of.texels, ofCrop.texels);
    EXPECT_EQ(of.sheets, ofCrop.sheets);
    const Dials whole = momentDials(scene, of, 0.02), part = momentDials(crop, of, 0.02);
    EXPECT_EQ(whole.texel, part.texel);
    EXPECT_EQ(whole.sheetThickness, part.sheetThickness);
}

// Pilots know errors from differences of two pictures, which may be alike or not: sqrt(3) either way. From the pilots'
// dials to those of a still, errors of order 2 fall by 7 % more than the model has them fall, and smooth smoke's do.
TEST(MomentDials, TellTheErrorOfTheReferenceFromPilots) {
    ViewScene scene = smokeScene();
    const ToleranceModel model = momentModel(scene);
    for (const double coarser : {1.0, 1.5, 2.0}) {
        scene.dials.texel = 0.3 * coarser;
        scene.dials.sheetThickness = 0.4 * coarser;
        const double told = model.predict(scene.dials.texel, scene.dials.sheetThickness);
        const double error = errorOf(scene, 200);
        EXPECT_GT(told, error / 1.75) << coarser;
        EXPECT_LT(told, error * 2.0) << coarser;
    }
}

}  // namespace
}  // namespace scrim::test
