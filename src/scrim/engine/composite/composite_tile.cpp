// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/composite/composite_tile.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scrim/engine/composite/composite_tile.cpp"
#include <hwy/foreach_target.h>
#include <scrim/engine/simd-inl.h>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

using FirstDepth = PixelTiles::FirstDepth;

// b + (1 + hidden) * a, where `hidden` is a negated opacity.
HWY_ATTR HWY_INLINE V4 through(const V4& hidden, const V4& a, const V4& b) {
    return each4([&](std::size_t i) HWY_ATTR {
        return hn::MulAdd(hn::Add(hn::Set(D4(), Real(1)), hidden.part[i]), a.part[i], b.part[i]);
    });
}
HWY_ATTR HWY_INLINE V4 before(V4 state, V4 texel) {
    return through(lastLane(state), texel, state);
}
HWY_ATTR HWY_INLINE V4 behind(V4 state, V4 texel) {
    return through(lastLane(texel), state, texel);
}

// Composites one sample into a pixel's state, for any number of quads. quad(q) gives the sample's
// quads. Returns the quad whose last lane is the sample's negated opacity.
template <bool kFrontToBack, bool kColoured, class Quad>
HWY_ATTR HWY_INLINE V4 addSample(int quads, const Quad& quad, Real* state) {
    const int last = quads - 1;
    const V4 hides = quad(last);
    if constexpr (kColoured) {
        const V4 hidden = load4(state + 4 * last);
        for (int q = 0; q < last; ++q) {
            const V4 own = quad(q), gathered = load4(state + 4 * q);
            store4(kFrontToBack ? through(hidden, own, gathered) : through(hides, gathered, own), state + 4 * q);
        }
        store4(kFrontToBack ? through(hidden, hides, hidden) : through(hides, hidden, hides), state + 4 * last);
    } else {
        for (int q = 0; q <= last; ++q) {
            const V4 own = quad(q), gathered = load4(state + 4 * q);
            store4(kFrontToBack ? before(gathered, own) : behind(gathered, own), state + 4 * q);
        }
    }
    return hides;
}

// The negated opacity of a sample that counts as visible, for depth.
template <class Quad>
HWY_ATTR HWY_INLINE Real visible(const OutputLayout& layout, const Quad& quad, const V4& hides) {
    return layout.seen ? -lane0(quad(layout.quadOf(*layout.seen))) : lane3(hides);
}

Real opticalDepth(Real hides) {
    constexpr Real kOpaque = Real(1e-7);
    return -std::log1p(std::max(hides, kOpaque - 1));
}

// The depth at which the contents of sheets with the optical depths a, b, c begin, see FirstDepth.
// `middle`: depth of the first of them.
Real beginOf(Real a, Real b, Real c, Real middle, Real step) {
    if (b == 0) return middle;
    if (b <= a) return middle - step / 2;
    if (c <= b) return middle + step / 2 - step * (a / b);
    return middle + step * Real(1.5) - step * ((a + b) / c);
}

// Front to back the first visible sheet counts, back to front the last one.
template <bool kFrontToBack>
HWY_ATTR void noteDepth(FirstDepth& first, Real hides, Real depth, Real signedStep) {
    const Real step = std::abs(signedStep);
    const bool adjoins = std::abs(depth - first.last) < Real(1.5) * step;
    if constexpr (kFrontToBack) {
        if (first.depth == 0) {
            if (-hides > kLeastVisible) first = {depth, opticalDepth(hides), 0, depth};
        } else if (first.last != 0) {
            const Real tau = opticalDepth(hides);
            if (tau == 0) {
                // Whether an empty sheet is walked depends on what else is in the picture, so it must not round.
                first.last = 0;
                return;
            }
            const bool second = first.after == 0;
            if (adjoins && second) first.depth = beginOf(first.next, tau, 0, depth - step, step);
            if (adjoins && !second) first.depth = beginOf(first.next, first.after, tau, depth - 2 * step, step);
            const bool goesOn = adjoins && second && tau > first.next;
            first.after = tau;
            first.last = goesOn ? depth : Real(0);
        }
    } else {
        const Real tau = opticalDepth(hides);
        if (!adjoins) first.next = first.after = 0;
        if (-hides > kLeastVisible) first.depth = beginOf(tau, first.next, first.after, depth, step);
        first.after = first.next;
        first.next = tau;
        first.last = depth;
    }
}

// Where the rays of a tile meet one plane.
struct Addresses {
    alignas(64) RealIndex texel[kTileSize];  // texel number; the offset may not fit, see `walk`
    alignas(64) Real u[kTileSize];           // fractions
    alignas(64) Real v[kTileSize];
};

HWY_ATTR void locate(const RayTile& rays, Real step, int width, int height, Addresses& at) {
    const DF d;
    const DI di;
    const auto steps = hn::Set(d, step);
    for (int k = 0; k < kTileSize; k += static_cast<int>(hn::Lanes(d))) {
        const Split u = split(hn::MulAdd(steps, load(rays.stepU, k), load(rays.u, k)), 0, width);
        const Split v = split(hn::MulAdd(steps, load(rays.stepV, k), load(rays.v, k)), 0, height);
        hn::Store(hn::Add(hn::Mul(v.whole, hn::Set(di, width)), u.whole), di, at.texel + k);
        hn::Store(u.fraction, d, at.u + k);
        hn::Store(v.fraction, d, at.v + k);
    }
}

// The pixels of a tile that are not opaque yet.
struct OpenPixels {
    std::int32_t pixels[kTileSize];
    int count = 0;
};
template <bool kFrontToBack>
HWY_ATTR void findOpen(const std::uint8_t* closed, OpenPixels& open) {
    for (int k = 0; k < kTileSize; ++k) {
        open.pixels[open.count] = k;
        open.count += !kFrontToBack || !closed || !closed[k] ? 1 : 0;
    }
}

// Walks plane by plane and within a plane pixel by pixel: neighbouring pixels are independent, while the sheets of one
// pixel depend on each other. add(k, texel, u, v, rowStride, s) composites pixel k over the texels at address `texel`.
template <bool kFrontToBack, class Add>
HWY_ATTR HWY_INLINE void walk(const RayTile& rays, const SheetList& sheets, const Add& add) {
    const int floats = sheets.layout.floats();
    const std::ptrdiff_t rowStride = static_cast<std::ptrdiff_t>(floats) * sheets.width;
    OpenPixels open;
    findOpen<kFrontToBack>(sheets.closed, open);
    if (open.count == 0) return;
    Addresses at;
    for (int s = 0; s < sheets.count; ++s) {
        locate(rays, sheets.steps[s], sheets.width, sheets.height, at);
        const Real* plane = sheets.planes[s];
        for (int i = 0; i < open.count; ++i) {
            const int k = open.pixels[i];
            add(k, plane + static_cast<std::ptrdiff_t>(at.texel[k]) * floats, at.u[k], at.v[k], rowStride, s);
        }
    }
}

// The case of the beauty alone with grey extinction.
template <bool kFrontToBack>
HWY_ATTR void walkBeauty(const RayTile& rays, const SheetList& sheets, Real* states) {
    walk<kFrontToBack>(rays, sheets,
                       [&](int k, const Real* at, Real u, Real v, std::ptrdiff_t rowStride, int) HWY_ATTR {
                           const auto texel = bilinear4(at, 4, rowStride, u, v);
                           const auto state = load4(states + 4 * k);
                           store4(kFrontToBack ? before(state, texel) : behind(state, texel), states + 4 * k);
                       });
}

template <bool kFrontToBack, bool kColoured, bool kDepth>
HWY_ATTR void walkOutputs(const RayTile& rays, const SheetList& sheets, Real* states,
                          [[maybe_unused]] FirstDepth* first) {
    const int quads = sheets.layout.quads(), floats = sheets.layout.floats();
    walk<kFrontToBack>(
        rays, sheets,
        [&](int k, const Real* at, Real u, Real v, std::ptrdiff_t rowStride, [[maybe_unused]] int s) HWY_ATTR {
            const auto quad = [&](int q) HWY_ATTR { return bilinear4(at + 4 * q, floats, rowStride, u, v); };
            [[maybe_unused]] const V4 hides = addSample<kFrontToBack, kColoured>(quads, quad, states + floats * k);
            if constexpr (kDepth)
                noteDepth<kFrontToBack>(first[k], visible(sheets.layout, quad, hides),
                                        rays.depth[k] + sheets.steps[s] * rays.stepDepth[k], rays.stepDepth[k]);
        });
}

template <bool kFrontToBack>
HWY_ATTR void walkAny(const RayTile& rays, const SheetList& sheets, Real* state, FirstDepth* first) {
    if (sheets.layout.beautyAlone())
        walkBeauty<kFrontToBack>(rays, sheets, state);
    else if (sheets.layout.coloured && first)
        walkOutputs<kFrontToBack, true, true>(rays, sheets, state, first);
    else if (sheets.layout.coloured)
        walkOutputs<kFrontToBack, true, false>(rays, sheets, state, first);
    else if (first)
        walkOutputs<kFrontToBack, false, true>(rays, sheets, state, first);
    else
        walkOutputs<kFrontToBack, false, false>(rays, sheets, state, first);
}

HWY_ATTR void compositeTileOnTarget(const RayTile& rays, const SheetList& sheets, bool frontToBack, Real* state,
                                    FirstDepth* first) {
    if (frontToBack)
        walkAny<true>(rays, sheets, state, first);
    else
        walkAny<false>(rays, sheets, state, first);
}

HWY_ATTR void samplePlaneOnTarget(const RayTile& rays, const Real* at, const ShadedPlane& plane, Real* samples) {
    const int floats = plane.layout.floats(), width = plane.width, height = plane.height;
    for (int k = 0; k < kTileSize; ++k) {
        const Real u = std::clamp(rays.u[k] + at[k] * rays.stepU[k], Real(0), static_cast<Real>(width - 2));
        const Real v = std::clamp(rays.v[k] + at[k] * rays.stepV[k], Real(0), static_cast<Real>(height - 2));
        const Real column = std::floor(u), row = std::floor(v);
        const Real* texel =
            plane.texels + floats * (static_cast<std::ptrdiff_t>(row) * width + static_cast<std::ptrdiff_t>(column));
        for (int q = 0; q < plane.layout.quads(); ++q)
            store4(bilinear4(texel + 4 * q, floats, static_cast<std::ptrdiff_t>(floats) * width, u - column, v - row),
                   samples + floats * k + 4 * q);
    }
}

// The fraction of the opacity -hides that a fraction f of the sheet has: its optical depth is tau
// f, so its opacity is 1 - (1 - alpha)^f.
Real shownShare(Real hides, Real part) {
    const Real alpha = std::clamp(-hides, Real(0), Real(1));
    if (alpha <= Real(1e-20)) return part;
    const Real shown = alpha < 1 ? -std::expm1(part * std::log1p(-alpha)) : (part > 0 ? Real(1) : Real(0));
    return shown / alpha;
}

// Keeps the visible fraction of a sample: radiance in proportion to its opacity.
void keepPart(const OutputLayout& layout, Real part, const Real* from, Real* to) {
    const int last = layout.floats() - 4;
    for (int c = 0; c < 4; ++c) {
        const Real share = shownShare(from[last + (layout.coloured ? c : 3)], part);
        for (int q = 0; q <= last; q += 4) to[q + c] = from[q + c] * share;
    }
}

#if HWY_TARGET != HWY_SCALAR && !defined(SCRIM_DOUBLE)
// The beauty with grey extinction and a fully visible sheet: several pixels per vector.
template <bool kFrontToBack>
HWY_ATTR void addBeauty(const Real* samples, Real* states) {
    const hn::ScalableTag<Real> d;
    for (int i = 0; i < 4 * kTileSize; i += static_cast<int>(hn::Lanes(d))) {
        const auto sample = hn::LoadU(d, samples + i), state = hn::LoadU(d, states + i);
        const auto front = kFrontToBack ? state : sample, back = kFrontToBack ? sample : state;
        const auto open = hn::Add(hn::Set(d, Real(1)), hn::Broadcast<3>(front));
        hn::StoreU(hn::MulAdd(open, back, front), d, states + i);
    }
}
#endif

template <bool kFrontToBack>
HWY_ATTR void addSamples(const RayTile& rays, const SheetSamples& sheet, Real* states, FirstDepth* first) {
#if HWY_TARGET != HWY_SCALAR && !defined(SCRIM_DOUBLE)
    const bool allOpen =
        !sheet.closed || std::none_of(sheet.closed, sheet.closed + kTileSize, [](auto c) { return c; });
    if (sheet.layout.beautyAlone() && !sheet.part && !first && allOpen)
        return addBeauty<kFrontToBack>(sheet.samples, states);
#endif
    const int floats = sheet.layout.floats(), quads = sheet.layout.quads();
    std::array<Real, 4 * 256> kept;
    for (int k = 0; k < kTileSize; ++k) {
        if (sheet.closed && sheet.closed[k]) continue;
        const Real* sample = sheet.samples + floats * k;
        if (sheet.part && sheet.part[k] < 1) {
            keepPart(sheet.layout, sheet.part[k], sample, kept.data());
            sample = kept.data();
        }
        Real* state = states + floats * k;
        const auto quad = [&](int q) HWY_ATTR { return load4(sample + 4 * q); };
        const V4 hides = sheet.layout.coloured ? addSample<kFrontToBack, true>(quads, quad, state)
                                               : addSample<kFrontToBack, false>(quads, quad, state);
        if (first)
            noteDepth<kFrontToBack>(first[k], visible(sheet.layout, quad, hides),
                                    rays.depth[k] + sheet.at[k] * rays.stepDepth[k], rays.stepDepth[k]);
    }
}

HWY_ATTR void compositeSamplesOnTarget(const RayTile& rays, const SheetSamples& sheet, bool frontToBack, Real* states,
                                       FirstDepth* first) {
    if (frontToBack)
        addSamples<true>(rays, sheet, states, first);
    else
        addSamples<false>(rays, sheet, states, first);
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scrim {

HWY_EXPORT(compositeTileOnTarget);
HWY_EXPORT(samplePlaneOnTarget);
HWY_EXPORT(compositeSamplesOnTarget);

void compositeTile(const RayTile& rays, const SheetList& sheets, bool frontToBack, Real* state,
                   PixelTiles::FirstDepth* first) {
    SCRIM_ON_TARGET(sheets.simd, compositeTileOnTarget)(rays, sheets, frontToBack, state, first);
}

void keepSeenPart(const OutputLayout& layout, Real part, const Real* sample, Real* kept) {
    HWY_STATIC_DISPATCH(keepPart)(layout, part, sample, kept);
}

void samplePlane(const RayTile& rays, const Real* at, const ShadedPlane& plane, Real* samples, Simd simd) {
    SCRIM_ON_TARGET(simd, samplePlaneOnTarget)(rays, at, plane, samples);
}

void compositeSamples(const RayTile& rays, const SheetSamples& sheet, bool frontToBack, Real* state,
                      PixelTiles::FirstDepth* first) {
    SCRIM_ON_TARGET(sheet.simd, compositeSamplesOnTarget)(rays, sheet, frontToBack, state, first);
}

}  // namespace scrim
#endif
