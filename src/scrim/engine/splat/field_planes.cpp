// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/field_planes.h>

#include <algorithm>

namespace scrim {
namespace {

// Consecutive sheets that one task splats: voxels reach into about four, so fewer would locate them more often.
constexpr int kSheetsPerTask = 8;

}  // namespace

FieldPlanes::Splatter FieldPlanes::splatterFor(const std::vector<ViewField>& fields, const Settings& s,
                                               const Dials& dials, const Sheets& sheets, const Lattice& lattice) {
    const Mat4 tsFromIs = sheets.tsFrom(fields.front().wsFromIs);
    if (!lattice.parallel()) {
        std::vector<WarpedSplatter> splatters;
        for (const ViewField& field : fields)
            splatters.emplace_back(*field.field, tsFromIs, lattice, dials.kernel, s.stepsPerVoxel, s.scale, s.most);
        return splatters;
    }
    FieldSplatter splatter(*fields.front().field, lattice.rsFromTs * tsFromIs, dials.kernel, s.stepsPerVoxel, s.scale,
                           s.most, Simd(dials.simd));
    for (std::size_t f = 1; f < fields.size(); ++f) splatter.join(*fields[f].field);
    return splatter;
}

FieldPlanes::FieldPlanes(const std::vector<std::vector<ViewField>>& placements, const Settings& settings,
                         const Dials& dials, const Sheets& sheets, const Lattice& lattice, int batchSheets)
    : m_lattice(lattice), m_settings(settings), m_simd(dials.simd) {
    m_splatters.reserve(placements.size());
    int bandTiles = 0;
    for (const std::vector<ViewField>& fields : placements) {
        m_splatters.push_back(splatterFor(fields, settings, dials, sheets, lattice));
        if (const auto* own = std::get_if<FieldSplatter>(&m_splatters.back()))
            bandTiles = std::max(bandTiles, own->bandTiles());
    }
    for (Splatter& splatter : m_splatters)
        if (auto* own = std::get_if<FieldSplatter>(&splatter)) own->useBands(bandTiles);
    for (std::size_t f = 0; f < placements.front().size(); ++f)
        m_planes.emplace_back(batchSheets + 2 * settings.halo, lattice.width, lattice.height, 1);
}

void FieldPlanes::beginBatch(int firstSheet, int count) {
    if (m_origin < 0) {
        m_origin = firstSheet;
        m_readySheet = firstSheet - m_settings.halo;
    }
    m_runs.clear();
    m_firstReady = m_readySheet;
    const int end = firstSheet + count + m_settings.halo;
    while (m_readySheet < end) {
        const int wrap = planes().planes() - planeOf(m_readySheet);
        const int run = std::min({kSheetsPerTask, end - m_readySheet, wrap});
        m_runs.push_back({m_readySheet, run});
        m_readySheet += run;
    }
    for (PlaneStack& planes : m_planes)
        for (int sheet = m_firstReady; sheet < m_readySheet; ++sheet) planes.begin(planeOf(sheet));
}

// Phases take turns at the bands of rows; views that warp their footprints have no bands.
int FieldPlanes::tasks(int phase) const {
    const auto* splatter = std::get_if<FieldSplatter>(&m_splatters.front());
    const int bands = splatter ? splatter->bands(planes()) : 1;
    return static_cast<int>(m_runs.size()) * ((bands + 1 - phase) / kPhases);
}

std::uint64_t FieldPlanes::splat(int phase, int task, const NeededTiles* needed, const TileCull& cull) {
    const int runs = static_cast<int>(m_runs.size());
    const Run& run = m_runs[task % runs];
    const int first = planeOf(run.sheet);
    TileCull culled = cull;
    if (needed)
        culled = [box = needed->over(run.sheet, run.sheet + run.count), &cull](const Box2<int>& tiles) {
            return intersection(tiles, box).empty() || (cull && cull(tiles));
        };
    const int end = run.sheet + run.count;
    std::uint64_t footprints = 0;
    for (const Splatter& splatter : m_splatters) {
        if (const auto* own = std::get_if<FieldSplatter>(&splatter)) {
            footprints +=
                own->splat(run.sheet, end, std::span(m_planes), first, culled, kPhases * (task / runs) + phase);
            continue;
        }
        for (std::size_t f = 0; f < m_planes.size(); ++f)
            footprints += std::get<1>(splatter)[f].splat(run.sheet, end, m_planes[f], first, culled);
    }
    return footprints;
}

void FieldPlanes::finish(int plane) {
    const int p = planeOf(m_firstReady + plane);
    for (PlaneStack& planes : m_planes) {
        planes.finish(p);
        if (m_lattice.shared()) {
            planes.prefilter(p, m_simd);  // views look between its texels
            continue;
        }
        if (m_lattice.parallel()) planes.raiseToZero(p);  // slopes of footprints go below 0 around the field's rim
        planes.dropEmpty(p);
    }
}

std::size_t FieldPlanes::bytes() const {
    std::size_t sum = m_planes.size() * PlaneStack::bytes(planes().planes(), planes().width(), planes().height(), 1);
    for (const Splatter& splatter : m_splatters)
        if (const auto* own = std::get_if<FieldSplatter>(&splatter))
            sum += own->tableBytes();
        else
            for (const WarpedSplatter& warped : std::get<1>(splatter)) sum += warped.table().bytes();
    return sum;
}

std::size_t FieldPlanes::bytes(const ViewField& field, const Settings& settings, const Dials& dials,
                               const Sheets& sheets, const Lattice& lattice, int batchSheets) {
    return PlaneStack::bytes(batchSheets + 2 * settings.halo, lattice.width, lattice.height, 1) +
           placementBytes(field, settings, dials, sheets, lattice);
}

std::size_t FieldPlanes::placementBytes(const ViewField& field, const Settings& settings, const Dials& dials,
                                        const Sheets& sheets, const Lattice& lattice) {
    const std::size_t sum = field.field->blockCount() * 8;
    if (!lattice.parallel()) return sum;  // one small table
    const Mat4 rsFromIs = lattice.rsFromTs * sheets.tsFrom(field.wsFromIs);
    const FootprintTable::Steps steps = footprintSteps(rsFromIs, settings.stepsPerVoxel);
    return sum +
           FootprintTable::bytes(dials.kernel, rsFromIs, steps.texel, steps.sheet, FootprintTable::Lookup::sloped);
}

}  // namespace scrim
