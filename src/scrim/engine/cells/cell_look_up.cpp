// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/cells/cell_look_up.h>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scrim/engine/cells/cell_look_up.cpp"
#include <hwy/foreach_target.h>
#include <scrim/engine/simd-inl.h>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {
namespace {

// Places are doubles, as SheetPath has them; values are those of cells, as many.
using DPlace = hn::CappedTag<double, 8>;
using DValue = hn::Rebind<Real, DPlace>;
using DIndex = hn::RebindToSigned<DValue>;
using VPlace = hn::Vec<DPlace>;
using VValue = hn::Vec<DValue>;
using VIndex = hn::Vec<DIndex>;

#ifdef SCRIM_DOUBLE
HWY_ATTR HWY_INLINE VPlace places(VValue v) {
    return v;
}
HWY_ATTR HWY_INLINE VValue values(VPlace v) {
    return v;
}
HWY_ATTR HWY_INLINE VIndex indices(VPlace whole) {
    return hn::ConvertTo(DIndex(), whole);
}
#else
HWY_ATTR HWY_INLINE VPlace places(VValue v) {
    return hn::PromoteTo(DPlace(), v);
}
HWY_ATTR HWY_INLINE VValue values(VPlace v) {
    return hn::DemoteTo(DValue(), v);
}
HWY_ATTR HWY_INLINE VIndex indices(VPlace whole) {
    return hn::DemoteTo(DIndex(), whole);
}
#endif

HWY_ATTR HWY_INLINE VPlace place(double v) {
    return hn::Set(DPlace(), v);
}

struct Places {
    VPlace x, y, z;
};

// from + a u + b v, in this order, as SheetPath adds them.
HWY_ATTR HWY_INLINE Places along(const Vec3& from, VPlace a, const Vec3& u, VPlace b, const Vec3& v) {
    const auto sum = [&](int c) HWY_ATTR {
        return hn::Add(hn::Add(place(from[c]), hn::Mul(a, place(u[c]))), hn::Mul(b, place(v[c])));
    };
    return {sum(0), sum(1), sum(2)};
}

// Where the samples from k on count, relative to the centre of the grid's first cell, in cells.
// `thick`: 1 where the sheet is not thin there, else 0.
HWY_ATTR HWY_INLINE Places seenIn(const CellGrid& grid, const SamplePlane& plane, const SampleTile& samples, int k,
                                  VValue extinction, VValue& thick) {
    const auto row = [&](const Real* from) HWY_ATTR { return places(hn::LoadU(DValue(), from + k)); };
    const Places middle = along(plane.wsOrigin, row(samples.u), plane.wsPerU, row(samples.v), plane.wsPerV);
    const Places aside = along(Vec3(0), row(samples.eyeA), plane.wsPerU, row(samples.eyeB), plane.wsPerV);
    const auto through = [&](VPlace slope, int c) HWY_ATTR {
        return hn::Add(place(plane.wsPerSheet[c]), hn::Mul(place(plane.toTexels), slope));
    };
    const Places way{through(aside.x, 0), through(aside.y, 1), through(aside.z, 2)};
    const VPlace length =
        hn::Sqrt(hn::Add(hn::Add(hn::Mul(way.x, way.x), hn::Mul(way.y, way.y)), hn::Mul(way.z, way.z)));
    const VPlace tau = hn::Mul(places(extinction), length), t2 = hn::Mul(tau, tau), one = place(1);
    thick = values(hn::IfThenElseZero(hn::Gt(tau, place(SheetPath::kThick)), one));
    // SheetPath::nearerThanMiddle
    const auto less = [&](double part, VPlace inner)
                          HWY_ATTR { return hn::Sub(one, hn::Mul(hn::Mul(t2, place(part)), inner)); };
    const VPlace series = less(1.0 / 60, less(1.0 / 42, less(1.0 / 40, one)));
    const VPlace seen = hn::Mul(hn::Mul(tau, place(1.0 / 12)), series);
    const auto inCells = [&](VPlace from, VPlace step, int c) HWY_ATTR {
        const VPlace ws = hn::Add(from, hn::Mul(seen, hn::Mul(place(plane.towardsEye), step)));
        const VPlace cells = hn::Div(hn::Sub(ws, place(grid.wsCorner()[c])), place(grid.edge()));
        const VPlace at = hn::Sub(hn::Sub(cells, place(grid.origin()[c])), place(0.5));
        return hn::Min(hn::Max(at, place(-1e9)), place(1e9));
    };
    return {inCells(middle.x, way.x, 0), inCells(middle.y, way.y, 1), inCells(middle.z, way.z, 2)};
}

HWY_ATTR HWY_INLINE VValue mix(VValue a, VValue b, VValue t) {
    return hn::Add(a, hn::Mul(t, hn::Sub(b, a)));
}

// Cells, as whole places, and places between their centres.
struct Cells {
    VIndex x, y, z;
    VValue fx, fy, fz;

    HWY_ATTR explicit Cells(const Places& at) {
        const auto part = [](VPlace v, VIndex& whole, VValue& fraction) HWY_ATTR {
            const VPlace floor = hn::Floor(v);
            whole = indices(floor);
            fraction = values(hn::Sub(v, floor));
        };
        part(at.x, x, fx);
        part(at.y, y, fy);
        part(at.z, z, fz);
    }
    // Between eight cells, of which `first` is the first one's value, and `index` the distance to each sample's.
    HWY_ATTR VValue between(const Real* first, VIndex index, std::ptrdiff_t step) const {
        const DValue d;
        const auto row = [&](int second, int third) HWY_ATTR {
            const Real* p = first + (third * kPaddedEdge + second) * kPaddedEdge * step;
            return mix(hn::GatherIndex(d, p, index), hn::GatherIndex(d, p + step, index), fx);
        };
        const VValue near = mix(row(0, 0), row(1, 0), fy), far = mix(row(0, 1), row(1, 1), fy);
        return mix(near, far, fz);
    }
};

// The blocks of some cells.
struct Blocks {
    static constexpr int kShift = 3;
    static_assert(1 << kShift == kCellEdge);
    VIndex x, y, z;
    HWY_ATTR explicit Blocks(const Cells& cells)
        : x(hn::ShiftRight<kShift>(cells.x)), y(hn::ShiftRight<kShift>(cells.y)), z(hn::ShiftRight<kShift>(cells.z)) {}
    HWY_ATTR hn::Mask<DIndex> in(const Int3& block) const {
        const auto same = [](VIndex own, int of) HWY_ATTR { return hn::Eq(own, hn::Set(DIndex(), of)); };
        return hn::And(same(x, block.x), hn::And(same(y, block.y), same(z, block.z)));
    }
    HWY_ATTR Int3 of(std::size_t lane) const {
        return {static_cast<int>(hn::ExtractLane(x, lane)), static_cast<int>(hn::ExtractLane(y, lane)),
                static_cast<int>(hn::ExtractLane(z, lane))};
    }
};

// paddedOffset() of each cell in its own block, times `colours`.
HWY_ATTR HWY_INLINE VIndex offsets(const Cells& cells, int colours) {
    const DIndex d;
    const auto inside = [&](VIndex cell)
                            HWY_ATTR { return hn::Add(hn::And(cell, hn::Set(d, kCellEdge - 1)), hn::Set(d, 1)); };
    const auto edge = hn::Set(d, kPaddedEdge);
    const auto rows = hn::Add(hn::Mul(inside(cells.z), edge), inside(cells.y));
    return hn::Mul(hn::Add(hn::Mul(rows, edge), inside(cells.x)), hn::Set(d, colours));
}

}  // namespace

HWY_ATTR int lookUpThinOnTarget(const CellValues& field, const SamplePlane& plane, const SampleTile& samples,
                                const Real* extinction, Real* const rgb[3], int* left) {
    const DValue d;
    const auto lanes = static_cast<int>(hn::Lanes(d));
    Int3 lastBlock(1 << 30);
    std::int32_t stored = -1;
    int count = 0;
    const auto leave = [&](int k, hn::Mask<DValue> some) HWY_ATTR {
        for (int lane = 0; lane < lanes; ++lane)
            if (hn::ExtractLane(hn::IfThenElseZero(some, hn::Set(d, Real(1))), std::size_t(lane)) != 0)
                left[count++] = k + lane;
    };
    for (int k = 0; k < kTileSize; k += lanes) {
        const VValue own = hn::LoadU(d, extinction + k), zero = hn::Zero(d);
        VValue out[3] = {zero, zero, zero};
        auto open = hn::Ne(own, zero);
        if (!hn::AllFalse(d, open)) {
            VValue thick;
            const Cells cells(seenIn(*field.grid, plane, samples, k, own, thick));
            const Blocks blocks(cells);
            const VIndex index = offsets(cells, static_cast<int>(field.colours));
            const auto isThick = hn::And(open, hn::Ne(thick, zero));
            if (!hn::AllFalse(d, isThick)) leave(k, isThick);
            open = hn::AndNot(isThick, open);
            // Block by block: neighbouring samples are mostly in the same one.
            for (std::ptrdiff_t lane = hn::FindFirstTrue(d, open); lane >= 0; lane = hn::FindFirstTrue(d, open)) {
                const Int3 block = blocks.of(std::size_t(lane));
                if (block != lastBlock) lastBlock = block, stored = field.grid->stored(block);
                const auto same = hn::And(open, hn::RebindMask(d, blocks.in(block)));
                open = hn::AndNot(same, open);
                if (stored < 0) {
                    leave(k, same);
                    continue;
                }
                const VIndex from = hn::IfThenElseZero(hn::RebindMask(DIndex(), same), index);
                const Real* first = field.values + std::size_t(stored) * kPaddedCells * field.colours;
                const auto step = static_cast<std::ptrdiff_t>(field.colours);
                for (std::size_t c = 0; c < field.colours; ++c)
                    out[c] = hn::IfThenElse(same, cells.between(first + c, from, step), out[c]);
            }
        }
        for (std::size_t c = 0; c < 3; ++c)
            hn::StoreU(hn::Mul(out[field.colours == 1 ? 0 : c], hn::Set(d, field.tint[c])), d, rgb[c] + k);
    }
    return count;
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scrim {

HWY_EXPORT(lookUpThinOnTarget);

int lookUpThin(const CellValues& field, const SamplePlane& plane, const SampleTile& samples, const Real* extinction,
               Real* const rgb[3], int* left) {
    return SCRIM_ON_TARGET(plane.simd, lookUpThinOnTarget)(field, plane, samples, extinction, rgb, left);
}

}  // namespace scrim
#endif
