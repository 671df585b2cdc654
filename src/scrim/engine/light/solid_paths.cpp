// SPDX-License-Identifier: Apache-2.0
// Looks up paths in a raster of solids: a vector of them at a time, at points twice as far apart as the finest rays.
#include <scrim/engine/light/solid_raster.h>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scrim/engine/light/solid_paths.cpp"
#include <hwy/foreach_target.h>
#include <scrim/engine/simd-inl.h>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

// The most points on a path. Longer paths are looked up more coarsely than cells are divided.
constexpr int kMostPoints = 64;

// What the nearest rays say at a vector of points.
HWY_ATTR HWY_INLINE VF endsAt(const SolidRaster::Table& table, VF x, VF y) {
    const DF d;
    const DI di;
    const auto column = hn::Floor(x), row = hn::Floor(y);
    const auto cell = hn::Add(hn::Mul(hn::ConvertTo(di, row), hn::Set(di, table.width - 1)), hn::ConvertTo(di, column));
    const auto first = hn::GatherIndex(di, table.first, cell);
    const auto whole = hn::Lt(first, hn::Zero(di));
    const auto parts = hn::IfThenElse(hn::RebindMask(d, whole), constant(1), constant(static_cast<Real>(table.parts)));
    const auto stride = hn::IfThenElse(whole, hn::Set(di, table.width), hn::Set(di, table.parts + 1));
    const auto i = hn::NearestInt(hn::Mul(hn::Sub(x, column), parts));
    const auto j = hn::NearestInt(hn::Mul(hn::Sub(y, row), parts));
    const auto begin = hn::IfThenElse(whole, hn::Not(first), first);
    return hn::GatherIndex(d, table.ends, hn::Add(begin, hn::Add(i, hn::Mul(j, stride))));
}

HWY_ATTR void passPathsOnTarget(const SolidRaster& raster, const RasterPaths& paths, Real* light) {
    const DF d;
    const SolidRaster::Table table = raster.table();
    const auto least = constant(0), lastX = constant(static_cast<Real>(table.width - 2)),
               lastY = constant(static_cast<Real>(table.height - 2));
    const Real perCell = std::max(Real(0.5) * static_cast<Real>(table.parts), Real(1));  // points
    const auto within = [&](const Real* from, int k, VF last)
                            HWY_ATTR { return hn::Min(hn::Max(load(from, k), least), last); };
    const auto smallest = [&](VF a, VF b) HWY_ATTR { return hn::GetLane(hn::MinOfLanes(d, hn::Min(a, b))); };
    const auto largest = [&](VF a, VF b) HWY_ATTR { return hn::GetLane(hn::MaxOfLanes(d, hn::Max(a, b))); };
    forSamples([&](int k) HWY_ATTR {
        const auto x0 = within(paths.first.x, k, lastX), x1 = within(paths.last.x, k, lastX);
        const auto y0 = within(paths.first.y, k, lastY), y1 = within(paths.last.y, k, lastY);
        const auto n0 = load(paths.first.n, k), n1 = load(paths.last.n, k);
        const SolidRaster::Range seen =
            raster.range(smallest(x0, x1), smallest(y0, y1), largest(x0, x1), largest(y0, y1));
        if (seen.least >= largest(n0, n1)) return;
        if (seen.most < smallest(n0, n1)) return hn::Store(constant(0), d, light + k);
        const auto dx = hn::Sub(x1, x0), dy = hn::Sub(y1, y0), dn = hn::Sub(n1, n0);
        const Real wanted = std::ceil(largest(hn::Abs(dx), hn::Abs(dy)) * perCell);
        const int points = static_cast<int>(std::min(std::max(wanted, Real(2)), Real(kMostPoints)));
        const Real step = 1 / static_cast<Real>(points);
        auto sum = constant(0);
        for (int i = 0; i < points; ++i) {
            const auto t = constant((static_cast<Real>(i) + Real(0.5)) * step);
            const auto end = endsAt(table, hn::MulAdd(dx, t, x0), hn::MulAdd(dy, t, y0));
            sum = hn::Add(sum, hn::IfThenElseZero(hn::Ge(end, hn::MulAdd(dn, t, n0)), constant(1)));
        }
        hn::Store(hn::Mul(load(light, k), hn::Mul(sum, constant(step))), d, light + k);
    });
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scrim {

HWY_EXPORT(passPathsOnTarget);

void SolidRaster::pass(const RasterPaths& paths, Simd simd, Real* light) const {
    SCRIM_ON_TARGET(simd, passPathsOnTarget)(*this, paths, light);
}

}  // namespace scrim
#endif
