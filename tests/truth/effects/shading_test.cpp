// SPDX-License-Identifier: Apache-2.0
// Shading by parameters: densities that are remapped, masked, and changed by noise; fields that noise displaces;
// colours by ramps of any grid. Each is compared with its formula.
#include "support/expect_error.h"
#include "support/fields.h"

#include <scrim/scene/noise_blocks.h>
#include <scrim/shot/derived_fields.h>
#include <scrim/shot/shaded_field.h>
#include <scrim/volume/field_sampler.h>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace scrim::test {
namespace {

const Int3 kLower{-6, -3, 2}, kUpper{13, 12, 17};

double voxelOf(const FieldPointer& field, const Int3& at) {
    return FieldSampler(*field).voxel(at);
}

/// A field without symmetry, above 0.
std::shared_ptr<SparseField> bumps(double voxel = 0.5) {
    return makeField(kLower, kUpper, voxel, [](const Vec3& is) {
        return 0.6 + 0.3 * std::sin(0.4 * is.x) * std::cos(0.3 * is.y) + 0.02 * is.z;
    });
}

template <typename Expected>
void expectValues(const FieldPointer& field, const Expected& expected, double tolerance = 1e-6) {
    for (int x = kLower.x; x <= kUpper.x; ++x)
        for (int y = kLower.y; y <= kUpper.y; ++y)
            for (int z = kLower.z; z <= kUpper.z; ++z)
                ASSERT_NEAR(voxelOf(field, {x, y, z}), expected(Int3(x, y, z)), tolerance) << x << " " << y << " " << z;
}

/// The noise of one voxel.
double noiseAt(const Noise& noise, const Mat4& placeFromIs, const Int3& at, std::uint32_t part = 0) {
    std::array<float, kBlockVoxels> values;
    NoiseBlocks(noise, placeFromIs, part).fill(at, values.data());  // the block may begin anywhere
    return double(values[0]);
}

TEST(Remap, MapsRangesAndBendsThem) {
    Remap remap{{0.2, 0.6}, {0, 4}};
    EXPECT_EQ(remap.at(0.1), 0);
    EXPECT_NEAR(remap.at(0.3), 1, 1e-12);
    EXPECT_EQ(remap.at(9), 4);
    remap.gamma = 2;
    EXPECT_NEAR(remap.at(0.3), 4 * std::sqrt(0.25), 1e-12);
    remap.gamma = 1;
    remap.contrast = 3;
    EXPECT_NEAR(remap.at(0.3), 4 * 0.5 * std::pow(0.5, 3), 1e-12);
    EXPECT_NEAR(remap.at(0.5), 4 * (1 - 0.5 * std::pow(0.5, 3)), 1e-12);
    EXPECT_NEAR(remap.at(0.4), 2, 1e-12) << "the middle stays";
    EXPECT_EQ(remap.at(0.6), 4) << "and so do the ends";
    const Remap falling{{0, 1}, {1, 0}};
    EXPECT_NEAR(falling.at(0.25), 0.75, 1e-12);
}

TEST(ShadedDensity, IsTheFormulaAtEachVoxel) {
    const auto density = bumps();
    const auto other =
        makeField({-20, -20, -20}, {40, 40, 40}, 0.25, [](const Vec3& is) { return 0.5 + 0.01 * is.x + 0.005 * is.z; });
    DensityShading shading;
    shading.remap = Remap{{0.2, 1}, {0, 2}, 1.5, 2};
    shading.edge = {{0.3, 0.9}};
    shading.mask = Mask{"m", Remap{{0.2, 0.8}, {1, 0.25}}, ""};
    shading.noise = Noise{.amount = 0.8, .frequency = 0.7, .octaves = 3};
    const FieldPointer made = shadedDensity(density, shading, other, Mat4(1.0));
    expectValues(made, [&](const Int3& at) {
        double v = shading.remap->at(voxelOf(density, at));
        const double t = std::clamp((v - 0.3) / 0.6, 0.0, 1.0);
        v *= t * t * (3 - 2 * t);
        v *= shading.mask->remap.at(0.5 + 0.01 * 2 * at.x + 0.005 * 2 * at.z);  // half the voxel: twice the index
        return v * std::max(0.0, 1 + 0.8 * noiseAt(*shading.noise, density->wsFromIs, at));
    });
    shading.noiseMode = NoiseMode::erode;
    const FieldPointer eroded =
        shadedDensity(density, {.noise = shading.noise, .noiseMode = NoiseMode::erode}, nullptr, Mat4(1.0));
    expectValues(eroded, [&](const Int3& at) {
        const double n = noiseAt(*shading.noise, density->wsFromIs, at);
        return std::max(0.0, voxelOf(density, at) - 0.8 * 0.5 * (1 + n));
    });
}

TEST(ShadedDensity, KeepsTilesWhereNothingVaries) {
    auto density = std::make_shared<SparseField>();
    density->tiles = {{{0, 0, 0}, 4096, 0.5f}};
    density->activeVoxels = std::uint64_t{4096} * 4096 * 4096;
    const FieldPointer made = shadedDensity(density, {.remap = Remap{{0, 1}, {0, 3}}}, nullptr, Mat4(1.0));
    ASSERT_EQ(made->tiles.size(), 1u);
    EXPECT_FLOAT_EQ(made->tiles[0].value, 1.5f);
    EXPECT_NE(errorOf(ErrorKind::memory, [&] { shadedDensity(density, {.noise = Noise()}, nullptr, Mat4(1.0)); })
                  .find("too large for masks, noise or displacement"),
              std::string::npos);
    EXPECT_NE(errorOf(ErrorKind::memory, [&] { displacedField(density, Noise(), Mat4(1.0)); }).find("too large"),
              std::string::npos);
}

TEST(Noise, IsBoundedHasNoMeanAndDependsOnThePlaceAlone) {
    Noise noise{.frequency = 0.31, .octaves = 5};
    const Mat4 place(0.5);
    double sum = 0, squares = 0, most = 0;
    int count = 0;
    std::array<float, kBlockVoxels> values, others;
    for (int x = -64; x < 64; x += 8)
        for (int y = -64; y < 64; y += 8)
            for (int z = -64; z < 64; z += 8) {
                NoiseBlocks(noise, place).fill({x, y, z}, values.data());
                for (const float v : values) {
                    sum += double(v);
                    squares += double(v) * double(v);
                    most = std::max(most, std::abs(double(v)));
                    ++count;
                }
            }
    EXPECT_LE(most, 1.04);
    EXPECT_NEAR(sum / count, 0, 0.02);
    EXPECT_GT(std::sqrt(squares / count), 0.1);
    // A voxel's noise is the same whichever block it is in.
    NoiseBlocks(noise, place).fill({0, 0, 0}, values.data());
    NoiseBlocks(noise, place).fill({3, 2, 1}, others.data());
    EXPECT_EQ(values[std::size_t(blockOffset(5, 5, 5))], others[std::size_t(blockOffset(2, 3, 4))]);
    // An offset moves the pattern.
    Noise moved = noise;
    moved.offset = {1, 0.5, -2};  // 2, 1 and -4 voxels
    EXPECT_NEAR(noiseAt(noise, Mat4(0.5), {3, 4, 5}), noiseAt(moved, Mat4(0.5), {5, 5, 1}), 1e-6);
}

TEST(Noise, AddsOctavesByRoughnessAndLacunarity) {
    const Noise both{.frequency = 0.37, .octaves = 2, .roughness = 0.6, .lacunarity = 3};
    // At lattice points of the first octave and of the second alone, gradient noise is 0.
    const Mat4 place(1.0);
    Noise first = both;
    first.octaves = 1;
    const Int3 at(4, -7, 2);
    const double one = noiseAt(first, place, at), two = noiseAt(both, place, at);
    const double second = (two * 1.6 - one) / 0.6;
    EXPECT_LE(std::abs(second), 1.04);
    EXPECT_GT(std::abs(two - one), 1e-4);
    const Noise lattice{.frequency = 1, .octaves = 3, .lacunarity = 2};
    EXPECT_EQ(noiseAt(lattice, place, at), 0) << "whole numbers are lattice points of all three";
}

TEST(Noise, EvolvesWithoutJumpsAndKeepsItsStrength) {
    Noise noise{.frequency = 0.37, .octaves = 3};
    const Int3 at(4, -7, 2);
    const auto after = [&](double evolution) {
        noise.evolution = evolution;
        return noiseAt(noise, Mat4(1.0), at);
    };
    EXPECT_NEAR(after(0.999999), after(1.000001), 1e-5);
    EXPECT_NEAR(after(-0.000001), after(0.000001), 1e-5);
    EXPECT_NEAR(after(0.5), std::numbers::sqrt2 / 2 * (after(0) + after(1)), 1e-6);
    EXPECT_NE(after(0), after(1));
}

TEST(DisplacedField, SaysThatTheAmountIsTooLarge) {
    const auto field = makeField(kLower, kUpper, 0.5, [](const Vec3&) { return 1.0; });
    for (const double amount : {1e3, 1e9, 1e15, 1e300}) {
        const Noise noise{.amount = amount, .where = "s.toml:8:16"};
        EXPECT_EQ(errorOf(ErrorKind::input, [&] { displacedField(field, noise, Mat4(1.0)); }),
                  fmt::format("s.toml:8:16: displacement by {:g} spreads grid '{}' over more than 1073 million voxels; "
                              "expected a smaller 'amount'",
                              amount, field->name));
    }
}

TEST(DisplacedField, IsTheFieldAtThePlaceThatNoiseLeadsTo) {
    const auto field = makeField(kLower, kUpper, 0.5, [](const Vec3& is) { return 3 + 0.1 * is.x + 0.05 * is.y; });
    const Noise noise{.amount = 1.5, .frequency = 0.2, .octaves = 2};
    const FieldPointer made = displacedField(field, noise, Mat4(1.0));
    const Bounds inside{Vec3(kLower), Vec3(kUpper)};
    int compared = 0, outside = 0;
    for (int x = -14; x <= 22; ++x)
        for (int y = -12; y <= 22; ++y)
            for (int z = -8; z <= 26; ++z) {
                Vec3 way;
                for (std::uint32_t c = 0; c < 3; ++c)
                    way[int(c)] = 1.5 * noiseAt(noise, field->wsFromIs, {x, y, z}, c) / 0.5;
                const Vec3 from = Vec3(x, y, z) - way;
                const double value = voxelOf(made, {x, y, z});
                if (!inside.contains(from)) {
                    if (!Bounds{inside.lower - 1.0, inside.upper + 1.0}.contains(from)) {
                        ASSERT_EQ(value, 0);
                    }
                    continue;
                }
                ++compared;
                outside += inside.contains(Vec3(x, y, z)) ? 0 : 1;
                // Linear interpolation of a linear function is that function.
                ASSERT_NEAR(value, 3 + 0.1 * from.x + 0.05 * from.y, 1e-5) << x << " " << y << " " << z;
            }
    EXPECT_GT(compared, 4000);
    EXPECT_GT(outside, 50) << "it grows beyond its bounds";
}

TEST(DisplacedField, RestsInTheWorldOrMovesWithTheVolume) {
    const auto field = bumps();
    Noise noise{.amount = 0.6, .frequency = 0.3};
    Mat4 place(2.0);
    place[3] = {5, 1, -3, 1};
    EXPECT_EQ(voxelOf(displacedField(field, noise, place), {3, 3, 8}),
              voxelOf(displacedField(field, noise, Mat4(1.0)), {3, 3, 8}));
    noise.inWorld = true;
    EXPECT_NE(voxelOf(displacedField(field, noise, place), {3, 3, 8}),
              voxelOf(displacedField(field, noise, Mat4(1.0)), {3, 3, 8}));
}

TEST(MaskedField, IsTheProductAtEachVoxel) {
    const auto flame = bumps();
    const auto grid = makeField(kLower, kUpper, 0.5, [](const Vec3& is) { return 0.05 * (is.x + 8); });
    const Mask mask{"m", Remap{{0.1, 0.9}, {0, 1}}, ""};
    expectValues(maskedField(flame, mask, grid), [&](const Int3& at) {
        return voxelOf(flame, at) * std::clamp((0.05 * (at.x + 8) - 0.1) / 0.8, 0.0, 1.0);
    });
}

TEST(ScatteringFields, TakeColoursFromRampsOfAnyGrid) {
    const auto density = bumps();
    const auto heat = makeField({0, kLower.y, kLower.z}, kUpper, 0.5, [](const Vec3& is) { return 0.1 * is.x; });
    ColourGrid look;
    look.ramp = {{0, {0.1, 0.2, 0.3}}, {1, {0.9, 0.4, 0}}};
    const auto fields = scatteringFields(*density, {heat, heat, heat}, look);
    expectValues(fields[0], [&](const Int3& at) {
        const double t = at.x < 0 ? 0 : std::min(0.1 * at.x, 1.0);  // where there is no heat, it is 0
        return voxelOf(density, at) * (0.1 + 0.8 * t);
    });
}

}  // namespace
}  // namespace scrim::test
