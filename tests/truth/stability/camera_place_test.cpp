// SPDX-License-Identifier: Apache-2.0
// Eyes where the geometry is degenerate: inside the volume, on a voxel, on the plane between two sheets, cut by the
// near plane; and with fields of view from half a degree to 150 degrees.
#include "truth/stability/scenes.h"
#include "support/verified.h"

namespace scrim::test {
namespace {

const double kPi = std::acos(-1.0);
constexpr double kExtinction = 0.05;

// Haze whose ambient light shows how far a ray has come: radiance and alpha are 1 - e^-tau.
ViewScene haze(const Way& way, const Vec3& from, double fov, int resolution = 24) {
    Medium medium;
    medium.densityScale = kExtinction;
    medium.albedo = Rgb(1);
    ViewScene scene = orthographicScene(boxField(Int3(-12), Int3(11)), medium, 20, resolution);
    look(scene, from, from + Vec3(0, 0, -1), fov);
    scene.ambient = Rgb(1);
    scene.dials.opacityCutoff = 0;
    take(way, scene);
    return scene;
}

// Length of a ray from `o` along `d` within the box of haze, tents counted by half a voxel.
double lengthWithin(const Vec3& o, const Vec3& d) {
    double begin = 0, end = 1e30;
    for (int axis = 0; axis < 3; ++axis) {
        if (std::abs(d[axis]) < 1e-12) continue;
        const double a = (-12.5 - o[axis]) / d[axis], b = (11.5 - o[axis]) / d[axis];
        begin = std::max(begin, std::min(a, b));
        end = std::min(end, std::max(a, b));
    }
    return std::max(0.0, end - begin) * glm::length(d);
}

struct Stand {
    const char* name;
    Vec3 at;
};
void PrintTo(const Stand& s, std::ostream* out) {
    *out << s.name;
}
class EyeAt : public testing::TestWithParam<Stand> {};

// How far the way through the haze may be off, in voxels, where the eye stands in it. At pixels: rays that begin within
// a sheet see a part of it, which in even haze is exact (at its rim, tents' ramps are taken for even: a sixteenth). Per
// view: footprints of a sheet whose middle lies behind the eye fall nowhere, which is at most the half of a sheet. At
// texels the sheet next to the eye is seen at slants that change by more than they are from texel to texel, which
// counts it up to two and a half times: `auto` takes pixels here.
double stated(const Way& way) {
    return way.splat == SplatMode::perView ? 0.55 : way.shade == ShadeMode::texel ? 1.8 : 0.08;
}

const Way kInside[] = {kAutomatic, kPixels, kPerView, kTexels};

TEST_P(EyeAt, SeesTheHazeFromThereOn) {
    for (const Way& way : kInside) {
        const ViewScene scene = haze(way, GetParam().at, 50);
        const Frame frame = renderScene(scene);
        ASSERT_TRUE(sane(frame.image)) << way.name;
        const RayFamily rays = wsRays(scene.camera);
        for (const auto& [x, y] : {std::pair{12, 12}, {8, 14}, {15, 10}}) {
            const double length = lengthWithin(GetParam().at, rays.direction(x + 0.5, y + 0.5));
            EXPECT_NEAR(-std::log1p(-pixelOf(frame, x, y)[3]) / kExtinction, length, stated(way))
                << way.name << " " << x << "," << y;
            EXPECT_NEAR(pixelOf(frame, x, y)[0], pixelOf(frame, x, y)[3], 1e-6) << way.name;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Stands, EyeAt,
                         testing::Values(Stand{"theVolumesMiddle", {-0.5, -0.5, -0.5}},
                                         Stand{"aVoxelsCentre", {0, 0, 0}}, Stand{"aHairBesideIt", {1e-9, -1e-9, 1e-9}},
                                         Stand{"theLastVoxel", {0, 0, 11}}, Stand{"theBoxesFace", {0, 0, 12}},
                                         Stand{"anotherVoxel", {3, -4, 5}}),
                         [](const auto& test) { return std::string(test.param.name); });

// On planes of the sheets and between them.
TEST(EyeInASheet, SeesAsMuchOfItAsIsLeft) {
    for (const Way& way : kInside) {
        const Sheets sheets = makePlan(haze(way, {0, 0, 1}, 30), 1).groups[0].sheets;
        const double n = std::floor(sheets.tsPoint({0, 0, 1}).z);
        for (const double part : {0.0, 1e-12, 1e-6, 0.2, 0.5, 0.8, 1 - 1e-6}) {
            Vec3 at = sheets.wsPoint({0, 0, n + part});
            at.x = at.y = 0.25;
            const Frame frame = renderScene(haze(way, at, 30));
            ASSERT_TRUE(sane(frame.image)) << way.name << " " << part;
            EXPECT_NEAR(-std::log1p(-pixelOf(frame, 12, 12)[3]) / kExtinction, at.z + 12.5, stated(way))
                << way.name << " " << part;
        }
    }
}

// `auto` shades at texels where pixels are finer than those, but not where the eye is that near.
TEST(EyeAmongVolumes, IsShadedAtPixels) {
    const auto lit = [](const Vec3& at) {
        ViewScene scene = haze(kAutomatic, at, 50, 2048);
        scene.lights = {distantLight({0, -1, -1})};
        return scene;
    };
    for (const double z : {0.0, 11.5, 14.0}) EXPECT_TRUE(makePlan(lit({0, 0, z}), 1).shadeAtPixels);
    EXPECT_FALSE(makePlan(lit({0, 0, 40}), 1).shadeAtPixels);
    // A parallel view has no eye to stand anywhere.
    ViewScene parallel = lit({0, 0, 0});
    parallel.camera.type = CameraType::orthographic;
    EXPECT_FALSE(makePlan(parallel, 1).shadeAtPixels);
}

// The near plane, before, in and behind the volume, on and between the planes of sheets, for both kinds of camera and
// both orders.
TEST(NearPlane, CutsTheVolumeWhereItStands) {
    for (const bool perspective : {true, false})
        for (const Way& way : {kTexels, kPixels, kPerView})
            for (const double near : {5.0, 28.0, 40.0, 40.5, 41.0, 47.77, 52.0, 60.0})
                for (const double side : {-1.0, 1.0}) {
                    ViewScene scene = haze(way, {0, 0, 40}, 20);
                    if (!perspective) scene.camera.type = CameraType::orthographic;
                    scene.camera.height = 8;
                    scene.camera.near = near;
                    scene.lights = {distantLight({0, 0, side}, 0.01)};
                    const Frame frame = renderScene(scene);
                    ASSERT_TRUE(sane(frame.image)) << way.name << " " << near;
                    // Where the plane cuts a sheet with the tents' ramp in it, a sixteenth of a voxel is taken for
                    // even.
                    const double length = std::max(0.0, std::min(24.0, 52.5 - near));
                    EXPECT_NEAR(-std::log1p(-pixelOf(frame, 12, 12)[3]) / kExtinction, length, near == 52 ? 0.2 : 0.07)
                        << way.name << " near " << near << " light " << side << (perspective ? "" : " orthographic");
                }
}

// Half a degree, from as far away as that makes the picture as large as ever: the same as a parallel view to the change
// of directions, and to brute force.
TEST(NarrowEye, OfHalfADegreeAgreesWithBruteForceAndWithAParallelOne) {
    for (const Way& way : {kTexels, kPixels, kPerView}) {
        Medium medium;
        medium.densityScale = 0.35;
        ViewScene scene = orthographicScene(smoothField(), medium, 18, 32);
        scene.lights = {distantLight({-1, -0.7, -0.5}, 2)};
        take(way, scene);
        const Image parallel = renderScene(scene).image;
        const double distance = 9 / std::tan(0.25 * kPi / 180);
        look(scene, {0, 0, distance}, {0, 0, 0}, 0.5);
        const Frame frame = renderScene(scene);
        ASSERT_TRUE(sane(frame.image)) << way.name;
        expectConvergence(scene, 40, 1, 0.007, way.name);
        // Ten voxels before and behind the middle are 1 % larger and smaller: a fiftieth of a voxel at the rim. Per
        // view the two kinds of camera have splatters of their own (3 % measured).
        EXPECT_LT(changeOf(std::string(way.name) + "Change", parallel, frame.image),
                  way.splat == SplatMode::perView ? 0.04 : 0.004)
            << way.name;
    }
}

// 150 degrees, from outside, where all of the volume is in the picture's middle, and from within, where texels are off
// for the reason above: a test says by how much.
TEST(WideEye, Of150DegreesAgreesWithBruteForceFromOutsideAndInside) {
    for (const Way& way : {kAutomatic, kPixels, kTexels}) {
        for (const Vec3& from : {Vec3(1, 2, 30), Vec3(1.3, -2.1, 6.2)}) {
            Medium medium;
            medium.densityScale = 0.15;
            ViewScene scene = orthographicScene(smoothField(), medium, 18, 40);
            look(scene, from, from + Vec3(0.1, -0.1, -1), 150);
            scene.lights = {distantLight({-1, -0.7, -0.5}, 2)};
            scene.ambient = Rgb(0.1);
            take(way, scene);
            const Frame frame = renderScene(scene);
            ASSERT_TRUE(sane(frame.image)) << way.name;
            const bool inside = from.z < 20;
            const bool off = inside && way.shade == ShadeMode::texel;
            // From outside all of it is in thirteen pixels: in one tile with rays that run away from the sheets.
            expectConvergence(scene, inside ? 40 : 13, off ? 0.5 : 1, off ? 0.06 : 0.004,
                              std::string(way.name) + (inside ? "Inside" : "Outside"));
        }
    }
}

// Over all fields of view a ray is the same ray: the picture's middle pixel does not change (a pixel at 150 degrees is
// as wide as the box; rays are points).
TEST(MiddleRay, IsTheSameAtEveryFieldOfView) {
    for (const Way& way : {kTexels, kPixels, kPerView})
        for (const double fov : {0.5, 5.0, 45.0, 89.0, 91.0, 120.0, 150.0}) {
            if (way.splat == SplatMode::perView && fov > 50) continue;  // its raster is the picture's: too coarse then
            ViewScene scene = haze(way, {0.2, -0.3, 40}, fov, 25);
            const double tau = kExtinction * 24;
            EXPECT_NEAR(-std::log1p(-pixelOf(renderScene(scene), 12, 12)[3]), tau, 5e-3) << way.name << " " << fov;
        }
}

}  // namespace
}  // namespace scrim::test
