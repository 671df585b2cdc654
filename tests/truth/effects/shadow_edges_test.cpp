// SPDX-License-Identifier: Apache-2.0
// Light through sharp edges: beams through holes in solids, and slides with hard borders. Closed forms, and the
// reference, which finds edges by itself.
#include "scenes.h"
#include "support/meshes.h"
#include "support/slides.h"
#include "support/verified.h"

#include <scrim/engine/sweep.h>
#include <scrim/verify/reference.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace scrim::test {
namespace {

const double kPi = std::acos(-1.0);
constexpr double kSigma = 1e-5, kDepth = 6.13;

// Thin haze of voxels of 1 in a room, 8 pixels a voxel, seen along -z. The sun shines through a window in the wall at
// x = -12 that is 6 high and 6.13 deep: where the beam passes a pixel, it is as deep.
ViewScene roomWithWindow(int depth = 10) {
    Medium medium;
    medium.densityScale = kSigma;
    medium.albedo = Rgb(1);
    ViewScene scene = orthographicScene(boxField({-40, -40, -depth}, {39, 39, depth - 1}), medium, 20, 160);
    scene.dials.texel = 1;
    scene.dials.sheetThickness = 1.3;
    scene.lights = {distantLight({1, 0, -0.8}, 1)};
    const Vec3 lower(-12, -30, -30), upper(60, 30, 30);
    const auto part = [&](double y, double z) { return Vec2((y + 30) / 60, (z + 30) / 60); };
    scene.solids = oneSolid(roomMesh(lower, upper, 0, part(-3, 7), part(3, 7 + kDepth)), false);
    return scene;
}
constexpr double kBeam = kSigma * kDepth / (4 * 3.14159265358979);

TEST(Reference, FindsTheEdgesOfABeam) {
    const ViewScene scene = roomWithWindow();
    const Reference reference(scene);
    // Edges are found to 2^-12 of an eighth of a voxel; what is left is the change of a thin medium's light on its way.
    for (int x = 48; x < 120; x += 5) EXPECT_NEAR(reference.pixel(x, 80)[0] / kBeam, 1, 1e-3) << x;
}

// A ray of the light's raster stands for 1/16 of a cell of a voxel, and a point of a path for 1/8. An edge is therefore
// placed to 3/32 of a cell, which the eye's ray crosses in 1.15 voxels: two edges are off by at most 0.22 of 6.13.
TEST(ShadowOfASolid, OfAWindowIsABeamWithStraightEdges) {
    const Frame frame = renderScene(roomWithWindow());
    double squares = 0;
    int count = 0;
    for (int y = 40; y < 120; ++y) {
        const double height = std::abs((79.5 - y) / 8);
        if (std::abs(height - 3) < 3.0 / 32) continue;
        for (int x = 48; x < 120; ++x) {
            const double off = pixelOf(frame, x, y)[0] / kBeam - (height < 3 ? 1 : 0);
            ASSERT_LE(std::abs(off), 0.22 / kDepth) << x << ", " << y;
            squares += off * off;
            ++count;
        }
    }
    EXPECT_LE(std::sqrt(squares / count), 0.22 / kDepth / std::sqrt(3.0)) << "errors are spread evenly, or less";
}

// Bars of two voxels, two voxels apart, before haze of some depth, at the dials that `standard` has for such a scene.
TEST(ShadowOfASolid, OfALatticeKeepsThePromise) {
    ViewScene scene = roomWithWindow(40);
    scene.volumes[0].medium.densityScale = 0.01;
    scene.dials.sheetThickness = 1.5;
    auto bars = std::make_shared<TriangleMesh>();
    for (int i = 0; i < 32; ++i) {
        const auto first = static_cast<std::uint32_t>(bars->points.size());
        const double z = -50 + 4.1 * i;
        for (const Vec2& at : {Vec2(-20, 0), Vec2(20, 0), Vec2(20, 2), Vec2(-20, 2)})
            bars->points.push_back({-12, at.x, z + at.y});
        bars->triangles.push_back({first, first + 1, first + 2});
        bars->triangles.push_back({first, first + 2, first + 3});
    }
    for (const bool holdout : {false, true}) {
        scene.solids = oneSolid(bars, holdout);
        EXPECT_LE(errorOf(scene, 300), 0.01) << holdout;
    }
}

TEST(SlideWithHardBorders, KeepsThePromise) {
    ViewScene scene = roomWithWindow(40);
    scene.solids = nullptr;
    scene.volumes[0].medium.densityScale = 0.01;
    const auto squares =
        makeTexture(256, 256, [](int x, int y) { return Rgb(x / 32 % 2 == 0 && y / 32 % 2 == 0 ? 1 : 0); });
    for (const Vec3& from : {Vec3(-60, 8, 12), Vec3(-40, -45, 50)}) {
        scene.lights = {projector(from, 40, squares)};
        EXPECT_LE(errorOf(scene, 300), 0.01) << from.y;
    }
}

}  // namespace
}  // namespace scrim::test
