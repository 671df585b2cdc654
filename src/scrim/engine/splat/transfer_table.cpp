// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/transfer_table.h>

#include <algorithm>
#include <cmath>
#include <limits>

#ifndef SCRIM_TABULATED_MEANS
#define SCRIM_TABULATED_MEANS
namespace scrim {

// A function and its integral, in units of cells, at cells + 1 places.
struct TabulatedMeans {
    const Real* values;
    const Real* integrals;
    int cells;
    Real beyond;   // value beyond the last place
    Real nothing;  // all values up to that place are 0
    Real cellsPerValue;
};

}  // namespace scrim
#endif

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scrim/engine/splat/transfer_table.cpp"
#include <hwy/foreach_target.h>
#include <scrim/engine/simd-inl.h>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

struct Lookup {
    const Real* table;
    int cells;
    Real beyond;  // slope beyond the last place

    // Linear between places; beyond the last one it continues with slope `beyond`.
    HWY_ATTR HWY_INLINE VF at(VF x) const {
        const DF d;
        const auto last = hn::Set(d, static_cast<Real>(cells));
        const auto inside = hn::Min(hn::Max(x, hn::Zero(d)), last);
        const auto floor = hn::Min(hn::Floor(inside), hn::Set(d, static_cast<Real>(cells - 1)));
        const auto index = hn::ConvertTo(DI(), floor);
        const auto lower = hn::GatherIndex(d, table, index), upper = hn::GatherIndex(d, table + 1, index);
        const auto value = hn::MulAdd(hn::Sub(inside, floor), hn::Sub(upper, lower), lower);
        return hn::MulAdd(hn::Max(hn::Sub(x, last), hn::Zero(d)), hn::Set(d, beyond), value);
    }
};

// The mean over [x, y], in cells. If that is shorter than a cell, the value at its middle is used,
// because the difference of two integrals would be rounding only.
HWY_ATTR HWY_INLINE VF meanBetween(const Lookup& value, VF x, VF y, VF integralX, VF integralY) {
    const DF d;
    const auto run = hn::Sub(y, x);
    const auto isShort = hn::Lt(hn::Abs(run), hn::Set(d, Real(1)));
    const auto safe = hn::IfThenElse(isShort, hn::Set(d, Real(1)), run);
    const auto quotient = hn::Div(hn::Sub(integralY, integralX), safe);
    if (hn::AllFalse(d, isShort)) return quotient;
    const auto middle = value.at(hn::Mul(hn::Set(d, Real(0.5)), hn::Add(x, y)));
    return hn::IfThenElse(isShort, middle, quotient);
}

HWY_ATTR void meanOnTarget(const TabulatedMeans& of, const Real* a, const Real* b, const Real* c, int count,
                           Real* out) {
    const DF d;
    // The tables of integrals are in units of cells, so that means are differences divided by differences of cells.
    const Lookup value{of.values, of.cells, 0}, integral{of.integrals, of.cells, of.beyond};
    const auto scale = hn::Set(d, of.cellsPerValue);
    for (int k = 0; k < count; k += static_cast<int>(hn::Lanes(d))) {
        const auto x = hn::Mul(hn::Load(d, a + k), scale), y = hn::Mul(hn::Load(d, b + k), scale),
                   z = hn::Mul(hn::Load(d, c + k), scale);
        if (hn::AllTrue(d, hn::Le(hn::Max(hn::Max(x, y), z), hn::Set(d, of.nothing)))) {
            hn::Store(hn::Zero(d), d, out + k);
            continue;
        }
        const auto ix = integral.at(x), iy = integral.at(y), iz = integral.at(z);
        const auto sum = hn::Add(meanBetween(value, x, y, ix, iy), meanBetween(value, y, z, iy, iz));
        hn::Store(hn::Max(hn::Mul(hn::Set(d, Real(0.5)), sum), hn::Zero(d)), d, out + k);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scrim {

HWY_EXPORT(meanOnTarget);

namespace {

constexpr int kCells = 2048;  // over the range of values

}  // namespace

struct TransferTable::Function {
    std::vector<Real> value, integral;  // at kCells + 1 places
    Real beyond = 0;                    // value beyond the last place
};

TransferTable::~TransferTable() = default;

TransferTable::TransferTable(const Classified& classified) {
    const std::vector<TransferPoint>& points = classified.transfer;
    m_cell = std::max(points.back().value, std::numeric_limits<float>::min() * 1e6) / kCells;
    for (int f = 0; f < 4; ++f) {
        Function& function = m_functions.emplace_back();
        const auto at = [&](double value) {
            const ClassifiedValue c = classify(classified, value);
            return c.extinction * (f == 0 ? 1.0 : c.color[f - 1]);
        };
        // Between two neighbouring places or points, extinction times colour is a quadratic, for
        // which Simpson's rule is exact.
        double integral = 0;
        for (int i = 0; i <= kCells; ++i) {
            const double place = i * m_cell;
            function.value.push_back(static_cast<Real>(at(place)));
            function.integral.push_back(static_cast<Real>(integral));
            std::vector<double> cuts{place};
            for (const TransferPoint& p : points)
                if (p.value > place && p.value < place + m_cell) cuts.push_back(p.value);
            cuts.push_back(place + m_cell);
            for (std::size_t c = 1; c < cuts.size(); ++c) {
                const double width = cuts[c] - cuts[c - 1], inset = 1e-9 * width;
                if (width <= 0) continue;
                const double sum = at(cuts[c - 1] + inset) + 4 * at(cuts[c - 1] + 0.5 * width) + at(cuts[c] - inset);
                integral += sum / 6 * width / m_cell;
            }
        }
        function.beyond = static_cast<Real>(at(points.back().value + 1));
    }
    const double infinity = std::numeric_limits<double>::infinity();
    const auto addOpaque = [&](double first, double last) {
        if (!m_opaque.empty() && m_opaque.back().second == first)
            m_opaque.back().second = last;
        else
            m_opaque.emplace_back(first, last);
    };
    if (points.front().extinction > 0) addOpaque(-infinity, points.front().value);
    for (std::size_t i = 1; i < points.size(); ++i)
        if (points[i - 1].extinction > 0 || points[i].extinction > 0) addOpaque(points[i - 1].value, points[i].value);
    if (points.back().extinction > 0) addOpaque(points.back().value, infinity);
    const double first = m_opaque.empty() ? infinity : m_opaque.front().first / m_cell;
    m_nothing = static_cast<Real>(std::floor(std::clamp(first, -1.0, double(kCells))));
}

void TransferTable::mean(const Function& f, const Real* a, const Real* b, const Real* c, int count, Real* out,
                         Simd simd) const {
    SCRIM_ON_TARGET(simd, meanOnTarget)
    ({f.value.data(), f.integral.data(), kCells, f.beyond, m_nothing, static_cast<Real>(1 / m_cell)}, a, b, c, count,
     out);
}

void TransferTable::meanExtinction(const Real* a, const Real* b, const Real* c, int count, Real* out, Simd simd) const {
    mean(m_functions[0], a, b, c, count, out, simd);
}

void TransferTable::meanEmission(int channel, const Real* a, const Real* b, const Real* c, int count, Real* out,
                                 Simd simd) const {
    mean(m_functions[1 + channel], a, b, c, count, out, simd);
}

bool TransferTable::anyBetween(Real low, Real high) const {
    return std::any_of(m_opaque.begin(), m_opaque.end(),
                       [&](const auto& range) { return high >= range.first && low <= range.second; });
}

bool TransferTable::clear(Real low, Real high) const {
    return std::none_of(m_opaque.begin(), m_opaque.end(),
                        [&](const auto& range) { return high > range.first && low < range.second; });
}

Real TransferTable::edge(Real clear, Real other) const {
    double nearest = other;
    for (const auto& [first, last] : m_opaque) {
        if (clear <= first) nearest = std::min(nearest, first);
        if (clear >= last) nearest = std::max(nearest, last);
    }
    return static_cast<Real>(nearest);
}

}  // namespace scrim
#endif
