// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/framing.h>

#include <scrim/image/blackbody.h>
#include <scrim/scene/field_rays.h>

#include "unit/scene/read_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

#include "support/expect_error.h"

namespace scrim {
namespace {

/// A field of blocks at `origins` whose voxels all have one value.
SparseField blocks(std::vector<Int3> origins, float value, const Mat4& wsFromIs) {
    SparseField field;
    field.name = "density";
    field.wsFromIs = wsFromIs;
    const auto values = std::make_shared<std::vector<float>>(origins.size() * kBlockVoxels, value);
    field.blockValues = std::shared_ptr<const float>(values, values->data());
    field.activeVoxels = values->size();
    field.maxValue = value;
    field.blockOrigins = std::move(origins);
    return field;
}

Mat4 scaled(double voxel, const Vec3& place) {
    Mat4 m(1.0);
    for (int i = 0; i < 3; ++i) m[i][i] = voxel;
    m[3] = glm::dvec4(place, 1);
    return m;
}

/// The corners of the blocks' cells and half a voxel more, where the linear kernel ends.
std::vector<Vec3> wsReach(const SparseField& field) {
    std::vector<Vec3> corners;
    for (const Int3& origin : field.blockOrigins) {
        const Bounds is{Vec3(origin) - 1.0, Vec3(origin) + double(kBlockEdge)};
        for (const Vec3& corner : is.corners()) corners.push_back(transformPoint(field.wsFromIs, corner));
    }
    return corners;
}

/// Largest |x| and |y| of the field's corners in normalised device coordinates.
Vec2 reach(const Camera& camera, const SparseField& field) {
    const Mat4 ndcFromWs = worldToNdc(camera);
    Vec2 most(0);
    for (const Vec3& corner : wsReach(field)) {
        const glm::dvec4 p = ndcFromWs * glm::dvec4(corner, 1);
        EXPECT_GT(p.w, 0) << "behind the camera";
        most = glm::max(most, glm::abs(Vec2(p) / p.w));
    }
    return most;
}

Scene framed(const SparseField& field, Int2 resolution) {
    return test::read(
        framingScene({.file = "smoke.####.vdb", .name = "smoke", .grid = "density", .field = &field}, resolution));
}

TEST(FieldRays, FindTheOccupiedCells) {
    SparseField field = blocks({{-8, 0, 0}, {8, 0, 0}}, 1, Mat4(1.0));
    field.tiles.push_back({{0, 16, 0}, 16, 1.0f});
    EXPECT_EQ(isOccupied(field).lower, Vec3(-8.5, -0.5, -0.5));
    EXPECT_EQ(isOccupied(field).upper, Vec3(15.5, 31.5, 15.5));
    EXPECT_TRUE(isOccupied(SparseField()).empty());

    auto values = std::make_shared<std::vector<float>>(kBlockVoxels, 0.0f);
    values->at(static_cast<std::size_t>(blockOffset(2, 3, 4))) = 1;
    SparseField one = blocks({{0, 0, 0}}, 0, Mat4(1.0));
    one.blockValues = std::shared_ptr<const float>(values, values->data());
    EXPECT_EQ(isOccupied(one).lower, Vec3(1.5, 2.5, 3.5));
    EXPECT_EQ(isOccupied(one).upper, Vec3(2.5, 3.5, 4.5));
}

TEST(FieldRays, FindTheOccupiedCellsOfAnyVoxels) {
    for (int seed = 0; seed < 200; ++seed) {
        const Int3 origin(8 * (seed % 5 - 2), 8 * (seed % 7 - 3), 8 * (seed % 3 - 1));
        auto values = std::make_shared<std::vector<float>>(kBlockVoxels, 0.0f);
        Bounds expected;
        for (int k = 0; k <= seed % 3; ++k) {
            const Int3 at(seed * (3 + k) % 8, (seed / 8 + 5 * k) % 8, (seed * 7 + k) % 8);
            values->at(static_cast<std::size_t>(blockOffset(at.x, at.y, at.z))) = 0.5f;
            expected.include(Vec3(origin + at) - 0.5);
            expected.include(Vec3(origin + at) + 0.5);
        }
        SparseField field = blocks({origin}, 0, Mat4(1.0));
        field.blockValues = std::shared_ptr<const float>(values, values->data());
        EXPECT_EQ(isOccupied(field).lower, expected.lower) << seed;
        EXPECT_EQ(isOccupied(field).upper, expected.upper) << seed;
    }
}

/// As negligibleIn, by the definition: in steps of a quarter of a power of two.
Negligible negligibleByLogarithms(const std::vector<float>& values) {
    std::map<int, std::pair<double, double>> bins;  // number and sum
    double sum = 0, voxels = 0;
    for (const float v : values) {
        if (!(v > 0)) continue;
        auto& [number, total] = bins[static_cast<int>(std::floor(4 * std::log2(double(v))))];
        ++number;
        total += double(v);
        ++voxels;
        sum += double(v);
    }
    double above = 0;
    auto core = bins.rbegin();
    while (2 * (above += core->second.second) < sum) ++core;
    const int least = core->first + static_cast<int>(4 * std::log2(1e-4));
    Negligible out{static_cast<float>(std::exp2(least / 4.0)), 0};
    for (const auto& [bin, content] : bins)
        if (bin < least) out.part += content.first / voxels;
    return out;
}

TEST(FieldRays, SortValuesAsLogarithmsDo) {
    constexpr std::size_t kBlocks = 130;
    std::vector<Int3> origins;
    for (std::size_t i = 0; i < kBlocks; ++i) origins.push_back({0, 0, 8 * static_cast<int>(i)});
    SparseField field = blocks(origins, 0, Mat4(1.0));
    for (const double scale : {1e-30, 1.0, 1e30}) {
        auto values = std::make_shared<std::vector<float>>(kBlocks * kBlockVoxels, 0.0f);
        for (std::size_t i = 0; i < values->size(); ++i) {
            // At the borders of steps, and beside them.
            const auto border = static_cast<float>(scale * std::exp2(double(i * i % 120) / 4 - 20));
            (*values)[i] = i % 5 == 0 ? 0 : i % 5 == 1 ? std::nextafter(border, 0.0f) : border;
        }
        field.blockValues = std::shared_ptr<const float>(values, values->data());
        const Negligible found = negligibleIn(field), expected = negligibleByLogarithms(*values);
        EXPECT_EQ(found.below, expected.below) << scale;
        EXPECT_NEAR(found.part, expected.part, 1e-12) << scale;
    }
}

TEST(FieldRays, IntegrateBlocksAndTiles) {
    SparseField field = blocks({{-8, 0, 0}}, 2, scaled(0.5, {10, 0, 0}));
    field.tiles.push_back({{-16, -16, -16}, 16, 3.0f});
    const FieldRays rays(field);
    // 8 voxels of 0.5 world units of value 2; the ray's direction need not be a unit vector.
    EXPECT_NEAR(rays.integral({10 - 4 * 0.5, 2, -100}, {0, 0, 3}), 8 * 0.5 * 2, 1e-9);
    EXPECT_NEAR(rays.integral({10 - 8 * 0.5, -4, 100}, {0, 0, -1}), 16 * 0.5 * 3, 1e-9);
    EXPECT_EQ(rays.integral({10 - 4 * 0.5, 2, -100}, {0, 0, -1}), 0);
    EXPECT_EQ(rays.integral({11, 2, -100}, {0, 0, 1}), 0);
}

TEST(Framing, FillsThePictureUpToTheMargin) {
    const SparseField field = blocks({{0, 0, 0}, {0, 8, 0}, {8, 8, 0}, {16, 8, 8}}, 1, scaled(0.1, {0, 0, 0}));
    for (const Int2 resolution : {Int2(512, 512), Int2(1920, 800), Int2(300, 900)}) {
        const Scene scene = framed(field, resolution);
        EXPECT_EQ(scene.camera.resolution, resolution);
        const Vec2 most = reach(scene.camera, field);
        // 3 % of the picture on each side is 6 % of the half width; numbers are rounded to a thousandth of the size.
        EXPECT_NEAR(std::max(most.x, most.y), 0.94, 0.01) << resolution.x << " x " << resolution.y;
    }
}

TEST(Framing, LooksFromTheFrontTheRightAndAbove) {
    const Scene scene = framed(blocks({{0, 0, 0}}, 1, Mat4(1.0)), {512, 512});
    const Vec3 axis = viewingAxis(scene.camera);
    EXPECT_LT(axis.z, -0.8);
    EXPECT_LT(axis.x, -0.3);
    EXPECT_LT(axis.y, -0.1);
    EXPECT_GT(scene.camera.wsFromCamera[1].y, 0.9);
}

TEST(Framing, StandsUprightWhateverIsUp) {
    // Longer to the top than to the sides, in a world where z is up, and in one where -x is.
    const SparseField y = blocks({{0, 0, 0}, {0, 8, 0}}, 1, Mat4(1.0));
    const Scene upright = framed(y, {512, 512});
    for (const Vec3& wsUp : {Vec3(0, 0, 1), Vec3(-1, 0, 0), Vec3(0, -1, 0)}) {
        const Mat3 turn = wsFromUpright(wsUp);
        EXPECT_NEAR(glm::determinant(turn), 1, 1e-12);
        SparseField turned = y;
        turned.wsFromIs = Mat4(turn) * y.wsFromIs;
        const Scene scene =
            test::read(framingScene({.file = "a.vdb", .field = &turned, .wsFromUpright = turn}, {512, 512}));
        EXPECT_NEAR(glm::length(scene.camera.wsPosition - turn * upright.camera.wsPosition), 0, 0.03);
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_NEAR(glm::length(scene.camera.wsFromCamera[axis] - turn * upright.camera.wsFromCamera[axis]), 0,
                        2e-3);
        EXPECT_NEAR(glm::length(scene.lights[0].wsDirection - turn * upright.lights[0].wsDirection), 0, 2e-3);
    }
}

TEST(Framing, AFaintHaloDoesNotCount) {
    const SparseField dense = blocks({{0, 0, 0}, {8, 0, 0}}, 1, Mat4(1.0));
    SparseField halo = blocks({{-80, 0, 0}, {0, 0, 0}, {8, 0, 0}}, 1, Mat4(1.0));
    const auto values = std::make_shared<std::vector<float>>(halo.block(0), halo.block(0) + 3 * kBlockVoxels);
    std::fill_n(values->begin(), kBlockVoxels, 1e-4f);
    halo.blockValues = std::shared_ptr<const float>(values, values->data());
    EXPECT_EQ(framed(dense, {512, 512}).camera.wsPosition, framed(halo, {512, 512}).camera.wsPosition);
    EXPECT_GT(faintValue(halo), 1e-4f);
    EXPECT_LE(faintValue(halo), 1.0f);
}

TEST(Framing, ResidueOfASimulationChangesNothing) {
    const SparseField clean = blocks({{0, 0, 0}, {8, 0, 0}}, 39, Mat4(1.0));
    // Twenty blocks of residue around two of smoke: nine of ten voxels and of rays meet nothing else.
    std::vector<Int3> places;
    for (int x = -40; x < 40; x += 8)
        for (int y = -40; y < 40; y += 40) places.push_back({x, y, 0});
    places.push_back({0, 0, 0});
    places.push_back({8, 0, 0});
    places.erase(std::remove(places.begin(), places.end() - 2, Int3(0, 0, 0)), places.end() - 2);
    places.erase(std::remove(places.begin(), places.end() - 2, Int3(8, 0, 0)), places.end() - 2);
    SparseField residue = blocks(places, 39, Mat4(1.0));
    const auto values = std::make_shared<std::vector<float>>(residue.activeVoxels, 39.0f);
    for (std::size_t i = 0; i + 2 * kBlockVoxels < values->size(); ++i)
        (*values)[i] = std::pow(10.0f, -4.0f - float(i % 30));
    residue.blockValues = std::shared_ptr<const float>(values, values->data());
    const Scene with = framed(residue, {512, 512}), without = framed(clean, {512, 512});
    EXPECT_EQ(with.camera.wsPosition, without.camera.wsPosition);
    EXPECT_NEAR(with.volumes[0].densityScale, without.volumes[0].densityScale, 0.02 * without.volumes[0].densityScale);
    EXPECT_NEAR(negligibleIn(residue).part, 1 - 2 / double(places.size()), 0.05);
    EXPECT_EQ(negligibleIn(clean).part, 0);
}

TEST(Framing, WideVoxelsAreInterpolatedSmoothly) {
    std::vector<Int3> many;
    for (int x = 0; x < 20; ++x)
        for (int y = 0; y < 20; ++y) many.push_back({8 * x, 8 * y, 0});
    const SparseField coarse = blocks({{0, 0, 0}}, 1, scaled(0.3, Vec3(0))), fine = blocks(many, 1, Mat4(1.0));
    EXPECT_EQ(framed(coarse, {512, 512}).volumes[0].interpolation, GridInterpolation::smooth);
    EXPECT_EQ(framed(fine, {512, 512}).volumes[0].interpolation, GridInterpolation::automatic);
    // The same asset in a larger picture has wider voxels.
    EXPECT_EQ(framed(fine, {2048, 2048}).volumes[0].interpolation, GridInterpolation::smooth);
}

TEST(Framing, FireIsAsBrightAsThePictureTakesAtAnySize) {
    for (const double voxel : {1e-3, 1.0, 1e3})
        for (const float hottest : {0.5f, 1.0f, 5.0f, 1900.0f}) {
            const SparseField smoke = blocks({{0, 0, 0}, {0, 8, 0}}, 1, scaled(voxel, Vec3(0)));
            const SparseField heat = blocks({{0, 0, 0}}, hottest, scaled(voxel, Vec3(0)));
            const FramedAsset asset{.file = "a.vdb", .field = &smoke, .fire = FramedFire{"heat", &heat, hottest}};
            const Scene scene = test::read(framingScene(asset, {512, 512}));
            ASSERT_EQ(scene.volumes[0].emission.size(), 1u);
            const Emission& fire = scene.volumes[0].emission[0];
            EXPECT_NEAR(hottest * fire.kelvinScale + fire.kelvinOffset, 1900, 20) << hottest;
            // Half as hot, it keeps a sixteenth of its light: fire has no rim of its coldest red.
            EXPECT_EQ(fire.kelvinOffset, 0) << hottest;
            // A block of it, all as hot, seen through smoke of at most optical depth 2 for half of the rays.
            const double clear = fire.scale * blackbodyRadiance(1900) * 8 * voxel;
            EXPECT_GT(clear, 0.9) << voxel << ", " << hottest;
            EXPECT_LT(clear, 1.2 * 1.8 * std::exp(2.0)) << voxel << ", " << hottest;
            EXPECT_LT(scene.lights[0].intensity.x, 10);
        }
}

TEST(Framing, KeepsItsShapeFarAwayAndAtAnySize) {
    for (const double voxel : {1e-6, 1e-3, 1.0, 1e4})
        for (const double place : {0.0, 1e6}) {
            const SparseField field = blocks({{0, 0, 0}, {8, 0, 0}}, 1, scaled(voxel, Vec3(place, -place, place)));
            const Scene scene = framed(field, {640, 480});
            const Vec2 most = reach(scene.camera, field);
            EXPECT_NEAR(std::max(most.x, most.y), 0.94, 0.02) << voxel << " at " << place;
        }
}

TEST(Framing, HalfOfTheRaysAreDeeperThanThreeAndAHalf) {
    for (const float value : {1e-6f, 1.0f, 1e6f})
        for (const double voxel : {1e-6, 1.0, 1e4}) {
            // A cube of 8 voxels. Its mean chord along the view is volume over projected area, 8 / 1.507
            // = 5.31 voxels (1.507: sum of the axis' components); the median is longer, and shorter than 8.
            // So is what 3.5 spread over it makes of 8 voxels.
            const SparseField field = blocks({{0, 0, 0}}, value, scaled(voxel, Vec3(0)));
            const Scene scene = framed(field, {512, 512});
            const double depth = scene.volumes[0].densityScale * double(value) * voxel * 8;
            EXPECT_GT(depth, 3.5) << value << ", " << voxel;
            EXPECT_LT(depth, 3.5 * 1.507) << value << ", " << voxel;
        }
}

TEST(Framing, LightsComeFromAboveLeftFromTheRightAndFromBehind) {
    const Scene scene = framed(blocks({{0, 0, 0}}, 1, Mat4(1.0)), {512, 512});
    ASSERT_EQ(scene.lights.size(), 3u);
    const Mat3& axes = scene.camera.wsFromCamera;
    const Vec3 key = scene.lights[0].wsDirection * axes, fill = scene.lights[1].wsDirection * axes;
    EXPECT_EQ(scene.lights[0].name, "key");
    EXPECT_TRUE(scene.lights[0].shadows);
    EXPECT_GT(key.x, 0.3);
    EXPECT_LT(key.y, -0.3);
    EXPECT_LT(fill.x, -0.3);
    EXPECT_LT(scene.lights[1].intensity.x, scene.lights[0].intensity.x);
    EXPECT_GT(scene.lights[0].intensity.x, scene.lights[0].intensity.z);
    EXPECT_LT(scene.lights[1].intensity.x, scene.lights[1].intensity.z);
    EXPECT_GT((scene.lights[2].wsDirection * axes).z, 0.5) << "towards the eye";
    EXPECT_GT(scene.ambient.x, 0);
    EXPECT_EQ(scene.volumes[0].name, "smoke");
    EXPECT_EQ(scene.volumes[0].sequence.pattern, "smoke.####.vdb");
    EXPECT_EQ(scene.volumes[0].densityGrid, "density");
    EXPECT_EQ(scene.volumes[0].medium.phase.g, 0.3);
}

TEST(Framing, ReadsWell) {
    const SparseField field = blocks({{0, 0, 0}}, 1, scaled(0.1, {0, 0, 0}));
    const std::string text = framingScene({.file = "a \"b\".vdb", .grid = "density", .field = &field}, {512, 512});
    EXPECT_NE(text.find("file = \"a \\\"b\\\".vdb\"\n"), std::string::npos) << text;
    std::size_t longest = 0, digits = 0;
    for (const char c : text) {
        digits = c >= '0' && c <= '9' ? digits + 1 : 0;
        longest = std::max(longest, digits);
    }
    EXPECT_LE(longest, 4u) << text;
    EXPECT_EQ(text, framingScene({.file = "a \"b\".vdb", .grid = "density", .field = &field}, {512, 512}));
}

TEST(Framing, AGridWithoutANameIsLeftToTheReader) {
    const SparseField field = blocks({{0, 0, 0}}, 1, Mat4(1.0));
    const Scene scene = test::read(framingScene({.file = "a.vdb", .field = &field}, {512, 512}));
    EXPECT_EQ(scene.volumes[0].densityGrid, "");
    EXPECT_EQ(scene.volumes[0].name, "volume");
}

TEST(Framing, AnEmptyAssetGetsAPictureOfTheOrigin) {
    const SparseField empty = blocks({}, 0, Mat4(1.0));
    const Scene scene = test::read(framingScene({.file = "a.vdb", .grid = "density", .field = &empty}, {512, 512}));
    EXPECT_EQ(scene.volumes[0].densityScale, 1);
    EXPECT_LT(glm::length(scene.camera.wsPosition), 5);
}

TEST(Framing, WhatIsTooLargeForACameraIsRefusedByItsVoxels) {
    const SparseField field = blocks({Int3(0)}, 1, scaled(3e18, Vec3(0)));
    FramedAsset asset;
    asset.file = "huge.vdb";
    asset.name = "huge";
    asset.field = &field;
    const std::string text = test::errorOf(ErrorKind::input, [&] { framingScene(asset, {32, 32}); });
    EXPECT_TRUE(text.starts_with("huge.vdb: has voxels of 3e+18 world units, and would be seen from ")) << text;
    EXPECT_TRUE(text.ends_with(" away; expected at most 1e+15. A scene with transform = { scale = 1e-20 } shows it"))
        << text;
}

}  // namespace
}  // namespace scrim
