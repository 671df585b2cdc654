// SPDX-License-Identifier: Apache-2.0
// Compositing against the over operator in double precision.
//
// The ray positions are multiples of 1/64, so that look-ups fall on the same texels here and there; what is left is
// rounding of some forty sheets: 1e-5 on values around 1.
#include <scrim/engine/composite/composite_tile.h>
#include <scrim/engine/splat/plane_stack.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace scrim::test {
namespace {

constexpr int kWidth = 48, kHeight = 32, kCount = 37;
constexpr double kTolerance = 1e-5;

using Rgba = std::array<double, 4>;

struct Stack {
    std::vector<std::vector<float>> planes;
    std::vector<const float*> pointers;
    std::vector<float> steps;

    SheetList list() const {
        return {pointers.data(), steps.data(), static_cast<int>(pointers.size()), kWidth, kHeight};
    }
    Stack reversed() const {
        Stack out;
        out.planes.assign(planes.rbegin(), planes.rend());
        out.pointTo({steps.rbegin() + 8, steps.rend()});
        return out;
    }
    void pointTo(std::vector<float> places) {
        for (const auto& plane : planes) pointers.push_back(plane.data());
        steps = std::move(places);
        steps.resize(planes.size() + 8, 0.0f);  // vectors read ahead
    }
};

// Random shaded sheets, (S, -alpha), with zeros at the border. Every third place in the batch is left out.
Stack randomStack(unsigned seed, double mostAlpha) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    Stack stack;
    std::vector<float> places;
    for (int n = 0; n < kCount; ++n) {
        std::vector<float> plane(kWidth * kHeight * 4 + 64, 0.0f);
        for (int y = 2; y < kHeight - 2; ++y)
            for (int x = 2; x < kWidth - 2; ++x)
                for (int c = 0; c < 4; ++c)
                    plane[static_cast<std::size_t>((y * kWidth + x) * 4 + c)] =
                        static_cast<float>(c < 3 ? unit(random) : -mostAlpha * unit(random));
        stack.planes.push_back(std::move(plane));
        places.push_back(static_cast<float>(n + n / 2));
    }
    stack.pointTo(std::move(places));
    return stack;
}

RayTile randomRays(unsigned seed) {
    std::mt19937 random(seed);
    const auto dyadic = [&](int lower, int upper) {
        const int steps = static_cast<int>(random() % static_cast<unsigned>((upper - lower) * 64));
        return static_cast<float>(lower * 64 + steps) / 64;
    };
    RayTile rays{};
    for (int k = 0; k < kTileSize; ++k) {
        rays.u[k] = dyadic(-6, kWidth + 6);  // some miss the plane at first
        rays.v[k] = dyadic(-6, kHeight + 6);
        rays.stepU[k] = dyadic(-1, 1);
        rays.stepV[k] = dyadic(-1, 1);
    }
    return rays;
}

Rgba sampled(const std::vector<float>& plane, double u, double v) {
    u = std::clamp(u, 0.0, kWidth - 2.0);
    v = std::clamp(v, 0.0, kHeight - 2.0);
    const int x = static_cast<int>(u), y = static_cast<int>(v);
    const double s = u - x, t = v - y;
    Rgba out{};
    for (std::size_t c = 0; c < 4; ++c) {
        const auto at = [&](int i, int j) {
            return double(plane[static_cast<std::size_t>(((y + j) * kWidth + x + i) * 4) + c]);
        };
        out[c] = (1 - t) * ((1 - s) * at(0, 0) + s * at(1, 0)) + t * ((1 - s) * at(0, 1) + s * at(1, 1));
    }
    return out;
}

// C and A over all sheets, the first one nearest to the eye, in the terms of ZC02 eq. 1: C += T S, T *= 1 - alpha.
Rgba composited(const RayTile& rays, const Stack& stack, int k) {
    Rgba out{};
    double transmittance = 1;
    for (std::size_t n = 0; n < stack.planes.size(); ++n) {
        const Rgba texel = sampled(stack.planes[n], rays.u[k] + double(stack.steps[n]) * rays.stepU[k],
                                   rays.v[k] + double(stack.steps[n]) * rays.stepV[k]);
        for (std::size_t c = 0; c < 3; ++c) out[c] += transmittance * texel[c];
        transmittance *= 1 + texel[3];
    }
    out[3] = transmittance - 1;  // -A
    return out;
}

struct alignas(64) States {
    float values[4 * kTileSize] = {};
};

TEST(CompositeTile, FrontToBackIsTheOverOperator) {
    for (const double mostAlpha : {1e-4, 0.05, 0.6}) {
        const Stack stack = randomStack(1, mostAlpha);
        const RayTile rays = randomRays(2);
        States states;
        compositeTile(rays, stack.list(), true, states.values);
        for (int k = 0; k < kTileSize; ++k) {
            const Rgba expected = composited(rays, stack, k);
            for (int c = 0; c < 4; ++c)
                ASSERT_NEAR(states.values[4 * k + c], expected[static_cast<std::size_t>(c)], 4 * kTolerance)
                    << "pixel " << k << " channel " << c;
        }
    }
}

TEST(CompositeTile, BackToFrontThroughTheReversedSheetsIsTheSame) {
    for (const double mostAlpha : {1e-4, 0.05, 0.6}) {
        const Stack stack = randomStack(3, mostAlpha), reversed = stack.reversed();
        const RayTile rays = randomRays(4);
        States states;
        compositeTile(rays, reversed.list(), false, states.values);
        for (int k = 0; k < kTileSize; ++k) {
            const Rgba expected = composited(rays, stack, k);
            for (int c = 0; c < 4; ++c)
                ASSERT_NEAR(states.values[4 * k + c], expected[static_cast<std::size_t>(c)], 4 * kTolerance)
                    << "pixel " << k << " channel " << c;
        }
    }
}

// A list may be walked in parts: that is how batches meet.
TEST(CompositeTile, InTwoListsIsTheSameBitsAsInOne) {
    const Stack stack = randomStack(5, 0.1);
    const RayTile rays = randomRays(6);
    for (const bool frontToBack : {true, false}) {
        States whole, parts;
        compositeTile(rays, stack.list(), frontToBack, whole.values);
        SheetList first = stack.list(), second = stack.list();
        first.count = 13;
        second.planes += 13;
        second.steps += 13;
        second.count -= 13;
        compositeTile(rays, first, frontToBack, parts.values);
        compositeTile(rays, second, frontToBack, parts.values);
        for (int i = 0; i < 4 * kTileSize; ++i) ASSERT_EQ(whole.values[i], parts.values[i]) << i;
    }
}

// Transmittance is kept as opacity, so that what is thin is not lost against 1.
TEST(CompositeTile, KeepsOpacitiesFarBelowAFloatsRoundingOfOne) {
    Stack stack;
    stack.planes.assign(10, std::vector<float>(kWidth * kHeight * 4 + 64, 0.0f));
    for (auto& plane : stack.planes)
        for (std::size_t i = 3; i < kWidth * kHeight * 4; i += 4) plane[i] = -1e-12f;
    stack.pointTo(std::vector<float>(10, 0.0f));
    RayTile rays{};
    for (int k = 0; k < kTileSize; ++k) rays.u[k] = rays.v[k] = 8;
    for (const bool frontToBack : {true, false}) {
        States states;
        compositeTile(rays, stack.list(), frontToBack, states.values);
        EXPECT_NEAR(states.values[3], -1e-11, 1e-17);
    }
}

// Front to back, a pixel that is closed is done; back to front there is no such thing.
TEST(CompositeTile, LeavesPixelsAloneThatAreOpaqueAlready) {
    const Stack stack = randomStack(7, 0.2);
    RayTile rays{};
    for (int k = 0; k < kTileSize; ++k) {
        rays.u[k] = static_cast<float>(8 + k % 16);
        rays.v[k] = static_cast<float>(4 + k / 16);
    }
    const auto opaque = [](int k) { return k % 3 == 0; };
    for (const bool frontToBack : {true, false}) {
        States before, after, without;
        for (int k = 0; k < kTileSize; ++k) before.values[4 * k + 3] = opaque(k) ? -0.995f : -0.5f;
        after = without = before;
        std::array<std::uint8_t, kTileSize> closed;
        for (std::size_t k = 0; k < kTileSize; ++k) closed[k] = 1 + before.values[4 * k + 3] < 0.01f ? 1 : 0;
        SheetList list = stack.list();
        list.closed = closed.data();
        compositeTile(rays, list, frontToBack, after.values);
        compositeTile(rays, stack.list(), frontToBack, without.values);
        for (int k = 0; k < kTileSize; ++k)
            for (int c = 0; c < 4; ++c) {
                if (frontToBack && opaque(k)) {
                    ASSERT_EQ(after.values[4 * k + c], before.values[4 * k + c]) << k;
                } else {
                    ASSERT_NE(after.values[4 * k + c], before.values[4 * k + c]) << k;
                    // What is lost to pixels that become opaque on the way is less than 0.01 of what is behind.
                    ASSERT_NEAR(after.values[4 * k + c], without.values[4 * k + c], 0.01 * kCount) << k;
                }
            }
    }
}

TEST(SamplePlane, IsBilinearAtTheRaysPlaceInTheBatch) {
    const Stack stack = randomStack(9, 0.5);
    RayTile rays = randomRays(10);
    alignas(64) float at[kTileSize], samples[4 * kTileSize];
    for (int k = 0; k < kTileSize; ++k) at[k] = static_cast<float>(k % 32) / 4;
    samplePlane(rays, at, {stack.planes[0].data(), kWidth, kHeight}, samples);
    for (int k = 0; k < kTileSize; ++k) {
        const Rgba expected = sampled(stack.planes[0], rays.u[k] + double(at[k]) * rays.stepU[k],
                                      rays.v[k] + double(at[k]) * rays.stepV[k]);
        for (int c = 0; c < 4; ++c) EXPECT_NEAR(samples[4 * k + c], expected[static_cast<std::size_t>(c)], kTolerance);
    }
}

// 256 samples of opacities from 1e-12 to 1, and radiance.
void fillSamples(float* samples) {
    for (int k = 0; k < kTileSize; ++k) {
        for (int c = 0; c < 3; ++c) samples[4 * k + c] = 0.1f * static_cast<float>(c + 1);
        samples[4 * k + 3] = k == 0 ? 0.0f : k == 1 ? -1.0f : -static_cast<float>(std::pow(10, -12.0 * k / 256));
    }
}

TEST(CompositeSamples, WithoutPartsIsTheOverOperator) {
    alignas(64) float samples[4 * kTileSize];
    fillSamples(samples);
    for (const bool frontToBack : {true, false}) {
        States states;
        for (int k = 0; k < kTileSize; ++k) {
            states.values[4 * k] = 0.25f;
            states.values[4 * k + 3] = -0.75f;
        }
        compositeSamples({}, {samples, nullptr}, frontToBack, states.values);
        for (int k = 0; k < kTileSize; ++k) {
            const double alpha = -samples[4 * k + 3], left = 1 - alpha;
            EXPECT_NEAR(states.values[4 * k], frontToBack ? 0.25 + 0.25 * 0.1 : 0.1 + left * 0.25, 1e-6);
            EXPECT_NEAR(states.values[4 * k + 3], -1 + 0.25 * left, 1e-6);
        }
    }
}

// A part f of a sheet has the optical depth f tau: opacity 1 - (1 - alpha)^f, and radiance in proportion to opacity.
TEST(CompositeSamples, OfAPartOfASheetHasThatPartOfItsOpticalDepth) {
    alignas(64) float samples[4 * kTileSize], part[kTileSize];
    fillSamples(samples);
    for (const float f : {0.0f, 0.25f, 0.5f, 0.9f}) {
        std::fill_n(part, kTileSize, f);
        for (const bool frontToBack : {true, false}) {
            States states;
            compositeSamples({}, {samples, part}, frontToBack, states.values);
            for (int k = 2; k < kTileSize; ++k) {
                const double alpha = -double(samples[4 * k + 3]), shown = -std::expm1(f * std::log1p(-alpha));
                EXPECT_NEAR(states.values[4 * k + 3], -shown, 1e-6 * shown) << "alpha " << alpha << " part " << f;
                EXPECT_NEAR(states.values[4 * k], 0.1 * shown / alpha, 1e-6) << "alpha " << alpha << " part " << f;
            }
        }
    }
}

// The two parts of a sheet, one after the other, hide what the whole hides, and show what it shows.
TEST(CompositeSamples, OfBothPartsIsTheWhole) {
    alignas(64) float samples[4 * kTileSize], part[kTileSize];
    fillSamples(samples);
    States whole, parts;
    compositeSamples({}, {samples, nullptr}, true, whole.values);
    std::fill_n(part, kTileSize, 0.3f);
    compositeSamples({}, {samples, part}, true, parts.values);
    std::fill_n(part, kTileSize, 0.7f);
    compositeSamples({}, {samples, part}, true, parts.values);
    for (int k = 1; k < kTileSize; ++k)
        for (int c = 0; c < 4; ++c)
            EXPECT_NEAR(parts.values[4 * k + c], whole.values[4 * k + c], 2e-6 * std::abs(whole.values[4 * k + c]))
                << "alpha " << samples[4 * k + 3] << " channel " << c;
}

TEST(CompositeSamples, OfNothingOrOfAWallStayFinite) {
    alignas(64) float samples[4 * kTileSize], part[kTileSize];
    fillSamples(samples);
    for (const float f : {0.0f, 0.5f, 1.0f}) {
        std::fill_n(part, kTileSize, f);
        States states;
        compositeSamples({}, {samples, part}, true, states.values);
        for (const float v : states.values) ASSERT_TRUE(std::isfinite(v)) << f;
        EXPECT_EQ(states.values[3], 0);                         // alpha 0
        EXPECT_EQ(states.values[4 + 3], f > 0 ? -1.0f : 0.0f);  // alpha 1: any part of it hides all
    }
}

// Light layers of 16 lights over a raster of 6,400 texels' edge are more floats than 32 bits count. Planes are address
// space until they are written.
TEST(CompositeTile, ReadsPlanesOfMoreThanTwoToTheThirtyOneFloats) {
    OutputLayout layout;
    layout.outputs = 18;
    layout.beautyParts = 17;
    const int edge = 6400, floats = layout.floats();
    ASSERT_GT(double(edge) * edge * floats, 2147483648.0);
    PlaneStack plane(1, edge, edge, floats);
    const int last = edge - 8;
    for (int y = 0; y < 2; ++y)
        for (int x = 0; x < 2; ++x)
            for (int f = 0; f < floats; ++f)
                plane.plane(0)[(std::ptrdiff_t(last + y) * edge + last + x) * floats + f] = f + 1 == floats ? -0.5f : 2;
    RayTile rays{};
    std::fill(rays.u, rays.u + kTileSize, last + 0.5f);
    std::fill(rays.v, rays.v + kTileSize, last + 0.5f);
    const Real* pointer = plane.plane(0);
    std::vector<Real> steps(9, 0.0f), state(std::size_t(floats) * kTileSize, 0.0f);
    compositeTile(rays, {&pointer, steps.data(), 1, edge, edge, layout}, true, state.data());
    for (int f = 0; f < floats; ++f) EXPECT_EQ(state[std::size_t(f)], f + 1 == floats ? -0.5f : 2.0f) << f;
}

}  // namespace
}  // namespace scrim::test
