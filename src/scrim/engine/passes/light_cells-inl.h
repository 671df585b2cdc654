// SPDX-License-Identifier: Apache-2.0
// Internal: the sweep of light_cells.cpp through a box of cells, slice by slice along one axis.
//
// The rays of a source cross every slice at the same places of a raster: for parallel rays the raster is sheared with
// their direction, for rays from a point it is the picture that the point sees of the slice, and grows with the
// distance. Thus transmittance is multiplied up without being interpolated from slice to slice; only extinction is, to
// the rays, and transmittance once, to the cells: its depth would be dark where half of the light passes an edge.
#ifndef SCRIM_LIGHT_CELLS_BOX
#define SCRIM_LIGHT_CELLS_BOX

#include <scrim/base/real.h>
#include <scrim/engine/passes/cell_slices.h>
#include <scrim/geometry/spaces.h>
#include <scrim/scene/classified.h>
#include <scrim/scene/medium.h>
#include <scrim/scene/phase_over_caps.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <tuple>
#include <vector>

namespace scrim {

/// A source of light without extent, in the axes of CellSlices and in cells.
struct CellRays {
    bool parallel = true;
    Vec3 way{0, 0, 1};                   ///< parallel: direction of travel, unit; otherwise the normal of an element
    Vec3 from{0};                        ///< the place of a source that is not parallel
    double radius2 = 0, decayScale = 0;  ///< irradiance is weight / max(r2, radius2) * decayScale; 0: no decay
    bool lamp = false;                   ///< a point of a lamp, of which only the transmittance is asked
    bool oneSided = false;               ///< an element: irradiance has the cosine to its normal as factor
    double spreadTangent = 0, spreadScale = 0;                   ///< of an element (see Spread); scale 0: none
    std::optional<std::tuple<double, Vec3, Mat3>> pattern = {};  ///< of a part of a mesh: CellSlices::seriesOf
    bool attenuated = true;                                      ///< false: only surfaces hold the light back
    double extinction = 1;                                       ///< factor on that of the cells
    bool blocked = false;                                        ///< surfaces hold the light back
    const Real* phaseRow = nullptr;  ///< in place of CellView's phase function (PhaseRow); null: that one
    /// Of a part of a surface: its means in place of the phase function; null: that one.
    const PhaseOverCaps* caps = nullptr;
    double capRadius = 0;  ///< of the disk that the part stands for
    Real weight[3] = {0, 0, 0};
};

/// What all sources of a sweep share.
struct CellView {
    Phase phase;                          ///< towards the eye
    const Classified* surface = nullptr;  ///< Phong's model in place of the phase function
    bool mirrored = false;                ///< its highlights alone; else its diffuse part alone
    bool parallelEye = true;
    Vec3 eye{0};  ///< its place, in the axes of CellSlices and in cells; parallel: the direction towards it
    std::size_t colours = 1;
    /// The number of steps after which the ray from + steps perStep (cells of the box) is dark, because it has met a
    /// surface; infinity where it meets none. Parallel rays begin at minus infinity, others at 0.
    std::function<double(const Vec3& from, const Vec3& perStep, bool parallel)> darkFrom;
};

}  // namespace scrim
#endif

#if defined(SCRIM_LIGHT_CELLS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SCRIM_LIGHT_CELLS_INL_H_
#undef SCRIM_LIGHT_CELLS_INL_H_
#else
#define SCRIM_LIGHT_CELLS_INL_H_
#endif

#include <scrim/engine/passes/values_before-inl.h>
#include <scrim/engine/simd-inl.h>

#include <cmath>
#include <numbers>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

HWY_ATTR HWY_INLINE V8 transmittance(V8 tau) {
    return shortExpMinus(D8(), hn::Min(tau, value8(80)));
}

/// The transmittance below which no light is looked for within opaque matter.
constexpr double kDark = 1e-4;

/// Cells of row j of slice k, from cell i on.
struct CellPlace {
    int i, j, k;
};

/// The vectors from the centres of cells towards the eye.
struct ToEye {
    V8 x, y, z, length;

    HWY_ATTR HWY_INLINE ToEye(const CellView& view, const CellPlace& cell)
        : x(value8(view.eye.x)), y(value8(view.eye.y)), z(value8(view.eye.z)), length(value8(1)) {
        if (view.parallelEye) return;
        x = hn::Sub(x, hn::Add(counted(cell.i), value8(0.5)));
        y = value8(view.eye.y - (cell.j + 0.5));
        z = value8(view.eye.z - (cell.k + 0.5));
        length = hn::Sqrt(hn::MulAdd(x, x, hn::MulAdd(y, y, hn::MulAdd(z, z, value8(1e-12)))));
    }
    HWY_ATTR HWY_INLINE V8 cosine(V8 ax, V8 ay, V8 az) const {
        return hn::Div(hn::MulAdd(ax, x, hn::MulAdd(ay, y, hn::Mul(az, z))), length);
    }
};

/// The phase function towards the eye, for the cells of one row.
class TowardsEye {
  public:
    static constexpr bool kOpaque = false;
    HWY_ATTR TowardsEye(const CellView& view)
        : m_view(view), m_lobe(view.phase.g, kSphere), m_other(view.phase.g2, kSphere, view.phase.alpha) {}

    /// True if the phase function is the same for parallel rays at all cells: its value is then `constantAt`.
    bool constantFor(bool parallel) const { return m_view.phase.isotropic() || (parallel && m_view.parallelEye); }
    double constantIn(const Real* row, const Vec3& travel) const {
        return phaseIn(PhaseRow(row, row + kPhaseAngles + 1), glm::dot(travel, m_view.eye));
    }
    double constantAt(const Vec3& travel) const {
        return m_view.phase.isotropic() ? double(kSphere) : phaseValue(m_view.phase, glm::dot(travel, m_view.eye));
    }
    /// For light that travels along (x, y, z), unit, at the cells with these coordinates.
    HWY_ATTR V8 at(V8 x, V8 y, V8 z, const CellPlace& cell) const { return valueAt(cosineAt(x, y, z, cell)); }
    /// The same by a row (PhaseRow) in place of the phase function.
    HWY_ATTR V8 in(const Real* row, V8 x, V8 y, V8 z, const CellPlace& cell) const {
        return rowAt(D8(), row, entryOf(D8(), cosineAt(x, y, z, cell)));
    }
    /// The mean over caps of these half angles.
    HWY_ATTR V8 over(const PhaseOverCaps& caps, V8 halfAngle, V8 x, V8 y, V8 z, const CellPlace& cell) const {
        return capsAt(D8(), caps, halfAngle, cosineAt(x, y, z, cell));
    }

  private:
    HWY_ATTR V8 cosineAt(V8 x, V8 y, V8 z, const CellPlace& cell) const { return ToEye(m_view, cell).cosine(x, y, z); }
    HWY_ATTR V8 valueAt(V8 cosine) const {
        if (m_view.phase.type == PhaseType::rayleigh) {
            const V8 directed = hn::MulAdd(value8(0.75), hn::Mul(cosine, cosine), value8(-0.25));
            return hn::Mul(hn::MulAdd(value8(m_view.phase.strength), directed, value8(1)), hn::Set(D8(), kSphere));
        }
        V8 value = henyeyGreenstein(D8(), cosine, m_lobe);
        if (m_view.phase.type == PhaseType::twoLobe)
            value = hn::MulAdd(value8(m_view.phase.blend), hn::Sub(drainePhase(D8(), cosine, m_other), value), value);
        return value;
    }

    static constexpr Real kSphere = Real(1 / (4 * std::numbers::pi));
    const CellView& m_view;
    Lobe m_lobe, m_other;
};

/// What surfaces reflect towards the eye of light that arrives in the cells of one row: phong() in classified.h, of
/// which one part is kept.
template <bool kMirrored>
class Reflected {
  public:
    static constexpr bool kOpaque = true;
    HWY_ATTR Reflected(const CellView& view, const CellSlices& box)
        : m_view(view),
          m_box(box),
          m_share(static_cast<Real>((kMirrored ? view.surface->specular : view.surface->diffuse) / std::numbers::pi)),
          m_exponent(static_cast<Real>(view.surface->exponent)),
          m_twoSided(view.surface->twoSided) {}

    bool constantFor(bool) const { return false; }
    double constantIn(const Real*, const Vec3&) const { return 0; }
    double constantAt(const Vec3&) const { return 0; }
    HWY_ATTR V8 at(V8 x, V8 y, V8 z, const CellPlace& cell) const {
        const D8 d;
        const auto own = [&](std::size_t part)
                             HWY_ATTR { return hn::LoadU(d, m_box.facing(part, cell.j, cell.k) + cell.i); };
        const V8 nx = own(0), ny = own(1), nz = own(2), weight = own(3), zero = hn::Zero(d),
                 share = hn::Set(d, m_share);
        const V8 cosine = hn::Neg(hn::MulAdd(nx, x, hn::MulAdd(ny, y, hn::Mul(nz, z))));
        const V8 facing = m_twoSided ? hn::Abs(cosine) : hn::Max(cosine, zero);
        if constexpr (!kMirrored) {
            return hn::Mul(share, hn::Max(hn::MulAdd(weight, hn::Sub(facing, value8(1)), value8(1)), zero));
        } else {
            // The direction to the light is -(x, y, z).
            const ToEye eye(m_view, cell);
            const V8 mirrored = hn::MulAdd(hn::Add(cosine, cosine), eye.cosine(nx, ny, nz), eye.cosine(x, y, z));
            const V8 safe = hn::Max(mirrored, value8(1e-30));
            const V8 tau = hn::Mul(hn::Neg(hn::Log(d, safe)), hn::Set(d, m_exponent));
            const V8 shine = hn::IfThenElseZero(hn::And(hn::Gt(facing, zero), hn::Gt(mirrored, zero)),
                                                transmittance(hn::Max(tau, zero)));
            return hn::Mul(share, hn::Mul(shine, weight));
        }
    }
    HWY_ATTR V8 in(const Real*, V8 x, V8 y, V8 z, const CellPlace& cell) const { return at(x, y, z, cell); }
    HWY_ATTR V8 over(const PhaseOverCaps&, V8, V8 x, V8 y, V8 z, const CellPlace& cell) const {
        return at(x, y, z, cell);
    }

  private:
    const CellView& m_view;
    const CellSlices& m_box;
    Real m_share, m_exponent;
    bool m_twoSided;
};

/// What is left of `light` behind an optical depth; at the least what no eye sees, because tiny numbers are slow.
HWY_ATTR HWY_INLINE V8 passed(V8 light, V8 tau) {
    return hn::Max(hn::Mul(light, transmittance(tau)), value8(1e-30));
}

/// Adds light to the cells of row j of slice k from cell i on.
HWY_ATTR HWY_INLINE void addTo(CellSlices& box, const CellView& view, const CellRays& rays, int i, int j, int k,
                               V8 light) {
    for (std::size_t c = 0; c < view.colours; ++c) {
        Real* to = box.sums(c, j, k) + i;
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
        if (box.integral()) m_before.begin(std::size_t(m_rows), m_stride);
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
    int rows() const { return m_rays.attenuated ? m_box.size[1] + 1 : 0; }
    int slice(int step) const { return m_down ? m_box.size[2] - 1 - step : step; }
    bool reaches(int) const { return true; }

    /// What lies between the slice before and this one holds back the rays of a row, by the values of the field.
    HWY_ATTR void attenuateTo(int step, int row) {
        const D8 d;
        const Offset x(m_begin[0] + step * m_slope[0]), y(m_begin[1] + step * m_slope[1]);
        const int j = row - 1, k = slice(step), shift = 2 - x.whole;
        const CellSpan span = m_box.withValues(j, k);
        const int begin = span.begin - 1, end = span.end;
        const CellSpan met = span.empty() ? CellSpan() : CellSpan{begin + shift, end + shift};
        Real* before = m_before.of(std::size_t(j - y.whole + 2), met) + shift;
        if (span.empty()) return;
        const Real* a = m_box.values(j, k);
        const Real* b = m_box.values(j + 1, k);
        Real* to = through(j - y.whole) - x.whole;
        const V8 fx = value8(x.fraction), fy = value8(y.fraction), perSlice = value8(m_perSlice * m_box.edge());
        for (int i = begin; i < end; i += static_cast<int>(hn::Lanes(d))) {
            const V8 value = bilinear(hn::LoadU(d, a + i), hn::LoadU(d, a + i + 1), hn::LoadU(d, b + i),
                                      hn::LoadU(d, b + i + 1), fx, fy);
            const V8 old = hn::LoadU(d, before + i), left = hn::LoadU(d, to + i);
            const V8 tau = hn::Mul(perSlice, meanBetween(*m_box.integral(), old, value));
            const auto inside = hn::Lt(counted(i), value8(end));
            hn::StoreU(hn::IfThenElse(inside, passed(left, tau), left), d, to + i);
            hn::StoreU(hn::IfThenElse(inside, value, old), d, before + i);
        }
    }

    /// The extinction of a slice holds back the rays of one row of those that cross it.
    HWY_ATTR void attenuate(int step, int row) {
        const D8 d;
        const Offset x(m_begin[0] + step * m_slope[0]), y(m_begin[1] + step * m_slope[1]);
        const int j = row - 1, k = slice(step);
        const CellSpan span = m_box.full[m_box.paddedRow(j, k)].with(m_box.full[m_box.paddedRow(j + 1, k)]);
        if (span.empty()) return;
        const Real* a = m_box.row(j, k);
        const Real* b = m_box.row(j + 1, k);
        Real* to = through(j - y.whole) - x.whole;
        const V8 fx = value8(x.fraction), fy = value8(y.fraction), perSlice = value8(m_perSlice);
        for (int i = span.begin - 1; i < span.end; i += static_cast<int>(hn::Lanes(d))) {
            const V8 a0 = hn::LoadU(d, a + i), a1 = hn::LoadU(d, a + i + 1);
            const V8 b0 = hn::LoadU(d, b + i), b1 = hn::LoadU(d, b + i + 1);
            const V8 tau = hn::Mul(perSlice, bilinear(a0, a1, b0, b1, fx, fy));
            hn::StoreU(passed(hn::LoadU(d, to + i), tau), d, to + i);
        }
    }

    /// Adds the light that arrives in the cells of row j of a slice.
    template <class Towards>
    HWY_ATTR void light(int step, int j, const CellView& view, const Towards& towards, CellSlices& box) const {
        const D8 d;
        const int k = slice(step);
        const CellSpan span = box.wanted[box.rowIndex(j, k)];
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
                const V8 open = litBetween(hn::LoadU(d, dark + i), hn::LoadU(d, dark + i - 1), hn::LoadU(d, beside + i),
                                           hn::LoadU(d, beside + i - 1), value8(step), fx, fy);
                arrives = hn::Mul(arrives, open);
            }
            addTo(box, view, m_rays, i, j, k, hn::Mul(p, arrives));
        }
    }

  private:
    struct Offset {
        explicit Offset(double x) : whole(static_cast<int>(std::floor(x))), fraction(x - whole) {}
        int whole;
        double fraction;
    };
    // A row of the raster, from the ray on that crosses i = 0 where the whole offset is 0.
    Real* through(int row) { return m_through.data() + std::size_t(row + 2) * m_stride + 2; }
    const Real* through(int row) const { return m_through.data() + std::size_t(row + 2) * m_stride + 2; }

    const CellSlices& m_box;
    const CellRays& m_rays;
    bool m_down;
    double m_perSlice;
    double m_slope[2], m_begin[2];
    std::size_t m_stride;
    int m_rows;
    std::vector<Real>& m_through;
    std::vector<Real> m_dark;
    ValuesBefore m_before;
};

/// Transmittances of the rays from a point to the cells of one face of a cube around it; for a lamp their depths.
class PointRaster {
  public:
    PointRaster(const CellSlices& box, const CellRays& rays, const CellView& view, std::vector<Real>& through,
                bool down)
        : m_box(box), m_rays(rays), m_down(down), m_through(through) {
        while (m_first < box.size[2] && distance(m_first) + 0.5 <= 0) ++m_first;
        if (m_first == box.size[2]) return;
        const double near = middle(m_first), far = middle(box.size[2] - 1);
        m_cell = 1 / std::max(far, 1.0);
        int count[2];
        for (int a = 0; a < 2; ++a) {
            const double low = -1 - rays.from[a], high = box.size[a] + 1 - rays.from[a];
            const double least = std::max(-1.0, low / (low < 0 ? near : far)),
                         most = std::min(1.0, high / (high > 0 ? near : far));
            m_begin[a] = least - 2 * m_cell;
            count[a] = most > least ? static_cast<int>((most - least) / m_cell) + 6 : 0;
        }
        m_width = count[0];
        m_rows = m_width > 0 ? count[1] : 0;
        m_stride = std::size_t(m_width + 2 * kRowSlack);
        m_through.assign(std::size_t(m_rows) * m_stride, Real(rays.lamp ? 0 : 1));
        if (box.integral()) m_before.begin(std::size_t(m_rows), m_stride);
        if (!rays.blocked) return;
        m_dark.resize(m_through.size());
        for (int q = 0; q < m_rows; ++q)
            for (std::size_t p = 0; p < m_stride; ++p)
                m_dark[std::size_t(q) * m_stride + p] = static_cast<Real>(view.darkFrom(
                    rays.from, {m_begin[0] + double(p) * m_cell, m_begin[1] + q * m_cell, down ? -1 : 1}, false));
    }
    int rows() const { return m_rays.attenuated ? m_rows : 0; }
    int slice(int step) const { return m_down ? m_box.size[2] - 1 - step : step; }
    bool reaches(int step) const { return m_rows > 0 && step >= m_first; }

    HWY_ATTR void attenuateTo(int step, int row) {
        const D8 d;
        const hn::RebindToSigned<D8> di;
        const int k = slice(step);
        const double z = middle(step), thickness = m_box.edge() * (step > m_first ? z - middle(step - 1) : z);
        const double aside = m_begin[1] + row * m_cell, y = m_rays.from.y + aside * z - 0.5;
        const int j = static_cast<int>(std::floor(y));
        const CellSpan span = j < -1 || j >= m_box.size[1] ? CellSpan() : m_box.withValues(j, k);
        // Ray p crosses the slice at i = x0 + p perRay.
        const double x0 = m_rays.from.x + m_begin[0] * z - 0.5, perRay = m_cell * z;
        const CellSpan met =
            span.empty() ? CellSpan()
                         : CellSpan{std::max(0, static_cast<int>(std::floor((span.begin - 1 - x0) / perRay))),
                                    std::min(m_width, static_cast<int>(std::ceil((span.end - x0) / perRay)) + 1)};
        Real* before = m_before.of(std::size_t(row), met.empty() ? CellSpan() : met);
        if (met.empty()) return;
        const Real* a = m_box.values(j, k);
        const Real* b = m_box.values(j + 1, k);
        Real* to = m_through.data() + std::size_t(row) * m_stride;
        const V8 fy = value8(y - j), part = value8(thickness), across2 = value8(1 + aside * aside);
        for (int p = met.begin; p < met.end; p += static_cast<int>(hn::Lanes(d))) {
            const V8 x = hn::Min(hn::Max(hn::MulAdd(counted(p), value8(perRay), value8(x0)), value8(span.begin - 1)),
                                 value8(span.end));
            const V8 whole = hn::Floor(x), fx = hn::Sub(x, whole);
            const auto i = hn::ConvertTo(di, whole), next = hn::Add(i, hn::Set(di, 1));
            const V8 value = bilinear(hn::GatherIndex(d, a, i), hn::GatherIndex(d, a, next), hn::GatherIndex(d, b, i),
                                      hn::GatherIndex(d, b, next), fx, fy);
            const V8 along = hn::MulAdd(counted(p), value8(m_cell), value8(m_begin[0]));
            const V8 way = hn::Mul(part, hn::Sqrt(hn::MulAdd(along, along, across2)));
            const V8 old = hn::LoadU(d, before + p), left = hn::LoadU(d, to + p);
            const V8 tau = hn::Mul(way, meanBetween(*m_box.integral(), old, value));
            const auto inside = hn::Lt(counted(p), value8(met.end));
            hn::StoreU(hn::IfThenElse(inside, passed(left, tau), left), d, to + p);
            hn::StoreU(hn::IfThenElse(inside, value, old), d, before + p);
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
        const CellSpan span = m_box.full[m_box.paddedRow(j, k)].with(m_box.full[m_box.paddedRow(j + 1, k)]);
        if (span.empty()) return;
        // Ray p crosses the slice at i = x0 + p perRay.
        const double x0 = m_rays.from.x + m_begin[0] * z - 0.5, perRay = m_cell * z;
        const int begin = std::max(0, static_cast<int>(std::floor((span.begin - 1 - x0) / perRay)));
        const int end = std::min(m_width, static_cast<int>(std::ceil((span.end - x0) / perRay)) + 1);
        const Real* a = m_box.row(j, k);
        const Real* b = m_box.row(j + 1, k);
        Real* to = m_through.data() + std::size_t(row) * m_stride;
        const V8 fy = value8(y - j), part = value8(thickness), across2 = value8(1 + aside * aside);
        for (int p = begin; p < end; p += static_cast<int>(hn::Lanes(d))) {
            const V8 x = hn::Min(hn::Max(hn::MulAdd(counted(p), value8(perRay), value8(x0)), value8(span.begin - 1)),
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

    template <class Towards>
    HWY_ATTR void light(int step, int j, const CellView& view, const Towards& towards, CellSlices& box) const {
        const D8 d;
        const hn::RebindToSigned<D8> di;
        const int k = slice(step);
        const double z = distance(step),
                     own = m_rays.attenuated && !box.integral() ? m_rays.extinction * std::min(z, 0.5) : 0,
                     y = j + 0.5 - m_rays.from.y;
        if (z <= 0 || !owns(1, y, z)) return;
        const CellSpan span = range(box.wanted[box.rowIndex(j, k)], z);
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
        for (int i = span.begin; i < span.end; i += static_cast<int>(hn::Lanes(d))) {
            const V8 center = hn::Add(counted(i), half), x = hn::Sub(center, value8(m_rays.from.x));
            const V8 at = hn::Min(hn::MulAdd(x, perCell, first), value8(m_width + 4)), whole = hn::Floor(at),
                     fx = hn::Sub(at, whole);
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
            if (m_rays.decayScale > 0)
                light = hn::Div(hn::Mul(light, value8(m_rays.decayScale)), hn::Max(r2, value8(m_rays.radius2)));
            V8 seen = value8(m_rays.capRadius);
            if (m_rays.oneSided) {
                const V8 facing = hn::Max(dot8(wx, wy, wz, m_rays.way), hn::Zero(d));
                light = hn::Mul(light, throughSpread(facing));
                seen = hn::Mul(seen, hn::Sqrt(facing));
            }
            if (m_rays.pattern) light = hn::Mul(light, sentAlong(wx, wy, wz));
            light = hn::Mul(light, constant ? phase
                                   : caps   ? towards.over(*caps, hn::Mul(seen, one), wx, wy, wz, {i, j, k})
                                            : towards.at(wx, wy, wz, {i, j, k}));
            // Cells beyond the face belong to another one.
            light = hn::IfThenElseZero(hn::Lt(counted(i), value8(span.end)), light);
            addTo(box, view, m_rays, i, j, k, light);
        }
    }

  private:
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
    // Whether a cell at this place beside the source, along i (0) or j (1), lies in the face. Cells on an edge belong
    // to the face whose axis comes first in the world.
    bool inclusive(int a) const { return m_box.axes[2] < m_box.axes[std::size_t(a)]; }
    bool owns(int a, double beside, double z) const {
        return inclusive(a) ? std::abs(beside) <= z : std::abs(beside) < z;
    }
    CellSpan range(const CellSpan& wanted, double z) const {
        const double low = m_rays.from.x - z - 0.5, high = m_rays.from.x + z - 0.5;
        const double begin = inclusive(0) ? std::ceil(low) : std::floor(low) + 1,
                     end = inclusive(0) ? std::floor(high) + 1 : std::ceil(high);
        return {std::max(wanted.begin, static_cast<int>(std::max(begin, -1e9))),
                std::min(wanted.end, static_cast<int>(std::min(end, 1e9)))};
    }

    const CellSlices& m_box;
    const CellRays& m_rays;
    bool m_down;
    int m_first = 0, m_width = 0, m_rows = 0;
    double m_cell = 1, m_begin[2] = {0, 0};
    std::size_t m_stride = 0;
    std::vector<Real>& m_through;
    std::vector<Real> m_dark;
    ValuesBefore m_before;
};

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
