// SPDX-License-Identifier: Apache-2.0
// Voxels that no simulation should write, and grids that hardly exist: all come out as a picture of finite numbers.
#include "truth/stability/scenes.h"

#include <scrim/volume/field_builder.h>

#include <limits>

namespace scrim::test {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kLargest = std::numeric_limits<float>::max();
constexpr float kDenormal = std::numeric_limits<float>::denorm_min();

using Block = std::array<float, kBlockVoxels>;

std::shared_ptr<const SparseField> built(const std::vector<std::pair<Int3, Block>>& blocks,
                                         const std::vector<ConstantTile>& tiles = {}) {
    FieldBuilder builder("density", Mat4(1.0));
    for (const auto& [origin, values] : blocks) builder.addBlock(origin, values.data());
    for (const ConstantTile& tile : tiles) builder.addTile(tile);
    return std::make_shared<const SparseField>(builder.finish());
}

Block halves() {
    Block block;
    for (int i = 0; i < kBlockVoxels; ++i) block[static_cast<std::size_t>(i)] = static_cast<float>(i % 11) / 20;
    return block;
}

class OddValues : public testing::TestWithParam<Way> {
  protected:
    // Seen from the side, one light on either side of the eye's plane: both orders, several sweeps.
    static ViewScene scene(std::shared_ptr<const SparseField> field) {
        ViewScene scene = smallScene(GetParam(), 24, std::move(field));
        scene.lights.push_back(distantLight({0.3, -0.4, 1}, 1));
        return scene;
    }
    static Frame picture(std::shared_ptr<const SparseField> field) { return renderScene(scene(std::move(field))); }
};

TEST_P(OddValues, ThatAreNotNumbersOrNegativeCountAsNothing) {
    Block odd = halves(), clean = halves();
    const float wrong[] = {std::nanf(""), kInfinity, -kInfinity, -1, -kLargest, -0.0f, kDenormal, -kDenormal};
    for (std::size_t i = 0; i < odd.size(); i += 7) {
        odd[i] = wrong[i / 7 % std::size(wrong)];
        clean[i] = 0;
    }
    const auto field = built({{{0, 0, 0}, odd}});
    EXPECT_GT(field->nonFinite, 0u);
    EXPECT_GT(field->negative, 0u);
    const Frame frame = picture(field), expected = picture(built({{{0, 0, 0}, clean}}));
    EXPECT_TRUE(sane(frame.image));
    EXPECT_EQ(frame.image.rgba, expected.image.rgba);
    EXPECT_EQ(frame.work.footprints, expected.work.footprints);
}

// Denormal values are dropped before they reach the splatter, and what a small scale makes of normal ones becomes 0 on
// the way: neither costs a footprint.
TEST_P(OddValues, ThatAreDenormalDoNoWork) {
    Block block{};
    block.fill(kDenormal * 100);
    const Frame none = picture(built({{{0, 0, 0}, block}}));
    EXPECT_EQ(none.work.voxelsFed, 0u);
    EXPECT_EQ(none.work.footprints, 0u);
    if (GetParam().classified) return;
    block.fill(1e-20f);
    ViewScene tiny = scene(built({{{0, 0, 0}, block}}));
    tiny.volumes[0].medium.densityScale = 1e-20;
    const Frame frame = renderScene(tiny);
    EXPECT_EQ(frame.work.footprints, 0u);
    EXPECT_EQ(brightest(frame.image), 0);
}

// The largest float, alone, beside others, everywhere, and scaled beyond what a float holds: opaque, and nothing else.
TEST_P(OddValues, ThatAreTheLargestFloatAreOpaque) {
    Block one{}, some = halves(), all;
    one[blockOffset(4, 4, 4)] = some[blockOffset(4, 4, 4)] = kLargest;
    all.fill(kLargest);
    for (const double scale : {1e-30, 1.0, 1e6})
        for (const Block* block : {&one, &some, &all}) {
            ViewScene s = scene(built({{{0, 0, 0}, *block}}));
            s.volumes[0].medium.densityScale = scale;
            look(s, {4, 4, 40}, {4, 4, 4}, 30);
            const Frame frame = renderScene(s);
            EXPECT_TRUE(sane(frame.image)) << "scale " << scale
                                           << (block == &one   ? " one"
                                               : block == &all ? " all"
                                                               : "");
            // Two voxels of tent at least, of the transfer function's last extinction (0.6).
            EXPECT_GT(pixelOf(frame, 12, 12)[3], GetParam().classified ? -std::expm1(-1.2) : 0.999) << scale;
        }
}

TEST_P(OddValues, AnEmptyGridIsABlackPictureThatCostsNothing) {
    for (const auto& field : {built({}), built({{{0, 0, 0}, Block{}}}), built({}, {{{0, 0, 0}, 8, 0}})}) {
        const Frame frame = picture(field);
        EXPECT_EQ(brightest(frame.image), 0);
        EXPECT_EQ(frame.work.sheets, 0u);
    }
}

// Beside another grid an empty one changes nothing, to the bit.
TEST_P(OddValues, AnEmptyGridBesideAnotherChangesNothing) {
    ViewScene with = scene(built({{{0, 0, 0}, halves()}}));
    const auto alone = renderScene(with).image.rgba;
    with.volumes.insert(with.volumes.begin(), with.volumes[0]);
    with.volumes[0].field = built({});
    EXPECT_EQ(alone, renderScene(with).image.rgba);
}

// A voxel in each corner of its leaf, next to the border of everything that is derived from leaves.
TEST_P(OddValues, ASingleVoxelShowsWhereverItLiesInItsLeaf) {
    for (const int corner : {0, 1, 2, 4, 7}) {
        const Int3 at(corner & 1 ? 7 : 0, corner & 2 ? 7 : 0, corner & 4 ? 7 : 0);
        Block block{};
        block[static_cast<std::size_t>(blockOffset(at.x, at.y, at.z))] = 1;
        ViewScene s = scene(built({{{8, -16, 0}, block}}));
        s.volumes[0].medium.densityScale = 3;
        const Vec3 middle = Vec3(at) + Vec3(8, -16, 0);
        look(s, middle + Vec3(0, 0, 40), middle, 10);
        s.dials.texel = s.dials.sheetThickness = 0.25;
        take(GetParam(), s);
        s.camera.resolution = {25, 25};
        s.region = {0, 0, 25, 25};
        const Frame frame = renderScene(s);
        ASSERT_TRUE(sane(frame.image));
        // Through the middle of the tent the integral of 1 - |z| is 1; between texels a quarter of a voxel apart its
        // tip is cut by up to (7/8)^2, of which sharpening restores a half. Classified: more than half opaque.
        const double alpha = pixelOf(frame, 12, 12)[3];
        if (GetParam().classified)
            EXPECT_GT(alpha, 0.5) << corner;
        else
            EXPECT_NEAR(-std::log1p(-alpha), 3, 0.5) << corner;
        EXPECT_EQ(pixelOf(frame, 0, 0)[3], 0);
    }
}

// Grids of tiles only, of every size, look like the leaves they stand for.
TEST_P(OddValues, TilesAloneLookLikeLeaves) {
    Block block;
    block.fill(0.5f);
    std::vector<std::pair<Int3, Block>> leaves;
    for (int i = 0; i < 8; ++i) leaves.push_back({Int3(i >> 2 & 1, i >> 1 & 1, i & 1) * 8 - 8, block});
    std::vector<ConstantTile> tiles;
    for (const auto& [origin, values] : leaves) tiles.push_back({origin, 8, 0.5f});
    // Leaves are added in the order of their depth, tiles as they come: to rounding.
    const Image a = picture(built(leaves)).image, b = picture(built({}, tiles)).image;
    EXPECT_LT(changeOf("change", a, b), GetParam().classified ? 1e-5 : 1e-6);
    const Image c = picture(built({{{0, 0, 0}, block}})).image, d = picture(built({}, {{{0, 0, 0}, 8, 0.5f}})).image;
    EXPECT_EQ(c.rgba, d.rgba);
}

INSTANTIATE_TEST_SUITE_P(Ways, OddValues, testing::Values(kTexels, kPixels, kPerView, kSurface, kSurfacePerView),
                         nameOfWay);

}  // namespace
}  // namespace scrim::test
