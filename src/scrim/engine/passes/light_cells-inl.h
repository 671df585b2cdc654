// SPDX-License-Identifier: Apache-2.0
// Internal: the sweep of light_cells.cpp through a box of cells, slice by slice along one axis.
//
// The rays of a source cross every slice at the same places of a raster: for parallel rays the raster is sheared with
// their direction, for rays from a point it is the picture that the point sees of the slice, and grows with the
// distance. Thus transmittance is multiplied up without being interpolated from slice to slice; only extinction is, to
// the rays, and transmittance once, to the cells: its depth would be dark where half of the light passes an edge.
#if defined(SCRIM_LIGHT_CELLS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SCRIM_LIGHT_CELLS_INL_H_
#undef SCRIM_LIGHT_CELLS_INL_H_
#else
#define SCRIM_LIGHT_CELLS_INL_H_
#endif

#include <scrim/engine/passes/cell_rays.h>
#include <scrim/engine/passes/cell_slices.h>
#include <scrim/engine/passes/mean_between-inl.h>
#include <scrim/engine/passes/shown_light-inl.h>
#include <scrim/engine/simd-inl.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

/// The transmittance below which no light is looked for within opaque matter, and that below which rays end there.
constexpr double kDark = 1e-4, kBlack = 1e-6;
/// What is left of light at the least, because tiny numbers are slow.
constexpr double kNothing = 1e-30;

/// What is left of `light` behind an optical depth.
HWY_ATTR HWY_INLINE V8 passed(V8 light, V8 tau) {
    return hn::Max(hn::Mul(light, transmittance(tau)), value8(kNothing));
}

/// Adds light to these cells, to the sums from `first` on.
HWY_ATTR HWY_INLINE void addTo(CellSlices& box, const CellView& view, const CellRays& rays, const CellPlace& cell,
                               V8 light, std::size_t first = 0) {
    for (std::size_t c = 0; c < view.colours; ++c) {
        Real* to = box.sums(first + c, cell.j, cell.k) + cell.i;
        hn::StoreU(hn::MulAdd(hn::Set(D8(), rays.weight[c]), light, hn::LoadU(D8(), to)), D8(), to);
    }
}

/// The part of four rays that is lit at this place, interpolated between them; each is dark from its place on.
HWY_ATTR HWY_INLINE V8 litBetween(V8 a0, V8 a1, V8 b0, V8 b1, V8 at, V8 fx, V8 fy) {
    const auto lit = [&](V8 darkFrom) HWY_ATTR { return hn::IfThenElseZero(hn::Gt(darkFrom, at), value8(1)); };
    return bilinear(lit(a0), lit(a1), lit(b0), lit(b1), fx, fy);
}

/// Transmittances of parallel rays, in `through`, whose memory one source after another uses.
class ParallelRaster {
  public:
    ParallelRaster(const CellSlices& box, const CellRays& rays, const CellView& view, std::vector<Real>& through)
        : m_box(box), m_rays(rays), m_down(rays.way.z < 0), m_through(through) {
        const double along = std::abs(rays.way.z);
        m_perSlice = rays.extinction / along;
        for (int a = 0; a < 2; ++a) {
            m_slope[a] = rays.way[a] / along;
            m_begin[a] = m_slope[a] > 0 ? -m_slope[a] * box.size[2] : 0;
        }
        m_stride = std::size_t(box.size[0] + std::ceil(std::abs(m_slope[0]) * box.size[2]) + 4 + 2 * kRowSlack);
        m_rows = box.size[1] + static_cast<int>(std::ceil(std::abs(m_slope[1]) * box.size[2])) + 4;
        m_through.assign(std::size_t(m_rows) * m_stride, Real(1));
        if (box.integral()) {
            m_before.assign(m_through.size(), Real(-1));
            m_black.assign(m_through.size() / kChunk + 1, 0);
        }
        if (!rays.blocked) return;
        // Ray (p, q) crosses the middle of the first slice at p + begin, q + begin, from the middle of the first cell.
        const double first = slice(0) + 0.5;
        const Vec3 perStep(m_slope[0], m_slope[1], m_down ? -1 : 1);
        m_dark.resize(m_through.size());
        for (int q = 0; q < m_rows; ++q)
            for (std::size_t p = 0; p < m_stride; ++p)
                m_dark[std::size_t(q) * m_stride + p] = static_cast<Real>(
                    view.darkFrom({double(p) - 1.5 + m_begin[0], q - 1.5 + m_begin[1], first}, perStep, true));
    }
    int slice(int step) const { return m_down ? m_box.size[2] - 1 - step : step; }
    bool reaches(int step) const {
        return !m_rays.forFiner || (m_down ? slice(step) >= m_box.wantedBox.begin[2] : step < m_box.wantedBox.end[2]);
    }

    /// What lies between the slice before and this one holds back the rays, by the values of the field.
    HWY_ATTR void attenuateTo(int step) {
        if (!m_rays.attenuated) return;
        for (const int row : m_box.besideRows[std::size_t(slice(step))]) attenuateTo(step, row);
    }
    /// The extinction of a slice holds back the rays that cross it.
    HWY_ATTR void attenuate(int step) {
        if (!m_rays.attenuated) return;
        for (const int row : m_box.crossedRows[std::size_t(slice(step))]) attenuate(step, row);
    }

    /// Adds the light that arrives in the cells of row j of a slice. `left`: what media that the
    /// box does not have leave of it, as from cell 0 on; null: all.
    template <class Towards>
    HWY_ATTR void light(int step, int j, const CellView& view, const Towards& towards, const Real* left,
                        CellSlices& box) const {
        const D8 d;
        const int k = slice(step);
        const Offset x(m_begin[0] + step * m_slope[0]), y(m_begin[1] + step * m_slope[1]);
        const Real* far = through(j - y.whole) - x.whole;
        const Real* near = through(j - y.whole - 1) - x.whole;
        const Real* own = box.row(j, k);
        const V8 fx = value8(x.fraction), fy = value8(y.fraction), ownHalf = value8(0.5 * m_perSlice);
        const bool constant = towards.constantFor(true);
        const Real* row = m_rays.phaseRow;
        const V8 phase = value8(!constant ? 0
                                : row     ? towards.constantIn(row, m_rays.way)
                                          : towards.constantAt(m_rays.way));
        const V8 wx = value8(m_rays.way.x), wy = value8(m_rays.way.y), wz = value8(m_rays.way.z);
        for (const CellSpan& span : box.wanted.row(box.rowIndex(j, k)))
            for (int i = span.begin; i < span.end; i += static_cast<int>(hn::Lanes(d))) {
                const V8 a1 = hn::LoadU(d, far + i), a0 = hn::LoadU(d, far + i - 1);
                const V8 b1 = hn::LoadU(d, near + i), b0 = hn::LoadU(d, near + i - 1);
                const V8 before = bilinear(a1, a0, b1, b0, fx, fy);
                if (Towards::kOpaque && hn::AllTrue(d, hn::Lt(before, value8(kDark)))) continue;
                const CellPlace cell{i, j, k};
                const V8 p = constant ? phase : row ? towards.in(row, wx, wy, wz, cell) : towards.at(wx, wy, wz, cell);
                V8 arrives = !m_rays.attenuated ? value8(1)
                             : box.integral()   ? before
                                                : passed(before, hn::Mul(ownHalf, hn::LoadU(d, own + i)));
                if (m_rays.blocked) {
                    const Real* dark = m_dark.data() + (far - m_through.data());
                    const Real* beside = m_dark.data() + (near - m_through.data());
                    const V8 open =
                        litBetween(hn::LoadU(d, dark + i), hn::LoadU(d, dark + i - 1), hn::LoadU(d, beside + i),
                                   hn::LoadU(d, beside + i - 1), value8(step), fx, fy);
                    arrives = hn::Mul(arrives, open);
                }
                if (left) arrives = hn::Mul(arrives, hn::LoadU(d, left + i));
                addTo(box, view, m_rays, cell, hn::Mul(p, arrives));
                if constexpr (Towards::kMirrors)
                    addTo(box, view, m_rays, cell, hn::Mul(towards.mirroredAt(wx, wy, wz, cell), arrives),
                          view.colours);
            }
    }

  private:
    struct Offset {
        explicit Offset(double x) : whole(static_cast<int>(std::floor(x))), fraction(x - whole) {}
        int whole;
        double fraction;
    };
    // The rays that cross a slice between its rows j and j + 1: `to` is the one that does so at i =
    // 0 or, by the fractions, beyond it.
    struct RayRow {
        int j, k;
        Real* to;
        V8 fx, fy;
        HWY_ATTR RayRow(ParallelRaster& of, int step, int row) : j(row - 1), k(of.slice(step)) {
            const Offset x(of.m_begin[0] + step * of.m_slope[0]), y(of.m_begin[1] + step * of.m_slope[1]);
            to = of.through(j - y.whole) - x.whole;
            fx = value8(x.fraction), fy = value8(y.fraction);
        }
    };
    HWY_ATTR void attenuateTo(int step, int row) {
        const D8 d;
        const auto [j, k, to, fx, fy] = RayRow(*this, step, row);
        const Real* a = m_box.values(j, k);
        const Real* b = m_box.values(j + 1, k);
        Real* before = m_before.data() + (to - m_through.data());
        const V8 perSlice = value8(m_perSlice * m_box.edge());
        const V8 empty = hn::Set(d, m_box.integral()->empty);
        // Rays that have met opaque matter are black in whole chunks, which later slices pass over.
        const auto first = static_cast<std::size_t>(to - m_through.data());
        for (const CellSpan& span : m_box.beside.row(m_box.paddedRow(j, k)))
            for (int i = span.begin - 1, end = i; i < span.end; i = end) {
                const std::size_t ray = first + static_cast<std::size_t>(static_cast<std::ptrdiff_t>(i));
                end = std::min(span.end, i + kChunk - static_cast<int>(ray % kChunk));
                if (m_black[ray / kChunk]) continue;
                bool black = end - i == kChunk;
                for (; i < end; i += static_cast<int>(hn::Lanes(d))) {
                    const V8 left = hn::LoadU(d, to + i);
                    if (hn::AllTrue(d, hn::Lt(left, value8(kBlack)))) continue;
                    black = false;
                    const V8 value = bilinear(hn::LoadU(d, a + i), hn::LoadU(d, a + i + 1), hn::LoadU(d, b + i),
                                              hn::LoadU(d, b + i + 1), fx, fy);
                    const V8 old = hn::LoadU(d, before + i);
                    const auto inside = hn::Lt(counted(i), value8(end));
                    hn::StoreU(hn::IfThenElse(inside, value, old), d, before + i);
                    if (hn::AllTrue(d, hn::Lt(hn::Max(old, value), empty))) continue;
                    const V8 tau = hn::Mul(perSlice, meanBetween(*m_box.integral(), old, value));
                    hn::StoreU(hn::IfThenElse(inside, passed(left, tau), left), d, to + i);
                }
                m_black[ray / kChunk] = black;
            }
    }

    HWY_ATTR void attenuate(int step, int row) {
        const D8 d;
        const auto [j, k, to, fx, fy] = RayRow(*this, step, row);
        const Real* a = m_box.row(j, k);
        const Real* b = m_box.row(j + 1, k);
        const V8 perSlice = value8(m_perSlice);
        for (const CellSpan& span : m_box.crossed.row(m_box.paddedRow(j, k)))
            for (int i = span.begin - 1; i < span.end; i += static_cast<int>(hn::Lanes(d))) {
                const V8 left = hn::LoadU(d, to + i);
                if (hn::AllTrue(d, hn::Le(left, value8(kNothing)))) continue;
                const V8 a0 = hn::LoadU(d, a + i), a1 = hn::LoadU(d, a + i + 1);
                const V8 b0 = hn::LoadU(d, b + i), b1 = hn::LoadU(d, b + i + 1);
                const V8 tau = hn::Mul(perSlice, bilinear(a0, a1, b0, b1, fx, fy));
                hn::StoreU(passed(left, tau), d, to + i);
            }
    }

    // A row of the raster, from the ray on that crosses i = 0 where the whole offset is 0.
    Real* through(int row) { return m_through.data() + std::size_t(row + 2) * m_stride + 2; }
    const Real* through(int row) const { return m_through.data() + std::size_t(row + 2) * m_stride + 2; }

    static constexpr int kChunk = 64;  // rays

    const CellSlices& m_box;
    const CellRays& m_rays;
    bool m_down;
    double m_perSlice;
    double m_slope[2], m_begin[2];
    std::size_t m_stride;
    int m_rows;
    std::vector<Real>& m_through;
    std::vector<Real> m_dark;
    std::vector<Real> m_before;  // for each ray the value of the field where it met the slice before; -1: unknown
    std::vector<std::uint8_t> m_black;  // for each chunk of rays whether all are below kBlack
};

/// Transmittances of the rays from a point to the cells of one face of a cube around it; for a lamp their depths.
class PointRaster {
  public:
    PointRaster(const CellSlices& box, const CellRays& rays, const CellView& view, std::vector<Real>& through,
                bool down)
        : m_box(box), m_rays(rays), m_down(down), m_face(rays.forFiner ? 1.5 : 1), m_through(through) {
        // In steps: where light is wanted.
        const CellBox all = rays.forFiner ? box.wantedBox : box.whole();
        const int begin = down ? box.size[2] - all.end[2] : all.begin[2];
        m_end = down ? box.size[2] - all.begin[2] : all.end[2];
        while (m_first < m_end && distance(m_first) + 0.5 <= 0) ++m_first;
        if (m_first >= m_end) return;
        const double near = middle(std::max(m_first, begin)), far = middle(m_end - 1);
        m_cell = 1 / std::max(far, 1.0);
        int count[2];
        for (int a = 0; a < 2; ++a) {
            const double low = all.begin[std::size_t(a)] - 1 - rays.from[a],
                         high = all.end[std::size_t(a)] + 1 - rays.from[a];
            const double least = std::max(-m_face, low / (low < 0 ? near : far)),
                         most = std::min(m_face, high / (high > 0 ? near : far));
            m_begin[a] = least - 2 * m_cell;
            count[a] = most > least ? static_cast<int>((most - least) / m_cell) + 6 : 0;
        }
        m_width = count[0];
        m_rows = m_width > 0 ? count[1] : 0;
        m_stride = std::size_t(m_width + 2 * kRowSlack);
        m_through.assign(std::size_t(m_rows) * m_stride, Real(rays.lamp ? 0 : 1));
        if (box.integral()) m_before.assign(m_through.size(), Real(-1));
        if (!rays.blocked) return;
        m_dark.resize(m_through.size());
        for (int q = 0; q < m_rows; ++q)
            for (std::size_t p = 0; p < m_stride; ++p)
                m_dark[std::size_t(q) * m_stride + p] = static_cast<Real>(view.darkFrom(
                    rays.from, {m_begin[0] + double(p) * m_cell, m_begin[1] + q * m_cell, down ? -1 : 1}, false));
    }
    int slice(int step) const { return m_down ? m_box.size[2] - 1 - step : step; }
    bool reaches(int step) const { return m_rows > 0 && step >= m_first && step < m_end; }

    HWY_ATTR void attenuateTo(int step) {
        for (int row = 0; m_rays.attenuated && row < m_rows; ++row) attenuateTo(step, row);
    }
    HWY_ATTR void attenuate(int step) {
        for (int row = 0; m_rays.attenuated && row < m_rows; ++row) attenuate(step, row);
    }

    template <class Towards>
    HWY_ATTR void light(int step, int j, const CellView& view, const Towards& towards, const Real* left,
                        CellSlices& box) const {
        const D8 d;
        const hn::RebindToSigned<D8> di;
        const int k = slice(step);
        const double z = distance(step),
                     own = m_rays.attenuated && !box.integral() ? m_rays.extinction * std::min(z, 0.5) : 0,
                     y = j + 0.5 - m_rays.from.y;
        if (z <= 0 || !owns(1, y, z)) return;
        const double row = (y / z - m_begin[1]) / m_cell;
        const int q = static_cast<int>(std::floor(row));
        const Real* a = m_through.data() + std::size_t(q) * m_stride;
        const Real* b = a + m_stride;
        const Real* extinction = box.row(j, k);
        const V8 fy = value8(row - q), half = value8(0.5), ahead = value8(m_down ? -z : z),
                 perCell = value8(1 / (z * m_cell)), first = value8(-m_begin[0] / m_cell);
        const bool constant = towards.constantFor(false);
        const PhaseOverCaps* caps = m_rays.caps;
        const V8 phase = value8(constant ? towards.constantAt({0, 0, 1}) : 0);
        for (const CellSpan& some : box.wanted.row(box.rowIndex(j, k))) {
            const CellSpan span = range(some, z);
            for (int i = span.begin; i < span.end; i += static_cast<int>(hn::Lanes(d))) {
                const V8 center = hn::Add(counted(i), half), x = hn::Sub(center, value8(m_rays.from.x));
                const V8 at = hn::Max(hn::Min(hn::MulAdd(x, perCell, first), value8(m_width + 4)), hn::Zero(d)),
                         whole = hn::Floor(at), fx = hn::Sub(at, whole);
                const auto p = hn::ConvertTo(di, whole), next = hn::Add(p, hn::Set(di, 1));
                const V8 a0 = hn::GatherIndex(d, a, p), a1 = hn::GatherIndex(d, a, next);
                const V8 b0 = hn::GatherIndex(d, b, p), b1 = hn::GatherIndex(d, b, next);
                const V8 before = bilinear(a0, a1, b0, b1, fx, fy);
                if (Towards::kOpaque && hn::AllTrue(d, hn::Lt(before, value8(kDark)))) continue;
                const V8 r2 = hn::MulAdd(x, x, value8(y * y + z * z)), r = hn::Sqrt(r2), one = hn::Div(value8(1), r);
                const V8 tau = hn::Mul(hn::Mul(r, value8(own / z)), hn::LoadU(d, extinction + i));
                const V8 wx = hn::Mul(x, one), wy = hn::Mul(value8(y), one), wz = hn::Mul(ahead, one);
                V8 light = m_rays.lamp ? transmittance(hn::Add(before, tau)) : passed(before, tau);
                if (m_rays.blocked) {
                    const Real* dark = m_dark.data() + (a - m_through.data());
                    const Real* beside = dark + m_stride;
                    const V8 open =
                        litBetween(hn::GatherIndex(d, dark, p), hn::GatherIndex(d, dark, next),
                                   hn::GatherIndex(d, beside, p), hn::GatherIndex(d, beside, next), value8(z), fx, fy);
                    light = hn::Mul(light, open);
                }
                if (left) light = hn::Mul(light, hn::LoadU(d, left + i));
                if (m_rays.decayScale > 0)
                    light = hn::Div(hn::Mul(light, value8(m_rays.decayScale)), hn::Max(r2, value8(m_rays.radius2)));
                V8 seen = value8(m_rays.capRadius);
                if (m_rays.oneSided) {
                    const V8 facing = hn::Max(dot8(wx, wy, wz, m_rays.way), hn::Zero(d));
                    light = hn::Mul(light, throughSpread(facing));
                    seen = hn::Mul(seen, hn::Sqrt(facing));
                }
                if (m_rays.pattern) light = hn::Mul(light, sentAlong(wx, wy, wz));
                // Cells beyond the face belong to another one.
                light = hn::IfThenElseZero(hn::Lt(counted(i), value8(span.end)), light);
                const CellPlace cell{i, j, k};
                const V8 shown = constant ? phase
                                 : caps   ? towards.over(*caps, hn::Mul(seen, one), wx, wy, wz, cell)
                                          : towards.at(wx, wy, wz, cell);
                addTo(box, view, m_rays, cell, hn::Mul(light, shown));
                if constexpr (Towards::kMirrors)
                    addTo(box, view, m_rays, cell, hn::Mul(light, towards.mirroredAt(wx, wy, wz, cell)), view.colours);
            }
        }
    }

  private:
    // Of one row of the rays.
    HWY_ATTR void attenuateTo(int step, int row) {
        const D8 d;
        const hn::RebindToSigned<D8> di;
        const int k = slice(step);
        const double z = middle(step), thickness = m_box.edge() * (step > m_first ? z - middle(step - 1) : z);
        const double aside = m_begin[1] + row * m_cell, y = m_rays.from.y + aside * z - 0.5;
        const int j = static_cast<int>(std::floor(y));
        if (j < -1 || j >= m_box.size[1]) return;
        const Real* a = m_box.values(j, k);
        const Real* b = m_box.values(j + 1, k);
        Real* to = m_through.data() + std::size_t(row) * m_stride;
        Real* before = m_before.data() + std::size_t(row) * m_stride;
        const V8 fy = value8(y - j), part = value8(thickness), across2 = value8(1 + aside * aside);
        // Ray p crosses the slice at i = x0 + p perRay.
        const double x0 = m_rays.from.x + m_begin[0] * z - 0.5, perRay = m_cell * z;
        for (const CellSpan& span : m_box.beside.row(m_box.paddedRow(j, k))) {
            const CellSpan met = raysThrough(span, x0, perRay);
            for (int p = met.begin; p < met.end; p += static_cast<int>(hn::Lanes(d))) {
                const V8 left = hn::LoadU(d, to + p);
                if (hn::AllTrue(d, hn::Lt(left, value8(kBlack)))) continue;
                const V8 x =
                    hn::Min(hn::Max(hn::MulAdd(counted(p), value8(perRay), value8(x0)), value8(span.begin - 1)),
                            value8(span.end));
                const V8 whole = hn::Floor(x), fx = hn::Sub(x, whole);
                const auto i = hn::ConvertTo(di, whole), next = hn::Add(i, hn::Set(di, 1));
                const V8 value = bilinear(hn::GatherIndex(d, a, i), hn::GatherIndex(d, a, next),
                                          hn::GatherIndex(d, b, i), hn::GatherIndex(d, b, next), fx, fy);
                const V8 along = hn::MulAdd(counted(p), value8(m_cell), value8(m_begin[0]));
                const V8 way = hn::Mul(part, hn::Sqrt(hn::MulAdd(along, along, across2)));
                const V8 old = hn::LoadU(d, before + p);
                const V8 tau = hn::Mul(way, meanBetween(*m_box.integral(), old, value));
                const auto inside = hn::Lt(counted(p), value8(met.end));
                hn::StoreU(hn::IfThenElse(inside, passed(left, tau), left), d, to + p);
                hn::StoreU(hn::IfThenElse(inside, value, old), d, before + p);
            }
        }
    }

    HWY_ATTR void attenuate(int step, int row) {
        const D8 d;
        const hn::RebindToSigned<D8> di;
        const int k = slice(step);
        const double z = middle(step), thickness = 2 * m_rays.extinction * (distance(step) + 0.5 - z);
        const double aside = m_begin[1] + row * m_cell, y = m_rays.from.y + aside * z - 0.5;
        const int j = static_cast<int>(std::floor(y));
        if (j < -1 || j >= m_box.size[1]) return;
        // Ray p crosses the slice at i = x0 + p perRay.
        const double x0 = m_rays.from.x + m_begin[0] * z - 0.5, perRay = m_cell * z;
        const Real* a = m_box.row(j, k);
        const Real* b = m_box.row(j + 1, k);
        Real* to = m_through.data() + std::size_t(row) * m_stride;
        const V8 fy = value8(y - j), part = value8(thickness), across2 = value8(1 + aside * aside);
        for (const CellSpan& span : m_box.crossed.row(m_box.paddedRow(j, k))) {
            const CellSpan met = raysThrough(span, x0, perRay);
            for (int p = met.begin; p < met.end; p += static_cast<int>(hn::Lanes(d))) {
                const V8 x =
                    hn::Min(hn::Max(hn::MulAdd(counted(p), value8(perRay), value8(x0)), value8(span.begin - 1)),
                            value8(span.end));
                const V8 whole = hn::Floor(x), fx = hn::Sub(x, whole);
                const auto i = hn::ConvertTo(di, whole), next = hn::Add(i, hn::Set(di, 1));
                const V8 a0 = hn::GatherIndex(d, a, i), a1 = hn::GatherIndex(d, a, next);
                const V8 b0 = hn::GatherIndex(d, b, i), b1 = hn::GatherIndex(d, b, next);
                const V8 along = hn::MulAdd(counted(p), value8(m_cell), value8(m_begin[0]));
                const V8 way = hn::Mul(part, hn::Sqrt(hn::MulAdd(along, along, across2)));
                const V8 tau = hn::Mul(way, bilinear(a0, a1, b0, b1, fx, fy)), before = hn::LoadU(d, to + p);
                hn::StoreU(m_rays.lamp ? hn::Add(before, tau) : passed(before, tau), d, to + p);
            }
        }
    }
    // What a part of a mesh sends along (x, y, z).
    HWY_ATTR V8 sentAlong(V8 x, V8 y, V8 z) const {
        const auto& [even, linear, quadratic] = *m_rays.pattern;
        const V8 slope[3] = {dot8(x, y, z, quadratic[0]), dot8(x, y, z, quadratic[1]), dot8(x, y, z, quadratic[2])};
        V8 sum = hn::Add(value8(even), dot8(x, y, z, linear));
        sum = hn::MulAdd(x, slope[0], hn::MulAdd(y, slope[1], hn::MulAdd(z, slope[2], sum)));
        return hn::Max(sum, hn::Zero(D8()));
    }
    // The cosine to an element's normal, and what its spread lets through.
    HWY_ATTR V8 throughSpread(V8 facing) const {
        if (m_rays.spreadScale == 0) return facing;
        const V8 sine = hn::Sqrt(hn::Max(hn::NegMulAdd(facing, facing, value8(1)), hn::Zero(D8())));
        const V8 part = hn::MulSub(facing, value8(m_rays.spreadTangent), sine);
        return hn::Mul(hn::Max(part, hn::Zero(D8())), value8(m_rays.spreadScale));
    }
    // Distances from the source to the middle of a slice, and to the middle of its part that lies ahead of the source.
    double distance(int step) const { return (slice(step) + 0.5 - m_rays.from.z) * (m_down ? -1 : 1); }
    double middle(int step) const { return std::max(distance(step), 0.5 * (distance(step) + 0.5)); }
    // Whether a cell at this place beside the source, along i (0) or j (1), lies in the face. Cells
    // on an edge belong to the face whose axis comes first in the world.
    bool inclusive(int a) const { return m_box.axes[2] < m_box.axes[std::size_t(a)]; }
    bool owns(int a, double beside, double z) const {
        const double most = m_face * z;
        return inclusive(a) ? std::abs(beside) <= most : std::abs(beside) < most;
    }
    // The rays that cross these cells, or half of one beside them; ray p crosses the slice at i = x0 + p perRay.
    CellSpan raysThrough(const CellSpan& cells, double x0, double perRay) const {
        return {std::max(0, static_cast<int>(std::floor((cells.begin - 1 - x0) / perRay))),
                std::min(m_width, static_cast<int>(std::ceil((cells.end - x0) / perRay)) + 1)};
    }
    CellSpan range(const CellSpan& wanted, double z) const {
        const double reach = m_face * z;
        const double low = m_rays.from.x - reach - 0.5, high = m_rays.from.x + reach - 0.5;
        const double begin = inclusive(0) ? std::ceil(low) : std::floor(low) + 1,
                     end = inclusive(0) ? std::floor(high) + 1 : std::ceil(high);
        return {std::max(wanted.begin, static_cast<int>(std::max(begin, -1e9))),
                std::min(wanted.end, static_cast<int>(std::min(end, 1e9)))};
    }

    const CellSlices& m_box;
    const CellRays& m_rays;
    bool m_down;
    double m_face;  // half of the edge of a face at distance 1
    int m_first = 0, m_end = 0, m_width = 0, m_rows = 0;
    double m_cell = 1, m_begin[2] = {0, 0};
    std::size_t m_stride = 0;
    std::vector<Real>& m_through;
    std::vector<Real> m_dark;
    std::vector<Real> m_before;  // for each ray the value of the field where it met the slice before; -1: unknown
};

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
