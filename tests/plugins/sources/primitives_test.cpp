// SPDX-License-Identifier: Apache-2.0
#include "plugins/sources/generated.h"

#include <cstring>

namespace scrim::test {
namespace {

const double kPi = std::acos(-1.0);

class Primitives : public BuiltSource {
  protected:
    static SparseField shapes(const std::string& text, Parameters more = {}) {
        more.insert(more.begin(), {"shapes", text});
        return make("primitives", more);
    }
    static double massOf(const std::string& text, const std::string& voxel = "0.05") {
        return mass(shapes(text, {{"voxel", voxel}}));
    }
};

// The ramp is symmetric about the surface, so a flat one keeps its mass; sampling at voxels and the curvature within
// the ramp leave errors of second order in the voxel over the extent, here about (0.05 / 1)^2 and less.
TEST_F(Primitives, HaveTheVolumesOfTheirSolids) {
    EXPECT_NEAR(massOf("box size=1,2,3"), 6, 6e-3);
    EXPECT_NEAR(massOf("sphere radius=1"), 4 * kPi / 3, 4e-3 * 4 * kPi / 3);
    EXPECT_NEAR(massOf("cylinder from=0,-1,0 to=0,1,0 radius=0.7"), 2 * kPi * 0.49, 4e-3 * 2 * kPi * 0.49);
    EXPECT_NEAR(massOf("capsule from=-1,0,0 to=1,0,0 radius=0.5"), kPi * 0.5 + kPi / 6, 0.01);
    EXPECT_NEAR(massOf("torus radius=1 tube=0.4"), 2 * kPi * kPi * 0.16, 4e-3 * 2 * kPi * kPi * 0.16);
    EXPECT_NEAR(massOf("plane size=2,3 thickness=0.5"), 3, 3e-3);
    EXPECT_NEAR(massOf("ellipsoid size=2,1,1.4"), kPi / 6 * 2.8, 6e-3 * kPi / 6 * 2.8);
    // A rounded edge along y leaves out (1 - pi / 4) r^2 of its square, those along x and z too.
    EXPECT_LT(massOf("box size=1,2,3 round=0.2"), 6 - 0.04 * (1 - kPi / 4) * 4 * 5);
}

TEST_F(Primitives, KeepTheirVolumeWhenTurned) {
    EXPECT_NEAR(massOf("box size=1,2,3 rotate=20,35,-60 center=0.3,0.2,0.1"), 6, 6e-3);
    EXPECT_NEAR(massOf("cylinder from=-0.5,-1,0.2 to=0.7,1,-0.3 radius=0.7"), kPi * 0.49 * std::sqrt(1.44 + 4 + 0.25),
                0.02);
    EXPECT_NEAR(massOf("torus radius=1 tube=0.4 axis=1,2,3 rotate=10,0,0"), 2 * kPi * kPi * 0.16, 0.02);
}

TEST_F(Primitives, EdgesAreLinearRampsAboutTheSurface) {
    // Voxel centres along x lie at 0.05, 0.15, ...; the face at 1 is the middle of a ramp from 0.8 to 1.2.
    const SparseField f = shapes("box size=2,2,2 density=3", {{"voxel", "0.1"}, {"soft", "0.4"}});
    for (const double x : {0.65, 0.75, 0.85, 0.95, 1.05, 1.15, 1.25})
        EXPECT_NEAR(valueAt(f, Vec3(x, 0.05, 0.05)), 3 * std::clamp(0.5 - (x - 1) / 0.4, 0.0, 1.0), 1e-6) << x;
    const SparseField own = shapes("box size=2,2,2 soft=0.4", {{"voxel", "0.1"}, {"soft", "0.1"}});
    EXPECT_NEAR(valueAt(own, Vec3(0.85, 0.05, 0.05)), 0.875, 1e-6);
    const SparseField preset = shapes("box size=2.1,2,2", {{"voxel", "0.1"}});
    EXPECT_NEAR(valueAt(preset, Vec3(1.05, 0.05, 0.05)), 0.5, 1e-5);
    EXPECT_EQ(valueAt(preset, Vec3(0.95, 0.05, 0.05)), 1);
    EXPECT_EQ(valueAt(preset, Vec3(1.15, 0.05, 0.05)), 0);
}

TEST_F(Primitives, AreSymmetricWhereTheirShapesAre) {
    const SparseField f = shapes("torus radius=1 tube=0.3", {{"voxel", "0.06"}});
    std::size_t seen = 0;
    forVoxels(f, [&](const Int3& p, float v) {
        if (++seen % 7 != 0) return;  // looking all of them up takes long
        // The voxel i lies at (i + 0.5) voxel: its mirror image is -1 - i.
        EXPECT_NEAR(valueAt(f, Int3(-1 - p.x, p.y, p.z)), v, 1e-6);
        EXPECT_NEAR(valueAt(f, Int3(p.x, -1 - p.y, p.z)), v, 1e-6);
        EXPECT_NEAR(valueAt(f, Int3(p.z, p.y, p.x)), v, 1e-6);
    });
    EXPECT_GT(seen, 5000u);
}

TEST_F(Primitives, InsidesAreTilesOfTheDensity) {
    const SparseField f = shapes("box size=4,4,4 density=2.5", {{"resolution", "256"}});
    ASSERT_FALSE(f.tiles.empty());
    for (const ConstantTile& t : f.tiles) EXPECT_EQ(t.value, 2.5f);
    // Blocks are at the faces alone: 32 blocks along an edge.
    EXPECT_LE(f.blockCount(), 6u * 34 * 34);
    EXPECT_NEAR(mass(f), 160, 0.2);
    std::int32_t largest = 0;
    for (const ConstantTile& t : f.tiles) largest = std::max(largest, t.edge);
    EXPECT_GE(largest, 32);
}

TEST_F(Primitives, OfTwoThatOverlapTheDenserCounts) {
    const std::string two = "box size=2,2,2 density=1; sphere radius=0.5 density=3; sphere radius=0.7 density=0.5";
    const SparseField most = shapes(two, {{"voxel", "0.05"}});
    EXPECT_EQ(valueAt(most, Vec3(0.025, 0.025, 0.025)), 3);
    EXPECT_EQ(valueAt(most, Vec3(0.625, 0.025, 0.025)), 1);
    const SparseField sum = shapes(two, {{"voxel", "0.05"}, {"combine", "sum"}});
    EXPECT_EQ(valueAt(sum, Vec3(0.025, 0.025, 0.025)), 4.5);
    EXPECT_EQ(valueAt(sum, Vec3(0.575, 0.025, 0.025)), 1.5);
    EXPECT_NEAR(mass(sum), 8 + 3 * kPi / 6 + 0.5 * kPi * 4 / 3 * 0.343, 0.03);
}

TEST_F(Primitives, BoxesSideBySideAreOneWhenSummed) {
    const SparseField f = shapes("box size=1,1,1 center=-0.5,0,0; box size=1,1,1 center=0.5,0,0",
                                 {{"voxel", "0.04"}, {"soft", "0.2"}, {"combine", "sum"}});
    for (double x = -0.38; x < 0.4; x += 0.04) EXPECT_NEAR(valueAt(f, Vec3(x, 0.02, 0.02)), 1, 1e-6) << x;
}

TEST_F(Primitives, MayFillSeveralGrids) {
    const auto fields = makeAll("primitives", {{"shapes",
                                                "sphere radius=1 grid=robot # the head\n"
                                                "\n  box size=1,1,1 center=3,0,0;sphere radius=0.5 grid=robot "
                                                "center=0,1.2,0 # the hat\n"}});
    ASSERT_EQ(fields.size(), 2u);
    EXPECT_EQ(fields[0].name, "robot");
    EXPECT_EQ(fields[1].name, "density");
    EXPECT_EQ(fields[0].wsFromIs, fields[1].wsFromIs);
    EXPECT_EQ(valueAt(fields[0], Vec3(0, 1.5, 0)), 1);
    EXPECT_EQ(valueAt(fields[0], Vec3(3, 0, 0)), 0);
    EXPECT_EQ(valueAt(fields[1], Vec3(3, 0, 0)), 1);
}

TEST_F(Primitives, PlanesLieBelowTheirSurface) {
    const SparseField f = shapes("plane center=0,1,0 size=4,2 thickness=0.5", {{"voxel", "0.1"}});
    EXPECT_EQ(valueAt(f, Vec3(0, 0.85, 0)), 1);
    EXPECT_EQ(valueAt(f, Vec3(0, 1.15, 0)), 0);
    EXPECT_EQ(valueAt(f, Vec3(1.85, 0.75, 0)), 1);
    EXPECT_EQ(valueAt(f, Vec3(0, 0.75, 1.15)), 0);
    const SparseField wall = shapes("plane normal=0,0,1 size=4,2 thickness=0.5", {{"voxel", "0.1"}});
    EXPECT_EQ(valueAt(wall, Vec3(0, 0, -0.25)), 1);
    EXPECT_EQ(valueAt(wall, Vec3(0, 0, 0.25)), 0);
}

TEST_F(Primitives, TurnAboutTheirMiddleAsScenesDo) {
    // About x by 90 degrees, y becomes z.
    const SparseField f = shapes("box size=1,3,1 center=5,0,0 rotate=90,0,0", {{"voxel", "0.1"}});
    EXPECT_EQ(valueAt(f, Vec3(5, 0, 1.3)), 1);
    EXPECT_EQ(valueAt(f, Vec3(5, 1.3, 0)), 0);
    const SparseField ring = shapes("torus radius=1 tube=0.2 axis=0,0,1", {{"voxel", "0.05"}});
    EXPECT_EQ(valueAt(ring, Vec3(0, 1, 0)), 1);
    EXPECT_EQ(valueAt(ring, Vec3(0, 0, 1)), 0);
}

TEST_F(Primitives, AreTheSameOnEveryRun) {
    const auto run = [] { return shapes("torus radius=1 tube=0.3 axis=1,1,0; box size=1,1,1 rotate=10,20,30"); };
    const SparseField a = run(), b = run();
    ASSERT_EQ(a.blockOrigins, b.blockOrigins);
    EXPECT_EQ(std::memcmp(a.block(0), b.block(0), a.blockCount() * kBlockVoxels * sizeof(float)), 0);
}

TEST_F(Primitives, ListsThatAreWrongAreRefusedWithThePlace) {
    const auto list = [](const std::string& text) { return reason("primitives", {{"shapes", text}}); };
    EXPECT_EQ(list(" ; # sphere radius=1\n"),
              "'shapes' lists none, expected some such as 'box size=1,1,1; sphere radius=0.7'");
    EXPECT_EQ(list("sphere radius=1; blob size=2"),
              "shape 2: unknown kind 'blob', expected 'box', 'sphere', 'ellipsoid', 'cylinder', 'capsule', 'torus' or "
              "'plane'");
    EXPECT_EQ(list("radius=1"), "shape 1: 'radius=1': expected a kind of shape before its keys");
    EXPECT_EQ(list("sphere radius"), "shape 1: 'radius': expected key=value without blanks");
    EXPECT_EQ(list("box size=1, 1, 1"), "shape 1: '1,': expected key=value without blanks");
    EXPECT_EQ(list("sphere radius=1 radius=2"), "shape 1: 'radius' is given twice");
    EXPECT_EQ(list("sphere radius=1 size=2,2,2"),
              "shape 1 (sphere): unknown key 'size', expected 'center', 'radius', 'rotate', 'density', 'soft' or "
              "'grid'");
    EXPECT_EQ(list("sphere"), "shape 1 (sphere): lacks 'radius', expected a number above 0");
    EXPECT_EQ(list("sphere radius=-1"), "shape 1 (sphere): 'radius' is '-1', expected a number above 0");
    EXPECT_EQ(list("sphere radius=nan"), "shape 1 (sphere): 'radius' is 'nan', expected a number above 0");
    EXPECT_EQ(list("box size=1,2"), "shape 1 (box): 'size' is '1,2', expected three numbers above 0 such as 1,2,0.5");
    EXPECT_EQ(list("box size=1,0,1"),
              "shape 1 (box): 'size' is '1,0,1', expected three numbers above 0 such as 1,2,0.5");
    EXPECT_EQ(list("sphere radius=1 center=0,0"),
              "shape 1 (sphere): 'center' is '0,0', expected three numbers such as 0,1.5,0");
    EXPECT_EQ(list("box size=1,1,1 round=0.6"),
              "shape 1 (box): 'round' is 0.6, expected at most 0.5, half of the least extent");
    EXPECT_EQ(list("cylinder from=1,1,1 to=1,1,1 radius=1"), "shape 1 (cylinder): 'from' and 'to' are the same point");
    EXPECT_EQ(list("torus radius=1 tube=0.1 axis=0,0,0"),
              "shape 1 (torus): 'axis' is '0,0,0', expected a direction such as 0,1,0");
    EXPECT_EQ(list("plane thickness=1"), "shape 1 (plane): lacks 'size', expected two numbers above 0 such as 10,10");
    EXPECT_EQ(list("plane size=1 thickness=1"),
              "shape 1 (plane): 'size' is '1', expected two numbers above 0 such as 10,10");
    EXPECT_EQ(list("sphere radius=1 density=-1"),
              "shape 1 (sphere): 'density' is '-1', expected a number of at least 0");
    EXPECT_EQ(list("sphere radius=1 grid="), "shape 1 (sphere): 'grid' is '', expected the name of a grid");
}

TEST_F(Primitives, TooManyVoxelsAreRefused) {
    EXPECT_EQ(reason("primitives", {{"shapes", "box size=10,1,1"}, {"voxel", "0.0005"}}),
              "the shapes extend over 20001 voxels of 0.0005, expected at most 16384");
    EXPECT_EQ(reason("primitives", {{"shapes", "sphere radius=1 center=1e9,0,0"}, {"voxel", "0.1"}}),
              "the shapes lie 1e+10 voxels of 0.1 from the origin, expected at most 268435456");
    std::string many;
    for (int i = 0; i < 100001; ++i) many += "sphere radius=1;";
    EXPECT_EQ(reason("primitives", {{"shapes", many}}), "'shapes' lists more than 100000 shapes");
}

}  // namespace
}  // namespace scrim::test
