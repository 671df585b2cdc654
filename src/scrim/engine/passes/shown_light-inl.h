// SPDX-License-Identifier: Apache-2.0
// Internal, compiled once for each instruction set: what cells show the eye of light that arrives in them.
#if defined(SCRIM_SHOWN_LIGHT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SCRIM_SHOWN_LIGHT_INL_H_
#undef SCRIM_SHOWN_LIGHT_INL_H_
#else
#define SCRIM_SHOWN_LIGHT_INL_H_
#endif

#include <scrim/engine/passes/cell_rays.h>
#include <scrim/engine/passes/cell_slices.h>
#include <scrim/engine/simd-inl.h>

#include <cstddef>
#include <numbers>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

HWY_ATTR HWY_INLINE V8 transmittance(V8 tau) {
    return shortExpMinus(D8(), hn::Min(tau, value8(80)));
}

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
    static constexpr bool kOpaque = false, kMirrors = false;
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

/// What surfaces reflect towards the eye of light that arrives in the cells of one row: the two
/// parts of phong() in classified.h, of which the second one is only asked for with kMirrors.
template <bool mirrors>
class Reflected {
  public:
    static constexpr bool kOpaque = true, kMirrors = mirrors;
    HWY_ATTR Reflected(const CellView& view, const CellSlices& box)
        : m_view(view),
          m_box(box),
          m_diffuse(static_cast<Real>(view.surface->diffuse / std::numbers::pi)),
          m_specular(static_cast<Real>(view.surface->specular / std::numbers::pi)),
          m_exponent(static_cast<Real>(view.surface->exponent)),
          m_twoSided(view.surface->twoSided) {}

    bool constantFor(bool) const { return false; }
    double constantIn(const Real*, const Vec3&) const { return 0; }
    double constantAt(const Vec3&) const { return 0; }
    HWY_ATTR V8 at(V8 x, V8 y, V8 z, const CellPlace& cell) const {
        const Facing own(*this, cell);
        const V8 facing = own.towards(x, y, z);
        return hn::Mul(hn::Set(D8(), m_diffuse),
                       hn::Max(hn::MulAdd(own.weight, hn::Sub(facing, value8(1)), value8(1)), hn::Zero(D8())));
    }
    HWY_ATTR V8 in(const Real*, V8 x, V8 y, V8 z, const CellPlace& cell) const { return at(x, y, z, cell); }
    HWY_ATTR V8 over(const PhaseOverCaps&, V8, V8 x, V8 y, V8 z, const CellPlace& cell) const {
        return at(x, y, z, cell);
    }
    /// The direction to the light is -(x, y, z).
    HWY_ATTR V8 mirroredAt(V8 x, V8 y, V8 z, const CellPlace& cell) const {
        const D8 d;
        const Facing own(*this, cell);
        const V8 cosine = own.cosine(x, y, z), zero = hn::Zero(d);
        const ToEye eye(m_view, cell);
        const V8 mirrored = hn::MulAdd(hn::Add(cosine, cosine), eye.cosine(own.x, own.y, own.z), eye.cosine(x, y, z));
        const auto seen = hn::And(hn::Gt(own.towards(x, y, z), zero), hn::Gt(mirrored, zero));
        if (hn::AllFalse(d, seen)) return zero;
        const V8 safe = hn::Max(mirrored, value8(1e-30));
        const V8 tau = hn::Mul(hn::Neg(hn::Log(d, safe)), hn::Set(d, m_exponent));
        const V8 shine = hn::IfThenElseZero(seen, transmittance(hn::Max(tau, zero)));
        return hn::Mul(hn::Set(d, m_specular), hn::Mul(shine, own.weight));
    }

  private:
    // The normals of the cells.
    struct Facing {
        V8 x, y, z, weight;
        bool twoSided;
        HWY_ATTR Facing(const Reflected& of, const CellPlace& cell) : twoSided(of.m_twoSided) {
            const auto own = [&](std::size_t part)
                                 HWY_ATTR { return hn::LoadU(D8(), of.m_box.facing(part, cell.j, cell.k) + cell.i); };
            x = own(0), y = own(1), z = own(2), weight = own(3);
        }
        HWY_ATTR V8 cosine(V8 ax, V8 ay, V8 az) const {
            return hn::Neg(hn::MulAdd(x, ax, hn::MulAdd(y, ay, hn::Mul(z, az))));
        }
        HWY_ATTR V8 towards(V8 ax, V8 ay, V8 az) const {
            return twoSided ? hn::Abs(cosine(ax, ay, az)) : hn::Max(cosine(ax, ay, az), hn::Zero(D8()));
        }
    };

    const CellView& m_view;
    const CellSlices& m_box;
    Real m_diffuse, m_specular, m_exponent;
    bool m_twoSided;
};

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
