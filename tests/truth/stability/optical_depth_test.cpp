// SPDX-License-Identifier: Apache-2.0
// Optical depths from 1e-12 to 1e6, in one sheet and in total, over ten thousand sheets, and in a single voxel: against
// closed forms.
#include "truth/stability/scenes.h"
#include "support/verified.h"

#include <scrim/verify/reference.h>

namespace scrim::test {
namespace {

const double kPi = std::acos(-1.0);

// A slab seen along -z, lit from the front or from behind, `voxels` thick; in all of optical depth `tau`.
ViewScene slab(const Way& way, double tau, int voxels, bool front) {
    Medium medium;
    medium.densityScale = tau / voxels;
    medium.albedo = Rgb(1);
    ViewScene scene = orthographicScene(boxField({-16, -16, 0}, {15, 15, voxels - 1}), medium, 8, 16);
    scene.lights.push_back(distantLight({0, 0, front ? -1.0 : 1.0}, 4 * kPi));
    take(way, scene);
    return scene;
}

struct Case {
    Way way;
    double tau;
    int voxels;
};
void PrintTo(const Case& c, std::ostream* out) {
    *out << c.way.name << ", tau " << c.tau << ", " << c.voxels << " voxels";
}

std::vector<Case> everyDepth() {
    std::vector<Case> cases;
    for (const Way& way : {kTexels, kPixels, kPerView})
        for (const int voxels : {1, 10})
            for (const double tau : {1e-12, 1e-9, 1e-6, 1e-3, 1.0, 30.0, 1e3, 1e6}) cases.push_back({way, tau, voxels});
    return cases;
}

class Slab : public testing::TestWithParam<Case> {};

// (1 - e^-2 tau) / 2 from the front, tau e^-tau from behind (algorithm, section 6), relative to 1e-5: tables of the
// footprints (whose weights sum to the kernel's integral to float rounding) and the exponentials. An error of tau of
// 1e-6 is one of 1e-6 tau in e^-tau.
TEST_P(Slab, HasItsClosedFormAtEveryOpticalDepth) {
    const Case& c = GetParam();
    const double tau = c.tau;
    const auto front = pixelOf(renderScene(slab(c.way, tau, c.voxels, true)), 8, 8);
    EXPECT_NEAR(front[0], -0.5 * std::expm1(-2 * tau), 1e-5 * std::min(tau, 1.0));
    EXPECT_NEAR(front[3], -std::expm1(-tau), 1e-5 * std::min(tau, 1.0));
    const auto behind = pixelOf(renderScene(slab(c.way, tau, c.voxels, false)), 8, 8);
    const double expected = tau * std::exp(-tau);
    // Floats end at 1e-38, and exponentials before that are 0. A sheet's transmittance is kept as 1 - alpha: what lies
    // behind an opaque one is off by a last bit of itself, 1.2e-7 (measured behind tau = 15: 12 % of a 3e-7th).
    const double back = 0.5 * tau * std::exp(-0.5 * tau);
    EXPECT_NEAR(behind[0], expected, 1e-5 * (1 + tau) * expected + 1.2e-7 * back + 1e-30);
    EXPECT_NEAR(behind[3], front[3], 1e-6 * front[3]);
}

INSTANTIATE_TEST_SUITE_P(Depths, Slab, testing::ValuesIn(everyDepth()));

// The same slab in `count` sheets: each adds its rounding to a running sum of tau (half a last bit of the sum, always
// to the same side while the sum keeps its exponent), and to the pixel.
struct Sheetful {
    const char* name;
    int voxels;
    double thickness;
};
void PrintTo(const Sheetful& s, std::ostream* out) {
    *out << s.name;
}
class TenThousandSheets : public testing::TestWithParam<Sheetful> {};

TEST_P(TenThousandSheets, HaveTheClosedFormOfTheWhole) {
    for (const double tau : {1e-12, 1e-3, 1.0, 20.0})
        for (const bool front : {true, false}) {
            ViewScene scene = slab(kTexels, tau, GetParam().voxels, front);
            scene.dials.sheetThickness = GetParam().thickness;
            scene.dials.opacityCutoff = 0;
            scene.volumes[0].field = boxField({-4, -4, 0}, {3, 3, GetParam().voxels - 1});
            scene.camera.height = 2;
            const Plan plan = makePlan(scene, 2);
            ASSERT_GT(plan.groups[0].sheets.count, 9999);
            const Frame frame = render(scene, plan);
            ASSERT_TRUE(sane(frame.image));
            const double expected = front ? -0.5 * std::expm1(-2 * tau) : tau * std::exp(-tau);
            const double stated = 1e4 * 6e-8 * (front ? 1 : 1 + tau) * expected;
            EXPECT_NEAR(pixelOf(frame, 8, 8)[0], expected, stated) << "tau " << tau << (front ? " front" : " behind");
            EXPECT_NEAR(pixelOf(frame, 8, 8)[3], -std::expm1(-tau), 6e-4 * -std::expm1(-tau)) << "tau " << tau;
        }
}

INSTANTIATE_TEST_SUITE_P(Of, TenThousandSheets,
                         testing::Values(Sheetful{"aVoxelEach", 10000, 1.0}, Sheetful{"aHundredthOfAVoxel", 100, 0.01}),
                         [](const auto& test) { return std::string(test.param.name); });

// Sheets of 1e6 optical depths each, one behind the other, seen from the front, where all but the first are hidden, and
// from behind, where no light arrives.
TEST(OpaqueSheets, AreAllFrontAndNoBack) {
    for (const Way& way : {kTexels, kPixels, kPerView})
        for (const double thickness : {0.25, 1.0, 4.0}) {
            ViewScene scene = slab(way, 8e6, 8, true);
            scene.dials.sheetThickness = thickness;
            const Frame frame = renderScene(scene);
            ASSERT_TRUE(sane(frame.image)) << way.name;
            EXPECT_NEAR(pixelOf(frame, 8, 8)[0], 0.5, 1e-5) << way.name << " " << thickness;
            EXPECT_EQ(pixelOf(frame, 8, 8)[3], 1) << way.name << " " << thickness;
        }
}

// One voxel alone, which hides what is behind it. Seen along -z its tent has tau0 (1 - |x|)(1 - |y|). What remains of
// texels of a sixteenth of a voxel is the bilinear look-up of opacities (h^2 / 8 of their curvature, where e^-tau bends
// most: in its corners, at most 1.5e-2).
TEST(OpaqueVoxel, HasItsClosedFormSilhouette) {
    for (const Way& way : {kTexels, kPixels, kPerView})
        for (const double tau : {1.0, 50.0, 1e6}) {
            Medium medium;
            medium.densityScale = tau;
            ViewScene scene = orthographicScene(boxField(Int3(0), Int3(0)), medium, 2.5, 40);
            take(way, scene);
            scene.dials.texel = 0.0625;
            scene.camera.wsPosition = {0, 0, 10};
            scene.ambient = Rgb(1);
            scene.dials.opacityCutoff = 0;
            const Frame frame = renderScene(scene);
            ASSERT_TRUE(sane(frame.image)) << way.name << " " << tau;
            for (int y = 0; y < 40; ++y)
                for (int x = 0; x < 40; ++x) {
                    const double px = std::abs((x + 0.5) / 16 - 1.25), py = std::abs((y + 0.5) / 16 - 1.25);
                    const double depth = tau * std::max(0.0, 1 - px) * std::max(0.0, 1 - py);
                    // Within a texel of the tent's edge an opaque voxel's opacity jumps from 0 to 1.
                    const bool edge = std::abs(px - 1) < 0.13 || std::abs(py - 1) < 0.13;
                    if (edge && tau > 1) continue;
                    EXPECT_NEAR(pixelOf(frame, x, y)[3], -std::expm1(-depth), 1.5e-2)
                        << way.name << " tau " << tau << " pixel " << x << "," << y;
                }
        }
}

// An opaque voxel in thin smoke, lit and casting its shadow, on every way. Its silhouette is as sharp as the grid
// allows: texels of a quarter of a voxel blur it (1 % measured), and a little less where pixels are shaded (0.8 %).
TEST(OpaqueVoxel, InSmokeAgreesWithBruteForce) {
    for (const Way& way : {kTexels, kPixels, kPerView}) {
        const auto field =
            makeField(Int3(-6), Int3(6), 1, [](const Vec3& is) { return is == Vec3(1, 2, 1) ? 1000.0 : 1.0; });
        Medium medium;
        medium.densityScale = 0.03;
        ViewScene scene = orthographicScene(field, medium, 16, 48);
        scene.lights = {distantLight({-0.5, -1, -0.6}, 2)};
        scene.dials.texel = scene.dials.sheetThickness = 0.25;
        take(way, scene);
        const Frame frame = renderScene(scene);
        ASSERT_TRUE(sane(frame.image)) << way.name;
        expectConvergence(scene, 60, 0.5, 0.003, way.name);
    }
}

}  // namespace
}  // namespace scrim::test
