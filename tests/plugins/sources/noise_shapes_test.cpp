// SPDX-License-Identifier: Apache-2.0
// The shapes of `noise` that are no smoke; those that are, and their repeatability, are tested with the loader.
#include "plugins/sources/generated.h"

namespace scrim::test {
namespace {

class Noise : public BuiltSource {};

TEST_F(Noise, BoxWithoutTurbulenceIsEvenHazeInTiles) {
    const SparseField f = make("noise", {{"shape", "box"},
                                         {"turbulence", "0"},
                                         {"softness", "0.001"},
                                         {"size", "4"},
                                         {"density", "0.25"},
                                         {"proportions", "2, 1, 1"},
                                         {"resolution", "64"}});
    EXPECT_NEAR(mass(f), 0.25 * 4 * 2 * 2, 1e-9);
    EXPECT_EQ(f.blockCount(), 0u);
    for (const ConstantTile& t : f.tiles) EXPECT_EQ(t.value, 0.25f);
}

TEST_F(Noise, BoxFadesTowardsItsFaces) {
    const SparseField f =
        make("noise", {{"shape", "box"}, {"turbulence", "0"}, {"softness", "0.5"}, {"resolution", "64"}});
    // Half an edge is 1: smoothstep over 0.5 from the face at 1.
    EXPECT_EQ(valueAt(f, Vec3(0.45, 0, 0)), 1);
    const double x = 0.75 + 1.0 / 64, t = (1 - x) / 0.5;
    EXPECT_NEAR(valueAt(f, Vec3(x, 0, 0)), t * t * (3 - 2 * t), 1e-6);
    EXPECT_LT(valueAt(f, Vec3(0.99, 0, 0)), 0.01);
}

TEST_F(Noise, BoxWithTurbulenceIsThinnedNotThickened) {
    const SparseField f = make("noise", {{"shape", "box"}, {"density", "2"}, {"resolution", "48"}});
    EXPECT_LE(f.maxValue, 2);
    EXPECT_LT(mass(f), 2 * 8 * 0.8);
    EXPECT_GT(mass(f), 2 * 8 * 0.2);
}

TEST_F(Noise, HypertextureWithoutTurbulenceIsPerlinsSoftBall) {
    const SparseField f = make(
        "noise",
        {{"shape", "hypertexture"}, {"turbulence", "0"}, {"softness", "0.5"}, {"density", "3"}, {"resolution", "96"}});
    // Outer radius 0.48 of the size of 2, inner one half of that.
    const double outer = 0.96, inner = 0.48, step = 2.0 / 96;
    for (int i = 0; i < 48; i += 3) {
        const Vec3 p = step * (Vec3(i, 0, 0) + 0.5);
        const double r2 = p.x * p.x + p.y * p.y + p.z * p.z;
        const double expected = 3 * std::clamp((outer * outer - r2) / (outer * outer - inner * inner), 0.0, 1.0);
        EXPECT_NEAR(valueAt(f, p), expected, 1e-5) << i;
    }
}

TEST_F(Noise, HypertextureStaysInItsBall) {
    const auto run = [](const char* turbulence) {
        return make("noise", {{"shape", "hypertexture"}, {"turbulence", turbulence}, {"resolution", "64"}});
    };
    const SparseField smooth = run("0"), rough = run("0.8");
    EXPECT_LT(mass(rough), mass(smooth));
    forVoxels(rough, [](const Int3& p, float v) {
        EXPECT_LE(v, 1);
        const Vec3 c = (Vec3(p) + 0.5) / 32.0;
        EXPECT_LT(c.x * c.x + c.y * c.y + c.z * c.z, 0.96 * 0.96);
    });
}

}  // namespace
}  // namespace scrim::test
