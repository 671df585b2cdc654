// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/field_planes.h>

#include <scrim/base/parallel.h>
#include <scrim/engine/splat/warped_splatter.h>
#include <scrim/volume/kernel.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <variant>

#include <glm/geometric.hpp>

namespace scrim {
namespace {

// Consecutive sheets that one task splats. Voxels reach into about four sheets, so with fewer they
// would be located more often.
constexpr int kSheetsPerTask = 8;

Kernel kernelOf(const ViewField& field, const Dials& dials) {
    return field.kernel.value_or(dials.kernel);
}

// The number of rows of tiles that a block may touch, plus one. Bands must not depend on the
// contents of a batch, since they decide the order in which floats are added.
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

// The first and the last sheet that a field may reach.
std::pair<int, int> reachOf(const ViewField& field, const Dials& dials, const Sheets& sheets) {
    constexpr double kRounding = 2;  // rounding of footprint tables and of bounds, in sheets
    const Mat4 tsFromIs = sheets.tsFrom(field.wsFromIs);
    const double reach =
        kernelExtent(kernelOf(field, dials), {tsFromIs[0][2], tsFromIs[1][2], tsFromIs[2][2]}) + kRounding;
    const Bounds ts = transformed(tsFromIs, field.field->isBounds());
    return {static_cast<int>(std::floor(ts.lower.z - reach)), static_cast<int>(std::ceil(ts.upper.z + reach))};
}

// Upper bound on the bytes of a field's splatter.
std::size_t placementBytes(const ViewField& field, const FieldPlanes::Settings& settings, const Dials& dials,
                           const Sheets& sheets, const Lattice& lattice) {
    const std::size_t sum = FieldSplatter::bytesOfBlocks(*field.field);
    if (!lattice.parallel()) return sum;  // one small table
    const Mat4 rsFromIs = lattice.rsFromTs * sheets.tsFrom(field.wsFromIs);
    std::size_t tables = 0;
    Mat4 rsFromLevel = rsFromIs;
    for (int level = field.field->tiles.empty() ? 0 : coarserLevels(rsFromIs); level >= 0; --level) {
        tables += FootprintTable::bytes(kernelOf(field, dials), rsFromLevel,
                                        slopedSteps(kernelOf(field, dials), rsFromLevel, settings.stepsPerVoxel));
        for (int axis = 0; axis < 3; ++axis) rsFromLevel[axis] *= 2;
    }
    return sum + tables;
}

}  // namespace

struct FieldPlanes::Placement {
    std::vector<ViewField> fields;
    std::vector<const float*> values;  // values of the first field's blocks, if the field itself does not hold them
    int first, last;                   // the sheets that it may reach: [first, last]
    std::variant<std::monostate, FieldSplatter, std::vector<WarpedSplatter>> splatter = {};

    bool ready() const { return splatter.index() > 0; }
    bool reaches(int begin, int end) const { return first < end && last >= begin; }
};

FieldPlanes::~FieldPlanes() = default;

void FieldPlanes::makeSplatter(Placement& placement) const {
    const Settings& s = m_settings;
    const std::vector<ViewField>& fields = placement.fields;
    const Mat4 tsFromIs = m_sheets.tsFrom(fields.front().wsFromIs);
    const Kernel kernel = kernelOf(fields.front(), m_dials);
    if (!m_lattice.parallel()) {
        auto& splatters = placement.splatter.emplace<std::vector<WarpedSplatter>>();
        for (const ViewField& field : fields)
            splatters.emplace_back(*field.field, tsFromIs, m_lattice, kernel, s.stepsPerVoxel, s.scale, s.most);
        return;
    }
    auto& splatter = placement.splatter.emplace<FieldSplatter>(*fields.front().field, m_lattice.rsFromTs * tsFromIs,
                                                               kernel, s.stepsPerVoxel, s.scale, s.most, m_simd);
    if (!placement.values.empty()) splatter.useValues(placement.values);
    for (std::size_t f = 1; f < fields.size(); ++f) splatter.join(*fields[f].field);
    splatter.tighten();
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
        one.first = std::numeric_limits<int>::min();
        one.last = std::numeric_limits<int>::max();
        makeSplatter(one);
        if (const auto* splatter = std::get_if<FieldSplatter>(&one.splatter)) m_bandTiles = splatter->bandTiles();
    }
    for (std::size_t f = 0; f < placements.front().size(); ++f)
        m_planes.emplace_back(batchSheets + settings.before + settings.behind, lattice.width, lattice.height, 1);
}

void FieldPlanes::place(std::vector<ViewField> fields, std::vector<const float*> values) {
    const ViewField& first = fields.front();
    if (m_lattice.parallel())
        m_bandTiles = std::max(
            m_bandTiles, bandTilesFor(m_lattice.rsFromTs * m_sheets.tsFrom(first.wsFromIs), kernelOf(first, m_dials)));
    const auto [from, to] = reachOf(first, m_dials, m_sheets);
    m_placements.push_back({std::move(fields), std::move(values), from, to});
}

// Places a field. One without large constant tiles stays as it is; of others, the blocks and each
// level of tiles are placed separately.
void FieldPlanes::placeTiles(const ViewField& field) {
    // Larger tiles, which only sources can make, are divided where they are splatted, because their
    // hulls alone are too large.
    constexpr int kLargest = 4096;
    const std::vector<ConstantTile>& all = field.field->tiles;
    const bool cuts = std::all_of(all.begin(), all.end(), [](const ConstantTile& t) { return t.edge <= kLargest; });
    const std::span<const double> weights = twoScaleWeights(kernelOf(field, m_dials));
    if (m_lattice.parallel() && !all.empty() && cuts && !weights.empty()) {
        TileLevels tiles(*field.field, weights, coarserLevels(m_lattice.rsFromTs * m_sheets.tsFrom(field.wsFromIs)));
        if (!tiles.levels().empty()) {
            auto blocks = std::make_shared<SparseField>(*field.field);
            blocks->tiles.clear();
            if (!blocks->blockOrigins.empty()) place({{blocks, field.wsFromIs, field.kernel}});
            Mat4 wsFromLevel = field.wsFromIs;
            for (const TileLevel& level : tiles.levels()) {
                if (!level.field->empty()) place({{level.field, wsFromLevel, field.kernel}}, level.values);
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
        const bool reaches = placement.reaches(m_firstReady, m_readySheet);
        if (!reaches) placement.splatter = std::monostate();
        if (reaches && !placement.ready()) missing.push_back(&placement);
    }
    parallelFor(missing.size(), [&](std::size_t i) {
        makeSplatter(*missing[i]);
        if (auto* own = std::get_if<FieldSplatter>(&missing[i]->splatter)) own->useBands(m_bandTiles);
    });
    std::size_t bytes = 0;
    for (const Placement& placement : m_placements) {
        if (const auto* own = std::get_if<FieldSplatter>(&placement.splatter)) bytes += own->tableBytes();
        if (const auto* own = std::get_if<std::vector<WarpedSplatter>>(&placement.splatter))
            for (const WarpedSplatter& warped : *own) bytes += warped.table().bytes();
    }
    m_mostBytes = std::max(m_mostBytes, bytes);
}

void FieldPlanes::beginBatch(int firstSheet, int count) {
    // Without sheets beside the batch nothing is kept from one batch to the next, which may then be anywhere.
    if (m_origin < 0 || (m_settings.before == 0 && m_settings.behind == 0)) {
        m_origin = firstSheet;
        m_readySheet = firstSheet - m_settings.before;
    }
    m_firstReady = m_readySheet;
    m_readySheet = std::max(m_readySheet, firstSheet + count + m_settings.behind);
    for (PlaneStack& planes : m_planes)
        for (int sheet = m_firstReady; sheet < m_readySheet; ++sheet) planes.begin(planeOf(sheet));
    prepare();
    listTasks();
}

// Phases alternate between bands of rows; views that warp their footprints have no bands.
void FieldPlanes::listTasks() {
    for (std::vector<Task>& tasks : m_tasks) tasks.clear();
    std::vector<std::uint8_t> marked;
    for (int begin = m_firstReady; begin < m_readySheet;) {
        const int wrap = planes().planes() - planeOf(begin);
        const int end = begin + std::min({kSheetsPerTask, m_readySheet - begin, wrap});
        marked.assign(std::size_t(bands()), 0);
        for (const Placement& placement : m_placements) {
            if (!placement.reaches(begin, end)) continue;
            if (const auto* own = std::get_if<FieldSplatter>(&placement.splatter))
                own->markBands(begin, end, planes(), marked);
            else
                marked.front() = 1;
        }
        for (std::size_t band = 0; band < marked.size(); ++band)
            if (marked[band] != 0) m_tasks[band % kPhases].push_back({begin, end, static_cast<int>(band)});
        begin = end;
    }
}

int FieldPlanes::bands() const {
    return m_lattice.parallel() ? (planes().tilesY() + m_bandTiles - 1) / m_bandTiles : 1;
}

std::uint64_t FieldPlanes::splat(int phase, int task, const NeededTiles* needed, const TileCull& cull) {
    const auto [begin, end, band] = m_tasks[std::size_t(phase)][std::size_t(task)];
    const int first = planeOf(begin);
    TileCull culled = cull;
    if (needed)
        culled = [box = needed->over(begin, end), &cull](const Box2<int>& tiles) {
            return intersection(tiles, box).empty() || (cull && cull(tiles));
        };
    std::uint64_t footprints = 0;
    for (const Placement& placement : m_placements) {
        if (!placement.reaches(begin, end)) continue;
        if (const auto* own = std::get_if<FieldSplatter>(&placement.splatter))
            footprints += own->splat(begin, end, std::span(m_planes), first, culled, band);
        if (const auto* own = std::get_if<std::vector<WarpedSplatter>>(&placement.splatter))
            for (std::size_t f = 0; f < m_planes.size(); ++f)
                footprints += (*own)[f].splat(begin, end, m_planes[f], first, culled);
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
    return m_mostBytes + m_planes.size() * planes().bytes();
}

// The largest sum of bytes of placements that reach into the same batch.
std::size_t FieldPlanes::bytes(const std::vector<ViewField>& placements, const Settings& settings, const Dials& dials,
                               const Sheets& sheets, const Lattice& lattice, int batchSheets) {
    const int batch = batchSheets + settings.before + settings.behind;
    std::map<int, std::ptrdiff_t> changes;  // by the first sheet of the batch
    for (const ViewField& field : placements) {
        const auto [first, last] = reachOf(field, dials, sheets);
        const auto own = static_cast<std::ptrdiff_t>(placementBytes(field, settings, dials, sheets, lattice));
        changes[first - batch + 1] += own;
        changes[last + 1] -= own;
    }
    std::ptrdiff_t now = 0, most = 0;
    for (const auto& [sheet, change] : changes) most = std::max(most, now += change);
    return PlaneStack::bytes(batch, lattice.width, lattice.height, 1) + static_cast<std::size_t>(most);
}

}  // namespace scrim
