// SPDX-License-Identifier: Apache-2.0
// Where l.d changes its sign the axis of the sheets turns by a right angle and their order by the eye is reversed. What
// two sweeps of one scene may differ by is their error, whatever is in the scene; invariance/popping_test.cpp follows a
// light across in steps, with and without the cross-fade: this is about the two sides themselves.
#include "truth/stability/scenes.h"

#include <scrim/verify/reference.h>

namespace scrim::test {
namespace {

const double kPi = std::acos(-1.0);

struct Crossing {
    const char* name;
    Way way;
    bool perspective;
    double error;  // stated: largest difference of two sides over the brightest
};
void PrintTo(const Crossing& c, std::ostream* out) {
    *out << c.name;
}
class OrderFlip : public testing::TestWithParam<Crossing> {
  protected:
    // A light `degrees` past perpendicular, from the left and a little from above.
    static ViewScene scene(double degrees, double crossFade) {
        Medium medium;
        medium.densityScale = 0.35;
        medium.phase.g = 0.3;
        ViewScene scene = orthographicScene(smoothField(), medium, 20, 32);
        if (GetParam().perspective) look(scene, {0, 0, 60}, {0, 0, 0}, 20);
        const double angle = degrees * kPi / 180;
        scene.lights = {distantLight({0.9 * std::cos(angle), -std::sqrt(0.19) * std::cos(angle), std::sin(angle)}, 4)};
        scene.ambient = Rgb(0.05);
        scene.dials.crossFade = crossFade;
        take(GetParam().way, scene);
        return scene;
    }
};

// Without a cross-fade, a millionth of a degree to either side of the flip: two discretisations of one picture.
TEST_P(OrderFlip, TheTwoSidesDifferByTheStatedError) {
    const ViewScene a = scene(-1e-6, 0), b = scene(1e-6, 0);
    ASSERT_NE(makePlan(a, 1).groups[0].sameSide, makePlan(b, 1).groups[0].sameSide);
    const Image front = renderScene(a).image, back = renderScene(b).image;
    ASSERT_TRUE(sane(front) && sane(back));
    EXPECT_LT(changeOf("change", front, back), GetParam().error);
}

// With it, the same step changes nothing: shares of both sides are continuous.
TEST_P(OrderFlip, TheCrossFadeLeavesNoStep) {
    EXPECT_LT(changeOf("change", renderScene(scene(-1e-6, 2)).image, renderScene(scene(1e-6, 2)).image), 1e-5);
}

// Nor do its ends: where the other side's share reaches 0, it does so smoothly (a cubic, whose slope is 0 there: a part
// t of the fade before its end the share is 3 t^2).
TEST_P(OrderFlip, TheCrossFadeBeginsAndEndsWithoutAStep) {
    for (const double end : {-2.0, 2.0}) {
        const double inner = end * (1 - 1e-3), outer = end * (1 + 1e-3);
        ASSERT_GT(makePlan(scene(inner, 2), 1).groups.size(), 1u);
        EXPECT_LT(changeOf("change", renderScene(scene(inner, 2)).image, renderScene(scene(outer, 2)).image), 2e-3)
            << end;
    }
}

// Exactly perpendicular rounding must not choose the side: to the bit, for a light turned by whole quarters, whose
// cosine to the eye is 0 or some 1e-17.
TEST_P(OrderFlip, ExactlyPerpendicularIsAlwaysTheSameSide) {
    for (const double hair : {0.0, 1e-17, -1e-17, 1e-12, -1e-12}) {
        ViewScene s = scene(0, 0);
        s.lights[0].wsDirection = glm::normalize(Vec3(0.9, -std::sqrt(0.19), hair));
        EXPECT_TRUE(makePlan(s, 1).groups[0].sameSide) << hair;
    }
}

// Both sides lie around the truth: neither is the wrong one. Their alpha, which no light has a part in, is the same to
// the error of sheets alone.
TEST_P(OrderFlip, BothSidesAgreeWithBruteForce) {
    for (const double degrees : {-1e-6, 1e-6}) {
        const ViewScene s = scene(degrees, 0);
        const Frame frame = renderScene(s);
        const Reference reference(s);
        const double unit = brightest(frame.image);
        for (const auto& [x, y] : {std::pair{16, 16}, {12, 13}, {20, 18}, {11, 18}}) {
            const auto found = pixelOf(frame, x, y), truth = reference.pixel(x, y);
            EXPECT_NEAR(found[0], truth[0], (GetParam().way.classified ? 0.1 : 0.03) * unit)
                << degrees << " pixel " << x << "," << y;
            EXPECT_NEAR(found[3], truth[3], 0.03) << degrees << " pixel " << x << "," << y;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Ways, OrderFlip,
                         testing::Values(Crossing{"texels", kTexels, false, 0.006},
                                         Crossing{"pixels", kPixels, false, 0.006},
                                         Crossing{"perspective", kTexels, true, 0.008},
                                         Crossing{"perView", kPerView, false, 0.006},
                                         Crossing{"classified", kSurface, false, 0.04}),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace scrim::test
