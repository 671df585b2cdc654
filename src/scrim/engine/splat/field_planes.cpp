// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/field_planes.h>

#include <scrim/base/parallel.h>
#include <scrim/volume/kernel.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <glm/geometric.hpp>

namespace scrim {
namespace {

// Consecutive sheets that one task splats. Voxels reach into about four sheets, so with fewer they would be located
// more often.
constexpr int kSheetsPerTask = 8;

// The number of rows of tiles that a block may touch, plus one. Bands must not depend on the contents of a batch, since
// they decide the order in which floats are added.
int bandTilesFor(const Mat4& rsFromIs, Kernel kernel) {
    const Vec3 row(rsFromIs[0][1], rsFromIs[1][1], rsFromIs[2][1]);
    const double block = (kBlockEdge - 1) * (std::abs(row.x) + std::abs(row.y) + std::abs(row.z));
    return static_cast<int>((block + 2 * kernelExtent(kernel, row) + 3) / kTileEdge) + 4;
}

// The number of times that voxels may be doubled. Beyond that a footprint is many texels wide. Then there are few
// voxels, and the remaining gain is lost to the tables, which must resolve positions finely.
int coarserLevels(const Mat4& rsFromIs) {
    constexpr double kWidest = 4;  // edge of a voxel, in texels and in sheets
    double edge = 0;
    for (int axis = 0; axis < 3; ++axis) edge = std::max(edge, glm::length(Vec3(rsFromIs[axis])));
    int levels = 0;
    while (levels < 20 && 2 * edge <= kWidest) {
        edge *= 2;
        ++levels;
    }
    return levels;
}

}  // namespace

FieldPlanes::Splatter FieldPlanes::splatterFor(const Placement& placement) const {
    const Settings& s = m_settings;
    const std::vector<ViewField>& fields = placement.fields;
    const Mat4 tsFromIs = m_sheets.tsFrom(fields.front().wsFromIs);
    if (!m_lattice.parallel()) {
        std::vector<WarpedSplatter> splatters;
        for (const ViewField& field : fields)
            splatters.emplace_back(*field.field, tsFromIs, m_lattice, m_dials.kernel, s.stepsPerVoxel, s.scale, s.most);
        return splatters;
    }
    FieldSplatter splatter(*fields.front().field, m_lattice.rsFromTs * tsFromIs, m_dials.kernel, s.stepsPerVoxel,
                           s.scale, s.most, m_simd);
    if (!placement.values.empty()) splatter.useValues(placement.values);
    for (std::size_t f = 1; f < fields.size(); ++f) splatter.join(*fields[f].field);
    return splatter;
}

FieldPlanes::Reach FieldPlanes::reachOf(const ViewField& field, const Dials& dials, const Sheets& sheets) {
    constexpr double kRounding = 2;  // rounding of footprint tables and of bounds, in sheets
    const Mat4 tsFromIs = sheets.tsFrom(field.wsFromIs);
    const double reach = kernelExtent(dials.kernel, {tsFromIs[0][2], tsFromIs[1][2], tsFromIs[2][2]}) + kRounding;
    const Bounds ts = transformed(tsFromIs, field.field->isBounds());
    return {static_cast<int>(std::floor(ts.lower.z - reach)), static_cast<int>(std::ceil(ts.upper.z + reach))};
}

FieldPlanes::FieldPlanes(const std::vector<std::vector<ViewField>>& placements, const Settings& settings,
                         const Dials& dials, const Sheets& sheets, const Lattice& lattice, int batchSheets)
    : m_lattice(lattice), m_sheets(sheets), m_dials(dials), m_settings(settings), m_simd(dials.simd) {
    for (const std::vector<ViewField>& fields : placements) {
        if (fields.size() == 1)
            placeTiles(fields.front());
        else
            place(fields);
    }
    if (m_placements.size() == 1) {
        Placement& one = m_placements.front();
        one.reach = {std::numeric_limits<int>::min(), std::numeric_limits<int>::max()};
        one.splatter.emplace(splatterFor(one));
        if (const auto* splatter = std::get_if<FieldSplatter>(&*one.splatter)) m_bandTiles = splatter->bandTiles();
    }
    for (std::size_t f = 0; f < placements.front().size(); ++f)
        m_planes.emplace_back(batchSheets + 2 * settings.halo, lattice.width, lattice.height, 1);
}

void FieldPlanes::place(std::vector<ViewField> fields, std::vector<const float*> values) {
    const ViewField& first = fields.front();
    if (m_lattice.parallel())
        m_bandTiles =
            std::max(m_bandTiles, bandTilesFor(m_lattice.rsFromTs * m_sheets.tsFrom(first.wsFromIs), m_dials.kernel));
    const Reach reach = reachOf(first, m_dials, m_sheets);
    m_placements.push_back({std::move(fields), std::move(values), reach, std::nullopt});
}

// Places a field. One without large constant tiles stays as it is; of others, the blocks and each level of tiles are
// placed separately.
void FieldPlanes::placeTiles(const ViewField& field) {
    // Larger tiles, which only sources can make, are divided where they are splatted, because their hulls alone are too
    // large.
    constexpr int kLargest = 4096;
    const std::vector<ConstantTile>& all = field.field->tiles;
    const bool cuts = std::all_of(all.begin(), all.end(), [](const ConstantTile& t) { return t.edge <= kLargest; });
    const std::span<const double> weights = twoScaleWeights(m_dials.kernel);
    if (m_lattice.parallel() && !all.empty() && cuts && !weights.empty()) {
        TileLevels tiles(*field.field, weights, coarserLevels(m_lattice.rsFromTs * m_sheets.tsFrom(field.wsFromIs)));
        if (!tiles.levels().empty()) {
            auto blocks = std::make_shared<SparseField>(*field.field);
            blocks->tiles.clear();
            if (!blocks->blockOrigins.empty()) place({{blocks, field.wsFromIs}});
            Mat4 wsFromLevel = field.wsFromIs;
            for (const TileLevel& level : tiles.levels()) {
                if (!level.field->empty()) place({{level.field, wsFromLevel}}, level.values);
                for (int axis = 0; axis < 3; ++axis) wsFromLevel[axis] *= 2;
            }
            m_tiles.push_back(std::move(tiles));
            return;
        }
    }
    place({field});
}

// Makes splatters for the placements that the batch reaches, and drops all others.
void FieldPlanes::prepare() {
    std::vector<Placement*> missing;
    for (Placement& placement : m_placements) {
        const bool reaches = placement.reach.first < m_readySheet && placement.reach.last >= m_firstReady;
        if (!reaches) placement.splatter.reset();
        if (reaches && !placement.splatter) missing.push_back(&placement);
    }
    parallelFor(missing.size(), [&](std::size_t i) {
        missing[i]->splatter.emplace(splatterFor(*missing[i]));
        if (auto* own = std::get_if<FieldSplatter>(&*missing[i]->splatter)) own->useBands(m_bandTiles);
    });
    std::size_t bytes = 0;
    for (const Placement& placement : m_placements) {
        if (!placement.splatter) continue;
        if (const auto* own = std::get_if<FieldSplatter>(&*placement.splatter))
            bytes += own->tableBytes();
        else
            for (const WarpedSplatter& warped : std::get<1>(*placement.splatter)) bytes += warped.table().bytes();
    }
    m_mostBytes = std::max(m_mostBytes, bytes);
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
    prepare();
}

int FieldPlanes::bands() const {
    return m_lattice.parallel() ? (planes().tilesY() + m_bandTiles - 1) / m_bandTiles : 1;
}

// Phases alternate between bands of rows; views that warp their footprints have no bands.
int FieldPlanes::tasks(int phase) const {
    return static_cast<int>(m_runs.size()) * ((bands() + 1 - phase) / kPhases);
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
    for (const Placement& placement : m_placements) {
        if (!placement.splatter || placement.reach.first >= end || placement.reach.last < run.sheet) continue;
        const Splatter& splatter = *placement.splatter;
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
        if (m_lattice.parallel()) planes.raiseToZero(p);  // footprint slopes go below 0 around the field's rim
        planes.dropEmpty(p);
    }
}

std::size_t FieldPlanes::bytes() const {
    return m_mostBytes + m_planes.size() * PlaneStack::bytes(planes().planes(), planes().width(), planes().height(), 1);
}

std::size_t FieldPlanes::bytes(const ViewField& field, const Settings& settings, const Dials& dials,
                               const Sheets& sheets, const Lattice& lattice, int batchSheets) {
    return PlaneStack::bytes(batchSheets + 2 * settings.halo, lattice.width, lattice.height, 1) +
           placementBytes(field, settings, dials, sheets, lattice);
}

// The largest sum of bytes of placements that reach into the same batch.
std::size_t FieldPlanes::bytes(const std::vector<ViewField>& placements, const Settings& settings, const Dials& dials,
                               const Sheets& sheets, const Lattice& lattice, int batchSheets) {
    const int batch = batchSheets + 2 * settings.halo;
    std::map<int, std::ptrdiff_t> changes;  // by the first sheet of the batch
    for (const ViewField& field : placements) {
        const Reach reach = reachOf(field, dials, sheets);
        const auto own = static_cast<std::ptrdiff_t>(placementBytes(field, settings, dials, sheets, lattice));
        changes[reach.first - batch + 1] += own;
        changes[reach.last + 1] -= own;
    }
    std::ptrdiff_t now = 0, most = 0;
    for (const auto& [sheet, change] : changes) most = std::max(most, now += change);
    return PlaneStack::bytes(batch, lattice.width, lattice.height, 1) + static_cast<std::size_t>(most);
}

std::size_t FieldPlanes::placementBytes(const ViewField& field, const Settings& settings, const Dials& dials,
                                        const Sheets& sheets, const Lattice& lattice) {
    const std::size_t sum = field.field->blockCount() * 8;
    if (!lattice.parallel()) return sum;  // one small table
    const Mat4 rsFromIs = lattice.rsFromTs * sheets.tsFrom(field.wsFromIs);
    std::size_t tables = 0;
    Mat4 rsFromLevel = rsFromIs;
    for (int level = field.field->tiles.empty() ? 0 : coarserLevels(rsFromIs); level >= 0; --level) {
        const FootprintTable::Steps steps = footprintSteps(rsFromLevel, settings.stepsPerVoxel);
        tables +=
            FootprintTable::bytes(dials.kernel, rsFromLevel, steps.texel, steps.sheet, FootprintTable::Lookup::sloped);
        for (int axis = 0; axis < 3; ++axis) rsFromLevel[axis] *= 2;
    }
    return sum + tables;
}

}  // namespace scrim
