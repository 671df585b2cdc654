// SPDX-License-Identifier: Apache-2.0
// Where a scene stands and how large it is must not show: coordinates are made local in double before they become
// float, so that only the rounding of the input itself is left.
#include "truth/stability/scenes.h"

#include <scrim/verify/reference.h>

namespace scrim::test {
namespace {

class Place : public testing::TestWithParam<Way> {};

// A coordinate of 1e8 has steps of 1.5e-8: less of a voxel than a float's rounding of a texel's coordinate. Pictures
// may differ by what floats make of positions that differ in their last bit: 1e-6 of a texel on a plane of some ten,
// times the steepest slope of the picture (less than its brightest a texel; of classified volumes up to ten times
// that).
TEST_P(Place, AHundredMillionUnitsAwayIsTheSamePicture) {
    const ViewScene scene = smallScene(GetParam());
    const Image here = renderScene(scene).image;
    ASSERT_TRUE(sane(here));
    for (const Vec3& shift : {Vec3(1e6, -2e6, 3e6), Vec3(-1e8, 1e8 + 0.3, 1e8 + 0.7), Vec3(0, 0, 1e8 / 3)}) {
        const Image there = renderScene(moved(scene, 1, Mat3(1.0), shift)).image;
        const std::string what = "by" + std::to_string(int(glm::length(shift)));
        EXPECT_LT(changeOf(what, here, there), GetParam().classified ? 1e-4 : 1e-5) << shift.x << "," << shift.y;
    }
}

// A millionth is no power of two: every number is rounded anew, once.
TEST_P(Place, VoxelsFromAMillionthToTenThousandUnitsGiveTheSamePicture) {
    const ViewScene scene = smallScene(GetParam());
    const Image here = renderScene(scene).image;
    for (const double scale : {1e-6, 1e-3, 1e4}) {
        const Image there = renderScene(moved(scene, scale, Mat3(1.0), Vec3(0))).image;
        EXPECT_LT(changeOf("voxelsOf" + std::to_string(scale), here, there), GetParam().classified ? 1e-5 : 1e-6)
            << scale;
    }
}

// Both at once: a millionth of a unit, as far away as doubles can tell a ten-thousandth of a voxel.
TEST_P(Place, TinyVoxelsFarAwayAreTheSamePictureToTheRoundingOfTheirPlaces) {
    const ViewScene scene = smallScene(GetParam());
    const Image here = renderScene(scene).image;
    const double voxel = 1e-6, away = 4e5;  // steps of 5.8e-11: 6e-5 of a voxel
    const Image there = renderScene(moved(scene, voxel, Mat3(1.0), Vec3(away, 0, -away))).image;
    // Camera, grid and lamp are each off by up to half of that in every direction. Besides, a few voxels move across a
    // step of the footprint table, which changes their weights by up to a hundredth: 1e-4 of what a ray gathers.
    EXPECT_LT(changeOf("change", here, there), 5e-4);
}

INSTANTIATE_TEST_SUITE_P(Ways, Place, testing::Values(kTexels, kPixels, kPerView, kSurface, kSurfacePerView),
                         nameOfWay);

// The reference is judged by the same rule: it is what everything else is compared to.
TEST(PlaceOfTheReference, DoesNotChangeItsPixels) {
    const ViewScene scene = smallScene(kTexels);
    const Reference here(scene);
    const ViewScene far = moved(scene, 1, Mat3(1.0), {1e8, 1e8, -1e8}), tiny = moved(scene, 1e-6, Mat3(1.0), Vec3(0)),
                    huge = moved(scene, 1e4, Mat3(1.0), Vec3(0));
    for (const ViewScene* other : {&far, &tiny, &huge}) {
        const Reference there(*other);
        for (const auto& [x, y] : {std::pair{16, 16}, {11, 20}, {19, 9}})
            for (std::size_t c = 0; c < 4; ++c)
                EXPECT_NEAR(there.pixel(x, y)[c], here.pixel(x, y)[c], 1e-6) << x << "," << y << " channel " << c;
    }
}

}  // namespace
}  // namespace scrim::test
