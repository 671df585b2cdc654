// SPDX-License-Identifier: Apache-2.0
// Cells, and values that go from coarse cells to fine ones.
#include <scrim/engine/transport/cell_grid.h>

#include <scrim/base/error.h>
#include <scrim/engine/transport/cell_field.h>
#include <scrim/engine/transport/cell_media.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

#include <glm/common.hpp>

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

}  // namespace
}  // namespace scrim::test
