// SPDX-License-Identifier: Apache-2.0
// Internal, compiled once for each instruction set: extinction along rays by the values of a classified field, as
// sheets have it (splat/transfer_table.h): its mean between the values where rays cross two slices is exact if the
// field is linear between them, however much the transfer function bends.
#if defined(SCRIM_MEAN_BETWEEN_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SCRIM_MEAN_BETWEEN_INL_H_
#undef SCRIM_MEAN_BETWEEN_INL_H_
#else
#define SCRIM_MEAN_BETWEEN_INL_H_
#endif

#include <scrim/engine/cells/surface_cells.h>
#include <scrim/engine/simd-inl.h>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

/// The mean extinction between values of the field, a where rays crossed the slice before and b
/// where they cross this one. Below 0, a is not known, and counts as b.
HWY_ATTR HWY_INLINE V8 meanBetween(const ExtinctionIntegral& of, V8 a, V8 b) {
    const D8 d;
    const hn::RebindToSigned<D8> di;
    const V8 scale = hn::Set(d, of.scale), last = value8(ExtinctionIntegral::kCount);
    const V8 y = hn::Min(hn::Mul(b, scale), last), known = hn::Min(hn::Mul(a, scale), last);
    const V8 x = hn::IfThenElse(hn::Lt(a, hn::Zero(d)), y, known);
    const auto integral = [&](V8 at) HWY_ATTR {
        const V8 whole = hn::Floor(at);
        const auto index = hn::ConvertTo(di, whole);
        return hn::MulAdd(hn::Sub(at, whole), hn::Div(hn::GatherIndex(d, of.mean.data(), index), scale),
                          hn::GatherIndex(d, of.integral.data(), index));
    };
    const V8 apart = hn::Sub(y, x), between = hn::Mul(value8(0.5), hn::Add(x, y));
    const V8 near = hn::GatherIndex(d, of.mean.data(), hn::ConvertTo(di, hn::Floor(between)));
    const V8 far = hn::Div(hn::Mul(hn::Sub(integral(y), integral(x)), scale), apart);
    return hn::IfThenElse(hn::Gt(hn::Abs(apart), value8(1)), hn::Max(far, hn::Zero(d)), near);
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
