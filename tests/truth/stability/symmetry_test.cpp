// SPDX-License-Identifier: Apache-2.0
// The same scene said in other words: turned as a whole, in other units, cut into two grids, listed in another order.
// Each test says whether the picture is the same to the bit, to rounding or to a stated error.
#include "truth/stability/scenes.h"

#include <numeric>

namespace scrim::test {
namespace {

Mat3 turned(const Vec3& from, const Vec3& to, const Vec3& up) {
    return lookAt(from, to, up);
}

class SameScene : public testing::TestWithParam<Way> {};
class SameMedium : public SameScene {};

// To rounding: axes, rasters and footprints all follow the scene and the camera. (Floors of coordinates that are whole
// but for rounding may move a raster by a texel, which moves its texels onto others of the same lattice.)
TEST_P(SameScene, TurnedAsAWholeIsTheSamePicture) {
    const ViewScene scene = smallScene(GetParam());
    const Image before = renderScene(scene).image;
    for (const Vec3& from : {Vec3(1, 0, 0), Vec3(0, 0, -1), Vec3(1, 2, 3), Vec3(-3, 0.1, 1)}) {
        const Mat3 rotation = turned(from, Vec3(0), {0.2, 1, 0.1});
        EXPECT_LT(changeOf("turned", before, renderScene(moved(scene, 1, rotation, Vec3(0))).image),
                  GetParam().classified ? 1e-5 : 2e-6)
            << from.x << "," << from.y << "," << from.z;
    }
}

// To the bit: lengths in other units of a power of two leave every mantissa as it is.
TEST_P(SameScene, InHalfOrFourTimesTheUnitsIsTheSamePictureToTheBit) {
    const ViewScene scene = smallScene(GetParam());
    const Image before = renderScene(scene).image;
    for (const double scale : {0.5, 2.0, 1024.0, std::ldexp(1.0, -20)})
        EXPECT_EQ(before.rgba, renderScene(moved(scene, scale, Mat3(1.0), Vec3(0))).image.rgba) << scale;
}

// To the bit: the field in other units, a power of two, with extinction or transfer function to match. A voxel of 2^-60
// squared, as gradients are, is a float of 2^-120, next to the smallest.
TEST_P(SameScene, OfAFieldInOtherUnitsIsTheSamePictureToTheBit) {
    const ViewScene scene = smallScene(GetParam());
    const auto before = renderScene(scene).image.rgba;
    for (const int power : {-70, -20, 20, 70}) {
        ViewScene other = scene;
        const SparseField& field = *scene.volumes[0].field;
        const double unit = std::ldexp(1.0, power);
        other.volumes[0].field = makeField(Int3(-9), Int3(9), 1, [&](const Vec3& is) {
            const Int3 p(is), origin = p >> 3 << 3, at = p - origin;
            const auto block = std::find(field.blockOrigins.begin(), field.blockOrigins.end(), origin);
            if (block == field.blockOrigins.end()) return 0.0;
            const float* values = field.block(static_cast<std::size_t>(block - field.blockOrigins.begin()));
            return unit * values[blockOffset(at.x, at.y, at.z)];
        });
        other.volumes[0].medium.densityScale /= unit;
        if (GetParam().classified) {
            Classified look = *scene.volumes[0].classified;
            for (TransferPoint& point : look.transfer) point.value *= unit;
            other.volumes[0].classified = std::make_shared<const Classified>(look);
        }
        EXPECT_EQ(before, renderScene(other).image.rgba) << "times 2^" << power;
    }
}

// To rounding: two grids of half the density each.
TEST_P(SameMedium, AsTwoGridsOfHalfTheDensityIsTheSamePicture) {
    ViewScene scene = smallScene(GetParam());
    const Image before = renderScene(scene).image;
    scene.volumes[0].medium.densityScale *= 0.5;
    scene.volumes.push_back(scene.volumes[0]);
    EXPECT_LT(changeOf("change", before, renderScene(scene).image), 1e-6);
}

std::shared_ptr<SparseField> part(const SparseField& whole, bool odd) {
    auto field = std::make_shared<SparseField>(whole);
    auto values = std::make_shared<std::vector<float>>();
    field->blockOrigins.clear();
    field->activeVoxels = 0;
    for (std::size_t i = 0; i < whole.blockCount(); ++i) {
        const Int3 o = whole.blockOrigins[i] / 8;
        if (((o.x + o.y + o.z) & 1) != (odd ? 1 : 0)) continue;
        field->blockOrigins.push_back(whole.blockOrigins[i]);
        values->insert(values->end(), whole.block(i), whole.block(i) + kBlockVoxels);
        field->activeVoxels += static_cast<std::uint64_t>(
            std::count_if(whole.block(i), whole.block(i) + kBlockVoxels, [](float v) { return v > 0; }));
    }
    field->blockValues = std::shared_ptr<const float>(values, values->data());
    return field;
}

// A chessboard of leaves, to a stated error. Shared sheets are sharpened (unblur) and clamped at 0, each grid by
// itself: cut faces lose what was sharpened below 0, up to a twelfth of the change there (measured: 1.5 % of the
// brightest). Per-view footprints are tabulated along the ray through the middle of each grid, and the middles differ
// (0.1 %).
TEST_P(SameMedium, CutIntoTwoGridsLeafByLeafIsTheSamePicture) {
    ViewScene scene = smallScene(GetParam());
    const Image before = renderScene(scene).image;
    const auto whole = scene.volumes[0].field;
    scene.volumes.push_back(scene.volumes[0]);
    scene.volumes[0].field = part(*whole, false);
    scene.volumes[1].field = part(*whole, true);
    const double stated = GetParam().splat == SplatMode::perView ? 2e-3 : 0.03;
    EXPECT_LT(changeOf("change", before, renderScene(scene).image), stated);
}

// To rounding: sums run in the order of the scene.
TEST_P(SameScene, WithItsLightsAndVolumesInAnotherOrderIsTheSamePicture) {
    ViewScene scene = smallScene(GetParam());
    scene.lights.push_back(distantLight({0.5, -0.3, 0.8}, 1));
    scene.lights.back().name = "rim";
    scene.volumes.push_back(scene.volumes[0]);
    scene.volumes.back().wsFromIs[3] = glm::dvec4(3, -4, 5, 1);
    scene.volumes.push_back(scene.volumes[0]);
    scene.volumes.back().wsFromIs[3] = glm::dvec4(-6, 2, 1, 1);
    for (std::size_t i = 0; i < scene.volumes.size(); ++i)
        scene.volumes[i].medium.albedo = Rgb(0.2 + 0.3 * double(i), 0.5, 0.9 - 0.3 * double(i));
    const Image before = renderScene(scene).image;
    std::vector<std::size_t> order{0, 1, 2};
    while (std::next_permutation(order.begin(), order.end())) {
        ViewScene other = scene;
        for (std::size_t i = 0; i < 3; ++i) {
            other.volumes[i] = scene.volumes[order[i]];
            other.lights[i] = scene.lights[order[i]];
        }
        EXPECT_LT(changeOf("change", before, renderScene(other).image), 1e-6) << order[0] << order[1] << order[2];
    }
}

// A transfer function does not add up.
INSTANTIATE_TEST_SUITE_P(Ways, SameMedium, testing::Values(kTexels, kPixels, kPerView), nameOfWay);
INSTANTIATE_TEST_SUITE_P(Ways, SameScene, testing::Values(kTexels, kPixels, kPerView, kSurface, kSurfacePerView),
                         nameOfWay);

}  // namespace
}  // namespace scrim::test
