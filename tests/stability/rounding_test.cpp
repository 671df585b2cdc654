// SPDX-License-Identifier: Apache-2.0
// How much of a picture's error is rounding: the engine, which counts in floats from the sheets on, against a twin that
// does the same in double (support/double_twin.h).
//
// What this claims: sums of footprints, sharpening, shadow buffers, exponentials, look-ups between texels and the
// composite, of scenes with parallel rays. What it does not: the choices of plan and table, which both share (positions
// are double up to there), and the method's own error, which is a thousand times larger.
#include "stability/scenes.h"
#include "support/double_twin.h"

namespace scrim::test {
namespace {

struct Budget {
    double largest = 0, mean = 0;  // difference of a channel, over the brightest of its kind (colour or alpha)
    int sheets = 0;
};

Budget budgetOf(ViewScene scene) {
    scene.dials.shade = ShadeMode::texel;
    scene.dials.opacityCutoff = 0;
    const Plan plan = makePlan(scene, 2);
    const Image image = render(scene, plan).image;
    const auto twin = renderInDouble(scene, plan);
    double unit[2] = {0, 0};
    for (const auto& pixel : twin)
        for (std::size_t c = 0; c < 4; ++c) unit[c / 3] = std::max(unit[c / 3], pixel[c]);
    Budget budget;
    for (std::size_t i = 0; i < image.rgba.size(); ++i) {
        const double difference = std::abs(image.rgba[i] - twin[i / 4][i % 4]) / unit[i % 4 / 3];
        EXPECT_FALSE(std::isnan(difference)) << "pixel " << i / 4;
        budget.largest = std::max(budget.largest, difference);
        budget.mean += difference / static_cast<double>(image.rgba.size());
    }
    for (const GroupPlan& group : plan.groups) budget.sheets = std::max(budget.sheets, group.sheets.count);
    return budget;
}

ViewScene parallelScene(std::shared_ptr<const SparseField> field, double extinction, const std::vector<Vec3>& lights) {
    Medium medium;
    medium.densityScale = extinction;
    medium.phase.g = 0.3;
    ViewScene scene = orthographicScene(std::move(field), medium, 24, 32);
    scene.camera.wsPosition = {13, 9, 60};
    scene.camera.wsFromCamera = lookAt(scene.camera.wsPosition, Vec3(0.3, 0.1, 0), {0, 1, 0});
    for (const Vec3& direction : lights) scene.lights.push_back(distantLight(direction, 3));
    scene.ambient = Rgb(0.05);
    return scene;
}

struct Lit {
    const char* name;
    std::vector<Vec3> lights;
};
void PrintTo(const Lit& lit, std::ostream* out) {
    *out << lit.name;
}
class Rounding : public testing::TestWithParam<Lit> {};

// Half a last bit is 6e-8. Some fifty sheets add up to some of them; a voxel's place in its block is a float, too, and its
// weight changes by up to a whole over a voxel: 1e-6 of a texel is 1e-6 of the brightest. From faint to opaque; where a
// shadow buffer falls from tau = 100 to 0 within a cell, what sharpens it leaves half a last bit of the hundred.
TEST_P(Rounding, IsAMillionthOfTheBrightest) {
    for (const auto& field : {smoothField(), smokeField(9)})
        for (const double extinction : {1e-6, 0.03, 0.3, 3.0, 100.0}) {
            const Budget budget = budgetOf(parallelScene(field, extinction, GetParam().lights));
            RecordProperty("largestAt" + std::to_string(extinction), std::to_string(budget.largest * 1e6));
            EXPECT_LT(budget.largest, extinction < 100 ? 3e-6 : 1e-5) << "extinction " << extinction << ", " << budget.sheets << " sheets";
            EXPECT_LT(budget.mean, 2e-7) << "extinction " << extinction;
        }
}

INSTANTIATE_TEST_SUITE_P(Lights, Rounding,
                         testing::Values(Lit{"inFront", {{-1, -0.6, -0.7}}}, Lit{"behind", {{0.5, -0.6, 1.1}}},
                                         Lit{"along", {lookAt({13, 9, 60}, {0.3, 0.1, 0}, {0, 1, 0})[2] * -1.0}},
                                         Lit{"fading", {{1, 0, -13.0 / 60}}},
                                         Lit{"allRound",
                                             {{-1, -0.6, -0.7}, {0.5, -0.6, 1.1}, {1, 0.2, -0.1}, {0, 1, 0.4}}}),
                         [](const auto& test) { return std::string(test.param.name); });

// Sums over n sheets of 1/n the thickness: rounding grows at most as n does (it is biased where equal terms are added to
// a sum of one exponent), from one thickness to a hundredth.
TEST(RoundingOfManySheets, GrowsNoFasterThanTheirNumber) {
    double first = 0;
    int firstSheets = 1;
    for (const double thickness : {1.0, 0.1, 0.01}) {
        ViewScene scene = parallelScene(smoothField(), 0.3, {{-1, -0.6, -0.7}});
        scene.camera.resolution = {16, 16};
        scene.region = {0, 0, 16, 16};
        scene.dials.sheetThickness = thickness;
        const Budget budget = budgetOf(scene);
        RecordProperty("largestWith" + std::to_string(budget.sheets), std::to_string(budget.largest * 1e6));
        if (first == 0) {
            first = std::max(budget.largest, 1e-7);
            firstSheets = budget.sheets;
        }
        EXPECT_LT(budget.largest, 2 * first * budget.sheets / firstSheets) << budget.sheets << " sheets";
    }
}

}  // namespace
}  // namespace scrim::test
