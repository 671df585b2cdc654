// SPDX-License-Identifier: Apache-2.0
// Verification must be able to fail: plans that are wrong on purpose, each in a way that a bug in culling or planning
// would have, are rendered and found out.
#include "support/fields.h"

#include <scrim/shot/assemble.h>
#include <scrim/engine/plan/make_plan.h>
#include <scrim/verify/verify.h>
#include <scrim/verify/verify_pixels.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

namespace scrim::test {
namespace {

constexpr int kPixels = 100;  // of a verification
constexpr int kSeeds = 100;

// Smoke, with a small ball beside it, under two lights that need a sweep each.
ViewScene twoVolumes() {
    ViewScene scene = orthographicScene(smokeField(14), {0.25, Rgb(0.9), {}}, 44, 56);
    const auto ball = smokeField(5);
    ViewVolume small{"ball", ball, ball->wsFromIs, Medium{0.6, Rgb(0.9), {}}};
    small.wsFromIs[3] = {15, 12, 3, 1};
    scene.volumes.push_back(small);
    scene.lights = {distantLight({1, -0.5, -0.6}, 3), distantLight({-0.4, 0.2, 1}, 2)};
    scene.dials.texel = 0.35;
    scene.dials.sheetThickness = 0.5;
    return scene;
}

struct Mutation {
    const char* name;
    std::function<void(ViewScene&, Plan&)> apply;
};

Image renderedWith(ViewScene scene, const Mutation& mutation) {
    Plan plan = makePlan(scene, 2);
    mutation.apply(scene, plan);
    return render(scene, plan).image;
}

void loseTiles(ViewScene&, Plan& plan) {
    for (GroupPlan& group : plan.groups)
        for (auto& box : group.needed.sheets) box.x1 -= 5;  // of which some hold nothing
}

void loseSheets(ViewScene&, Plan& plan) {
    for (GroupPlan& group : plan.groups) {
        std::vector<Box2<int>>& sheets = group.needed.sheets;
        for (std::size_t n = sheets.size() / 2; n < sheets.size() * 3 / 4; ++n) sheets[n] = {};
    }
}

void loseLight(ViewScene&, Plan& plan) {
    for (GroupPlan& group : plan.groups)
        std::erase_if(group.lights, [](const PlannedLight& light) { return light.light == PlanLight(1); });
}

void loseVolume(ViewScene& scene, Plan& plan) {
    scene.volumes.pop_back();
    plan = makePlan(scene, 2);
}

void addGhost(ViewScene& scene, Plan& plan) {
    ViewVolume ghost = scene.volumes.back();
    ghost.wsFromIs[3] = {-16, -14, 0, 1};
    scene.volumes.push_back(ghost);
    plan = makePlan(scene, 2);
}

class Mutations : public testing::TestWithParam<Mutation> {
  protected:
    static void SetUpTestSuite() {
        s_scene = twoVolumes();
        s_sound = render(s_scene, makePlan(s_scene, 2)).image;
        const PixelSample all = samplePixels(s_scene, s_sound, kAllPixels, 1);
        s_error = summarise(all);
        for (const VerifiedPixel& p : all.pixels) s_reference[{p.x, p.y}] = p.reference;
    }

    // As samplePixels draws and counts, from references that are evaluated once.
    static Verification verified(const Image& image, unsigned seed) {
        std::vector<VerifiedPixel> pixels;
        for (const Int2& at : verificationOrder(s_scene, image, seed)) {
            const auto known = s_reference.find({at.x, at.y});
            VerifiedPixel p{at.x, at.y, {}, {}};
            if (known != s_reference.end()) p.reference = known->second;  // else no ray meets a volume
            pixels.push_back(p);
            setRendered({&pixels.back(), 1}, image);
            if (pixels.size() % 16 == 0 && summarisedCount(pixels) >= kPixels) break;
        }
        return summarise(pixels, 0.5);
    }
    static int summarisedCount(const std::vector<VerifiedPixel>& pixels) {
        return static_cast<int>(std::count_if(pixels.begin(), pixels.end(), [](const VerifiedPixel& p) {
            return std::max(p.reference[3], p.rendered[3]) > 1e-3;
        }));
    }
    // The share of the pixels that show something in which `image` is off by more than a quarter of the mean.
    static double touched(const Image& image) {
        int covered = 0, off = 0;
        for (int y = image.window.y0; y < image.window.y1; ++y)
            for (int x = image.window.x0; x < image.window.x1; ++x) {
                const float* was = s_sound.rgba.data() + s_sound.indexOf(x, y);
                const float* is = image.rgba.data() + image.indexOf(x, y);
                if (std::max(was[3], is[3]) < 1e-3f) continue;
                ++covered;
                off += std::abs(is[1] - was[1]) > 0.25 * s_error.mean ? 1 : 0;
            }
        return double(off) / covered;
    }

    static inline ViewScene s_scene;
    static inline Image s_sound;
    static inline Verification s_error;
    static inline std::map<std::pair<int, int>, std::array<double, 4>> s_reference;
};

// A pixel that is off by a quarter of the mean adds 0.25 / sqrt(100) to the error at 100 pixels: three times the sound
// picture's, which is below 0.8 %, is passed by a single one of them. Missing all of a share of 5 % has a chance of
// 0.95^100 = 0.6 %.
TEST_P(Mutations, AreCaughtInNinetyNineOfAHundredSeeds) {
    ASSERT_LT(s_error.error, 0.008);
    const Image image = renderedWith(s_scene, GetParam());
    const double share = touched(image);
    RecordProperty("share", std::to_string(share));
    ASSERT_GE(share, 0.05);
    int caught = 0;
    for (unsigned seed = 1; seed <= kSeeds; ++seed) caught += verified(image, seed).error > 0.024 ? 1 : 0;
    EXPECT_GE(caught, 99) << "share " << share;
}

// What says that a volume is of no use may be wrong: here that a block in the middle of the view is.
TEST(WrongCulling, OfAVolumeInViewIsCaught) {
    Scene scene;
    scene.camera.resolution = {48, 48};
    scene.camera.fov = 40;
    scene.camera.wsPosition = {0, 0, 60};
    scene.lights = {distantLight({-1, -1, -1}, 3)};
    scene.dials.texel = scene.dials.sheetThickness = 0.5;
    scene.volumes.resize(2);
    scene.volumes[0].medium.densityScale = scene.volumes[1].medium.densityScale = 0.3;
    scene.volumes[1].wsFromAsset[3] = {12, 12, 0, 1};
    std::vector<VolumeFields> fields{{smokeField(12), {}, {}}, {smokeField(4), {}, {}}};
    const auto errorNow = [&] {
        const ViewScene truth = assemble(scene, fields, {}, 0, VolumesOf::scene);
        return summarise(samplePixels(truth, renderScene(assemble(scene, fields, {}, 0)).image, kPixels, 1)).error;
    };
    EXPECT_LT(errorNow(), 0.03);
    fields[1].culled = "it is out of view, says a bug";
    EXPECT_GT(errorNow(), 0.1);
}

TEST_F(Mutations, OfNothingAreNotCaught) {
    for (unsigned seed = 1; seed <= kSeeds; ++seed) EXPECT_LT(verified(s_sound, seed).error, 0.024) << seed;
}

INSTANTIATE_TEST_SUITE_P(Plans, Mutations,
                         testing::Values(Mutation{"lostTiles", loseTiles}, Mutation{"lostSheets", loseSheets},
                                         Mutation{"lostLight", loseLight}, Mutation{"lostVolume", loseVolume},
                                         Mutation{"ghost", addGhost}),
                         [](const auto& of) { return std::string(of.param.name); });

}  // namespace
}  // namespace scrim::test
