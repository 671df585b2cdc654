// SPDX-License-Identifier: Apache-2.0
// Internal, compiled once for each instruction set (Highway's method): vectors of samples, interpolation between
// texels, and exponentials of optical depths, from which the engine's inner loops are built.
#if defined(SCRIM_ENGINE_SIMD_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SCRIM_ENGINE_SIMD_INL_H_
#undef SCRIM_ENGINE_SIMD_INL_H_
#else
#define SCRIM_ENGINE_SIMD_INL_H_
#endif

#include <scrim/base/real.h>
#include <scrim/geometry/sheets.h>
#include <scrim/scene/phase_over_caps.h>

#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>

#include <algorithm>
#include <cmath>
#include <numbers>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using DF = hn::CappedTag<Real, kTileEdge>;
using DI = hn::RebindToSigned<DF>;
using VF = hn::Vec<DF>;
using VI = hn::Vec<DI>;

HWY_ATTR HWY_INLINE VF constant(Real value) {
    return hn::Set(DF(), value);
}
HWY_ATTR HWY_INLINE VF load(const Real* from, int k) {
    return hn::Load(DF(), from + k);
}

// Calls body(k) for each vector of samples.
template <class Body>
HWY_ATTR HWY_INLINE void forSamples(const Body& body) {
    for (int k = 0; k < kTileSize; k += static_cast<int>(hn::Lanes(DF()))) body(k);
}

// A coordinate on an axis of `size` places from `first`, as index and fraction; clamped so that
// index and index + 1 lie on the axis.
struct Split {
    VI whole;
    VF fraction;
};

HWY_ATTR HWY_INLINE Split split(VF x, int first, int size, bool nearest = false) {
    const DF d;
    const DI di;
    x = hn::Min(hn::Max(x, hn::Set(d, static_cast<Real>(first))), hn::Set(d, static_cast<Real>(first + size - 1)));
    const auto floor = hn::Min(hn::Floor(x), hn::Set(d, static_cast<Real>(first + size - 2)));
    auto fraction = hn::Sub(x, floor);
    if (nearest) fraction = hn::Floor(hn::Add(fraction, hn::Set(d, Real(0.5))));
    return {hn::Sub(hn::ConvertTo(di, floor), hn::Set(di, first)), fraction};
}

HWY_ATTR HWY_INLINE VF lerp(VF a, VF b, VF t) {
    return hn::MulAdd(t, hn::Sub(b, a), a);
}

template <class D>
HWY_ATTR HWY_INLINE hn::Vec<D> lerpOf(D, hn::Vec<D> a, hn::Vec<D> b, hn::Vec<D> t) {
    return hn::MulAdd(t, hn::Sub(b, a), a);
}

// Four floats: the channels of a texel or a pixel, in one vector, or in several where the
// instruction set has shorter ones.
using D4 = hn::CappedTag<Real, 4>;
constexpr std::size_t kParts4 = 4 / hn::MaxLanes(D4());
struct V4 {
    hn::Vec<D4> part[kParts4];
};

// Makes a V4; make(i) gives part i.
template <class Make>
HWY_ATTR HWY_INLINE V4 each4(const Make& make) {
    V4 out;
    for (std::size_t i = 0; i < kParts4; ++i) out.part[i] = make(i);
    return out;
}
HWY_ATTR HWY_INLINE V4 load4(const Real* from) {
    return each4([&](std::size_t i) HWY_ATTR { return hn::LoadU(D4(), from + i * hn::MaxLanes(D4())); });
}
#ifdef SCRIM_DOUBLE
// Pixels of slides are floats in every build.
HWY_ATTR HWY_INLINE V4 load4(const float* from) {
    const hn::Rebind<float, D4> df;
    return each4([&](std::size_t i)
                     HWY_ATTR { return hn::PromoteTo(D4(), hn::LoadU(df, from + i * hn::MaxLanes(D4()))); });
}
#endif
HWY_ATTR HWY_INLINE void store4(const V4& v, Real* to) {
    for (std::size_t i = 0; i < kParts4; ++i) hn::StoreU(v.part[i], D4(), to + i * hn::MaxLanes(D4()));
}
// a + t (b - a)
HWY_ATTR HWY_INLINE V4 lerp4(const V4& a, const V4& b, Real t) {
    return each4([&](std::size_t i)
                     HWY_ATTR { return hn::MulAdd(hn::Set(D4(), t), hn::Sub(b.part[i], a.part[i]), a.part[i]); });
}
// The bilinear sample between four texels: `texel`, its neighbour `across` floats further, and the
// two that are `down` floats further.
HWY_ATTR HWY_INLINE V4 bilinear4(const Real* texel, std::ptrdiff_t across, std::ptrdiff_t down, Real u, Real v) {
    const Real* below = texel + down;
    return lerp4(lerp4(load4(texel), load4(texel + across), u), lerp4(load4(below), load4(below + across), u), v);
}
HWY_ATTR HWY_INLINE Real lane0(const V4& v) {
    return hn::GetLane(v.part[0]);
}
HWY_ATTR HWY_INLINE Real lane3(const V4& v) {
    constexpr std::size_t kLast = hn::MaxLanes(D4()) - 1;
    return hn::ExtractLane(v.part[kParts4 - 1], kLast);
}
HWY_ATTR HWY_INLINE V4 lastLane(const V4& v) {
#if HWY_TARGET == HWY_SCALAR
    return each4([&](std::size_t) HWY_ATTR { return v.part[kParts4 - 1]; });
#elif defined(SCRIM_DOUBLE)  // four lanes are more than a block, within which Broadcast stays
    return each4([&](std::size_t) HWY_ATTR { return hn::Set(D4(), lane3(v)); });
#else
    return each4([&](std::size_t) HWY_ATTR { return hn::Broadcast<3>(v.part[kParts4 - 1]); });
#endif
}

// 1 - e^-t for t >= 0, exact to rounding also for small t. Beyond 80 it is 1, since the library's
// exponential is only accurate down to where floats become denormal.
HWY_ATTR HWY_INLINE VF oneMinusExp(VF t) {
    return hn::Neg(hn::Expm1(DF(), hn::Neg(hn::Min(t, constant(80)))));
}

// e^-t for t >= 0; 0 beyond the smallest normal float.
HWY_ATTR HWY_INLINE VF expMinus(VF t) {
    const DF d;
    return hn::IfThenElseZero(hn::Lt(t, constant(87)), hn::Exp(d, hn::Neg(hn::Min(t, constant(87)))));
}

// e^-t for t from 0 to 80, to 2e-7 and in half the time of the library's exponential: a power of two and, for the rest
// of up to half a step, a polynomial (S. Moshier, Cephes Mathematical Library, exp2f).
template <class D>
HWY_ATTR HWY_INLINE hn::Vec<D> shortExpMinus(D d, hn::Vec<D> t) {
    const hn::RebindToSigned<D> di;
    constexpr int kMantissa = sizeof(Real) == 4 ? 23 : 52, kBias = sizeof(Real) == 4 ? 127 : 1023;
    const auto power = hn::Mul(t, hn::Set(d, static_cast<Real>(-std::numbers::log2e))), whole = hn::Round(power);
    const auto rest = hn::Sub(power, whole);
    auto sum = hn::Set(d, static_cast<Real>(1.535336188319500e-4));
    for (const double next : {1.339887440266574e-3, 9.618437357674640e-3, 5.550332471162809e-2, 2.402264791363012e-1,
                              6.931472028550421e-1, 1.0})
        sum = hn::MulAdd(sum, rest, hn::Set(d, static_cast<Real>(next)));
    const auto exponent = hn::Add(hn::ConvertTo(di, whole), hn::Set(di, kBias));
    return hn::Mul(sum, hn::BitCast(d, hn::ShiftLeft<kMantissa>(exponent)));
}

// (1 - e^-t) / t, see sheet_integral.h. 1e-20 stands in for 0; there the quotient is still exact to rounding.
HWY_ATTR HWY_INLINE VF psi(VF t) {
    const auto safe = hn::Max(t, constant(1e-20));
    return hn::Div(oneMinusExp(safe), safe);
}

// Rows of eight.
using D8 = hn::CappedTag<Real, 8>;
using V8 = hn::Vec<D8>;

HWY_ATTR HWY_INLINE V8 value8(double v) {
    return hn::Set(D8(), static_cast<Real>(v));
}
HWY_ATTR HWY_INLINE V8 counted(int first) {
    return hn::Iota(D8(), static_cast<Real>(first));
}
HWY_ATTR HWY_INLINE V8 dot8(V8 x, V8 y, V8 z, const Vec3& v) {
    return hn::MulAdd(x, value8(v.x), hn::MulAdd(y, value8(v.y), hn::Mul(z, value8(v.z))));
}
HWY_ATTR HWY_INLINE V8 bilinear(V8 a0, V8 a1, V8 b0, V8 b1, V8 fx, V8 fy) {
    const V8 first = hn::MulAdd(fy, hn::Sub(b0, a0), a0), second = hn::MulAdd(fy, hn::Sub(b1, a1), a1);
    return hn::MulAdd(fx, hn::Sub(second, first), first);
}

// Henyey and Greenstein's phase function times `scale`. 1 + g^2 - 2 g cos is never less than (1 -
// |g|)^2, but in floats it suffers from cancellation where a lobe is narrow, and a g close to 1 is
// rounded to 1. That would give 0 / 0 at the lobe's peak, or the square root of a negative number.
struct Lobe {
    Real g, strength, least, alpha;

    explicit Lobe(double wanted, Real scale = 1, double draine = 0)
        : g(static_cast<Real>(wanted)), alpha(static_cast<Real>(draine)) {
        constexpr double kNarrow = 0.999, kLeast = 1e-16;  // its power of 3/2 still fits a float
        const double width = 1 - std::abs(wanted);
        const Real rest = std::abs(wanted) > kNarrow ? static_cast<Real>(width * (2 - width)) : 1 - g * g;
        strength = rest * scale / static_cast<Real>(1 + draine * (1 + 2 * wanted * wanted) / 3);
        least = static_cast<Real>(std::max(width * width, kLeast));
    }
};

template <class D>
HWY_ATTR HWY_INLINE hn::Vec<D> henyeyGreenstein(D d, hn::Vec<D> cosine, const Lobe& lobe) {
    const auto x =
        hn::Max(hn::NegMulAdd(hn::Set(d, 2 * lobe.g), cosine, hn::Set(d, 1 + lobe.g * lobe.g)), hn::Set(d, lobe.least));
    return hn::Div(hn::Set(d, lobe.strength), hn::Mul(x, hn::Sqrt(x)));
}
template <class D>
HWY_ATTR HWY_INLINE hn::Vec<D> drainePhase(D d, hn::Vec<D> cosine, const Lobe& lobe) {
    const auto factor = hn::MulAdd(hn::Mul(hn::Set(d, lobe.alpha), cosine), cosine, hn::Set(d, Real(1)));
    return hn::Mul(henyeyGreenstein(d, cosine, lobe), factor);
}

// Where in a PhaseRow a cosine is looked up.
template <class D>
HWY_ATTR HWY_INLINE hn::Vec<D> entryOf(D d, hn::Vec<D> cosine) {
    const auto sine2 = hn::Mul(hn::Sub(hn::Set(d, Real(1)), cosine), hn::Set(d, Real(0.5)));
    const auto root = hn::Sqrt(hn::Sqrt(hn::Min(hn::Max(sine2, hn::Zero(d)), hn::Set(d, Real(1)))));
    return hn::Mul(root, hn::Set(d, Real(kPhaseAngles - 1)));
}
template <class D>
HWY_ATTR HWY_INLINE hn::Vec<D> rowAt(D d, const Real* row, hn::Vec<D> entry) {
    const hn::RebindToSigned<D> di;
    const auto whole = hn::Floor(entry);
    const auto i = hn::ConvertTo(di, whole);
    return lerpOf(d, hn::GatherIndex(d, row, i), hn::GatherIndex(d, row, hn::Add(i, hn::Set(di, 1))),
                  hn::Sub(entry, whole));
}
// The mean over caps of these half angles; wider ones count as the widest.
template <class D>
HWY_ATTR HWY_INLINE hn::Vec<D> capsAt(D d, const PhaseOverCaps& caps, hn::Vec<D> halfAngle, hn::Vec<D> cosine) {
    const hn::RebindToSigned<D> di;
    const auto part = hn::Min(hn::Mul(halfAngle, hn::Set(d, static_cast<Real>(1 / caps.most()))), hn::Set(d, Real(1)));
    const auto cap = hn::Mul(hn::Sqrt(part), hn::Set(d, Real(PhaseOverCaps::kCaps - 1)));
    const auto whole = hn::Min(hn::Floor(cap), hn::Set(d, Real(PhaseOverCaps::kCaps - 2)));
    const auto entry = entryOf(d, cosine), left = hn::Floor(entry), right = hn::Sub(entry, left);
    const auto first =
        hn::Add(hn::Mul(hn::ConvertTo(di, whole), hn::Set(di, kPhaseAngles + 1)), hn::ConvertTo(di, left));
    const Real* values = caps.values();
    const auto at = [&](int more) HWY_ATTR { return hn::GatherIndex(d, values, hn::Add(first, hn::Set(di, more))); };
    const auto near = lerpOf(d, at(0), at(1), right);
    const auto far = lerpOf(d, at(kPhaseAngles + 1), at(kPhaseAngles + 2), right);
    return lerpOf(d, near, far, hn::Sub(cap, whole));
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
