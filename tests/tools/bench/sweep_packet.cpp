// SPDX-License-Identifier: Apache-2.0
// The inner loops of the sweep marcher, compiled once for each instruction set.
#include "sweep_marcher.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sweep_packet.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace scrim::bench {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, 16>;
using DI = hn::RebindToSigned<D>;
using V = hn::Vec<D>;
using VI = hn::Vec<DI>;
using M = hn::Mask<D>;

constexpr float kLeastTransmittance = 1e-3f;

HWY_ATTR HWY_INLINE V constant(float v) {
    return hn::Set(D(), v);
}
HWY_ATTR HWY_INLINE V lerp(V a, V b, V t) {
    return hn::MulAdd(t, hn::Sub(b, a), a);
}
HWY_ATTR HWY_INLINE V expMinus(V t) {
    return hn::Exp(D(), hn::Neg(hn::Min(t, constant(80))));
}

/// from[at] and from[at + 1], both with one gather.
struct Pair {
    V first, second;
};
HWY_ATTR HWY_INLINE Pair pairAt(const float* from, VI at) {
#if HWY_TARGET == HWY_SCALAR
    return {hn::GatherIndex(D(), from, at), hn::GatherIndex(D(), from + 1, at)};
#else
    const hn::Repartition<std::int64_t, D> d64;
    const hn::Half<DI> half;
    const auto* wide = reinterpret_cast<const std::int64_t*>(from);
    const auto low = hn::ShiftLeft<2>(hn::PromoteTo(d64, hn::LowerHalf(half, at)));
    const auto high = hn::ShiftLeft<2>(hn::PromoteTo(d64, hn::UpperHalf(half, at)));
    const V a = hn::BitCast(D(), hn::GatherOffset(d64, wide, low));
    const V b = hn::BitCast(D(), hn::GatherOffset(d64, wide, high));
    return {hn::ConcatEven(D(), b, a), hn::ConcatOdd(D(), b, a)};
#endif
}

/// Positions in an array: index of the voxel below, and distances from it.
struct Place {
    VI at;
    V f[3];
};

HWY_ATTR HWY_INLINE Place placeAt(const int* size, V a, V b, V c) {
    const DI di;
    const VI ia = hn::ConvertTo(di, a), ib = hn::ConvertTo(di, b), ic = hn::ConvertTo(di, c);
    const VI row = hn::Add(hn::Mul(ia, hn::Set(di, size[1])), ib);
    return {
        hn::Add(hn::Mul(row, hn::Set(di, size[2])), ic),
        {hn::Sub(a, hn::ConvertTo(D(), ia)), hn::Sub(b, hn::ConvertTo(D(), ib)), hn::Sub(c, hn::ConvertTo(D(), ic))}};
}

HWY_ATTR HWY_INLINE V trilinear(const float* values, const int* size, const Place& p) {
    const auto along = [&](std::ptrdiff_t offset) HWY_ATTR {
        const Pair pair = pairAt(values + offset, p.at);
        return lerp(pair.first, pair.second, p.f[2]);
    };
    const std::ptrdiff_t b = size[2], a = b * size[1];
    return lerp(lerp(along(0), along(b), p.f[1]), lerp(along(a), along(a + b), p.f[1]), p.f[0]);
}

/// At cells of `coarseness` voxels.
HWY_ATTR HWY_INLINE V coarseLight(const float* light, const int* size, int coarseness, const V* p) {
    const float per = 1.0f / static_cast<float>(coarseness);
    V q[3];
    for (int a = 0; a < 3; ++a) {
        const V cell = hn::MulAdd(p[a], constant(per), constant(0.5f * per - 0.5f));
        q[a] = hn::Min(hn::Max(cell, constant(0)), constant(static_cast<float>(size[a]) - 1.001f));
    }
    return trilinear(light, size, placeAt(size, q[0], q[1], q[2]));
}

struct Rays {
    V origin[3], direction[3], inverse[3];

    HWY_ATTR HWY_INLINE void at(V t, V* p) const {
        for (int a = 0; a < 3; ++a) p[a] = hn::MulAdd(t, direction[a], origin[a]);
    }
};

/// How many bricks on the next is that is not empty.
HWY_ATTR HWY_INLINE VI gapAt(const DenseGrid& grid, const V* p) {
    const DI di;
    const auto brick = [&](int a) HWY_ATTR { return hn::ShiftRight<3>(hn::ConvertTo(di, p[a])); };
    const VI row = hn::Add(hn::Mul(brick(0), hn::Set(di, grid.bricks[1])), brick(1));
    return hn::GatherIndex(di, grid.gap, hn::Add(hn::Mul(row, hn::Set(di, grid.bricks[2])), brick(2)));
}

/// The steps that lead out of the cube of empty bricks around p, in whole steps, so that samples stay where they would
/// have been.
HWY_ATTR HWY_INLINE V leap(const Rays& rays, const V* p, VI gap, float step) {
    const V reach = hn::Mul(hn::ConvertTo(D(), gap), constant(8));
    V exit = constant(1e30f);
    for (int a = 0; a < 3; ++a) {
        const V brick = hn::Mul(hn::Floor(hn::Mul(p[a], constant(0.125f))), constant(8));
        const V bound = hn::IfThenElse(hn::Gt(rays.direction[a], constant(0)), hn::Add(brick, reach),
                                       hn::Sub(hn::Add(brick, constant(8)), reach));
        exit = hn::Min(exit, hn::Mul(hn::Sub(bound, p[a]), rays.inverse[a]));
    }
    const V steps = hn::Ceil(hn::Mul(hn::Add(hn::Max(exit, constant(0)), constant(1e-3f)), constant(1 / step)));
    return hn::Mul(hn::Max(steps, constant(1)), constant(step));
}

/// Pixels from `first` on, as many as a vector has.
HWY_ATTR void marchLanes(const DenseGrid& grid, const float* light, const int* lightSize, int coarseness, float step,
                         Packet& packet, std::size_t first) {
    Rays rays;
    for (int a = 0; a < 3; ++a) {
        rays.origin[a] = hn::LoadU(D(), packet.origin[a] + first);
        rays.direction[a] = hn::LoadU(D(), packet.direction[a] + first);
        rays.inverse[a] = hn::Div(constant(1), rays.direction[a]);
    }
    const V length = hn::LoadU(D(), packet.length + first);
    V t = constant(0.5f * step), transmittance = constant(1), radiance = constant(0), p[3];
    for (;;) {
        M alive = hn::And(hn::Lt(t, length), hn::Gt(transmittance, constant(kLeastTransmittance)));
        if (hn::AllFalse(D(), alive)) break;
        for (;;) {  // until all that march have something to look at
            rays.at(hn::IfThenElseZero(alive, t), p);
            const VI gap = gapAt(grid, p);
            const M empty = hn::And(alive, hn::RebindMask(D(), hn::Gt(gap, hn::Zero(DI()))));
            if (hn::AllFalse(D(), empty)) break;
            t = hn::Add(t, hn::IfThenElseZero(empty, leap(rays, p, gap, step)));
            alive = hn::And(alive, hn::Lt(t, length));
        }
        if (hn::AllFalse(D(), alive)) break;
        const Place place = placeAt(grid.size, p[0], p[1], p[2]);
        const V sigma = hn::IfThenElseZero(alive, trilinear(grid.values, grid.size, place));
        if (!hn::AllTrue(D(), hn::Le(sigma, constant(0)))) {
            const V lit =
                coarseness == 1 ? trilinear(light, grid.size, place) : coarseLight(light, lightSize, coarseness, p);
            const V passed = expMinus(hn::Mul(sigma, constant(step)));
            const V scattered = hn::Mul(transmittance, hn::Sub(constant(1), passed));
            radiance = hn::MulAdd(scattered, lit, radiance);
            transmittance = hn::Mul(transmittance, passed);
        }
        t = hn::Add(t, hn::IfThenElseZero(alive, constant(step)));
    }
    hn::StoreU(radiance, D(), packet.radiance + first);
    hn::StoreU(transmittance, D(), packet.transmittance + first);
}

HWY_ATTR int packetSizeOnTarget() {
    return HWY_MAX(4, static_cast<int>(hn::Lanes(D())));
}

HWY_ATTR void marchOnTarget(const DenseGrid& grid, const float* light, const int* lightSize, int coarseness, float step,
                            Packet& packet) {
    for (int i = 0; i < packetSizeOnTarget(); i += static_cast<int>(hn::Lanes(D())))
        marchLanes(grid, light, lightSize, coarseness, step, packet, static_cast<std::size_t>(i));
}

/// The look-up in the plane before for a vector of cells from `i` on. The weights' negative parts may overshoot.
HWY_ATTR HWY_INLINE V lookUp(const SweepRow& row, int i) {
    V sum = constant(0);
    for (int r = row.first; r < 4 - row.first; ++r) {
        const float* p = row.before + (r - 1) * row.stride + i - 1;
        V along = constant(0);
        for (int k = row.first; k < 4 - row.first; ++k)
            along = hn::MulAdd(hn::LoadU(D(), p + k), constant(row.across[k]), along);
        sum = hn::MulAdd(along, constant(row.down[r]), sum);
    }
    return hn::Min(hn::Max(sum, constant(0)), constant(1));
}

HWY_ATTR void sweepRowOnTarget(const SweepRow& row) {
    const int lanes = static_cast<int>(hn::Lanes(D()));
    // Rows are padded by a vector, so that none needs a rest.
    for (int i = 0; i < row.count; i += lanes) {
        const V before = lookUp(row, i);
        if (i + lanes <= row.begin || i >= row.end) {
            hn::StoreU(before, D(), row.out + i);
            continue;
        }
        const V passed = expMinus(hn::Mul(hn::LoadU(D(), row.extinction + i), constant(row.halfStep)));
        const V light = hn::Mul(hn::Sub(constant(1), before), passed);
        if (i + lanes <= row.count)
            hn::StoreU(light, D(), row.light + i);
        else
            for (int k = i; k < row.count; ++k) row.light[k] = hn::ExtractLane(light, static_cast<std::size_t>(k - i));
        hn::StoreU(hn::NegMulAdd(light, passed, constant(1)), D(), row.out + i);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim::bench
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scrim::bench {

HWY_EXPORT(marchOnTarget);
HWY_EXPORT(sweepRowOnTarget);
HWY_EXPORT(packetSizeOnTarget);

int packetSize() {
    return HWY_DYNAMIC_DISPATCH(packetSizeOnTarget)();
}
void marchPacket(const DenseGrid& grid, const float* light, const int* lightSize, int coarseness, float step,
                 Packet& packet) {
    HWY_DYNAMIC_DISPATCH(marchOnTarget)(grid, light, lightSize, coarseness, step, packet);
}
void sweepRow(const SweepRow& row) {
    HWY_DYNAMIC_DISPATCH(sweepRowOnTarget)(row);
}

}  // namespace scrim::bench
#endif
