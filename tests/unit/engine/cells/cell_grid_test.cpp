// SPDX-License-Identifier: Apache-2.0
// Cells, and values that go from coarse cells to fine ones.
#include <scrim/engine/cells/cell_grid.h>

#include "support/fields.h"
#include "support/meshes.h"

#include <scrim/base/error.h>
#include <scrim/engine/lamps/lamp_field.h>
#include <scrim/engine/cells/cell_media.h>
#include <scrim/engine/passes/cell_slices.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <vector>

#include <glm/common.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/trigonometric.hpp>

namespace scrim::test {
namespace {

// Two bodies apart from one another, so that the box around them is mostly empty.
std::vector<Bounds> bodies() {
    return {{Vec3(-3.1, 0.2, 0.4), Vec3(5.7, 6.1, 4.9)}, {Vec3(40, 41, 42), Vec3(43.5, 43, 42.5)}};
}

TEST(CellGrid, StoresTheBlocksThatMeetABoxAndNoOthers) {
    const CellGrid grid(0.5, bodies());  // blocks of 4 world units
    std::size_t stored = 0;
    for (int z = 0; z < grid.blocks().z; ++z)
        for (int y = 0; y < grid.blocks().y; ++y)
            for (int x = 0; x < grid.blocks().x; ++x) {
                const Vec3 lower = grid.wsFromCs(Vec3(x, y, z) * 8.0), upper = lower + 4.0;
                bool meets = false;
                for (const Bounds& box : bodies()) {
                    const Vec3 a = glm::max(lower, box.lower), b = glm::min(upper, box.upper);
                    meets = meets || (a.x < b.x && a.y < b.y && a.z < b.z);
                }
                EXPECT_EQ(grid.stored({x, y, z}) >= 0, meets) << x << " " << y << " " << z;
                stored += meets ? 1 : 0;
            }
    EXPECT_EQ(stored, grid.storedBlocks().size());
    EXPECT_EQ(grid.cells(), stored * kBlockCells);
    EXPECT_EQ(grid.stored({-1, 0, 0}), -1);
    EXPECT_EQ(grid.stored(grid.blocks()), -1);
}

TEST(CellGrid, FindsEveryCellWhereItIs) {
    const CellGrid grid(0.5, bodies());
    for (std::size_t i = 0; i < grid.cells(); ++i) {
        const Int3 place = grid.place(i);
        ASSERT_EQ(grid.index(place), std::ptrdiff_t(i));
        ASSERT_EQ(Int3(glm::floor(grid.csFromWs(grid.wsCenter(i)))), place);
    }
    EXPECT_EQ(grid.index({-1, 0, 0}), -1);
}

// Corners lie at multiples of the edge: the same cells for whatever volume.
TEST(CellGrid, StandsStillInTheWorld) {
    for (const double shift : {0.0, 0.3, 17.9, -123.4}) {
        const CellGrid grid(0.5, {{Vec3(shift), Vec3(shift + 3)}});
        const Vec3 corner = grid.wsFromCs(Vec3(0)) / 4.0;
        EXPECT_EQ(corner, glm::round(corner)) << shift;
    }
}

TEST(CellGrid, IsCoveredByACoarserOne) {
    const CellGrid fine(0.5, bodies()), coarse = CellGrid::coarser(fine);
    EXPECT_EQ(coarse.edge(), 1);
    for (std::size_t i = 0; i < fine.cells(); ++i)
        ASSERT_GE(coarse.index(Int3(glm::floor(coarse.csFromWs(fine.wsCenter(i))))), 0);
    EXPECT_LE(coarse.storedBlocks().size(), fine.storedBlocks().size());
}

TEST(CellGrid, RefusesMoreCellsThanCanBeNumbered) {
    EXPECT_THROW(CellGrid(1e-6, {{Vec3(-1e6), Vec3(-1e6 + 1)}, {Vec3(1e6), Vec3(1e6 + 1)}}), Error);
}

// Linear between the middles of coarse cells, so a linear field arrives as it was, but at the border, where there are
// no cells to look at beyond.
TEST(CellLevels, HandALinearFieldDownAsItIs) {
    const CellGrid fine(1, {{Vec3(0), Vec3(64)}}), coarse = CellGrid::coarser(fine);
    const auto field = [](const Vec3& ws) { return 5 + 0.3 * ws.x - 0.2 * ws.y + 0.1 * ws.z; };
    std::vector<std::int32_t> fineRows(fine.cells()), coarseRows(coarse.cells());
    std::iota(fineRows.begin(), fineRows.end(), 0);
    std::iota(coarseRows.begin(), coarseRows.end(), 0);
    std::vector<Real> from, to(2 * fine.cells(), Real(1));
    for (std::size_t i = 0; i < coarse.cells(); ++i)
        for (const double scale : {1.0, -2.0}) from.push_back(static_cast<Real>(scale * field(coarse.wsCenter(i))));
    addInterpolated(coarse, coarseRows, from, fine, fineRows, 2, to);
    int inner = 0;
    for (std::size_t i = 0; i < fine.cells(); ++i) {
        const Vec3 ws = fine.wsCenter(i);
        if (std::min({ws.x, ws.y, ws.z}) < 1 || std::max({ws.x, ws.y, ws.z}) > 63) continue;
        ++inner;
        ASSERT_NEAR(double(to[2 * i]), 1 + field(ws), 1e-4);
        ASSERT_NEAR(double(to[2 * i + 1]), 1 - 2 * field(ws), 2e-4);
    }
    EXPECT_EQ(inner, 62 * 62 * 62);
}

void expectSameMedia(const CellMedia& media, const CellMedia& other, double edge) {
    ASSERT_EQ(media.grid.cells(), other.grid.cells());
    double most = 0;
    for (const Real value : media.extinction[0]) most = std::max(most, double(value));
    ASSERT_GT(most, 0);
    for (std::size_t i = 0; i < media.grid.cells(); ++i)
        ASSERT_NEAR(double(media.extinction[0][i]), double(other.extinction[0][i]), 1e-5 * most) << "cells of " << edge;
}

// Blocks of a field whose axes are the world's are spread all at once, those of a classified volume voxel by voxel. A
// transfer function that is a line tells the two ways apart.
TEST(CellMedia, OfBlocksIsThatOfTheirVoxels) {
    ViewScene scene = orthographicScene(smokeField(14), {0.7, Rgb(1), {}}, 24, 24);
    scene.volumes[0].wsFromIs = Mat4(0.7, 0, 0, 0, 0, -0.9, 0, 0, 0, 0, 1.1, 0, 0.123, 4.56, -7.89, 1);
    ViewScene classified = scene;
    Classified line;
    line.transfer = {{0, Rgb(1), 0}, {1, Rgb(1), 0.7}};
    classified.volumes[0].classified = std::make_shared<const Classified>(line);
    for (const double edge : {2.3, 0.9, 0.4})
        expectSameMedia(cellMedia(scene, {}, edge, Simd()), cellMedia(classified, {}, edge, Simd()), edge);
}

// With a margin, voxels are tents in small cells. In a turned volume the field is asked instead; a turn of a billionth
// moves no value by more than that.
TEST(CellMedia, InSmallCellsIsTheInterpolatedFieldHoweverTheVolumeIsTurned) {
    ViewScene scene = orthographicScene(smokeField(14), {0.7, Rgb(1), {}}, 24, 24);
    scene.volumes[0].wsFromIs = Mat4(0.7, 0, 0, 0, 0, -0.9, 0, 0, 0, 0, 1.1, 0, 0.123, 4.56, -7.89, 1);
    ViewScene turned = scene;
    turned.volumes[0].wsFromIs[0].y = 1e-9;
    expectSameMedia(cellMedia(scene, {}, 0.4, Simd(), {.margin = 2}), cellMedia(turned, {}, 0.4, Simd(), {.margin = 2}),
                    0.4);
    // What a volume holds does not depend on how it lies.
    const auto sum = [](const CellMedia& media, double edge) {
        double all = 0;
        for (const Real value : media.extinction[0]) all += double(value) * edge * edge * edge;
        return all;
    };
    turned.volumes[0].wsFromIs = glm::rotate(scene.volumes[0].wsFromIs, 0.7, Vec3(1, 2, 0.5));
    for (const double edge : {0.4, 1.0, 2.3}) {
        const double straight = sum(cellMedia(scene, {}, edge, Simd(), {.margin = 2}), edge);
        EXPECT_NEAR(sum(cellMedia(turned, {}, edge, Simd(), {.margin = 2}), edge), straight, 0.003 * straight) << edge;
    }
}

// A strong shear brings blocks so close to one another that every other one still shares cells: nothing may be lost
// where they are deposited at once.
TEST(CellMedia, OfShearedVolumesHoldAllThatTheirVoxelsDo) {
    ViewScene scene = orthographicScene(boxField(Int3(0), Int3(63, 63, 7)), {0.7, Rgb(1), {}}, 24, 24);
    scene.volumes[0].wsFromIs = Mat4(1, 0, 0, 0, 8, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1);
    const double voxels = 64 * 64 * 8;
    for (int repeat = 0; repeat < 10; ++repeat) {
        const CellMedia media = cellMedia(scene, {}, 1.7, Simd());
        double sum = 0;
        for (const Real value : media.extinction[0]) sum += double(value) * 1.7 * 1.7 * 1.7;
        ASSERT_NEAR(sum, 0.7 * voxels, 1e-4 * voxels);
    }
}

// At 45 degrees two axes face a wall alike, and only one of them counts it.
TEST(CellGrid, WallsAtExactly45DegreesSendBackWhatThoseBesideDo) {
    const auto sentBack = [](double degrees) {
        const double a = glm::radians(degrees);
        CellGrid grid(1, {{Vec3(-11), Vec3(11)}});
        grid.raiseWalls(
            oneSolid(squareMesh({0.13, 0.07, 0.21}, {std::sin(a), std::cos(a), 0}, 6), true, true, false, Rgb(0.5)));
        double sum = 0;
        for (std::size_t side = 0; side < grid.sides(); ++side) sum += grid.albedoOfSide(side).x;
        return sum / double(grid.sides());
    };
    const double beside = 0.5 * (sentBack(44.7) + sentBack(45.3));
    EXPECT_NEAR(sentBack(45), beside, 0.03 * beside);
}

// At its very place a lamp without a radius shines through nothing: 0 times infinity.
TEST(LampField, IsFiniteAtTheLamp) {
    ViewScene scene = orthographicScene(boxField(Int3(-4), Int3(4)), {0.5, Rgb(1), {}}, 24, 24);
    scene.lights = {lamp({0, 0, 0}, 5)};
    const CellMedia media = cellMedia(scene, {}, 1, Simd(), {.margin = 1});
    LampField field({scene.lights[0], octavesOf({}), scene.camera}, std::make_shared<const CellGrid>(media.grid), 1);
    field.makeMean({&media}, nullptr);
    Real rgb[3] = {0, 0, 0};
    field.addTo(Vec3(0), rgb);
    EXPECT_TRUE(std::isfinite(rgb[0])) << rgb[0];
}

// Second differences of a quadratic function are the same everywhere. Cells around a block are sharpened as their
// neighbours are; a dark cell counts for none of those beside it.
TEST(LampField, SharpensMeansByASixthOfTheirSecondDifferences) {
    const auto grid = std::make_shared<const CellGrid>(1, std::vector<Bounds>{{Vec3(0.5), Vec3(23.5)}});
    CellField field(grid, 1);
    const auto mean = [](const Vec3& ws) { return 2 + 0.01 * ws.x * ws.x - 0.03 * ws.y * ws.y + 0.3 * ws.z; };
    const Int3 dark(5, 12, 12);
    const auto forAll = [&](const auto& visit) {
        for (std::size_t b = 0; b < grid->storedBlocks().size(); ++b)
            for (int i = 0; i < static_cast<int>(kPaddedCells); ++i)
                visit(grid->storedBlocks()[b] * kCellEdge - 1 +
                          Int3(i % kPaddedEdge, i / kPaddedEdge % kPaddedEdge, i / (kPaddedEdge * kPaddedEdge)),
                      field.block(b)[i]);
    };
    forAll([&](const Int3& place, Real& value) {
        value = place == dark ? Real(100) : static_cast<Real>(mean(grid->wsFromCs(Vec3(place) + 0.5)));
    });
    sharpenMeans(field, [](const Int3&) { return 1.0; });
    forAll([&](const Int3& place, Real& value) {
        if (place == dark || grid->index(place) < 0) return;
        const Int3 beside = glm::abs(place - dark);
        double bend = 0.02 - 0.06;
        if (beside == Int3(1, 0, 0)) bend -= 0.02;
        if (beside == Int3(0, 1, 0)) bend += 0.06;
        ASSERT_NEAR(double(value), mean(grid->wsFromCs(Vec3(place) + 0.5)) - bend / 6, 1e-5)
            << place.x << " " << place.y << " " << place.z;
    });
}

}  // namespace
}  // namespace scrim::test
