// SPDX-License-Identifier: Apache-2.0
// Internal, compiled once for each instruction set (Highway's method): gradient noise at as many points as a vector
// holds. No multiplication is fused with an addition, so that every instruction set gives the same bits.
#if defined(SCRIM_GRADIENT_NOISE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SCRIM_GRADIENT_NOISE_INL_H_
#undef SCRIM_GRADIENT_NOISE_INL_H_
#else
#define SCRIM_GRADIENT_NOISE_INL_H_
#endif

#include <hwy/highway.h>

#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace noise_source {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<double, 8>;
using DI = hn::Rebind<std::int32_t, D>;
using DU = hn::Rebind<std::uint32_t, D>;
using V = hn::Vec<D>;
using U = hn::Vec<DU>;

/// Points, one in each lane.
struct Points {
    V x, y, z;
};

HWY_ATTR HWY_INLINE V constant(double value) {
    return hn::Set(D(), value);
}

HWY_ATTR HWY_INLINE V mix(V t, V a, V b) {
    return a + t * (b - a);
}

/// The quintic fade of Perlin 2002.
HWY_ATTR HWY_INLINE V fade(V t) {
    return t * t * t * (t * (constant(6) * t - constant(15)) + constant(10));
}

/// The finaliser of MurmurHash3.
HWY_ATTR HWY_INLINE U mixed(U h) {
    const DU d;
    h = hn::Xor(h, hn::ShiftRight<16>(h));
    h = hn::Mul(h, hn::Set(d, 0x85ebca6bu));
    h = hn::Xor(h, hn::ShiftRight<13>(h));
    h = hn::Mul(h, hn::Set(d, 0xc2b2ae35u));
    return hn::Xor(h, hn::ShiftRight<16>(h));
}

/// The dot product of (x, y, z) and the gradient that the low four bits of `hash` choose: one of the twelve edges of a
/// cube, four of them twice (Perlin 2002). Each gradient has two components of +1 or -1: the first along x or y, the
/// second along y or z.
HWY_ATTR HWY_INLINE V gradientProduct(U hash, V x, V y, V z) {
    // Bit 0: the first is negative; bit 1: the second is negative; bit 2: the first is y; bit 3: the second is z.
    HWY_ALIGN static constexpr std::uint8_t kParts[16] = {0, 1, 2, 3, 8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 13, 15};
    const U choice = hn::And(hash, hn::Set(DU(), 15u));
#if HWY_TARGET == HWY_SCALAR  // looks up no more bytes than a vector has
    const U parts = hn::Set(DU(), kParts[hn::GetLane(choice)]);
#else
    const hn::CappedTag<std::uint8_t, HWY_MAX(16, 4 * HWY_MIN(8, HWY_LANES(double)))> bytes;
    const U parts = hn::TableLookupBytes(hn::LoadDup128(bytes, kParts), choice);
#endif
    const hn::Repartition<std::int64_t, D> d64;
    // The upper bytes of `parts` are garbage; no test looks at them, and the shifts drop them.
    const auto wide = hn::PromoteTo(d64, hn::BitCast(DI(), parts));
    const V first = hn::IfThenElse(hn::RebindMask(D(), hn::TestBit(wide, hn::Set(d64, 4))), y, x);
    const V second = hn::IfThenElse(hn::RebindMask(D(), hn::TestBit(wide, hn::Set(d64, 8))), z, y);
    const V sign = hn::SignBit(D());
    return hn::Xor(first, hn::And(hn::BitCast(D(), hn::ShiftLeft<63>(wide)), sign)) +
           hn::Xor(second, hn::And(hn::BitCast(D(), hn::ShiftLeft<62>(wide)), sign));
}

/// Along one axis, the coordinates of the lattice points below and above, each multiplied by the odd factor that they
/// are hashed with, and the distances from them.
struct Axis {
    U hash0, hash1;
    V t0, t1;
};

HWY_ATTR HWY_INLINE Axis axis(V p, std::uint32_t factor) {
    const V below = hn::Floor(p);
    const U hash = hn::Mul(hn::BitCast(DU(), hn::DemoteTo(DI(), below)), hn::Set(DU(), factor));
    return {hash, hn::Add(hash, hn::Set(DU(), factor)), p - below, p - below - constant(1)};
}

/// The values that noises of different seeds share at the same points.
struct Cells {
    Axis x, y, z;
    V u, v, w;
};

HWY_ATTR HWY_INLINE Cells cellsAt(const Points& p) {
    const Axis x = axis(p.x, 0x8da6b343u), y = axis(p.y, 0xd8163841u), z = axis(p.z, 0xcb1ab31fu);
    return {x, y, z, fade(x.t0), fade(y.t0), fade(z.t0)};
}

/// Bounds on the absolute value of gradient noise and on its slope. Both assume the worst gradients at the eight
/// corners of a cell, were found by search, and are rounded up.
constexpr double kNoiseBound = 1.04, kNoiseSlope = 3.76;

/// Gradient noise, about -1 to 1, 0 at lattice points. The gradient of a lattice point comes from the hash of three odd
/// multiples, which is well mixed.
HWY_ATTR inline V gradientNoise(const Cells& at, std::uint32_t seed) {
    const Axis &x = at.x, &y = at.y, &z = at.z;
    const auto alongX = [&](U hashYz, V ty, V tz) HWY_ATTR {
        return mix(at.u, gradientProduct(mixed(hn::Xor(hashYz, x.hash0)), x.t0, ty, tz),
                   gradientProduct(mixed(hn::Xor(hashYz, x.hash1)), x.t1, ty, tz));
    };
    const auto alongXy = [&](U hashZ, V tz) HWY_ATTR {
        return mix(at.v, alongX(hn::Xor(hashZ, y.hash0), y.t0, tz), alongX(hn::Xor(hashZ, y.hash1), y.t1, tz));
    };
    const U mask = hn::Set(DU(), seed);
    return mix(at.w, alongXy(hn::Xor(z.hash0, mask), z.t0), alongXy(hn::Xor(z.hash1, mask), z.t1));
}

}  // namespace HWY_NAMESPACE
}  // namespace noise_source
HWY_AFTER_NAMESPACE();

#endif
