// SPDX-License-Identifier: Apache-2.0
// Sweeps against what they must leave exactly as it is, whatever the cells' size.
#include <scrim/engine/solve/cell_sweep.h>

#include "support/meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include <glm/gtx/string_cast.hpp>
#include <glm/vector_relational.hpp>

namespace scrim::test {
namespace {

struct Box {
    CellGrid grid{1, {{Vec3(0.1), Vec3(15.9)}}};  // 2^3 blocks
    Ordinates set = ordinates(64);
    std::vector<Real> extinction;
    Inflow inflow;

    explicit Box(double sigma, double enters) : extinction(grid.cells(), Real(sigma)) {
        inflow.even.assign(std::size_t(set.count()), Real(enters));
    }
    CellSweep sweep(bool notBelowZero = false) const {
        return {&grid, &set, extinction.data(), &inflow, notBelowZero, {}};
    }
};

// Where nothing is, what enters is what is there.
TEST(CellSweep, ThroughNothingKeepsWhatEnters) {
    const Box box(0, 2.5);
    std::vector<Real> mean(box.grid.cells()), scratch;
    sweepIsotropic(box.sweep(), std::vector<Real>(box.grid.cells(), Real(0)), mean, scratch);
    for (const Real m : mean) ASSERT_NEAR(double(m), 2.5, 1e-5);
}

// What glows as brightly as what enters is in balance with it, however thick cells are.
TEST(CellSweep, IsInBalanceWithWhatGlowsAsBrightly) {
    for (const double sigma : {0.01, 1.0, 30.0}) {
        const Box box(sigma, 3);
        std::vector<Real> mean(box.grid.cells()), scratch;
        sweepIsotropic(box.sweep(), std::vector<Real>(box.grid.cells(), Real(3 * sigma)), mean, scratch);
        for (const Real m : mean) ASSERT_NEAR(double(m), 3, 1e-4) << sigma;
        // The same, direction by direction.
        std::vector<std::int32_t> slots(box.grid.cells());
        std::iota(slots.begin(), slots.end(), 0);
        std::vector<Real> radiance(box.grid.cells() * std::size_t(box.set.count()), Real(3 * sigma));
        sweepDirectional(box.sweep(), slots, radiance);
        for (const Real r : radiance) ASSERT_NEAR(double(r), 3, 1e-4) << sigma;
    }
}

// Both sweeps are one scheme: with an even source they agree.
TEST(CellSweep, OfOneDirectionAfterTheOtherIsThatOfTheirMean) {
    Box box(0.4, 0);
    std::vector<Real> source(box.grid.cells());
    for (std::size_t i = 0; i < source.size(); ++i) source[i] = static_cast<Real>(1 + std::sin(0.7 * double(i)));
    std::vector<Real> mean(box.grid.cells()), scratch;
    sweepIsotropic(box.sweep(), source, mean, scratch);
    std::vector<std::int32_t> slots(box.grid.cells());
    std::iota(slots.begin(), slots.end(), 0);
    const auto count = std::size_t(box.set.count());
    std::vector<Real> radiance;
    for (const Real s : source) radiance.insert(radiance.end(), count, s);
    sweepDirectional(box.sweep(), slots, radiance);
    for (std::size_t i = 0; i < mean.size(); ++i) {
        double sum = 0;
        for (std::size_t m = 0; m < count; ++m) sum += box.set.weights[m] * double(radiance[i * count + m]);
        ASSERT_NEAR(sum / (16 * std::atan(1.0)), double(mean[i]), 1e-4);
    }
}

// The cells whose centres are in a box.
std::vector<bool> within(const CellGrid& grid, const Vec3& lower, const Vec3& upper) {
    std::vector<bool> in(grid.cells());
    for (std::size_t cell = 0; cell < in.size(); ++cell) {
        const Vec3 ws = grid.wsCenter(cell);
        in[cell] = glm::all(glm::greaterThan(ws, lower)) && glm::all(glm::lessThan(ws, upper));
    }
    return in;
}

// A closed room lets nothing in, and what glows in it does not light what is outside.
TEST(CellSweep, DoesNotPassTheWallsOfAClosedRoom) {
    const Vec3 lower(3.3, 2.7, 4.2), upper(12.6, 11.1, 9.9);
    for (const bool glows : {false, true}) {
        Box box(0.2, glows ? 0 : 1);
        box.grid.raiseWalls(oneSolid(roomMesh(lower, upper)));
        const std::vector<bool> in = within(box.grid, lower, upper);
        std::vector<Real> source(box.grid.cells(), Real(0));
        for (std::size_t cell = 0; glows && cell < source.size(); ++cell) source[cell] = in[cell] ? Real(1) : Real(0);
        std::vector<Real> mean(box.grid.cells()), scratch;
        sweepIsotropic(box.sweep(true), source, mean, scratch);
        for (std::size_t cell = 0; cell < mean.size(); ++cell) {
            if (in[cell] == glows) {
                ASSERT_GT(double(mean[cell]), 1e-3) << cell;
            } else {
                ASSERT_EQ(double(mean[cell]), 0) << cell;
            }
        }
    }
}

// An oven: walls that shine evenly fill a room with that light, and catch as much. Stairs are no exception.
TEST(CellSweep, IsInBalanceWithWallsThatShineAsBrightly) {
    for (const auto& mesh : {roomMesh({3.3, 2.7, 4.2}, {12.6, 11.1, 9.9}), ballMesh({8.2, 7.7, 8.1}, 6.3)}) {
        Box box(0, 0);
        box.grid.raiseWalls(oneSolid(mesh, true, true, false, Rgb(1)));
        ASSERT_GT(box.grid.sides(), 100u);
        std::vector<Real> back;  // the albedo of what is closed of a face is 1, also that of stairs
        for (std::size_t side = 0; side < box.grid.sides(); ++side)
            back.push_back(static_cast<Real>(3 * box.grid.albedoOfSide(side).x));
        std::vector<Real> mean(box.grid.cells()), scratch, caught;
        CellSweep sweep = box.sweep();
        sweep.back = back.data();
        sweep.caught = &caught;
        sweepIsotropic(sweep, std::vector<Real>(box.grid.cells(), Real(0)), mean, scratch);
        const Vec3 middle(8.2, 7.7, 8.1);
        for (std::size_t side = 0; side < back.size(); ++side) {
            const std::size_t cell = box.grid.cellOfSide(side);
            if (!box.grid.sees(box.grid.wsInside(box.grid.place(cell)), middle)) continue;
            EXPECT_NEAR(double(mean[cell]), 3, 1e-4);
            EXPECT_NEAR(double(caught[side]), 3, 1e-4) << glm::to_string(box.grid.place(cell));
        }
    }
}

// A glowing cell in a thick medium: diamond differences alone fall below zero beside it, the last sweep does not.
TEST(CellSweep, IsNotBelowZeroWhereItMustNotBe) {
    const Box box(5, 0);
    std::vector<Real> source(box.grid.cells(), Real(0));
    source[0] = 100;
    std::vector<std::int32_t> slots(box.grid.cells());
    std::iota(slots.begin(), slots.end(), 0);
    const auto leastOf = [&](bool notBelowZero) {
        std::vector<Real> radiance;
        for (const Real s : source) radiance.insert(radiance.end(), std::size_t(box.set.count()), s);
        sweepDirectional(box.sweep(notBelowZero), slots, radiance);
        return *std::min_element(radiance.begin(), radiance.end());
    };
    EXPECT_LT(leastOf(false), -0.1);
    EXPECT_GE(leastOf(true), 0);
}

}  // namespace
}  // namespace scrim::test
