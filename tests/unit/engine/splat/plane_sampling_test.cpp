// SPDX-License-Identifier: Apache-2.0
// Vectorised look-ups against plain double ones. Values lie in [0, 1] and positions below 128, so that a float's
// position is good to 4e-6 texels and a sample to 1e-5.
#include <scrim/engine/splat/plane_stack.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace scrim::test {
namespace {

constexpr double kTolerance = 1e-5;
constexpr int kSide = 16;  // of a lattice

class Random {
  public:
    explicit Random(unsigned seed) : m_engine(seed) {}
    float in(double lower, double upper) {
        return static_cast<float>(std::uniform_real_distribution<double>(lower, upper)(m_engine));
    }

  private:
    std::mt19937 m_engine;
};

struct Plane {
    int width, height;
    std::vector<float> values;

    Plane(int w, int h, unsigned seed) : width(w), height(h) {
        Random random(seed);
        for (int i = 0; i < w * h; ++i) values.push_back(random.in(0, 1));
        // Vectors may read behind the last row, but nothing of that may count, not even times 0.
        values.resize(values.size() + 128, std::numeric_limits<float>::quiet_NaN());
    }
    FloatPlane view() const { return {values.data(), width, height}; }
    double at(int x, int y) const { return values[static_cast<std::size_t>(y * width + x)]; }
};

// The texel, or the mix of four, at (u, v); positions outside are clamped.
double sampled(const Plane& plane, double u, double v, bool nearest) {
    u = std::clamp(u, 0.0, plane.width - 1.0);
    v = std::clamp(v, 0.0, plane.height - 1.0);
    if (nearest) return plane.at(static_cast<int>(std::floor(u + 0.5)), static_cast<int>(std::floor(v + 0.5)));
    const int x = std::min(static_cast<int>(u), plane.width - 2), y = std::min(static_cast<int>(v), plane.height - 2);
    const double s = u - x, t = v - y;
    return (1 - t) * ((1 - s) * plane.at(x, y) + s * plane.at(x + 1, y)) +
           t * ((1 - s) * plane.at(x, y + 1) + s * plane.at(x + 1, y + 1));
}

// Half-way between texels a float may round either way.
bool undecided(double position) {
    return std::abs(position - std::floor(position) - 0.5) < 1e-4;
}

class PlaneSampling : public testing::TestWithParam<bool> {};

TEST_P(PlaneSampling, AtPointsIsThePlainLookUpAlsoOutside) {
    const bool nearest = GetParam();
    const Plane plane(37, 29, 1);
    Random random(2);
    constexpr int kCount = 4096;
    std::vector<float> u, v, out(kCount);
    for (int k = 0; k < kCount; ++k) {
        u.push_back(random.in(-8, 45));
        v.push_back(random.in(-8, 37));
    }
    // Borders and corners, exactly.
    const float edges[] = {0, 36, 35, -1e9f, 1e9f, 28};
    for (std::size_t i = 0; i < 36; ++i) {
        u[i] = edges[i % 6];
        v[i] = edges[i / 6];
    }
    samplePoints(plane.view(), u.data(), v.data(), nearest, kCount, out.data());
    for (std::size_t k = 0; k < kCount; ++k) {
        if (nearest && (undecided(u[k]) || undecided(v[k]))) continue;
        ASSERT_NEAR(out[k], sampled(plane, u[k], v[k], nearest), kTolerance) << "at " << u[k] << "," << v[k];
    }
}

TEST_P(PlaneSampling, OnALatticeIsThePlainLookUp) {
    const bool nearest = GetParam();
    const Plane plane(70, 64, 3);
    Random random(4);
    for (int i = 0; i < 400; ++i) {
        const float u = random.in(-20, 80), v = random.in(-20, 70);
        const float step = i % 2 ? 1.0f : random.in(0.05, 3);  // 1: the streaming path, where it lies inside
        float out[kSide * kSide];
        sampleLattice(plane.view(), u, v, step, nearest, out);
        for (int k = 0; k < kSide * kSide; ++k) {
            const double x = u + double(k % kSide) * step, y = v + double(k / kSide) * step;
            if (nearest && (undecided(x) || undecided(y))) continue;
            ASSERT_NEAR(out[k], sampled(plane, x, y, nearest), kTolerance) << x << "," << y << " step " << step;
        }
    }
}

// One texel a cell is streamed instead of gathered. At fractions that floats hold exactly there is no excuse for a
// single bit of difference.
TEST_P(PlaneSampling, StreamedIsTheSameBitsAsGathered) {
    const Plane plane(64, 48, 5);
    for (int i = 0; i < 64; ++i) {
        const float u = -3.0f + 0.78125f * static_cast<float>(i), v = 5.0f + 0.34375f * static_cast<float>(i);
        float streamed[kSide * kSide], gathered[kSide * kSide], us[kSide * kSide], vs[kSide * kSide];
        sampleLattice(plane.view(), u, v, 1, GetParam(), streamed);
        for (int k = 0; k < kSide * kSide; ++k) {
            us[k] = u + static_cast<float>(k % kSide);
            vs[k] = v + static_cast<float>(k / kSide);
        }
        samplePoints(plane.view(), us, vs, GetParam(), kSide * kSide, gathered);
        for (int k = 0; k < kSide * kSide; ++k) ASSERT_EQ(streamed[k], gathered[k]) << u << "," << v << " " << k;
    }
}

// A window of a plane answers as the whole does, as long as positions lie in it.
TEST_P(PlaneSampling, InAWindowIsTheSameBitsAsInTheWhole) {
    const Plane whole(80, 60, 6);
    constexpr int x0 = 16, y0 = 24, width = 48, height = 32;
    Plane window(width, height, 7);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            window.values[static_cast<std::size_t>(y * width + x)] = static_cast<float>(whole.at(x0 + x, y0 + y));
    const FloatPlane view{window.values.data(), width, height, x0, y0};
    Random random(8);
    for (int i = 0; i < 100; ++i) {
        const float step = i % 2 ? 1.0f : random.in(0.3, 1);
        const float u = random.in(x0, x0 + width - 1 - 15 * step), v = random.in(y0, y0 + height - 1 - 15 * step);
        float a[kSide * kSide], b[kSide * kSide];
        sampleLattice(whole.view(), u, v, step, GetParam(), a);
        sampleLattice(view, u, v, step, GetParam(), b);
        for (int k = 0; k < kSide * kSide; ++k) ASSERT_EQ(a[k], b[k]) << u << "," << v << " step " << step;
    }
}

// Beyond its border a window repeats that, as a plane does: clamping counts from the window's corner.
TEST_P(PlaneSampling, BeyondAWindowIsItsBorder) {
    const Plane plane(32, 32, 9);
    const FloatPlane view{plane.values.data(), 32, 32, 100, 50};
    float u[16], v[16], out[16];
    for (int k = 0; k < 16; ++k) {
        u[k] = k % 2 ? 0.0f : 1000.0f;
        v[k] = 60.0f;
    }
    samplePoints(view, u, v, GetParam(), 16, out);
    for (int k = 0; k < 16; ++k) EXPECT_NEAR(out[k], plane.at(k % 2 ? 0 : 31, 10), kTolerance);
}

TEST_P(PlaneSampling, AttenuateKeepsTauAtEntryAndAddsThePath) {
    const Plane extinction(64, 64, 10), before(40, 20, 11);
    Random random(12);
    for (int i = 0; i < 50; ++i) {
        Plane tau = before, entry(24, 16, 13);
        AttenuateTile tile{};
        tile.extinction = extinction.view();
        tile.u = random.in(5, 20);
        tile.v = random.in(5, 20);
        tile.step = i % 2 ? 1.0f : random.in(0.5, 2);
        tile.nearest = GetParam();
        tile.path = random.in(0.1, 2);
        tile.slopeA = random.in(-1.5, 1.5);
        tile.slopeB = random.in(-1.5, 1.5);
        tile.slopeStep = i % 3 ? random.in(0, 0.1) : 0.0f;
        tile.tau = tau.values.data() + 40 * 2 + 8;
        tile.tauStride = 40;
        tile.entry = entry.values.data();
        tile.entryStride = 24;
        attenuateTile(tile);
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x) {
                const double u = tile.u + double(x) * tile.step, v = tile.v + double(y) * tile.step;
                ASSERT_EQ(entry.at(x, y), before.at(8 + x, 2 + y));
                if (GetParam() && (undecided(u) || undecided(v))) continue;
                const double a = tile.slopeA + double(x) * tile.slopeStep, b = tile.slopeB + double(y) * tile.slopeStep;
                const double path = tile.path * std::sqrt(1 + a * a + b * b);
                ASSERT_NEAR(tau.at(8 + x, 2 + y),
                            before.at(8 + x, 2 + y) + path * sampled(extinction, u, v, GetParam()), 1e-4);
            }
        // Nothing beside the tile was touched.
        for (int y = 0; y < 20; ++y)
            for (int x = 0; x < 40; ++x)
                if (x < 8 || x >= 24 || y < 2 || y >= 18) {
                    ASSERT_EQ(tau.at(x, y), before.at(x, y)) << x << "," << y;
                }
    }
}

INSTANTIATE_TEST_SUITE_P(Filters, PlaneSampling, testing::Values(false, true),
                         [](const auto& test) { return test.param ? "nearest" : "bilinear"; });

}  // namespace
}  // namespace scrim::test
