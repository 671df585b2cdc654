// SPDX-License-Identifier: Apache-2.0
// Internal, one a SIMD target (Highway's way): vectors of samples, and exponentials of optical depths.
#if defined(SCRIM_SHADE_VECTOR_MATH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SCRIM_SHADE_VECTOR_MATH_INL_H_
#undef SCRIM_SHADE_VECTOR_MATH_INL_H_
#else
#define SCRIM_SHADE_VECTOR_MATH_INL_H_
#endif

#include <scrim/geometry/sheets.h>

#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using DF = hn::CappedTag<float, kTileEdge>;
using VF = hn::Vec<DF>;

HWY_ATTR HWY_INLINE VF constant(float value) {
    return hn::Set(DF(), value);
}
HWY_ATTR HWY_INLINE VF load(const float* from, int k) {
    return hn::Load(DF(), from + k);
}

// Calls body(k) for each vector of samples.
template <class Body>
HWY_ATTR HWY_INLINE void forSamples(const Body& body) {
    for (int k = 0; k < kTileSize; k += static_cast<int>(hn::Lanes(DF()))) body(k);
}

// 1 - e^-t for t >= 0, to rounding also where t is small. Past 80 it is 1: the library's exponential is only
// good down to where floats become denormal.
HWY_ATTR HWY_INLINE VF oneMinusExp(VF t) {
    return hn::Neg(hn::Expm1(DF(), hn::Neg(hn::Min(t, constant(80.0f)))));
}

// e^-t for t >= 0, 0 past the smallest normal float.
HWY_ATTR HWY_INLINE VF expMinus(VF t) {
    const DF d;
    return hn::IfThenElseZero(hn::Lt(t, constant(87.0f)), hn::Exp(d, hn::Neg(hn::Min(t, constant(87.0f)))));
}

// (1 - e^-t) / t, see sheet_integral.h. 1e-20 stands for 0: there the quotient's rounding is still exact.
HWY_ATTR HWY_INLINE VF psi(VF t) {
    const auto safe = hn::Max(t, constant(1e-20f));
    return hn::Div(oneMinusExp(safe), safe);
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
