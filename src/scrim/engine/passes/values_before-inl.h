// SPDX-License-Identifier: Apache-2.0
// Internal, compiled once for each instruction set: extinction along rays by the values of a classified field, as
// sheets have it (splat/transfer_table.h): its mean between the values where rays cross two slices is exact if the
// field is linear between them, however much the transfer function bends.
#if defined(SCRIM_VALUES_BEFORE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SCRIM_VALUES_BEFORE_INL_H_
#undef SCRIM_VALUES_BEFORE_INL_H_
#else
#define SCRIM_VALUES_BEFORE_INL_H_
#endif

#include <scrim/engine/cells/surface_cells.h>
#include <scrim/engine/passes/cell_slices.h>
#include <scrim/engine/simd-inl.h>

#include <cstddef>
#include <vector>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

/// The mean extinction between values of the field, a where rays crossed the slice before and b where they cross this
/// one. Below 0, a is not known, and counts as b.
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

/// The values of the field that rays of a raster met in the slice before, and which rays these were.
class ValuesBefore {
  public:
    void begin(std::size_t rows, std::size_t stride) {
        m_stride = stride;
        m_values.assign(rows * stride, Real(-1));
        m_met.assign(rows, {});
    }
    /// Of rays `met` of a row of the raster, which are met now; those that were met before and are not now begin anew.
    Real* of(std::size_t row, const CellSpan& met) {
        Real* values = m_values.data() + row * m_stride;
        const CellSpan& old = m_met[row];
        for (int p = old.begin; p < old.end; ++p)
            if (p < met.begin || p >= met.end) values[p] = -1;
        m_met[row] = met;
        return values;
    }

  private:
    std::size_t m_stride = 0;
    std::vector<Real> m_values;
    std::vector<CellSpan> m_met;
};

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
