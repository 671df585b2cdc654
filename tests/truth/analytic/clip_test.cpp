// SPDX-License-Identifier: Apache-2.0
// Volumes that are clipped: classified ones, which are cut where rays see them, and media, whose voxels are.
#include "support/verified.h"

#include <scrim/shot/shaded_field.h>

#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

const double kPi = std::acos(-1.0);

// What remains where dot(outwards, p) <= d.
HalfSpace below(const Vec3& outwards, double d) {
    const double length = glm::length(outwards);
    return {-outwards / length, d / length};
}

// A block that is alike all through, from z = -6.5 to 6.5, seen along z.
ViewScene block(double extinction, std::vector<HalfSpace> clip) {
    Classified look;
    look.transfer = {{0.5, Rgb(1), 0}, {0.5, Rgb(1), extinction}, {1, Rgb(1), extinction}};
    look.ambient = look.specular = 0;
    look.diffuse = 1;
    ViewScene scene = orthographicScene(boxField({-24, -24, -6}, {24, 24, 6}), {}, 16, 16);
    scene.volumes[0].classified = std::make_shared<const Classified>(look);
    scene.volumes[0].wsClip = std::move(clip);
    return scene;
}

TEST(Clip, AClassifiedVolumeIsAsDeepAsThePlaneLeavesItWhereverThatLiesInAVoxel) {
    constexpr double kExtinction = 0.1;
    const double whole = pixelOf(renderScene(block(kExtinction, {})), 8, 8)[3];
    // The block's own faces are steps within voxels, as in the picture without a clip.
    const double excess = -std::log(1 - whole) - kExtinction * 13;
    ASSERT_LT(std::abs(excess), 0.01 * 1.3);
    for (const double d : {-2.0, -0.37, 0.0, 0.5, 0.81, 3.25}) {
        ViewScene scene = block(kExtinction, {below({0, 0, 1}, d)});
        for (const double thickness : {0.3, 1.0, 2.0}) {
            scene.dials.sheetThickness = thickness;
            const double depth = -std::log(1 - pixelOf(renderScene(scene), 8, 8)[3]);
            // The cut itself is exact; what is left of the block's other face is at most what both had.
            EXPECT_NEAR(depth, kExtinction * (d + 6.5), std::abs(excess) + 0.02 * thickness * kExtinction) << d;
        }
    }
}

TEST(Clip, ASlantedCutIsNoStair) {
    constexpr double kExtinction = 0.1;
    const Vec3 outwards(1, 0, 2);  // z = (d - x) / 2 on the plane
    ViewScene scene = block(kExtinction, {below(outwards, 1.3)});
    const Frame frame = renderScene(scene);
    for (int x = 2; x < 14; ++x) {
        const double wsX = x + 0.5 - 8, depth = -std::log(1 - pixelOf(frame, x, 8)[3]);
        // A hundredth of a voxel; a stair would be off by up to half a voxel.
        EXPECT_NEAR(depth, kExtinction * ((1.3 - wsX) / 2 + 6.5), 0.02 * kExtinction) << x;
    }
}

TEST(Clip, ABoxAndAPlaneLeaveWhatIsInBoth) {
    constexpr double kExtinction = 0.1;
    ViewScene scene = block(kExtinction, {{{0, 0, 1}, 2.25}, {{0, 0, -1}, 4.5}, {{1, 0, 0}, 3}, below({0, 0, 1}, 0.7)});
    const Frame frame = renderScene(scene);
    EXPECT_NEAR(-std::log(1 - pixelOf(frame, 10, 8)[3]), kExtinction * (0.7 + 2.25), 1e-4);
    EXPECT_EQ(pixelOf(frame, 3, 8)[3], 0);
}

TEST(Clip, ACutFaceIsLitAsASurfaceThatFacesOutwards) {
    for (const double degrees : {0.0, 50.0}) {
        const double angle = degrees * kPi / 180;
        ViewScene scene = block(20, {below({0, 0, 1}, 0.4)});
        scene.lights.push_back(distantLight({std::sin(angle), 0, -std::cos(angle)}, kPi));
        // Within the matter: integral of sigma e^(-sigma t (1 + 1 / cos)) dt. Without the plane's normal matter that is
        // alike all through would be lit from all sides alike: 1.6 times as much at 50 degrees.
        const double expected = std::cos(angle) / (1 + 1 / std::cos(angle));
        EXPECT_NEAR(pixelOf(renderScene(scene), 8, 8)[0], expected, 0.08 * expected) << degrees;
    }
}

TEST(Clip, ShadowsEndAtTheCut) {
    // Light along x meets half of the block: what is left of it lets e^-tau through to the far side.
    ViewScene scene = block(0.02, {below({-1, 0, 0}, 3)});  // from x = -3 on
    scene.lights.push_back(distantLight({1, 0, 0}, kPi));
    ViewScene open = scene;
    open.lights[0].shadows = false;
    const Frame shadowed = renderScene(scene), lit = renderScene(open);
    for (const int x : {8, 11, 14}) {
        const double way = x + 0.5 - 8 + 3;
        EXPECT_NEAR(pixelOf(shadowed, x, 8)[0] / pixelOf(lit, x, 8)[0], std::exp(-0.02 * way), 0.01) << x;
    }
}

TEST(Clip, AgreesWithBruteForce) {
    Classified look;
    look.transfer = {{0.15, Rgb(0.3, 0.5, 1), 0}, {0.3, Rgb(0.3, 0.5, 1), 0.2}, {0.6, Rgb(1, 0.6, 0.3), 2}};
    ViewScene scene = orthographicScene(smokeField(24), {}, 60, 96);
    scene.volumes[0].classified = std::make_shared<const Classified>(look);
    scene.volumes[0].wsClip = {below({0.3, 0.2, 1}, 2.7), below({-1, 0, 0}, 9.1)};
    scene.ambient = Rgb(0.3);
    scene.lights.push_back(distantLight({1, -1, -0.6}, 3));
    expectConvergence(scene, 200, 1, 0.06);  // surfaces, and the edges of cuts
}

TEST(Clip, AMediumKeepsTheMassThatThePlaneLeaves) {
    const auto field = boxField({-4, -4, -6}, {4, 4, 6}, 0.5);
    for (const double d : {-1.1, 0.0, 0.3, 0.25, 2.9}) {
        const FieldPointer cut = clippedField(field, {below({0, 0, 1}, d)});
        double sum = 0;
        for (std::size_t b = 0; b < cut->blockCount(); ++b)
            for (int z = 0; z < kBlockEdge; ++z)
                if (cut->blockOrigins[b].x == 0 && cut->blockOrigins[b].y == 0)
                    sum += double(cut->block(b)[blockOffset(1, 1, z)]);
        EXPECT_NEAR(0.5 * sum, d + 3.25, 1e-6) << d;  // cells reach from -3.25 to 3.25
    }
    EXPECT_TRUE(clippedField(field, {below({0, 0, 1}, -3.3)})->empty());
}

}  // namespace
}  // namespace scrim::test
