// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/framing.h>

#include <scrim/scene/field_rays.h>

#include "unit/scene/read_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

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

/// The corners of the cells and half a voxel more, where the linear kernel ends.
std::vector<Vec3> wsReach(const SparseField& field) {
    Bounds is = isOccupied(field);
    is.lower -= 0.5;
    is.upper += 0.5;
    std::vector<Vec3> corners;
    for (const Vec3& corner : is.corners()) corners.push_back(transformPoint(field.wsFromIs, corner));
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
    return test::read(framingScene("smoke.####.vdb", {{"density", &field}}, resolution));
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
        // 5 % of the picture on each side is 10 % of the half width; numbers are rounded to a thousandth of
        // the size.
        EXPECT_NEAR(std::max(most.x, most.y), 0.9, 0.01) << resolution.x << " x " << resolution.y;
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

TEST(Framing, KeepsItsShapeFarAwayAndAtAnySize) {
    for (const double voxel : {1e-6, 1e-3, 1.0, 1e4})
        for (const double place : {0.0, 1e6}) {
            const SparseField field = blocks({{0, 0, 0}, {8, 0, 0}}, 1, scaled(voxel, Vec3(place, -place, place)));
            const Scene scene = framed(field, {640, 480});
            const Vec2 most = reach(scene.camera, field);
            EXPECT_NEAR(std::max(most.x, most.y), 0.9, 0.02) << voxel << " at " << place;
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

TEST(Framing, LightsComeFromAboveLeftAndFromTheRightOfTheCamera) {
    const Scene scene = framed(blocks({{0, 0, 0}}, 1, Mat4(1.0)), {512, 512});
    ASSERT_EQ(scene.lights.size(), 2u);
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
    EXPECT_GT(scene.ambient.x, 0);
    EXPECT_EQ(scene.volumes[0].sequence.pattern, "smoke.####.vdb");
    EXPECT_EQ(scene.volumes[0].densityGrid, "density");
    EXPECT_EQ(scene.volumes[0].medium.phase.g, 0.3);
}

TEST(Framing, ReadsWell) {
    const SparseField field = blocks({{0, 0, 0}}, 1, scaled(0.1, {0, 0, 0}));
    const std::string text = framingScene("a \"b\".vdb", {{"density", &field}}, {512, 512});
    EXPECT_NE(text.find("file = \"a \\\"b\\\".vdb\"\n"), std::string::npos) << text;
    std::size_t longest = 0, digits = 0;
    for (const char c : text) {
        digits = c >= '0' && c <= '9' ? digits + 1 : 0;
        longest = std::max(longest, digits);
    }
    EXPECT_LE(longest, 4u) << text;
    EXPECT_EQ(text, framingScene("a \"b\".vdb", {{"density", &field}}, {512, 512}));
}

TEST(Framing, AGridWithoutANameIsLeftToTheReader) {
    const SparseField field = blocks({{0, 0, 0}}, 1, Mat4(1.0));
    const Scene scene = test::read(framingScene("a.vdb", {{"", &field}}, {512, 512}));
    EXPECT_EQ(scene.volumes[0].densityGrid, "");
    EXPECT_EQ(scene.volumes[0].name, "volume");
}

TEST(Framing, AnEmptyAssetGetsAPictureOfTheOrigin) {
    const SparseField empty = blocks({}, 0, Mat4(1.0));
    const Scene scene = test::read(framingScene("a.vdb", {{"density", &empty}}, {512, 512}));
    EXPECT_EQ(scene.volumes[0].densityScale, 1);
    EXPECT_LT(glm::length(scene.camera.wsPosition), 5);
}

}  // namespace
}  // namespace scrim
