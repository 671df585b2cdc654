// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/field_planes.h>

#include <algorithm>

namespace scrim {
namespace {

// Consecutive sheets that one task splats: voxels reach into about four, so fewer would locate them more often.
constexpr int kSheetsPerTask = 4;

using Splatter = std::variant<FieldSplatter, WarpedSplatter>;

Splatter splatterFor(const ViewField& field, const FieldPlanes::Settings& s, const Dials& dials, const Sheets& sheets,
                     const Lattice& lattice) {
    const Mat4 tsFromIs = sheets.tsFrom(field.wsFromIs);
    if (!lattice.parallel())
        return WarpedSplatter(*field.field, tsFromIs, lattice, dials.kernel, s.stepsPerVoxel, s.scale, s.most);
    return FieldSplatter(*field.field, lattice.rsFromTs * tsFromIs, dials.kernel, s.stepsPerVoxel, s.scale, s.most,
                         Simd(dials.simd));
}

}  // namespace

FieldPlanes::FieldPlanes(const ViewField& field, const Settings& settings, const Dials& dials, const Sheets& sheets,
                         const Lattice& lattice, int batchSheets)
    : m_lattice(lattice),
      m_settings(settings),
      m_splatter(splatterFor(field, settings, dials, sheets, lattice)),
      m_planes(batchSheets + 2 * settings.halo, lattice.width, lattice.height, 1) {}

int FieldPlanes::beginBatch(int firstSheet, int count) {
    if (m_origin < 0) {
        m_origin = firstSheet;
        m_readySheet = firstSheet - m_settings.halo;
    }
    m_runs.clear();
    const int end = firstSheet + count + m_settings.halo;
    while (m_readySheet < end) {
        const int wrap = m_planes.planes() - planeOf(m_readySheet);
        const int run = std::min({kSheetsPerTask, end - m_readySheet, wrap});
        m_runs.push_back({m_readySheet, run});
        m_readySheet += run;
    }
    return static_cast<int>(m_runs.size());
}

std::uint64_t FieldPlanes::splat(int task, const NeededTiles* needed, const TileCull& cull) {
    const Run& run = m_runs[task];
    const int first = planeOf(run.sheet);
    TileCull culled = cull;
    if (needed)
        culled = [box = needed->over(run.sheet, run.sheet + run.count), &cull](const Box2<int>& tiles) {
            return intersection(tiles, box).empty() || (cull && cull(tiles));
        };
    for (int p = first; p < first + run.count; ++p) m_planes.begin(p);
    const std::uint64_t footprints = std::visit(
        [&](const auto& splatter) {
            return splatter.splat(run.sheet, run.sheet + run.count, m_planes, first, culled);
        },
        m_splatter);
    for (int p = first; p < first + run.count; ++p) {
        m_planes.finish(p);
        if (m_lattice.shared())
            m_planes.prefilter(p);  // views look between its texels
        else if (m_lattice.parallel())
            m_planes.raiseToZero(p);  // slopes of footprints go below 0 around the field's rim
        m_planes.dropEmpty(p);
    }
    return footprints;
}

std::size_t FieldPlanes::bytes() const {
    const std::size_t table = std::visit([](const auto& splatter) { return splatter.table().bytes(); }, m_splatter);
    return table + PlaneStack::bytes(m_planes.planes(), m_planes.width(), m_planes.height(), 1);
}

std::size_t FieldPlanes::bytes(const ViewField& field, const Settings& settings, const Dials& dials,
                               const Sheets& sheets, const Lattice& lattice, int batchSheets) {
    const std::size_t sum = PlaneStack::bytes(batchSheets + 2 * settings.halo, lattice.width, lattice.height, 1) +
                            field.field->blockCount() * 8;
    if (!lattice.parallel()) return sum;  // one small table
    const Mat4 rsFromIs = lattice.rsFromTs * sheets.tsFrom(field.wsFromIs);
    const FootprintSteps steps = footprintSteps(rsFromIs, settings.stepsPerVoxel);
    return sum + FootprintTable::bytes(dials.kernel, rsFromIs, steps.texel, steps.sheet, FootprintLookup::sloped);
}

}  // namespace scrim
