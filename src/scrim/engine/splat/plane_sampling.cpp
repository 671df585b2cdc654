// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/plane_sampling.h>

#include <scrim/geometry/sheets.h>

#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scrim/engine/splat/plane_sampling.cpp"
#include <hwy/foreach_target.h>
#include <scrim/engine/simd-inl.h>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

// Bilinear sample with its own position in every lane.
HWY_ATTR HWY_INLINE VF gather(const FloatPlane& plane, const Split& u, const Split& v) {
    const DF d;
    const DI di;
    const auto at = hn::Add(hn::Mul(v.whole, hn::Set(di, plane.width)), u.whole);
    const Real* below = plane.data + plane.width;
    const auto top = lerp(hn::GatherIndex(d, plane.data, at), hn::GatherIndex(d, plane.data + 1, at), u.fraction);
    const auto bottom = lerp(hn::GatherIndex(d, below, at), hn::GatherIndex(d, below + 1, at), u.fraction);
    return lerp(top, bottom, v.fraction);
}

HWY_ATTR void samplePointsOnTarget(const FloatPlane& plane, const Real* u, const Real* v, bool nearest, int count,
                                   Real* out) {
    const DF d;
    for (int k = 0; k < count; k += static_cast<int>(hn::Lanes(d))) {
        const auto su = split(hn::LoadU(d, u + k), plane.x0, plane.width, nearest);
        const auto sv = split(hn::LoadU(d, v + k), plane.y0, plane.height, nearest);
        hn::StoreU(gather(plane, su, sv), d, out + k);
    }
}

// Calls consume(j, i, samples) for the lattice of 16 x 16 positions, a vector of columns at a time.
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
            // One texel a cell: the whole row shares its fractions, and neighbours are consecutive floats.
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

HWY_ATTR void attenuateTileOnTarget(const AttenuateTile& tile) {
    const DF d;
    forLattice(tile.extinction, tile.u, tile.v, tile.step, tile.nearest, [&](int j, int i, VF sigma) HWY_ATTR {
        const auto a =
            hn::MulAdd(hn::Iota(d, static_cast<Real>(i)), hn::Set(d, tile.slopeStep), hn::Set(d, tile.slopeA));
        const auto b = hn::Set(d, tile.slopeB + static_cast<Real>(j) * tile.slopeStep);
        const auto slant = hn::Sqrt(hn::MulAdd(a, a, hn::MulAdd(b, b, hn::Set(d, Real(1)))));
        Real* tau = tile.tau + j * tile.tauStride + i;
        const auto before = hn::LoadU(d, tau);
        hn::StoreU(before, d, tile.entry + j * tile.entryStride + i);
        hn::StoreU(hn::MulAdd(sigma, hn::Mul(slant, hn::Set(d, tile.path)), before), d, tau);
    });
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scrim {

HWY_EXPORT(samplePointsOnTarget);
HWY_EXPORT(sampleLatticeOnTarget);
HWY_EXPORT(attenuateTileOnTarget);

void samplePoints(const FloatPlane& plane, const Real* u, const Real* v, bool nearest, int count, Real* out) {
    SCRIM_ON_TARGET(plane.simd, samplePointsOnTarget)(plane, u, v, nearest, count, out);
}

void sampleLattice(const FloatPlane& plane, Real u, Real v, Real step, bool nearest, Real* out) {
    SCRIM_ON_TARGET(plane.simd, sampleLatticeOnTarget)(plane, u, v, step, nearest, out);
}

void attenuateTile(const AttenuateTile& tile) {
    SCRIM_ON_TARGET(tile.extinction.simd, attenuateTileOnTarget)(tile);
}

}  // namespace scrim
#endif
