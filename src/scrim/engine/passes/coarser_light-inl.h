// SPDX-License-Identifier: Apache-2.0
// Internal, compiled once for each instruction set: what the media of coarser levels
// (cells/cell_levels.h) leave of the light that passes the cells of a level.
#if defined(SCRIM_COARSER_LIGHT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SCRIM_COARSER_LIGHT_INL_H_
#undef SCRIM_COARSER_LIGHT_INL_H_
#else
#define SCRIM_COARSER_LIGHT_INL_H_
#endif

#include <scrim/engine/passes/light_cells-inl.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include <glm/geometric.hpp>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

/// For one source of light after the other, and one thread.
class CoarserLight {
  public:
    /// `coarser`: the media of each coarser level, with their light wanted around the cells of
    /// `fine`, and slices along the same axis.
    CoarserLight(const std::vector<CellSlices>& coarser, const CellSlices& fine) : m_fine(fine) {
        for (const CellSlices& slices : coarser)
            m_levels.push_back({slices, fine.edge() / slices.edge(), slices.place(fine.wsPlace(Vec3(0))), {}});
        if (!coarser.empty()) m_row.resize(std::size_t(fine.size[0] + kRowSlack));
    }
    bool any() const { return !m_levels.empty(); }

    /// Passes a source of the fine cells through all levels.
    HWY_ATTR void pass(const CellRays& rays, bool down) {
        const CellView even;
        const TowardsEye towards(even);
        m_rays = &rays;
        for (Level& level : m_levels) {
            CellRays own{.parallel = rays.parallel, .way = rays.way, .lamp = rays.lamp};
            own.from = level.begin + level.scale * rays.from;
            own.extinction = rays.extinction;
            own.forFiner = true;
            own.weight[0] = static_cast<Real>(4 * std::numbers::pi);  // times the even phase function: 1
            level.slices.clearSums(1);
            if (own.parallel) {
                run(ParallelRaster(level.slices, own, even, m_memory), even, towards, level.slices);
            } else {
                run(PointRaster(level.slices, own, even, m_memory, down), even, towards, level.slices);
                makeMean(own, level.slices);
            }
        }
    }

    /// What they leave in row j of slice k of the fine cells, where their light is wanted, as from cell 0 on.
    HWY_ATTR const Real* row(int j, int k) {
        for (const CellSpan& span : m_fine.wanted.row(m_fine.rowIndex(j, k))) {
            std::fill(m_row.begin() + span.begin, m_row.begin() + span.end + kRowSlack, Real(1));
            for (Level& level : m_levels) multiply(level, j, k, span);
        }
        return m_row.data();
    }

  private:
    struct Level {
        CellSlices slices;
        double scale;  // edges of its cells in that of a fine one
        Vec3 begin;    // the place of the corner of the fine box
        std::vector<Real> between;
    };

    template <class Raster>
    HWY_ATTR void run(Raster raster, const CellView& even, const TowardsEye& towards, CellSlices& box) const {
        for (int step = 0; step < box.size[2]; ++step) {
            if (!raster.reaches(step)) continue;
            for (const int j : box.wantedRows[std::size_t(raster.slice(step))])
                raster.light(step, j, even, towards, nullptr, box);
            raster.attenuate(step);
        }
    }

    // A place between the centres of two cells of an axis.
    struct Between {
        int first;
        Real part;
        Between(const Level& level, int axis, double fine) {
            const double at = level.begin[axis] + level.scale * fine - 0.5;
            first = std::clamp(static_cast<int>(std::floor(at)), 0, level.slices.size[std::size_t(axis)] - 2);
            part = static_cast<Real>(std::clamp(at - first, 0.0, 1.0));
        }
    };

    // Replaces transmittances from a point by the mean extinction on the way, per edge of a cell, which changes slowly
    // close to the point. Where no ray of the point's face has come, it is that of the cell.
    static void makeMean(const CellRays& rays, CellSlices& box) {
        for (int k = 0; k < box.size[2]; ++k)
            for (const int j : box.wantedRows[std::size_t(k)])
                for (const CellSpan& span : box.wanted.row(box.rowIndex(j, k)))
                    for (int i = span.begin; i < span.end; ++i) {
                        Real& value = box.sums(0, j, k)[i];
                        const double way = glm::distance(Vec3(i, j, k) + 0.5, rays.from);
                        value = static_cast<Real>(value > 0 && way > kLeastWay
                                                      ? -std::log(double(value)) / way
                                                      : rays.extinction * double(box.row(j, k)[i]));
                    }
    }

    // The values of a level's row between four rows of its cells, from cell `first` on.
    HWY_ATTR void interpolateRow(Level& level, const Between& y, const Between& z, int first, std::size_t count) const {
        level.between.assign(count, Real(0));
        for (int corner = 0; corner < 4; ++corner) {
            const Real part = ((corner & 1) != 0 ? y.part : 1 - y.part) * ((corner & 2) != 0 ? z.part : 1 - z.part);
            const Real* from = level.slices.sums(0, y.first + (corner & 1), z.first + (corner >> 1)) + first;
            for (std::size_t i = 0; i < count; ++i) level.between[i] += part * from[i];
        }
    }

    HWY_ATTR void multiply(Level& level, int j, int k, const CellSpan& span) {
        const D8 d;
        const hn::RebindToSigned<D8> di;
        const int first = Between(level, 0, span.begin + 0.5).first, last = Between(level, 0, span.end - 0.5).first + 1;
        interpolateRow(level, {level, 1, j + 0.5}, {level, 2, k + 0.5}, first, std::size_t(last - first + 1));
        const V8 begin = value8(level.begin.x + 0.5 * level.scale - 0.5 - first), scale = value8(level.scale);
        const V8 most = value8(last - first), x0 = value8(0.5 - m_rays->from.x);
        const double y = j + 0.5 - m_rays->from.y, z = k + 0.5 - m_rays->from.z;
        for (int i = span.begin; i < span.end; i += static_cast<int>(hn::Lanes(d))) {
            const V8 at = hn::Min(hn::Max(hn::MulAdd(counted(i), scale, begin), hn::Zero(d)), most);
            const V8 whole = hn::Min(hn::Floor(at), hn::Sub(most, value8(1)));
            const auto index = hn::ConvertTo(di, whole);
            const V8 a = hn::GatherIndex(d, level.between.data(), index),
                     b = hn::GatherIndex(d, level.between.data(), hn::Add(index, hn::Set(di, 1)));
            V8 left = hn::MulAdd(hn::Sub(at, whole), hn::Sub(b, a), a);
            if (!m_rays->parallel) {
                const V8 x = hn::Add(counted(i), x0), way = hn::Sqrt(hn::MulAdd(x, x, value8(y * y + z * z)));
                left = transmittance(hn::Mul(left, hn::Mul(way, scale)));
            }
            Real* to = m_row.data() + i;
            hn::StoreU(hn::Mul(hn::LoadU(d, to), left), d, to);
        }
    }

    static constexpr double kLeastWay = 1e-3;  // cells

    const CellSlices& m_fine;
    std::vector<Level> m_levels;
    const CellRays* m_rays = nullptr;  // the source
    std::vector<Real> m_memory, m_row;
};

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
