// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/splatter.h>

#include <scrim/base/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include <glm/matrix.hpp>

namespace scrim {

Bounds extentOf(int edge, const Mat4& tsFromIs) {
    Bounds extent;
    for (const Vec3& corner : Bounds{Vec3(0), Vec3(edge - 1)}.corners())
        extent.include(transformVector(tsFromIs, corner));
    return extent;
}

namespace {

// Bound on the error of a position in a table, in sheets: half a step, and as much again for rounding of floats.
double rounding(const FootprintTable& table) {
    return 1.0 / table.sheetSteps();
}

// The first and last sheets that footprints of voxels at depths [lower, upper] may be written to.
int firstTouched(const FootprintTable& table, double lower) {
    return static_cast<int>(std::floor(lower - rounding(table))) + table.firstSheet();
}
int lastTouched(const FootprintTable& table, double upper) {
    return static_cast<int>(std::floor(upper + rounding(table))) + table.firstSheet() + table.sheets() - 1;
}

constexpr int kLeastBand = 6;  // rows of tiles; enough work for a task

}  // namespace

// Cubes of one size, ascending by the first sheet that they touch, then by index.
struct FieldSplatter::SheetOrder {
    std::vector<std::uint32_t> cubes;
    std::vector<std::int32_t> firstSheets;  // in the same order
    int span = 0;                           // most sheets that a cube can touch

    std::span<const std::uint32_t> touching(int firstSheet, int lastSheet) const {
        const auto begin = std::lower_bound(firstSheets.begin(), firstSheets.end(), firstSheet - span);
        const auto end = std::lower_bound(begin, firstSheets.end(), lastSheet);
        return {cubes.data() + (begin - firstSheets.begin()), static_cast<std::size_t>(end - begin)};
    }
};

bool FieldSplatter::isScattered(const SparseField& field) {
    constexpr std::size_t kFew = 64;  // voxels of a block
    return field.blockCount() > 0 && field.activeVoxels <= kFew * field.blockCount();
}

std::size_t FieldSplatter::bytesOfBlocks(const SparseField& field) {
    constexpr std::size_t kOrder = 8, kRow = 4;
    return field.blockCount() * (kOrder + kRow + (isScattered(field) ? sizeof(Bounds) + 8 : 0));
}

FieldSplatter::FieldSplatter(FieldSplatter&&) noexcept = default;
FieldSplatter::~FieldSplatter() = default;

struct FieldSplatter::Target {
    BlockSplat splat;
    std::span<PlaneStack> planes;
    int firstPlane;
    const TileCull* cull;
    int band, bands;
    std::uint64_t footprints = 0;
};

FieldSplatter::FieldSplatter(const SparseField& field, const Mat4& tsFromIs, Kernel kernel, int stepsPerVoxel,
                             Real scale, Real most, Simd simd)
    : m_field(field),
      m_tsFromIs(tsFromIs),
      m_scale(scale),
      m_most(most),
      m_simd(simd),
      m_table(kernel, tsFromIs, slopedSteps(kernel, tsFromIs, stepsPerVoxel)),
      m_pieces(m_table),
      m_order(tsFromIs) {
    m_table.dropWeights();
    std::vector<const float*>& values = m_values.emplace_back();
    if (field.blockValues)
        for (std::size_t b = 0; b < field.blockCount(); ++b) values.push_back(field.block(b));
    const Bounds lattice = extentOf(kBlockEdge, tsFromIs);
    // Slopes extend one step beyond the kernel.
    const double texelStep = 1.0 / m_table.texelSteps();
    m_footprint = m_table.extent() + Vec3(texelStep, texelStep, 2 * rounding(m_table));
    m_reach = {lattice.lower - m_footprint, lattice.upper + m_footprint};
    // One more tile accounts for the position of blocks within tiles, another for the tables' extent beyond footprints.
    m_bandTiles = std::max(kLeastBand, static_cast<int>((m_reach.size().y + 1) / kTileEdge) + 3);

    m_rows.reserve(field.blockCount());
    for (const Int3& origin : field.blockOrigins)
        m_rows.push_back(tilesUnder(transformPoint(tsFromIs, Vec3(origin)), m_reach).y0);
    std::vector<std::uint32_t> blocks(field.blockCount());
    std::iota(blocks.begin(), blocks.end(), 0U);
    addOrder(std::move(blocks), kBlockEdge, [&](std::uint32_t b) { return field.blockOrigins[b]; });
    std::map<int, std::vector<std::uint32_t>> tiles;
    for (std::uint32_t t = 0; t < field.tiles.size(); ++t) tiles[field.tiles[t].edge].push_back(t);
    for (auto& [edge, numbers] : tiles)
        addOrder(std::move(numbers), edge, [&](std::uint32_t t) { return field.tiles[t].origin; });
}

// `origin(i)`: the first voxel of cube i, one of `numbers`.
template <class Origin>
void FieldSplatter::addOrder(std::vector<std::uint32_t> numbers, int edge, const Origin& origin) {
    const Bounds voxels = extentOf(edge, m_tsFromIs);
    SheetOrder& order = m_orders.emplace_back();
    order.span = lastTouched(m_table, voxels.size().z) - firstTouched(m_table, 0) + 2;
    std::vector<std::pair<std::int32_t, std::uint32_t>> cubes;
    cubes.reserve(numbers.size());
    for (const std::uint32_t number : numbers)
        cubes.emplace_back(firstTouched(m_table, transformPoint(m_tsFromIs, Vec3(origin(number))).z + voxels.lower.z),
                           number);
    std::sort(cubes.begin(), cubes.end());
    order.cubes = std::move(numbers);
    order.firstSheets.reserve(cubes.size());
    for (std::size_t i = 0; i < cubes.size(); ++i) {
        order.firstSheets.push_back(cubes[i].first);
        order.cubes[i] = cubes[i].second;
    }
}

// They stay in their own order, since sums depend on it.
std::vector<std::uint32_t> FieldSplatter::tilesTouching(int firstSheet, int lastSheet) const {
    std::vector<std::uint32_t> tiles;
    for (std::size_t i = 1; i < m_orders.size(); ++i) {
        const auto touching = m_orders[i].touching(firstSheet, lastSheet);
        tiles.insert(tiles.end(), touching.begin(), touching.end());
    }
    std::sort(tiles.begin(), tiles.end());
    return tiles;
}

void FieldSplatter::join(const SparseField& field) {
    static constexpr std::array<float, kBlockVoxels> kNothing{};
    std::vector<const float*>& values = m_values.emplace_back();
    std::size_t own = 0;
    for (const Int3& origin : m_field.blockOrigins) {
        const bool has = own < field.blockCount() && field.blockOrigins[own] == origin;
        values.push_back(has ? field.block(own++) : kNothing.data());
    }
}

void FieldSplatter::markBands(int firstSheet, int lastSheet, const PlaneStack& planes,
                              std::vector<std::uint8_t>& marked) const {
    const int all = bands(planes);
    for (const std::uint32_t b : m_orders.front().touching(firstSheet, lastSheet))
        if (touches(b, firstSheet, lastSheet)) marked[std::size_t(bandOf(m_rows[b], all))] = 1;
    for (const std::uint32_t t : tilesTouching(firstSheet, lastSheet)) {
        const Bounds ts = tsBoxOf(m_field.tiles[t].origin, m_field.tiles[t].edge);
        const auto first = marked.begin() + bandOf(ts.lower, all), last = marked.begin() + bandOf(ts.upper, all);
        std::fill(first, last + 1, std::uint8_t{1});
    }
}

// The box of a block's voxels that are not 0 in all fields, in voxels from its first; empty if all are.
Bounds FieldSplatter::liveVoxels(std::size_t block) const {
    Bounds live;
    for (const auto& values : m_values)
        for (int i = 0; i < kBlockVoxels; ++i)
            if (values[block][i] != 0)
                live.include(Vec3(i / (kBlockEdge * kBlockEdge), i / kBlockEdge % kBlockEdge, i % kBlockEdge));
    return live;
}

// A spark in a block of its own fills a hundredth of the tiles and sheets that the block may touch.
void FieldSplatter::tighten() {
    if (!isScattered(m_field)) return;
    Mat4 offset = m_tsFromIs;
    offset[3] = {0, 0, 0, 1};
    // Voxels are splatted from the nearest step, and slopes reach a step beyond kernels from there.
    const double step = 1.0 / m_table.texelSteps();
    const Vec3 reach = m_footprint + Vec3(step, step, 0);
    m_live.resize(m_field.blockCount());
    parallelFor(m_live.size(), [&](std::size_t b) {
        const Bounds live = liveVoxels(b);
        if (live.empty()) return;
        const Bounds ts = transformed(offset, live);
        m_live[b] = {ts.lower - reach, ts.upper + reach};
    });
    // Blocks keep their order, on which sums depend.
    constexpr auto kNever = std::numeric_limits<std::int32_t>::max();
    m_touched.resize(m_live.size(), {kNever, kNever});
    for (std::size_t b = 0; b < m_live.size(); ++b) {
        if (m_live[b].empty()) continue;
        const double n = transformPoint(m_tsFromIs, Vec3(m_field.blockOrigins[b])).z;
        m_touched[b] = {firstTouched(m_table, n + m_live[b].lower.z + reach.z),
                        lastTouched(m_table, n + m_live[b].upper.z - reach.z) + 1};
    }
}

std::uint64_t FieldSplatter::splat(int firstSheet, int lastSheet, std::span<PlaneStack> planes, int firstPlane,
                                   const TileCull& cull) const {
    std::uint64_t footprints = 0;
    for (const int phase : {0, 1})
        for (int band = phase; band < bands(planes.front()); band += 2)
            footprints += splat(firstSheet, lastSheet, planes, firstPlane, cull, band);
    return footprints;
}

std::uint64_t FieldSplatter::splat(int firstSheet, int lastSheet, std::span<PlaneStack> planes, int firstPlane,
                                   const TileCull& cull, int band) const {
    const std::span<const std::uint32_t> touching = m_orders.front().touching(firstSheet, lastSheet);
    const std::vector<std::uint32_t> tiles = tilesTouching(firstSheet, lastSheet);
    if (touching.empty() && tiles.empty()) return 0;
    PlaneStack& own = planes.front();
    const std::vector<std::ptrdiff_t> offsets = m_pieces.offsets(own.planeStride(), own.rowStride());
    Target target{{&m_order,
                   &m_table,
                   &m_pieces,
                   offsets.data(),
                   {},
                   static_cast<int>(planes.size()),
                   own.planeStride(),
                   own.rowStride(),
                   firstSheet,
                   lastSheet,
                   m_scale,
                   m_most,
                   own.width(),
                   own.height(),
                   false,
                   m_simd},
                  planes,
                  firstPlane,
                  &cull,
                  band,
                  bands(own)};
    for (std::size_t f = 0; f < planes.size(); ++f) target.splat.planes[f] = planes[f].plane(firstPlane);

    std::vector<std::pair<std::uint32_t, Vec3>> blocks;
    for (const std::uint32_t b : touching)
        if (touches(b, firstSheet, lastSheet) && bandOf(m_rows[b], target.bands) == target.band)
            blocks.emplace_back(b, transformPoint(m_tsFromIs, Vec3(m_field.blockOrigins[b])));
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        // Blocks are scattered over memory, and each is soon done; the one after the next is prefetched meanwhile.
        if (constexpr std::size_t kAhead = 2; i + kAhead < blocks.size()) prefetchBlock(blocks[i + kAhead].first);
        const auto& [b, ts] = blocks[i];
        std::array<const float*, BlockSplat::kMost> values{};
        for (std::size_t f = 0; f < m_values.size(); ++f) values[f] = m_values[f][b];
        splatOneBlock(ts, m_live.empty() ? m_reach : m_live[b], values.data(), target);
    }

    std::array<float, kBlockVoxels> constant;
    for (const std::uint32_t t : tiles) {
        const ConstantTile& tile = m_field.tiles[t];
        constant.fill(tile.value);
        splatTile(tile.origin, tile.edge, constant.data(), target);
    }
    return target.footprints;
}

// The box around the voxels of a cube.
Bounds FieldSplatter::tsBoxOf(const Int3& origin, int edge) const {
    return transformed(m_tsFromIs, {Vec3(origin), Vec3(origin + Int3(edge - 1))});
}

// The tiles that a block's footprints may touch, some possibly outside of the planes.
Box2<int> FieldSplatter::tilesUnder(const Vec3& ts, const Bounds& reach) const {
    const auto tile = [](double texel) { return static_cast<int>(std::floor(texel / kTileEdge)); };
    return {tile(ts.x + reach.lower.x), tile(ts.y + reach.lower.y), tile(ts.x + reach.upper.x + 1) + 1,
            tile(ts.y + reach.upper.y + 1) + 1};
}

// The band of a block by the first row of tiles that it may touch.
int FieldSplatter::bandOf(int row, int bands) const {
    return std::clamp(row / m_bandTiles, 0, bands - 1);
}

void FieldSplatter::prefetchBlock(std::uint32_t b) const {
    constexpr int kLine = 16;  // floats
    for (const auto& values : m_values)
        for (int i = 0; i < kBlockVoxels; i += kLine) __builtin_prefetch(values[b] + i);
}

// Halves a tile until its pieces are blocks or miss the sheets.
void FieldSplatter::splatTile(const Int3& origin, int edge, const float* values, Target& target) const {
    const Bounds ts = tsBoxOf(origin, edge);
    if (lastTouched(m_table, ts.upper.z) < target.splat.firstSheet ||
        firstTouched(m_table, ts.lower.z) >= target.splat.lastSheet)
        return;
    if (edge == kBlockEdge) {
        const Vec3 block = transformPoint(m_tsFromIs, Vec3(origin));
        if (bandOf(block, target.bands) == target.band) splatOneBlock(block, m_reach, &values, target);
        return;
    }
    if (bandOf(ts.upper, target.bands) < target.band || bandOf(ts.lower, target.bands) > target.band) return;
    const int half = edge / 2;
    for (int i = 0; i < 8; ++i) splatTile(origin + half * Int3(i >> 2 & 1, i >> 1 & 1, i & 1), half, values, target);
}

void FieldSplatter::splatOneBlock(const Vec3& ts, const Bounds& reach, const float* const* values,
                                  Target& target) const {
    const BlockSplat& splat = target.splat;
    // All voxels whose entry in the table includes one of the sheets count, even if its weights there are 0: which
    // voxels are splatted into a sheet must not depend on how calls share the sheets.
    const auto [first, second] =
        m_order.between(splat.firstSheet - m_table.firstSheet() - m_table.sheets() + 1 - rounding(m_table) - ts.z,
                        splat.lastSheet - m_table.firstSheet() - ts.z);
    if (first == second) return;

    // Activates the tiles under the block, once for each sheet that it may touch.
    const Box2<int> under = tilesUnder(ts, reach);
    const Box2<int> tiles = intersection(under, {0, 0, target.planes[0].tilesX(), target.planes[0].tilesY()});
    if (tiles.empty()) return;
    // Whole blocks are culled, whatever is in them.
    if (*target.cull && (*target.cull)(tilesUnder(ts, m_reach))) return;
    // Tables extend a little beyond the kernel: one texel before it, and rows are rounded up behind it.
    constexpr double kBefore = 2, kBehind = 6;
    target.splat.clipped = ts.x + reach.lower.x < kBefore || ts.y + reach.lower.y < kBefore ||
                           ts.x + reach.upper.x > splat.width - kBehind ||
                           ts.y + reach.upper.y > splat.height - kBehind;
    const int s0 = std::max(splat.firstSheet, static_cast<int>(std::floor(ts.z + reach.lower.z)));
    const int s1 = std::min(splat.lastSheet, static_cast<int>(std::floor(ts.z + reach.upper.z)) + 1);
    for (int s = s0; s < s1; ++s)
        for (int ty = tiles.y0; ty < tiles.y1; ++ty)
            for (int tx = tiles.x0; tx < tiles.x1; ++tx)
                for (PlaneStack& planes : target.planes)
                    planes.activate(target.firstPlane + s - splat.firstSheet, tx, ty);

    target.footprints += splatBlock(splat, ts, values, first, second);
}

}  // namespace scrim
