// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/plane_stack.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scrim/engine/splat/plane_stack.cpp"
#include <hwy/foreach_target.h>
#include <scrim/engine/simd-inl.h>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

// Interpolates between the texels at `at` and their right neighbours, separately in each lane.
HWY_ATTR HWY_INLINE VF between(const Real* data, VI at, VF fraction) {
    const DF d;
#if HWY_TARGET != HWY_SCALAR
    // Two neighbouring floats are loaded as one double, which halves the number of loads.
    if constexpr (sizeof(Real) == sizeof(float)) {
        const hn::Repartition<std::int64_t, DF> d64;
        const hn::Half<DI> half;
        const auto bytes = [&](auto index) HWY_ATTR { return hn::ShiftLeft<2>(hn::PromoteTo(d64, index)); };
        const auto* pairs = reinterpret_cast<const std::int64_t*>(data);
        const auto first = hn::BitCast(d, hn::GatherOffset(d64, pairs, bytes(hn::LowerHalf(half, at))));
        const auto second = hn::BitCast(d, hn::GatherOffset(d64, pairs, bytes(hn::UpperHalf(half, at))));
        return lerp(hn::ConcatEven(d, second, first), hn::ConcatOdd(d, second, first), fraction);
    }
#endif
    return lerp(hn::GatherIndex(d, data, at), hn::GatherIndex(d, data + 1, at), fraction);
}

// A bilinear sample at a different position in each lane.
HWY_ATTR HWY_INLINE VF gather(const FloatPlane& plane, const Split& u, const Split& v) {
    const DI di;
    const auto at = hn::Add(hn::Mul(v.whole, hn::Set(di, plane.width)), u.whole);
    return lerp(between(plane.data, at, u.fraction), between(plane.data + plane.width, at, u.fraction), v.fraction);
}

HWY_ATTR void samplePointsOnTarget(const FloatPlane& plane, const Real* u, const Real* v, bool nearest, int count,
                                   Real* out, const PlaneMap& map) {
    const DF d;
    const auto times = hn::Set(d, map.scale), plusU = hn::Set(d, map.firstU), plusV = hn::Set(d, map.firstV);
    for (int k = 0; k < count; k += static_cast<int>(hn::Lanes(d))) {
        const auto su = split(hn::MulAdd(hn::LoadU(d, u + k), times, plusU), plane.x0, plane.width, nearest);
        const auto sv = split(hn::MulAdd(hn::LoadU(d, v + k), times, plusV), plane.y0, plane.height, nearest);
        hn::StoreU(gather(plane, su, sv), d, out + k);
    }
}

HWY_ATTR void runThroughSheetOnTarget(const Real* before, const Real* here, const Real* behind, Real* front,
                                      Real* middle, Real* back) {
    const DF d;
    forSamples([&](int k) HWY_ATTR {
        const auto a = load(before, k), b = load(here, k), c = load(behind, k);
        const auto blur = hn::Mul(constant(Real(0.125)), hn::Add(hn::NegMulAdd(constant(2), b, a), c));
        const auto sharp = [&](VF value) HWY_ATTR { return hn::Max(hn::Sub(value, blur), constant(0)); };
        hn::Store(sharp(hn::Mul(constant(Real(0.5)), hn::Add(a, b))), d, front + k);
        hn::Store(sharp(b), d, middle + k);
        hn::Store(sharp(hn::Mul(constant(Real(0.5)), hn::Add(b, c))), d, back + k);
    });
}

HWY_ATTR void rangeOfOnTarget(const Real* values, int width, int height, std::ptrdiff_t stride, Real* range) {
    const DF d;
    const int lanes = static_cast<int>(hn::Lanes(d));
    auto low = hn::Set(d, values[0]), high = low;
    for (int y = 0; y < height; ++y, values += stride)
        for (int x = 0; x < width; x += lanes) {
            // The last vector of a row may repeat values of the one before.
            const auto some = hn::LoadU(d, values + std::min(x, width - lanes));
            low = hn::Min(low, some);
            high = hn::Max(high, some);
        }
    range[0] = hn::GetLane(hn::MinOfLanes(d, low));
    range[1] = hn::GetLane(hn::MaxOfLanes(d, high));
}

// Calls consume(j, i, samples) for the lattice of 16 x 16 positions, one vector of columns at a time.
template <class Consume>
HWY_ATTR HWY_INLINE void forLattice(const FloatPlane& plane, Real u, Real v, Real step, bool nearest,
                                    const Consume& consume) {
    const DF d;
    const int lanes = static_cast<int>(hn::Lanes(d));
    const Real floorU = std::floor(u);
    const Real column = floorU - static_cast<Real>(plane.x0);
    const bool streaming = step == Real(1) && column >= 0 && column + kTileEdge < static_cast<Real>(plane.width);
    for (int j = 0; j < kTileEdge; ++j) {
        const auto sv = split(hn::Set(d, v + static_cast<Real>(j) * step), plane.y0, plane.height, nearest);
        if (streaming) {
            // With one texel per cell, all cells of a row have the same fractions, and neighbours
            // are consecutive floats.
            Real fraction = u - floorU;
            if (nearest) fraction = std::floor(fraction + Real(0.5));
            const auto t = hn::Set(d, fraction);
            const Real* top = plane.data + hn::GetLane(sv.whole) * static_cast<std::ptrdiff_t>(plane.width) +
                              static_cast<std::ptrdiff_t>(column);
            const Real* bottom = top + plane.width;
            for (int i = 0; i < kTileEdge; i += lanes)
                consume(j, i,
                        lerp(lerp(hn::LoadU(d, top + i), hn::LoadU(d, top + i + 1), t),
                             lerp(hn::LoadU(d, bottom + i), hn::LoadU(d, bottom + i + 1), t), sv.fraction));
        } else {
            for (int i = 0; i < kTileEdge; i += lanes) {
                const auto at = hn::MulAdd(hn::Iota(d, static_cast<Real>(i)), hn::Set(d, step), hn::Set(d, u));
                consume(j, i, gather(plane, split(at, plane.x0, plane.width, nearest), sv));
            }
        }
    }
}

HWY_ATTR void sampleLatticeOnTarget(const FloatPlane& plane, Real u, Real v, Real step, bool nearest, Real* out) {
    const DF d;
    forLattice(plane, u, v, step, nearest,
               [&](int j, int i, VF sample) HWY_ATTR { hn::StoreU(sample, d, out + j * kTileEdge + i); });
}

// The world length of the path through a sheet for rays with slopes (a, b); `path` is the sheet's thickness.
HWY_ATTR HWY_INLINE VF wayThrough(VF a, VF b, Real path) {
    const DF d;
    const auto slant = hn::Sqrt(hn::MulAdd(a, a, hn::MulAdd(b, b, hn::Set(d, Real(1)))));
    return hn::Mul(slant, hn::Set(d, path));
}

// Attenuates a tile. `way(j, i)`: path lengths through the sheet for row j of the lattice from column i on.
template <class Way>
HWY_ATTR HWY_INLINE void attenuateAlong(const AttenuateTile& tile, const Way& way) {
    const DF d;
    forLattice(tile.extinction, tile.u, tile.v, tile.step, tile.nearest, [&](int j, int i, VF sigma) HWY_ATTR {
        Real* tau = tile.tau + j * tile.tauStride + i;
        const auto before = hn::LoadU(d, tau);
        hn::StoreU(before, d, tile.entry + j * tile.entryStride + i);
        hn::StoreU(hn::MulAdd(sigma, way(j, i), before), d, tau);
    });
}

HWY_ATTR void attenuateTileOnTarget(const AttenuateTile& tile) {
    const DF d;
    if (tile.slopeStep == Real(0)) {
        const auto parallel = wayThrough(hn::Set(d, tile.slopeA), hn::Set(d, tile.slopeB), tile.path);
        return attenuateAlong(tile, [&](int, int) HWY_ATTR { return parallel; });
    }
    attenuateAlong(tile, [&](int j, int i) HWY_ATTR {
        const auto a =
            hn::MulAdd(hn::Iota(d, static_cast<Real>(i)), hn::Set(d, tile.slopeStep), hn::Set(d, tile.slopeA));
        return wayThrough(a, hn::Set(d, tile.slopeB + static_cast<Real>(j) * tile.slopeStep), tile.path);
    });
}

template <bool kBetween>
HWY_ATTR Real prefilterLimited(const HaloTile& halo, Real strength, Real* out, std::ptrdiff_t stride) {
    const DF d;
    const auto minusStrength = hn::Set(d, -strength), four = hn::Set(d, Real(4));
    auto largest = hn::Zero(d);
    for (int y = 0; y < kTileEdge; ++y)
        for (int x = 0; x < kTileEdge; x += static_cast<int>(hn::Lanes(d))) {
            const Real* at = halo.at(x, y);
            const auto own = hn::Load(d, at), left = hn::LoadU(d, at - 1), right = hn::LoadU(d, at + 1);
            const auto above = hn::Load(d, at - HaloTile::kStride), below = hn::Load(d, at + HaloTile::kStride);
            const auto around = hn::Add(hn::Add(hn::Add(left, right), above), below);
            auto value = hn::MulAdd(minusStrength, hn::NegMulAdd(four, own, around), own);
            if constexpr (kBetween) {
                const auto least = hn::Min(hn::Min(hn::Min(left, right), hn::Min(above, below)), own);
                const auto most = hn::Max(hn::Max(hn::Max(left, right), hn::Max(above, below)), own);
                value = hn::Min(hn::Max(value, least), most);
            } else {
                value = hn::Max(value, hn::Zero(d));
            }
            largest = hn::Max(largest, value);
            hn::StoreU(value, d, out + y * stride + x);
        }
    return hn::GetLane(hn::MaxOfLanes(d, largest));
}

HWY_ATTR Real prefilterAboveZeroOnTarget(const HaloTile& halo, Real strength, Real* out, std::ptrdiff_t stride) {
    return prefilterLimited<false>(halo, strength, out, stride);
}
HWY_ATTR Real prefilterBetweenOnTarget(const HaloTile& halo, Real strength, Real* out, std::ptrdiff_t stride) {
    return prefilterLimited<true>(halo, strength, out, stride);
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scrim {

HWY_EXPORT(samplePointsOnTarget);
HWY_EXPORT(runThroughSheetOnTarget);
HWY_EXPORT(rangeOfOnTarget);
HWY_EXPORT(sampleLatticeOnTarget);
HWY_EXPORT(attenuateTileOnTarget);
HWY_EXPORT(prefilterAboveZeroOnTarget);
HWY_EXPORT(prefilterBetweenOnTarget);

void samplePoints(const FloatPlane& plane, const Real* u, const Real* v, bool nearest, int count, Real* out,
                  const PlaneMap& map) {
    SCRIM_ON_TARGET(plane.simd, samplePointsOnTarget)(plane, u, v, nearest, count, out, map);
}

void runThroughSheet(const Real* before, const Real* here, const Real* behind, Simd simd, Real* front, Real* middle,
                     Real* back) {
    SCRIM_ON_TARGET(simd, runThroughSheetOnTarget)(before, here, behind, front, middle, back);
}

std::pair<Real, Real> rangeOf(const Real* values, int width, int height, std::ptrdiff_t stride, Simd simd) {
    Real range[2];
    SCRIM_ON_TARGET(simd, rangeOfOnTarget)(values, width, height, stride, range);
    return {range[0], range[1]};
}

void sampleLattice(const FloatPlane& plane, Real u, Real v, Real step, bool nearest, Real* out) {
    SCRIM_ON_TARGET(plane.simd, sampleLatticeOnTarget)(plane, u, v, step, nearest, out);
}

void attenuateTile(const AttenuateTile& tile) {
    SCRIM_ON_TARGET(tile.extinction.simd, attenuateTileOnTarget)(tile);
}

Real prefilterAboveZero(const HaloTile& halo, Real strength, Simd simd, Real* out, std::ptrdiff_t stride) {
    return SCRIM_ON_TARGET(simd, prefilterAboveZeroOnTarget)(halo, strength, out, stride);
}

Real prefilterBetween(const HaloTile& halo, Real strength, Simd simd, Real* out, std::ptrdiff_t stride) {
    return SCRIM_ON_TARGET(simd, prefilterBetweenOnTarget)(halo, strength, out, stride);
}

namespace {

// Floats after the last row, which a vector read or a padded footprint row may touch.
constexpr std::size_t kTail = 64;

std::size_t planeFloats(int width, int height, int channels) {
    return rasterArea(width, height, "texels (a larger 'texel' needs fewer)") * std::size_t(channels) + kTail;
}

}  // namespace

std::size_t PlaneStack::bytes(int planes, int width, int height, int channels) {
    return planeFloats(width, height, channels) * std::size_t(planes) * sizeof(Real);
}

PlaneStack::PlaneStack(int planes, int width, int height, int channels)
    : m_planes(planes),
      m_width(width),
      m_height(height),
      m_channels(channels),
      m_planeStride(static_cast<std::ptrdiff_t>(planeFloats(width, height, channels))),
      m_data(bytes(planes, width, height, channels) / sizeof(Real)) {
    m_state.resize(std::size_t(planes) * std::size_t(tilesX()) * std::size_t(tilesY()));
}

bool PlaneStack::anyActive(int p, const Box2<int>& tiles) const {
    const Box2<int> box = intersection(tiles, {0, 0, tilesX(), tilesY()});
    for (int ty = box.y0; ty < box.y1; ++ty)
        for (int tx = box.x0; tx < box.x1; ++tx)
            if (active(p, tx, ty)) return true;
    return false;
}

bool anyActiveNear(const PlaneStack& planes, int p, const Box2<double>& texels) {
    if (texels.x1 < 0 || texels.y1 < 0 || texels.x0 >= planes.width() || texels.y0 >= planes.height()) return false;
    const auto tileOf = [](double texel, int size) {
        return static_cast<int>(std::clamp(std::floor(texel), 0.0, size - 1.0)) / kTileEdge;
    };
    return planes.anyActive(p, {tileOf(texels.x0, planes.width()), tileOf(texels.y0, planes.height()),
                                tileOf(texels.x1 + 1, planes.width()) + 1, tileOf(texels.y1 + 1, planes.height()) + 1});
}

int PlaneStack::activeCount(int p) const {
    const auto first = m_state.begin() + static_cast<std::ptrdiff_t>(tileIndex(p, 0, 0));
    return static_cast<int>(std::count(first, first + std::ptrdiff_t(tilesX()) * tilesY(), kActive));
}

Box2<int> PlaneStack::activeBounds(int p) const {
    Box2<int> box;
    for (int ty = 0; ty < tilesY(); ++ty) {
        const std::uint8_t* const row = m_state.data() + tileIndex(p, 0, ty);
        const auto count = std::size_t(tilesX());
        const void* const first = std::memchr(row, kActive, count);
        if (first == nullptr) continue;
        const void* const last = memrchr(row, kActive, count);
        box.include({static_cast<int>(static_cast<const std::uint8_t*>(first) - row), ty,
                     static_cast<int>(static_cast<const std::uint8_t*>(last) - row) + 1, ty + 1});
    }
    return box;
}

void PlaneStack::begin(int p) {
    std::uint8_t* const states = m_state.data() + tileIndex(p, 0, 0);
    forTilesIn(states, tilesX() * tilesY(), kActive, [&](int tile) { states[tile] = kStale; });
}

void PlaneStack::activate(int p, int tx, int ty) {
    std::uint8_t& state = m_state[tileIndex(p, tx, ty)];
    if (state == kStale) clearTile(p, tx, ty);
    state = kActive;
}

void PlaneStack::finish(int p) {
    for (int ty = 0; ty < tilesY(); ++ty) finishRow(p, ty);
}

void PlaneStack::finishRow(int p, int ty) {
    std::uint8_t* const states = m_state.data() + tileIndex(p, 0, ty);
    forTilesIn(states, tilesX(), kStale, [&](int tx) {
        clearTile(p, tx, ty);
        states[tx] = kClean;
    });
}

void PlaneStack::prefilter(int p, Simd simd) {
    constexpr Real kTwelfth = Real(1) / 12;
    forPrefilteredTiles(
        plane(p), tilesX(), tilesY(), rowStride(), [&](int ty, const auto& visit) { forActive(p, ty, visit); },
        [&](int tx, int ty, const HaloTile& halo, Real* out) {
            if (prefilterAboveZero(halo, kTwelfth, simd, out, rowStride()) == 0) m_state[tileIndex(p, tx, ty)] = kClean;
        });
}

void PlaneStack::raiseToZero(int p) {
    for (int ty = 0; ty < tilesY(); ++ty)
        forActive(p, ty, [&](int tx) {
            const int floats = kTileEdge * m_channels;
            Real* row = tile(p, tx, ty);
            for (int y = 0; y < kTileEdge; ++y, row += rowStride())
                for (int x = 0; x < floats; ++x) row[x] = std::max(row[x], Real(0));
        });
}

void PlaneStack::dropEmpty(int p) {
    for (int ty = 0; ty < tilesY(); ++ty)
        forActive(p, ty, [&](int tx) {
            const Real* row = tile(p, tx, ty);
            Real largest = 0;
            for (int y = 0; y < kTileEdge && largest == 0; ++y, row += rowStride())
                for (int x = 0; x < kTileEdge; ++x) largest = std::max(largest, row[x]);
            if (largest == 0) m_state[tileIndex(p, tx, ty)] = kClean;
        });
}

void PlaneStack::clearTile(int p, int tx, int ty) {
    const std::size_t rowFloats = std::size_t(kTileEdge * m_channels);
    Real* row = tile(p, tx, ty);
    for (int y = 0; y < kTileEdge; ++y, row += rowStride()) std::memset(row, 0, rowFloats * sizeof(Real));
}

}  // namespace scrim
#endif
