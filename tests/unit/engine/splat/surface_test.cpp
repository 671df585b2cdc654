// SPDX-License-Identifier: Apache-2.0
#include "support/fields.h"

#include <scrim/engine/splat/surface.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

constexpr int kSheets = 40;

// A ball with a soft rim, in sheets and texels of half a voxel.
class SurfaceOnItsWay : public ::testing::Test {
  protected:
    SurfaceOnItsWay() {
        Classified look;
        look.transfer = {{0.3, Rgb(1), 0}, {0.5, Rgb(1, 0.5, 0.2), 2}, {1, Rgb(0.2, 0.5, 0.2), 2}};
        scene.volumes[0].classified = std::make_shared<const Classified>(look);
        sheets.texel = sheets.thickness = 0.5;
        sheets.ssOrigin = Vec3(-10);
        sheets.width = sheets.height = 48;
        sheets.count = kSheets;
    }

    std::unique_ptr<Surface> splatted() const {
        auto surface =
            std::make_unique<Surface>(scene.volumes[0], scene.dials, sheets, sharedLattice(sheets), kSheets, 1);
        surface->beginBatch(0);
        FieldPlanes& field = surface->field();
        field.beginBatch(0, kSheets);
        for (int phase = 0; phase < FieldPlanes::kPhases; ++phase)
            for (int i = 0; i < field.tasks(phase); ++i) field.splat(phase, i, nullptr, {});
        for (int i = 0; i < field.planesToFinish(); ++i) field.finish(i);
        return surface;
    }

    ViewScene scene = orthographicScene(
        makeField(Int3(-8), Int3(8), 1,
                  [](const Vec3& is) { return std::clamp(0.5 + 0.2 * (5 - glm::length(is)), 0.0, 1.0); }),
        {1, Rgb(0.9), {}}, 20, 32);
    Sheets sheets;
};

bool same(const Real* a, const Real* b) {
    return std::equal(a, a + kTileSize, b);
}

// A plane and a face are shared by two sheets. What one has looked up, the next one uses.
TEST_F(SurfaceOnItsWay, LooksTheSameWhetherItIsFollowedOrMetAnew) {
    const auto surface = splatted();
    RayTile rays{};
    for (int k = 0; k < kTileSize; ++k) {
        rays.u[k] = Real(8.3) + Real(0.9) * static_cast<Real>(k % kTileEdge);
        rays.v[k] = Real(9.1) + Real(0.8) * static_cast<Real>(k / kTileEdge);
        rays.stepU[k] = Real(0.11);
        rays.stepV[k] = Real(0.07) * static_cast<Real>(k % 3);
    }
    SampleTile at{};
    at.rays = &rays;
    auto followed = std::make_unique<ClassifiedTile>();
    int seen = 0;
    for (int p = 0; p < kSheets; ++p) {
        at.step = static_cast<Real>(p);
        for (int k = 0; k < kTileSize; ++k) {
            at.u[k] = rays.u[k] + at.step * rays.stepU[k];
            at.v[k] = rays.v[k] + at.step * rays.stepV[k];
            at.eyeA[k] = rays.stepU[k];
            at.eyeB[k] = rays.stepV[k];
        }
        auto anew = std::make_unique<ClassifiedTile>();
        const bool shows = surface->classify(p, at, nullptr, *anew);
        EXPECT_EQ(surface->classify(p, at, nullptr, *followed), shows) << p;
        EXPECT_TRUE(same(followed->extinction, anew->extinction)) << p;
        if (!shows) continue;
        ++seen;
        for (int c = 0; c < 3; ++c) {
            EXPECT_TRUE(same(followed->emission[c], anew->emission[c])) << p;
            EXPECT_TRUE(same(followed->normal[c], anew->normal[c])) << p;
        }
    }
    EXPECT_GT(seen, 15);  // the ball is 20 sheets thick
}

// By the cells of a raster, or by the places of the same rays.
TEST_F(SurfaceOnItsWay, AttenuatesTheSameAlongCellsAndAlongRays) {
    const auto surface = splatted();
    LightView view;
    view.tsSource = {0.21, -0.13, 0};
    view.first = {6.4, 7.7};
    view.cell = 1.1;
    view.width = view.height = 2 * kTileEdge;
    const Int2 cell(kTileEdge, 0);
    auto byCells = std::make_unique<ClassifiedTile>();
    double depth = 0;
    for (int p = 0; p < kSheets; ++p) {
        SampleTile at{};
        const LightView::Cells map = view.at(p);
        for (int k = 0; k < kTileSize; ++k) {
            at.u[k] = static_cast<Real>(map.offsetU + (cell.x + k % kTileEdge) * map.scale);
            at.v[k] = static_cast<Real>(map.offsetV + (cell.y + k / kTileEdge) * map.scale);
            at.eyeA[k] = static_cast<Real>(view.tsSource.x);
            at.eyeB[k] = static_cast<Real>(view.tsSource.y);
        }
        auto byRays = std::make_unique<ClassifiedTile>();
        EXPECT_EQ(surface->meanExtinction(p, view, cell, nullptr, *byCells), surface->meanExtinction(p, at, *byRays))
            << p;
        for (int k = 0; k < kTileSize; ++k) {
            EXPECT_NEAR(byCells->extinction[k], byRays->extinction[k], 2e-3) << p << " " << k;
            depth += double(byCells->extinction[k]);
        }
    }
    EXPECT_GT(depth, 100);
}

}  // namespace
}  // namespace scrim::test
