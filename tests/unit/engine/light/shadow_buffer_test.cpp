// SPDX-License-Identifier: Apache-2.0
// Shadow buffers through media whose optical depth is known in closed form: tau at a sheet's entry.
#include <scrim/engine/light/shadow_buffer.h>

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <vector>

namespace scrim::test {
namespace {

constexpr int kWidth = 96, kHeight = 80, kSheets = 24;
constexpr double kTexel = 0.5, kThickness = 0.4, kSigma = 1.7;

Sheets sheetsOf(int count) {
    Sheets sheets;
    sheets.texel = kTexel;
    sheets.thickness = kThickness;
    sheets.width = kWidth;
    sheets.height = kHeight;
    sheets.count = count;
    return sheets;
}

// Extinction for all sheets; `value(x, y, n)` of 0 all over a tile leaves that inactive.
PlaneStack extinctionOf(const std::function<double(int x, int y, int n)>& value) {
    PlaneStack planes(kSheets, kWidth, kHeight, 1);
    for (int n = 0; n < kSheets; ++n) {
        planes.begin(n);
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x)
                if (const double v = value(x, y, n); v > 0) {
                    planes.activate(n, x / kTileEdge, y / kTileEdge);
                    planes.plane(n)[y * planes.rowStride() + x] = static_cast<float>(v);
                }
        planes.finish(n);
    }
    return planes;
}

PlaneStack uniform() {
    return extinctionOf([](int, int, int) { return kSigma; });
}

LightView distantView(double slopeU, double slopeV) {
    LightView view;
    view.tsSource = {slopeU, slopeV, 0};
    // At N = 0 rays start wherever the stack's last sheet may be reached from; half a texel off, as the middle of
    // sheet 0 is half a sheet in.
    view.first = {-64 - 0.5 * slopeU, -64 - 0.5 * slopeV};
    view.width = view.height = 256;
    view.slopeScale = kTexel / kThickness;
    return view;
}

// Tau at entry of every sheet at texel (x, y), the sheets carried through in batches of these sizes.
struct Taus {
    std::vector<std::vector<float>> sheets;  // kWidth x kHeight each, only active tiles filled in
    double at(int x, int y, int n) const {
        return sheets[static_cast<std::size_t>(n)][static_cast<std::size_t>(y * kWidth + x)];
    }
};

Taus carry(const LightView& view, const PlaneStack& extinction, const std::vector<int>& batches,
           ShadowFilter filter = ShadowFilter::bilinear) {
    ShadowBuffer buffer(view, sheetsOf(kSheets), filter, 0, kSheets);
    Taus out;
    int first = 0;
    for (const int count : batches) {
        // A batch's planes begin at 0 in the engine.
        PlaneStack batch(count, kWidth, kHeight, 1);
        for (int p = 0; p < count; ++p)
            for (int ty = 0; ty < batch.tilesY(); ++ty)
                for (int tx = 0; tx < batch.tilesX(); ++tx) {
                    if (!extinction.active(first + p, tx, ty)) continue;
                    batch.activate(p, tx, ty);
                    for (int y = ty * kTileEdge; y < (ty + 1) * kTileEdge; ++y)
                        for (int x = tx * kTileEdge; x < (tx + 1) * kTileEdge; ++x)
                            batch.plane(p)[y * kWidth + x] = extinction.plane(first + p)[y * kWidth + x];
                }
        buffer.beginBatch(first, count, batch);
        for (int task = 0; task < buffer.taskCount(); ++task) buffer.attenuate(task, batch, {});
        for (int p = 0; p < count; ++p) {
            std::vector<float> tau(kWidth * kHeight, -1.0f);
            for (int ty = 0; ty < batch.tilesY(); ++ty)
                for (int tx = 0; tx < batch.tilesX(); ++tx) {
                    if (!batch.active(p, tx, ty)) continue;
                    float tile[kTileSize];
                    buffer.lookUpTile(p, tx * kTileEdge, ty * kTileEdge, tile);
                    for (int k = 0; k < kTileSize; ++k)
                        tau[static_cast<std::size_t>((ty * kTileEdge + k / kTileEdge) * kWidth + tx * kTileEdge +
                                                     k % kTileEdge)] = tile[k];
                }
            out.sheets.push_back(std::move(tau));
        }
        first += count;
    }
    return out;
}

struct Slant {
    double u, v;
};
void PrintTo(const Slant& s, std::ostream* out) {
    *out << s.u << "," << s.v;
}

class DistantLight : public testing::TestWithParam<Slant> {};

// tau = sigma * n * thickness / cos at the entry of sheet n. Texels whose rays have stayed on the raster so far:
// beyond it nothing is fed, and nothing attenuates. Sums of 24 floats: 1e-6.
TEST_P(DistantLight, GathersThicknessOverCosine) {
    const auto [slopeU, slopeV] = GetParam();
    const Taus tau = carry(distantView(slopeU, slopeV), uniform(), {kSheets});
    const double scale = kTexel / kThickness;
    const double secant = std::sqrt(1 + scale * scale * (slopeU * slopeU + slopeV * slopeV));
    for (int n = 0; n < kSheets; ++n)
        for (int y = 40; y < 44; ++y)
            for (int x = 44; x < 52; ++x) {
                const double expected = kSigma * n * kThickness * secant;
                ASSERT_NEAR(tau.at(x, y, n), expected, 1e-6 * expected) << x << "," << y << " sheet " << n;
            }
}

TEST_P(DistantLight, IsNotChangedByABitByBatches) {
    const auto [slopeU, slopeV] = GetParam();
    std::mt19937 random(3);
    std::vector<float> noise(kWidth * kHeight * kSheets);
    for (float& v : noise) v = static_cast<float>(random() % 1000) / 1000;
    // A lens of noise with empty tiles around it, so that batches have different windows.
    const PlaneStack extinction = extinctionOf([&](int x, int y, int n) {
        const double r2 = std::pow(x - 50, 2) + std::pow(y - 40, 2) + 9 * std::pow(n - 12, 2);
        return r2 < 30 * 30 ? noise[static_cast<std::size_t>((n * kHeight + y) * kWidth + x)] : 0.0;
    });
    const LightView view = distantView(slopeU, slopeV);
    for (const ShadowFilter filter : {ShadowFilter::bilinear, ShadowFilter::nearest}) {
        const Taus whole = carry(view, extinction, {kSheets}, filter);
        EXPECT_EQ(whole.sheets, carry(view, extinction, {5, 8, 11}, filter).sheets);
        EXPECT_EQ(whole.sheets, carry(view, extinction, std::vector<int>(kSheets, 1), filter).sheets);
    }
}

INSTANTIATE_TEST_SUITE_P(Slants, DistantLight,
                         testing::Values(Slant{0, 0}, Slant{0.3, -0.2}, Slant{1, 0}, Slant{-0.77, 0.9},
                                         Slant{0, -1.3}));

// Along whole texels a sheet, look-ups fall on texels: tau is a plain sum of what lies before.
TEST(ShadowBuffer, IsTheSumOfTheSheetsBeforeAndNotOfItsOwn) {
    std::mt19937 random(5);
    std::vector<float> noise(kWidth * kHeight * kSheets);
    for (float& v : noise) v = static_cast<float>(1 + random() % 1000) / 1000;
    const auto sigma = [&](int x, int y, int n) {
        return double(noise[static_cast<std::size_t>((n * kHeight + y) * kWidth + x)]);
    };
    for (const int slope : {0, 1, -1}) {
        const Taus tau = carry(distantView(slope, 0), extinctionOf(sigma), {7, kSheets - 7});
        const double scale = kTexel / kThickness * slope, path = kThickness * std::sqrt(1 + scale * scale);
        for (int n = 0; n < kSheets; ++n)
            for (int y = 0; y < kHeight; y += 7)
                for (int x = 30; x < 60; ++x) {
                    double expected = 0;
                    for (int m = 0; m < n; ++m) expected += path * sigma(x - (n - m) * slope, y, m);
                    ASSERT_NEAR(tau.at(x, y, n), expected, 1e-5 * expected + 1e-9)
                        << x << "," << y << " sheet " << n << " slope " << slope;
                }
    }
}

// A raster of slopes that holds all rays from the source to the sheets.
LightView pointView() {
    LightView view;
    view.distant = false;
    view.tsSource = {47.3, 38.6, -30.2};
    view.cell = 0.7 / (kSheets + 31);
    view.first = {-1.6, -1.6};
    view.width = view.height = 256;
    view.slopeScale = kTexel / kThickness;
    return view;
}

// Rays fan out: the slant is each ray's own. Between cells the secant is interpolated, which misses its curvature
// times the square of a cell over eight: 1e-4 of it at most.
TEST(ShadowBuffer, OfAPointLightGathersEachRaysOwnSecant) {
    const LightView view = pointView();
    for (const std::vector<int>& batches : {std::vector<int>{kSheets}, {9, 15}}) {
        const Taus tau = carry(view, uniform(), batches);
        for (int n = 0; n < kSheets; ++n)
            for (int y = 2; y < kHeight - 2; y += 5)
                for (int x = 2; x < kWidth - 2; x += 5) {
                    const double away = n + 0.5 - view.tsSource.z, scale = kTexel / kThickness;
                    const double a = scale * (x - view.tsSource.x) / away, b = scale * (y - view.tsSource.y) / away;
                    const double expected = kSigma * n * kThickness * std::sqrt(1 + a * a + b * b);
                    ASSERT_NEAR(tau.at(x, y, n), expected, 2e-4 * expected) << x << "," << y << " sheet " << n;
                }
    }
}

// A light between the sheets lights those in front of it, and tau counts from there.
TEST(ShadowBuffer, OfALightBetweenTheSheetsStartsBehindIt) {
    LightView view = pointView();
    view.tsSource = {48, 40, 8};
    view.cell = 0.05;
    view.first = {-4, -4};
    const Taus tau = carry(view, uniform(), {6, 18});
    for (int n = 0; n < kSheets; ++n) {
        // Straight ahead, where a cell's ray is exactly along w.
        const double expected = n <= 8 ? 0 : kSigma * (n - 8) * kThickness;
        EXPECT_NEAR(tau.at(48, 40, n), expected, 1e-3 * expected) << "sheet " << n;
    }
}

TEST(ShadowBuffer, AtPointsIsTheTileThatHoldsThem) {
    const LightView view = distantView(0.3, -0.2);
    const PlaneStack extinction = uniform();
    ShadowBuffer buffer(view, sheetsOf(kSheets), ShadowFilter::bilinear, 0, kSheets);
    buffer.beginBatch(0, kSheets, extinction);
    std::uint64_t samples = 0;
    for (int task = 0; task < buffer.taskCount(); ++task) samples += buffer.attenuate(task, extinction, {});
    EXPECT_GE(samples, std::uint64_t{kSheets} * kWidth * kHeight);
    float u[kTileSize], v[kTileSize], tile[kTileSize], points[kTileSize];
    for (int k = 0; k < kTileSize; ++k) {
        u[k] = static_cast<float>(32 + k % kTileEdge);
        v[k] = static_cast<float>(48 + k / kTileEdge);
    }
    buffer.lookUpTile(11, 32, 48, tile);
    buffer.lookUpPoints(11, u, v, kTileSize, points);
    for (int k = 0; k < kTileSize; ++k) EXPECT_NEAR(points[k], tile[k], 1e-6 * tile[k]);
}

// Sheet 0 darkens by `tau(x)`; tau at entry of sheet 1 in buffers that are looked up so many times.
ShadowBuffer behindColumns(const std::function<double(int)>& tau, int lookUps) {
    PlaneStack extinction = uniform();
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) extinction.plane(0)[y * kWidth + x] = static_cast<float>(tau(x) / kThickness);
    ShadowBuffer buffer(distantView(0, 0), sheetsOf(kSheets), ShadowFilter::bilinear, lookUps, kSheets);
    buffer.beginBatch(0, kSheets, extinction);
    for (int task = 0; task < buffer.taskCount(); ++task) buffer.attenuate(task, extinction, {});
    buffer.prefilter(1);
    return buffer;
}

// Between cells a bilinear look-up of x^2 is too high by t (1 - t), on average by 1/6.
TEST(ShadowBuffer, SharpenedForOneLookUpIsRightOnAverage) {
    const auto meanError = [](int lookUps) {
        const ShadowBuffer buffer = behindColumns([](int x) { return 0.01 * x * x; }, lookUps);
        double sum = 0;
        float u[kTileSize], v[kTileSize], tau[kTileSize];
        for (int k = 0; k < kTileSize; ++k) {
            u[k] = 24 + static_cast<float>(k + 0.5) / kTileSize;
            v[k] = 40;
        }
        buffer.lookUpPoints(1, u, v, kTileSize, tau);
        for (int k = 0; k < kTileSize; ++k) sum += tau[k] - 0.01 * double(u[k]) * u[k];
        return sum / kTileSize;
    };
    EXPECT_NEAR(meanError(0), 0.01 / 6, 1e-5);
    EXPECT_NEAR(meanError(1), 0, 1e-5);
    EXPECT_NEAR(meanError(2), -0.01 / 6, 1e-5);
}

TEST(ShadowBuffer, SharpeningLeavesOpaqueEdgesAndTheBorderAsTheyAre) {
    constexpr int kEdge = 40;
    const ShadowBuffer plain = behindColumns([](int x) { return x < kEdge ? 0.5 : 1e5; }, 0);
    const ShadowBuffer sharpened = behindColumns([](int x) { return x < kEdge ? 0.5 : 1e5; }, 2);
    for (int ty = 0; ty < kHeight / kTileEdge; ++ty)
        for (int tx = 0; tx < kWidth / kTileEdge; ++tx) {
            float before[kTileSize], after[kTileSize];
            plain.lookUpTile(1, tx * kTileEdge, ty * kTileEdge, before);
            sharpened.lookUpTile(1, tx * kTileEdge, ty * kTileEdge, after);
            for (int k = 0; k < kTileSize; ++k)
                EXPECT_NEAR(after[k], before[k], 1e-6 * before[k]) << "tile " << tx << "," << ty << " cell " << k;
        }
}

TEST(ShadowBuffer, WithoutActiveTilesDoesNoWorkAndCastsNoShadow) {
    PlaneStack empty(4, kWidth, kHeight, 1);
    ShadowBuffer buffer(distantView(0, 0), sheetsOf(4), ShadowFilter::bilinear, 0, 4);
    buffer.beginBatch(0, 4, empty);
    EXPECT_EQ(buffer.taskCount(), 0);
    float tau[kTileSize];
    buffer.lookUpTile(2, 0, 0, tau);
    for (const float t : tau) EXPECT_EQ(t, 0);
}

TEST(ShadowBuffer, TakesNoMoreBytesThanEstimated) {
    for (const LightView& view : {distantView(0.3, -0.2), distantView(1.5, 1), pointView()})
        for (const int batch : {1, 8, kSheets}) {
            const PlaneStack extinction = uniform();
            ShadowBuffer buffer(view, sheetsOf(kSheets), ShadowFilter::bilinear, 0, batch);
            for (int first = 0; first + batch <= kSheets; first += batch) buffer.beginBatch(first, batch, extinction);
            // The list of tiles in use, a byte each, is not counted.
            const std::size_t tiles = 256u * 256 / kTileSize * static_cast<std::size_t>(batch);
            EXPECT_LE(buffer.bytes(), ShadowBuffer::bytes(view, sheetsOf(kSheets), batch) + tiles) << batch;
        }
}

}  // namespace
}  // namespace scrim::test
