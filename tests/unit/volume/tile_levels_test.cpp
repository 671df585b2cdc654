// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/tile_levels.h>

#include <scrim/volume/field_sampler.h>
#include <scrim/volume/field_builder.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <vector>

namespace scrim::test {
namespace {

// With the values of its blocks in itself.
SparseField whole(const TileLevel& level) {
    SparseField field = *level.field;
    const auto values = std::make_shared<float[]>(field.blockCount() * kBlockVoxels);
    for (std::size_t b = 0; b < field.blockCount(); ++b)
        std::memcpy(values.get() + b * kBlockVoxels, level.values[b], kBlockVoxels * sizeof(float));
    field.blockValues = std::shared_ptr<const float>(values, values.get());
    return field;
}

// Two bodies of tiles that touch, of two values, with ragged rims, one across 0, and a block beside them.
SparseField bodies() {
    FieldBuilder builder("bodies", Mat4(1.0));
    std::mt19937 random(3);
    for (int x = -12; x < 16; ++x)
        for (int y = -12; y < 12; ++y)
            for (int z = -12; z < 12; ++z) {
                const bool rim = x < -11 || y < -11 || z < -11 || y > 10 || z > 10;
                if (!rim || random() % 2 == 0) builder.addTile({8 * Int3(x, y, z), 8, x < 12 ? 0.5f : 0.25f});
            }
    std::vector<float> values(kBlockVoxels, 3.0f);
    builder.addBlock({-104, 0, 0}, values.data());
    return builder.finish();
}

class Levels : public ::testing::TestWithParam<Kernel> {};

TEST_P(Levels, SumUpToTheFieldsTiles) {
    SparseField field = bodies();
    const TileLevels levels(field, twoScaleWeights(GetParam()), 3);
    ASSERT_GE(levels.levels().size(), 3u);
    field.blockOrigins.clear();
    const FieldSampler tiles(field, GetParam());
    std::vector<SparseField> fields;
    for (const TileLevel& level : levels.levels()) fields.push_back(whole(level));
    std::vector<FieldSampler> probes;
    for (const SparseField& one : fields) probes.emplace_back(one, GetParam());
    std::mt19937 random(7);
    std::uniform_real_distribution<double> along(-103, 134);
    for (int i = 0; i < 20'000; ++i) {
        const Vec3 is(along(random), along(random), along(random));
        double sum = 0, scale = 1;
        for (const FieldSampler& probe : probes) {
            sum += probe.value(is / scale);
            scale *= 2;
        }
        // Values are floats, of which up to 4^3 a level are added.
        EXPECT_NEAR(sum, tiles.value(is), 1e-6) << is.x << ", " << is.y << ", " << is.z;
    }
}

INSTANTIATE_TEST_SUITE_P(Ways, Levels, ::testing::Values(Kernel::linear, Kernel::bspline));

TEST(TileLevels, NeedFewVoxelsOfWhatIsLarge) {
    FieldBuilder builder("cube", Mat4(1.0));
    builder.addTile({{0, 0, 0}, 512, 1.0f});
    const SparseField field = builder.finish();
    const TileLevels levels(field, twoScaleWeights(Kernel::linear), 3);
    double voxels = 0;
    for (const TileLevel& level : levels.levels()) voxels += double(level.field->activeVoxels);
    // A rim of two blocks of each level's voxels: 1 - (1 - 32/512)^3 of the finest, four times as much of an eighth of
    // those of the next one, ...
    EXPECT_LT(voxels, 0.3 * double(field.activeVoxels));
    EXPECT_GT(voxels, 0.01 * double(field.activeVoxels));
}

TEST(TileLevels, AreNoneOfSmallTiles) {
    FieldBuilder builder("dots", Mat4(1.0));
    for (int i = 0; i < 8; ++i) builder.addTile({{32 * i, 0, 0}, 16, 1.0f});
    EXPECT_TRUE(TileLevels(builder.finish(), twoScaleWeights(Kernel::linear), 3).levels().empty());
}

}  // namespace
}  // namespace scrim::test
