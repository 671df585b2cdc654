// SPDX-License-Identifier: Apache-2.0
// What per-view splatting puts into its cells, against integrals of the field along the cells' rays.
#include <scrim/engine/splat/warped_splatter.h>

#include "support/fields.h"

#include <scrim/volume/field_sampler.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim::test {
namespace {

constexpr int kCells = 64;

// A view from (0, 0, -60) that looks along N, a texel a cell at N = 0.
Lattice viewFromAfar() {
    Lattice raster;
    raster.kind = Lattice::Kind::perspective;
    raster.width = raster.height = kCells;
    const double w = 60, middle = kCells / 2 + 0.3;
    raster.rsFromTs[0] = {60, 0, 0, 0};
    raster.rsFromTs[1] = {0, 60, 0, 0};
    raster.rsFromTs[2] = {middle, middle, 1, 1};
    raster.rsFromTs[3] = {middle * w, middle * w, 0, w};
    return raster;
}

Mat4 leaning() {
    Mat4 m(1.0);
    m[0] = {0.9, 0.3, -0.2, 0};
    m[1] = {-0.25, 0.92, 0.25, 0};
    m[2] = {0.25, -0.2, 0.93, 0};
    m[3] = {0.3, -0.4, 8.2, 1};
    return m;
}

// Mean of the field along the ray through cell (x, y) within sheet n.
double meanAlongRay(const FieldSampler& probe, const Mat4& isFromTs, const Lattice& raster, int x, int y, int n) {
    const Mat3 plane = glm::inverse(raster.fromPlane(n + 0.5));
    const Vec3 p = plane * Vec3(x, y, 1);
    const Vec3 ray = raster.rayThrough(x, y), middle(p.x / p.z, p.y / p.z, n + 0.5);
    double sum = 0;
    constexpr int kSteps = 64;
    for (int i = 0; i < kSteps; ++i)
        sum += probe.value(transformPoint(isFromTs, middle + ray / ray.z * ((i + 0.5) / kSteps - 0.5))) / kSteps;
    return sum;
}

TEST(WarpedSplatter, CellsHoldTheMeanOfTheFieldAlongTheirRays) {
    const auto field = smokeField(9);
    const Lattice raster = viewFromAfar();
    const Mat4 tsFromIs = leaning();
    const WarpedSplatter splatter(*field, tsFromIs, raster, Kernel::linear, 32, 1);
    PlaneStack planes(20, kCells, kCells, 1);
    for (int p = 0; p < 20; ++p) planes.begin(p);
    const std::uint64_t footprints = splatter.splat(0, 20, planes, 0, {});
    for (int p = 0; p < 20; ++p) planes.finish(p);
    EXPECT_GT(footprints, field->activeVoxels);

    const FieldSampler probe(*field, Kernel::linear);
    const Mat4 isFromTs = glm::inverse(tsFromIs);
    double squares = 0, sum = 0, largest = 0;
    int count = 0;
    for (int n = 1; n < 17; n += 3)
        for (int y = 18; y < 46; y += 3)
            for (int x = 18; x < 46; x += 3) {
                const double expected = meanAlongRay(probe, isFromTs, raster, x, y, n);
                const double found = planes.plane(n)[y * kCells + x];
                squares += (found - expected) * (found - expected);
                sum += expected;
                largest = std::max(largest, std::abs(found - expected));
                ++count;
            }
    ASSERT_GT(sum / count, 0.01);
    // Slopes of up to 17 / 60 against the middle ray move the kernel by a seventh of a voxel at a sheet's faces;
    // that averages out to second order.
    EXPECT_LT(std::sqrt(squares / count) / (sum / count), 0.06);
    EXPECT_LT(largest, 0.05);
}

TEST(WarpedSplatter, FeedsTilesAsIfTheyWereVoxels) {
    SparseField tiled;
    tiled.tiles.push_back({{0, 0, 0}, 16, 1.0f});
    tiled.blockValues = std::make_shared<const float>(0.0f);
    tiled.activeVoxels = 4096;
    const auto voxels = boxField({0, 0, 0}, {15, 15, 15});
    const Lattice raster = viewFromAfar();
    const auto splatted = [&](const SparseField& field) {
        PlaneStack planes(16, kCells, kCells, 1);
        for (int p = 0; p < 16; ++p) planes.begin(p);
        WarpedSplatter(field, leaning(), raster, Kernel::linear, 16, 1).splat(0, 16, planes, 0, {});
        for (int p = 0; p < 16; ++p) planes.finish(p);
        return std::vector<float>(planes.plane(8), planes.plane(8) + kCells * kCells);
    };
    const auto a = splatted(tiled), b = splatted(*voxels);
    for (std::size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], 1e-4) << i;
    EXPECT_GT(*std::max_element(a.begin(), a.end()), 0.9f);
}

}  // namespace
}  // namespace scrim::test
