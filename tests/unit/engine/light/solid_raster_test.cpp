// SPDX-License-Identifier: Apache-2.0
// A raster of rays that is divided at edges, against shapes whose edges are known.
#include <scrim/engine/light/solid_raster.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace scrim::test {
namespace {

constexpr Real kNone = std::numeric_limits<Real>::infinity();

// A wall at 5 with a straight edge.
Real beside(double x, double y) {
    return static_cast<Real>(x + 0.3 * y > 12.37 ? 5 : kNone);
}

// The lit part of a path that crosses the edge.
TEST(SolidRaster, CutsPathsAtAnEdgeWithinAPartOfACell) {
    for (const int parts : {2, 4, 8, 16}) {
        const SolidRaster raster({32, 32}, parts, 1, beside);
        RasterPaths paths;
        alignas(64) Real light[kTileSize];
        for (int k = 0; k < kTileSize; ++k) {
            paths.first.x[k] = Real(3.1) + Real(0.01) * static_cast<Real>(k);
            paths.last.x[k] = paths.first.x[k] + 8;
            paths.first.y[k] = paths.last.y[k] = Real(9.7);
            paths.first.n[k] = 7;
            paths.last.n[k] = 8;
            light[k] = 2;
        }
        raster.pass(paths, Simd(), light);
        for (int k = 0; k < kTileSize; ++k) {
            const double length = 8, lit = std::clamp(12.37 - 0.3 * 9.7 - double(paths.first.x[k]), 0.0, length);
            // Half the distance of two rays in either direction, and half that of two points.
            EXPECT_NEAR(light[k], 2 * lit / length, 2 * (0.5 * 1.3 + 1) / parts / length) << parts << ", " << k;
        }
    }
}

// Rays that do not reach the wall are lit, those behind it dark, and a path that passes it is lit up to there.
TEST(SolidRaster, ComparesEndsWithWhereAPathIs) {
    const SolidRaster raster({16, 16}, 8, 1, [](double, double) { return Real(5); });
    RasterPaths paths{};
    alignas(64) Real light[kTileSize];
    for (int k = 0; k < kTileSize; ++k) {
        paths.first.x[k] = paths.first.y[k] = 2;
        paths.last.x[k] = paths.last.y[k] = 10;
        paths.first.n[k] = static_cast<Real>(k < 100 ? 2 : k < 200 ? 4 : 6);
        paths.last.n[k] = paths.first.n[k] + 2;
        light[k] = 1;
    }
    raster.pass(paths, Simd(), light);
    for (int k = 0; k < kTileSize; ++k) EXPECT_NEAR(light[k], k < 100 ? 1 : k < 200 ? 0.5 : 0, 1.0 / 32) << k;
}

// Rays are added along the edge only: in the 64 + 20 cells that it passes and the next ones, 25 at least and 17 x 17 at
// most.
TEST(SolidRaster, TracesFinerRaysOnlyWhereAnEdgeIs) {
    const SolidRaster plain({64, 64}, 16, 1, [](double, double) { return kNone; });
    EXPECT_EQ(plain.rays(), 64u * 64);
    const SolidRaster raster({64, 64}, 16, 1, beside);
    EXPECT_GT(raster.rays(), 64u * 64 + 100);
    EXPECT_LT(raster.rays(), 64u * 64 + 3 * 84 * 120);
    EXPECT_LE(raster.bytes(), SolidRaster::bytes({64, 64}, 16));
}

// Where every cell has edges, cells are divided less, so that memory is bounded.
TEST(SolidRaster, StaysWithinItsBoundOfMemory) {
    const auto leaves = [](double x, double y) {
        return static_cast<Real>(std::sin(9 * x) * std::sin(8 * y) > 0.1 ? 3 : kNone);
    };
    for (const Int2& size : {Int2(2, 2), Int2(2, 200), Int2(48, 16), Int2(300, 300)}) {
        const SolidRaster raster(size, 16, 1, leaves);
        EXPECT_LE(raster.bytes(), SolidRaster::bytes(size, 16)) << size.x;
    }
}

}  // namespace
}  // namespace scrim::test
