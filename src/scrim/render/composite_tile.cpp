// SPDX-License-Identifier: Apache-2.0
#include <scrim/render/composite_tile.h>

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scrim/render/composite_tile.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using DF = hn::CappedTag<float, kTileEdge>;
using DI = hn::RebindToSigned<DF>;

// The four channels of a texel. The scalar target has vectors of one lane only, so there they are an array.
#if HWY_TARGET == HWY_SCALAR
struct V4 {
    float c[4];
};
template <class Each>
V4 each(const Each& value) {
    return {{value(0), value(1), value(2), value(3)}};
}
HWY_INLINE V4 load4(const float* from) {
    return {{from[0], from[1], from[2], from[3]}};
}
HWY_INLINE void store4(V4 v, float* to) {
    std::copy_n(v.c, 4, to);
}
HWY_INLINE V4 times(V4 v, float by) {
    return each([&](int i) { return v.c[i] * by; });
}
HWY_INLINE V4 lerp4(V4 a, V4 b, float t) {
    return each([&](int i) { return a.c[i] + t * (b.c[i] - a.c[i]); });
}
HWY_INLINE V4 before(V4 state, V4 texel) {
    return each([&](int i) { return state.c[i] + (1 + state.c[3]) * texel.c[i]; });
}
HWY_INLINE V4 behind(V4 state, V4 texel) {
    return each([&](int i) { return texel.c[i] + (1 + texel.c[3]) * state.c[i]; });
}
#else
using D4 = hn::CappedTag<float, 4>;
using V4 = hn::Vec<D4>;

HWY_ATTR HWY_INLINE V4 load4(const float* from) {
    return hn::LoadU(D4(), from);
}
HWY_ATTR HWY_INLINE void store4(V4 v, float* to) {
    hn::StoreU(v, D4(), to);
}
HWY_ATTR HWY_INLINE V4 times(V4 v, float by) {
    return hn::Mul(v, hn::Set(D4(), by));
}
HWY_ATTR HWY_INLINE V4 lerp4(V4 a, V4 b, float t) {
    return hn::MulAdd(hn::Set(D4(), t), hn::Sub(b, a), a);
}
HWY_ATTR HWY_INLINE V4 before(V4 state, V4 texel) {
    return hn::MulAdd(hn::Add(hn::Set(D4(), 1.0f), hn::Broadcast<3>(state)), texel, state);
}
HWY_ATTR HWY_INLINE V4 behind(V4 state, V4 texel) {
    return hn::MulAdd(hn::Add(hn::Set(D4(), 1.0f), hn::Broadcast<3>(texel)), state, texel);
}
#endif

// Where the rays of a tile meet one plane.
struct Addresses {
    alignas(64) std::int32_t texel[kTileSize];  // offset of its first channel
    alignas(64) float u[kTileSize];             // fractions
    alignas(64) float v[kTileSize];
};

// Whole part and fraction of a coordinate, clamped to the plane, whose border is zeros.
HWY_ATTR HWY_INLINE void split(hn::Vec<DF> x, int size, hn::Vec<DI>& whole, hn::Vec<DF>& fraction) {
    const DF d;
    x = hn::Min(hn::Max(x, hn::Zero(d)), hn::Set(d, static_cast<float>(size - 2)));
    const auto floor = hn::Floor(x);
    whole = hn::ConvertTo(DI(), floor);
    fraction = hn::Sub(x, floor);
}

HWY_ATTR void locate(const RayTile& rays, float step, int width, int height, Addresses& at) {
    const DF d;
    const DI di;
    const auto steps = hn::Set(d, step);
    for (int k = 0; k < kTileSize; k += static_cast<int>(hn::Lanes(d))) {
        hn::Vec<DI> column, row;
        hn::Vec<DF> fu, fv;
        split(hn::MulAdd(steps, hn::Load(d, rays.stepU + k), hn::Load(d, rays.u + k)), width, column, fu);
        split(hn::MulAdd(steps, hn::Load(d, rays.stepV + k), hn::Load(d, rays.v + k)), height, row, fv);
        const auto texel = hn::Add(hn::Mul(row, hn::Set(di, width)), column);
        hn::Store(hn::ShiftLeft<2>(texel), di, at.texel + k);
        hn::Store(fu, d, at.u + k);
        hn::Store(fv, d, at.v + k);
    }
}

HWY_ATTR HWY_INLINE V4 bilinear(const float* texel, std::ptrdiff_t rowStride, float u, float v) {
    const float* below = texel + rowStride;
    return lerp4(lerp4(load4(texel), load4(texel + 4), u), lerp4(load4(below), load4(below + 4), u), v);
}

HWY_ATTR void fillRaysOnTarget(const RayRow& row, int j, RayTile& tile) {
    const hn::CappedTag<double, kTileEdge> d;
    const hn::Rebind<float, decltype(d)> df;
    for (int i = 0; i < kTileEdge; i += static_cast<int>(hn::Lanes(d))) {
        const auto column = hn::Iota(d, static_cast<double>(i));
        const auto at = [&](const double* start, const double* step, int axis)
                            HWY_ATTR { return hn::MulAdd(column, hn::Set(d, step[axis]), hn::Set(d, start[axis])); };
        const auto directionN = at(row.direction, row.directionStep, 2);
        const auto inverse = hn::Div(hn::Set(d, 1.0), directionN);
        const auto away = hn::Sub(hn::Set(d, row.reference), at(row.origin, row.originStep, 2));
        const auto slopeU = hn::Mul(at(row.direction, row.directionStep, 0), inverse);
        const auto slopeV = hn::Mul(at(row.direction, row.directionStep, 1), inverse);
        const int k = j * kTileEdge + i;
        const auto store = [&](auto value, float* to) HWY_ATTR { hn::StoreU(hn::DemoteTo(df, value), df, to + k); };
        store(hn::MulAdd(slopeU, away, at(row.origin, row.originStep, 0)), tile.u);
        store(hn::MulAdd(slopeV, away, at(row.origin, row.originStep, 1)), tile.v);
        store(slopeU, tile.stepU);
        store(slopeV, tile.stepV);
        store(hn::MulSub(hn::Set(d, row.near), directionN, away), tile.startN);
    }
}

// Plane by plane and pixel by pixel: neighbours do not wait for each other, as the sheets of one pixel do.
template <bool kFrontToBack>
HWY_ATTR void walk(const RayTile& rays, const SheetList& sheets, float cutoff, float* states) {
    const std::ptrdiff_t rowStride = std::ptrdiff_t{4} * sheets.width;
    std::int32_t open[kTileSize];
    int openCount = 0;
    for (int k = 0; k < kTileSize; ++k) {
        open[openCount] = k;
        openCount += !kFrontToBack || 1 + states[4 * k + 3] >= cutoff ? 1 : 0;
    }
    if (openCount == 0) return;
    Addresses at;
    for (int s = 0; s < sheets.count; ++s) {
        locate(rays, sheets.steps[s], sheets.width, sheets.height, at);
        const float* plane = sheets.planes[s];
        for (int i = 0; i < openCount; ++i) {
            const int k = open[i];
            const auto texel = bilinear(plane + at.texel[k], rowStride, at.u[k], at.v[k]);
            const auto state = load4(states + 4 * k);
            store4(kFrontToBack ? before(state, texel) : behind(state, texel), states + 4 * k);
        }
    }
}

HWY_ATTR void compositeTileOnTarget(const RayTile& rays, const SheetList& sheets, bool frontToBack, float cutoff,
                                    float* state) {
    if (frontToBack)
        walk<true>(rays, sheets, cutoff, state);
    else
        walk<false>(rays, sheets, cutoff, state);
}

HWY_ATTR void sampleRgbaOnTarget(const RayTile& rays, const float* at, const float* plane, int width, int height,
                                 float* samples) {
    for (int k = 0; k < kTileSize; ++k) {
        const float u = std::clamp(rays.u[k] + at[k] * rays.stepU[k], 0.0f, static_cast<float>(width - 2));
        const float v = std::clamp(rays.v[k] + at[k] * rays.stepV[k], 0.0f, static_cast<float>(height - 2));
        const float column = std::floor(u), row = std::floor(v);
        const float* texel =
            plane + 4 * (static_cast<std::ptrdiff_t>(row) * width + static_cast<std::ptrdiff_t>(column));
        store4(bilinear(texel, std::ptrdiff_t{4} * width, u - column, v - row), samples + 4 * k);
    }
}

HWY_ATTR void compositeSamplesOnTarget(const float* samples, const float* part, bool frontToBack, float* states) {
    for (int k = 0; k < kTileSize; ++k) {
        auto sample = load4(samples + 4 * k);
        if (part && part[k] < 1) {
            // A part f of the sheet has tau f: opacity 1 - (1 - alpha)^f, and radiance in proportion to it.
            const float alpha = std::clamp(-samples[4 * k + 3], 0.0f, 1.0f);
            const float shown = alpha < 1 ? -std::expm1(part[k] * std::log1p(-alpha)) : (part[k] > 0 ? 1.0f : 0.0f);
            const float ratio = alpha > 1e-20f ? shown / alpha : part[k];
            sample = times(sample, ratio);
        }
        const auto state = load4(states + 4 * k);
        store4(frontToBack ? before(state, sample) : behind(state, sample), states + 4 * k);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scrim {

HWY_EXPORT(fillRaysOnTarget);
HWY_EXPORT(compositeTileOnTarget);
HWY_EXPORT(sampleRgbaOnTarget);
HWY_EXPORT(compositeSamplesOnTarget);

void fillRays(const RayRow& row, int j, RayTile& tile) {
    HWY_DYNAMIC_DISPATCH(fillRaysOnTarget)(row, j, tile);
}

void compositeTile(const RayTile& rays, const SheetList& sheets, bool frontToBack, float cutoff, float* state) {
    HWY_DYNAMIC_DISPATCH(compositeTileOnTarget)(rays, sheets, frontToBack, cutoff, state);
}

void sampleRgba(const RayTile& rays, const float* at, const float* plane, int width, int height, float* samples) {
    HWY_DYNAMIC_DISPATCH(sampleRgbaOnTarget)(rays, at, plane, width, height, samples);
}

void compositeSamples(const float* samples, const float* part, bool frontToBack, float* state) {
    HWY_DYNAMIC_DISPATCH(compositeSamplesOnTarget)(samples, part, frontToBack, state);
}

}  // namespace scrim
#endif
