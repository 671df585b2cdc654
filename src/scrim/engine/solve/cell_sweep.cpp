// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/solve/cell_sweep.h>

#include <scrim/base/parallel.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include <glm/common.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scrim/engine/solve/cell_sweep.cpp"
#include <hwy/aligned_allocator.h>
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <scrim/engine/simd-inl.h>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

using DL = hn::CappedTag<Real, kOrdinateLanes>;
using VL = hn::Vec<DL>;

HWY_ATTR HWY_INLINE VL lanes(const Real* from) {
    return hn::LoadU(DL(), from);
}

// What cells emit: one value for each cell, or rows of ordinates, which lie far from each other in
// memory, so that they are fetched ahead.
struct SameEmission {
    const Real* source;

    HWY_ATTR VL operator()(std::size_t cell) const { return hn::Set(DL(), source[cell]); }
    void fetch(std::size_t) const {}
};
struct EmissionInRows {
    const std::int32_t* slots;
    const Real* rows;
    std::size_t count;

    HWY_ATTR VL operator()(std::size_t cell) const {
        return slots[cell] < 0 ? hn::Zero(DL()) : lanes(rows + std::size_t(slots[cell]) * count);
    }
    void fetch(std::size_t cell) const {
        if (slots[cell] >= 0) hwy::Prefetch(rows + std::size_t(slots[cell]) * count);
    }
};

// The result of one cell: the radiance in it, and what leaves it along each axis.
struct Passed {
    VL in, x, y, z;
};

// Some ordinates of one octant, which pass all cells in the same order.
class Bundle {
  public:
    // `caught`: the bundle's own row, with one value for each side of walls that send light back.
    HWY_ATTR Bundle(const CellSweep& sweep, int octant, int first, Real* caught)
        : m_sweep(sweep),
          m_caught(caught),
          m_first(std::size_t(octant * sweep.ordinates->perOctant + first)),
          m_lanes(hn::Lanes(DL())) {
        const Int3 blocks = sweep.grid->blocks();
        Vec3 onFace(0);  // pi, but for the quadrature's error
        for (std::size_t m = 0; m < sweep.ordinates->weights.size(); ++m)
            onFace += 0.5 * sweep.ordinates->weights[m] * glm::abs(sweep.ordinates->directions[m]);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            m_down[axis] = (octant >> axis & 1) != 0;
            for (std::size_t lane = 0; lane < m_lanes; ++lane)
                m_slope[axis][lane] = static_cast<Real>(
                    2 * std::abs(sweep.ordinates->directions[m_first + lane][int(axis)]) / sweep.grid->edge());
        }
        for (std::size_t lane = 0; lane < m_lanes; ++lane) {
            for (int axis = 0; axis < 3; ++axis)
                m_onFace[axis][lane] =
                    static_cast<Real>(sweep.ordinates->weights[m_first + lane] *
                                      std::abs(sweep.ordinates->directions[m_first + lane][axis]) / onFace[axis]);
            m_weight[lane] = static_cast<Real>(sweep.ordinates->weights[m_first + lane] / (4 * std::numbers::pi));
            m_inflow[lane] = sweep.inflow && !sweep.inflow->even.empty() ? sweep.inflow->even[m_first + lane] : Real(0);
        }
        m_acrossX = std::size_t(blocks.x) * kCellEdge;
        m_x = hwy::AllocateAligned<Real>(kCellEdge * kCellEdge * m_lanes);
        m_y = hwy::AllocateAligned<Real>(kCellEdge * m_acrossX * m_lanes);
        m_z = hwy::AllocateAligned<Real>(std::size_t(blocks.y) * kCellEdge * m_acrossX * m_lanes);
    }

    // Passes all blocks in the order in which light does, and calls cell(index, extinction, passed)
    // for each stored cell.
    template <class Source, class Result>
    HWY_ATTR void pass(const Source& source, const Result& result) {
        const Int3 blocks = m_sweep.grid->blocks();
        const std::size_t acrossY = std::size_t(blocks.y) * kCellEdge;
        enter(m_z.get(), acrossY * m_acrossX, 2, [&](std::size_t i) { return At{i % m_acrossX, i / m_acrossX}; });
        for (int k = 0; k < blocks.z; ++k) {
            const int atZ = m_down[2] ? blocks.z - 1 - k : k;
            const std::size_t z = std::size_t(atZ) * kCellEdge;
            enter(m_y.get(), kCellEdge * m_acrossX, 1, [&](std::size_t i) {
                return At{i % m_acrossX, z + i / m_acrossX};
            });
            for (int j = 0; j < blocks.y; ++j) {
                const int atY = m_down[1] ? blocks.y - 1 - j : j;
                const std::size_t y = std::size_t(atY) * kCellEdge;
                enter(m_x.get(), kCellEdge * kCellEdge, 0, [&](std::size_t i) {
                    return At{y + i % kCellEdge, z + i / kCellEdge};
                });
                for (int i = 0; i < blocks.x; ++i) {
                    const Int3 at(m_down[0] ? blocks.x - 1 - i : i, atY, atZ);
                    const std::int32_t stored = m_sweep.grid->stored(at);
                    if (stored < 0)
                        passEmpty(at);
                    else if (m_sweep.notBelowZero)
                        passBlock<true>(at, std::size_t(stored), source, result);
                    else
                        passBlock<false>(at, std::size_t(stored), source, result);
                }
            }
        }
    }

    std::size_t firstOrdinate() const { return m_first; }
    HWY_ATTR VL weight() const { return lanes(m_weight); }

  private:
    // A face of the border, counted along axesAcross().
    struct At {
        std::size_t u, v;
    };
    // Fills the faces across an axis at the border; place(i) is the place of face i.
    template <class PlaceOf>
    HWY_ATTR void enter(Real* faces, std::size_t count, int axis, const PlaceOf& place) const {
        if (m_sweep.inflow && m_sweep.inflow->even.empty()) return enterByPlace(faces, count, axis, place);
        const VL inflow = lanes(m_inflow);
        for (std::size_t i = 0; i < count; ++i) hn::StoreU(inflow, DL(), faces + i * m_lanes);
        if (!m_sweep.border || m_sweep.border->empty()) return;
        const auto ordinates = std::size_t(m_sweep.ordinates->count());
        const Int3 size = m_sweep.grid->blocks() * kCellEdge;
        const auto nx = std::size_t(size.x), ny = std::size_t(size.y), nz = std::size_t(size.z);
        const std::size_t first = axis == 0 ? 0 : axis == 1 ? ny * nz : (ny + nx) * nz, row = axis == 0 ? ny : nx;
        for (std::size_t i = 0; i < count; ++i) {
            const At at = place(i);
            const std::uint8_t* open = m_sweep.border->data() + (first + at.v * row + at.u) * ordinates + m_first;
            for (std::size_t lane = 0; lane < m_lanes; ++lane)
                faces[i * m_lanes + lane] *= static_cast<Real>(open[lane]);
        }
    }
    template <class PlaceOf>
    HWY_ATTR void enterByPlace(Real* faces, std::size_t count, int axis, const PlaceOf& place) const {
        const int side = 2 * axis + (m_down[axis] ? 1 : 0);
        const auto ordinates = std::size_t(m_sweep.ordinates->count());
        const Real* rows = m_sweep.inflow->byNode[std::size_t(side)].data() + m_first;
        const Int3 size = m_sweep.grid->blocks() * kCellEdge;
        const std::array<int, 2> axes = axesAcross(axis);
        for (std::size_t i = 0; i < count; ++i) {
            const At at = place(i);
            const Inflow::Place nodes = m_sweep.inflow->placeOn(
                side, {(double(at.u) + 0.5) / size[axes[0]], (double(at.v) + 0.5) / size[axes[1]]});
            VL sum = hn::Zero(DL());
            for (std::size_t k = 0; k < 4; ++k)
                sum = hn::MulAdd(hn::Set(DL(), nodes.weight[k]), lanes(rows + nodes.node[k] * ordinates), sum);
            hn::StoreU(sum, DL(), faces + i * m_lanes);
        }
    }
    Real* faceX(int y, int z) { return m_x.get() + std::size_t(z * kCellEdge + y) * m_lanes; }
    Real* faceY(int x, int z) { return m_y.get() + (std::size_t(z) * m_acrossX + std::size_t(x)) * m_lanes; }
    Real* faceZ(int x, int y) { return m_z.get() + (std::size_t(y) * m_acrossX + std::size_t(x)) * m_lanes; }

    template <bool kNotBelowZero, class Source, class Result>
    HWY_ATTR void passBlock(const Int3& at, std::size_t block, const Source& source, const Result& result) {
        if (m_sweep.grid->walled(block) >= 0)
            passCells<kNotBelowZero, true>(at, block, source, result);
        else
            passCells<kNotBelowZero, false>(at, block, source, result);
    }
    template <bool kNotBelowZero, bool kWalls, class Source, class Result>
    HWY_ATTR void passCells(const Int3& at, std::size_t block, const Source& source, const Result& result) {
        const std::size_t base = block * kBlockCells;
        const WallFaces walls = kWalls ? wallFaces(block) : WallFaces{};
        const VL slopeX = lanes(m_slope[0]), slopeY = lanes(m_slope[1]), slopeZ = lanes(m_slope[2]);
        const VL slopes = hn::Add(slopeX, hn::Add(slopeY, slopeZ));
        const DL d;
        const VL one = hn::Set(d, Real(1)), two = hn::Set(d, Real(2));
        for (int k = 0; k < kCellEdge; ++k) {
            const int z = m_down[2] ? kCellEdge - 1 - k : k;
            for (int j = 0; j < kCellEdge; ++j) {
                const int y = m_down[1] ? kCellEdge - 1 - j : j;
                Real* const intoX = faceX(y, z);
                VL x = lanes(intoX);
                const int nextY = m_down[1] ? y - 1 : y + 1;
                for (int i = 0; j + 1 < kCellEdge && i < kCellEdge; ++i)
                    source.fetch(base + std::size_t(cellOffset(i, nextY, z)));
                for (int i = 0; i < kCellEdge; ++i) {
                    const int cx = m_down[0] ? kCellEdge - 1 - i : i;
                    const std::size_t cell = base + std::size_t(cellOffset(cx, y, z));
                    Real* const intoY = faceY(at.x * kCellEdge + cx, z);
                    Real* const intoZ = faceZ(at.x * kCellEdge + cx, at.y * kCellEdge + y);
                    const VL extinction = hn::Set(d, m_sweep.extinction[cell]), sent = source(cell);
                    VL fromY = lanes(intoY), fromZ = lanes(intoZ);
                    if constexpr (kWalls) {
                        const auto padded = std::size_t(paddedOffset(cx + 1, y + 1, z + 1));
                        x = past(walls, 0, padded, cell - base, x);
                        fromY = past(walls, 1, padded, cell - base, fromY);
                        fromZ = past(walls, 2, padded, cell - base, fromZ);
                    }
                    // The cell's balance, with outflow = 2 in - inflow and slope = 2 |cosine| / edge.
                    const VL entered =
                        hn::MulAdd(slopeX, x, hn::MulAdd(slopeY, fromY, hn::MulAdd(slopeZ, fromZ, sent)));
                    // The quotient does not wait for the cell before.
                    const VL in = hn::Mul(entered, hn::Div(one, hn::Add(extinction, slopes)));
                    Passed out{in, hn::MulSub(two, in, x), hn::MulSub(two, in, fromY), hn::MulSub(two, in, fromZ)};
                    if constexpr (kNotBelowZero) {
                        const VL least = hn::Min(out.x, hn::Min(out.y, out.z));
                        if (!hn::AllTrue(d, hn::Ge(least, hn::Zero(d))))
                            balance(x, fromY, fromZ, extinction, sent, out);
                    }
                    if constexpr (kWalls) {
                        collect(walls, 0, cell - base, out.x);
                        collect(walls, 1, cell - base, out.y);
                        collect(walls, 2, cell - base, out.z);
                    }
                    hn::StoreU(out.y, d, intoY);
                    hn::StoreU(out.z, d, intoZ);
                    x = out.x;
                    result(cell, out.in);
                }
                hn::StoreU(x, d, intoX);
            }
        }
    }

    // The walls of a block, for each axis: how open the faces are by which light enters cells, and
    // the sides of walls at these faces and at those by which it leaves.
    struct WallFaces {
        const std::uint8_t* open[3];
        const std::int32_t *entered[3], *left[3];
    };
    WallFaces wallFaces(std::size_t block) const {
        const std::int32_t walled = m_sweep.grid->walled(block);
        WallFaces faces{};
        for (int axis = 0; axis < 3; ++axis) {
            const int down = m_down[axis] ? 1 : 0;
            faces.open[axis] =
                m_sweep.grid->open(walled, axis) + (down == 0 ? 0 : paddedOffset(axis == 0, axis == 1, axis == 2));
            if (!m_sweep.back) continue;
            faces.entered[axis] = m_sweep.grid->sidesAt(walled, 2 * axis + down);
            faces.left[axis] = m_sweep.grid->sidesAt(walled, 2 * axis + 1 - down);
        }
        return faces;
    }
    // What enters a cell through a face with walls: what gets past them, and what they send back.
    HWY_ATTR HWY_INLINE VL past(const WallFaces& walls, int axis, std::size_t padded, std::size_t cell,
                                VL light) const {
        const DL d;
        const std::uint8_t open = walls.open[axis][padded];
        if (open == kAllOpen) return light;
        light = hn::Mul(light, hn::Set(d, static_cast<Real>(open) / kAllOpen));
        const std::int32_t side = walls.entered[axis] ? walls.entered[axis][cell] : -1;
        return side < 0 ? light : hn::Add(light, hn::Set(d, m_sweep.back[side]));
    }
    HWY_ATTR HWY_INLINE void collect(const WallFaces& walls, int axis, std::size_t cell, VL light) const {
        const std::int32_t side = walls.left[axis] ? walls.left[axis][cell] : -1;
        if (side >= 0) m_caught[side] += hn::GetLane(hn::SumOfLanes(DL(), hn::Mul(lanes(m_onFace[axis]), light)));
    }

    // No light leaves through a face with negative outflow; the cell is balanced again without that
    // face. Another face may then go below zero, but this happens three times at most.
    HWY_ATTR void balance(VL x, VL y, VL z, VL extinction, VL sent, Passed& out) const {
        const DL d;
        const VL zero = hn::Zero(d), half = hn::Set(d, Real(0.5));
        VL a = lanes(m_slope[0]), b = lanes(m_slope[1]), c = lanes(m_slope[2]);
        VL keepX = hn::Set(d, Real(1)), keepY = keepX, keepZ = keepX;
        for (int round = 0; round < 3; ++round) {
            keepX = hn::IfThenZeroElse(hn::Lt(out.x, zero), keepX);
            keepY = hn::IfThenZeroElse(hn::Lt(out.y, zero), keepY);
            keepZ = hn::IfThenZeroElse(hn::Lt(out.z, zero), keepZ);
            // The inflow's weight is |cosine| / edge, and twice that where outflow = 2 in - inflow.
            const auto into = [&](VL slope, VL keep, VL inflow)
                                  HWY_ATTR { return hn::Mul(hn::Mul(half, slope), hn::MulAdd(keep, inflow, inflow)); };
            const VL entered = hn::Add(hn::Add(into(a, keepX, x), into(b, keepY, y)), hn::Add(into(c, keepZ, z), sent));
            const VL leaves = hn::MulAdd(a, keepX, hn::MulAdd(b, keepY, hn::MulAdd(c, keepZ, extinction)));
            // If all faces are closed and there is no extinction, nothing has entered.
            out.in = hn::Div(hn::Max(entered, zero), hn::Max(leaves, hn::Set(d, Real(1e-30))));
            out.x = hn::Mul(keepX, hn::Sub(hn::Add(out.in, out.in), x));
            out.y = hn::Mul(keepY, hn::Sub(hn::Add(out.in, out.in), y));
            out.z = hn::Mul(keepZ, hn::Sub(hn::Add(out.in, out.in), z));
        }
        out.x = hn::Max(out.x, zero);
        out.y = hn::Max(out.y, zero);
        out.z = hn::Max(out.z, zero);
    }

    // An empty block is passed as one large cell.
    HWY_ATTR void passEmpty(const Int3& at) {
        const DL d;
        const VL x = mean([&](int i, int j) { return faceX(i, j); });
        const VL y = mean([&](int i, int j) { return faceY(at.x * kCellEdge + i, j); });
        const VL z = mean([&](int i, int j) { return faceZ(at.x * kCellEdge + i, at.y * kCellEdge + j); });
        const VL a = lanes(m_slope[0]), b = lanes(m_slope[1]), c = lanes(m_slope[2]);
        const VL in = hn::Div(hn::MulAdd(a, x, hn::MulAdd(b, y, hn::Mul(c, z))), hn::Add(a, hn::Add(b, c)));
        // As in `balance`, without extinction: everything that enters leaves by the remaining faces.
        const VL twice = hn::Add(in, in), zero = hn::Zero(d);
        Passed out{in, hn::Sub(twice, x), hn::Sub(twice, y), hn::Sub(twice, z)};
        const VL least = hn::Min(out.x, hn::Min(out.y, out.z));
        if (!hn::AllTrue(d, hn::Ge(least, zero))) {
            const auto below = hn::Lt(least, zero);
            out.x = hn::IfThenElse(below, in, out.x);
            out.y = hn::IfThenElse(below, in, out.y);
            out.z = hn::IfThenElse(below, in, out.z);
        }
        for (int j = 0; j < kCellEdge; ++j)
            for (int i = 0; i < kCellEdge; ++i) {
                hn::StoreU(out.x, d, faceX(i, j));
                hn::StoreU(out.y, d, faceY(at.x * kCellEdge + i, j));
                hn::StoreU(out.z, d, faceZ(at.x * kCellEdge + i, at.y * kCellEdge + j));
            }
    }
    template <class Face>
    HWY_ATTR VL mean(const Face& face) {
        VL sum = hn::Zero(DL());
        for (int j = 0; j < kCellEdge; ++j)
            for (int i = 0; i < kCellEdge; ++i) sum = hn::Add(sum, lanes(face(i, j)));
        return hn::Mul(sum, hn::Set(DL(), Real(1) / (kCellEdge * kCellEdge)));
    }

    const CellSweep& m_sweep;
    Real* m_caught;
    std::size_t m_first, m_lanes, m_acrossX;
    bool m_down[3];
    Real m_slope[3][kOrdinateLanes];   // 2 |cosine| / edge
    Real m_weight[kOrdinateLanes];     // they sum to 1 over all ordinates
    Real m_onFace[3][kOrdinateLanes];  // weight times cosine: they sum to 1 over all ordinates to one side of a face
    Real m_inflow[kOrdinateLanes];
    // What enters the next cell along each axis: through the faces of a block, of a layer of blocks, of all of them.
    hwy::AlignedFreeUniquePtr<Real[]> m_x, m_y, m_z;
};

int bundleLanes() {
    return static_cast<int>(hn::Lanes(DL()));
}

// `sum`: the bundle's own row, with one value for each cell.
HWY_ATTR void passIsotropic(const CellSweep& sweep, int octant, int first, Real* caught, const Real* source,
                            Real* sum) {
    Bundle bundle(sweep, octant, first, caught);
    const DL d;
    const VL weight = bundle.weight();
    bundle.pass(SameEmission{source}, [&](std::size_t cell, VL in) HWY_ATTR {
        sum[cell] = hn::GetLane(hn::SumOfLanes(d, hn::Mul(weight, in)));
    });
}

HWY_ATTR void passDirectional(const CellSweep& sweep, int octant, int first, Real* caught, const std::int32_t* slots,
                              Real* radiance) {
    Bundle bundle(sweep, octant, first, caught);
    const DL d;
    const auto count = std::size_t(sweep.ordinates->count());
    const auto at = [&](std::size_t cell) {
        return radiance + std::size_t(slots[cell]) * count + bundle.firstOrdinate();
    };
    bundle.pass(EmissionInRows{slots, radiance + bundle.firstOrdinate(), count}, [&](std::size_t cell, VL in) HWY_ATTR {
        if (slots[cell] >= 0) hn::StoreU(in, d, at(cell));
    });
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scrim {

HWY_EXPORT(bundleLanes);
HWY_EXPORT(passIsotropic);
HWY_EXPORT(passDirectional);

namespace {

// Calls task(bundle, octant, first ordinate of the octant, the bundle's row of what walls catch) for all bundles.
template <class Task>
void forBundles(const CellSweep& sweep, const Task& task) {
    const int lanes = SCRIM_ON_TARGET(sweep.simd, bundleLanes)();
    const int each = sweep.ordinates->perOctant / lanes;
    const std::size_t sides = sweep.back ? sweep.grid->sides() : 0;
    std::vector<Real> caught(std::size_t(8 * each) * sides, Real(0));
    parallelFor(std::size_t(8 * each), [&](std::size_t i) {
        task(i, static_cast<int>(i) / each, static_cast<int>(i) % each * lanes, caught.data() + i * sides);
    });
    if (!sweep.back) return;
    sweep.caught->assign(sides, Real(0));
    for (std::size_t i = 0; i < caught.size(); ++i) (*sweep.caught)[i % sides] += caught[i];
}

}  // namespace

std::size_t bundlesOf(Simd simd, int ordinates) {
    return std::size_t(ordinates / SCRIM_ON_TARGET(simd, bundleLanes)());
}

void sweepIsotropic(const CellSweep& sweep, const std::vector<Real>& source, std::vector<Real>& mean,
                    std::vector<Real>& scratch) {
    const std::size_t cells = sweep.grid->cells();
    const std::size_t bundles = bundlesOf(sweep.simd, sweep.ordinates->count());
    // Sums have a fixed order, whichever thread finishes first.
    scratch.resize(std::max(scratch.size(), bundles * cells));
    std::fill_n(scratch.begin(), bundles * cells, Real(0));
    forBundles(sweep, [&](std::size_t i, int octant, int first, Real* caught) {
        SCRIM_ON_TARGET(sweep.simd, passIsotropic)
        (sweep, octant, first, caught, source.data(), scratch.data() + i * cells);
    });
    mean.assign(cells, Real(0));
    parallelFor(sweep.grid->storedBlocks().size(), [&](std::size_t block) {
        for (std::size_t i = 0; i < bundles; ++i)
            for (std::size_t c = block * kBlockCells; c < (block + 1) * kBlockCells; ++c)
                mean[c] += scratch[i * cells + c];
    });
}

void sweepDirectional(const CellSweep& sweep, const std::vector<std::int32_t>& slots, std::vector<Real>& radiance) {
    forBundles(sweep, [&](std::size_t, int octant, int first, Real* caught) {
        SCRIM_ON_TARGET(sweep.simd, passDirectional)(sweep, octant, first, caught, slots.data(), radiance.data());
    });
}

}  // namespace scrim
#endif
