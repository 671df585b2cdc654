// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/field_builder.h>

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <set>
#include <tuple>
#include <unordered_set>
#include <utility>

#include <fmt/format.h>
#include <glm/matrix.hpp>

namespace scrim {

namespace {

/// Blocks per task: some tens of microseconds of work.
constexpr std::size_t kBlocksPerTask = 64;
/// Blocks whose values FieldBuilder keeps together: 2 MB, a large page.
constexpr std::size_t kBlocksPerChunk = 1024;

/// Smallest normal value. Denormal values count as 0 without a warning: whether a thread can tell
/// them from 0 depends on its floating-point mode, and the result must not.
constexpr float kSmallest = std::numeric_limits<float>::min();

[[noreturn]] void refuse(const std::string& name, const std::string& reason) {
    throw Error(ErrorKind::input, "grid '" + shortened(name, 80) + "': " + reason);
}

bool aligned(const Int3& p, int edge) {
    return p.x % edge == 0 && p.y % edge == 0 && p.z % edge == 0;
}

void checkTransform(const std::string& name, const Mat4& m) {
    bool finite = true;
    for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r) finite = finite && std::isfinite(m[c][r]);
    if (!finite) refuse(name, "its transform is not finite");
    if (m[0][3] != 0 || m[1][3] != 0 || m[2][3] != 0 || m[3][3] != 1) refuse(name, "its transform is not affine");
    // The threshold is relative to the edge lengths, so that tiny voxels pass and flat ones do not.
    const double volume = std::abs(glm::determinant(Mat3(m)));
    const double edges = glm::length(Vec3(m[0])) * glm::length(Vec3(m[1])) * glm::length(Vec3(m[2]));
    if (!(volume > 1e-12 * edges)) refuse(name, "its transform cannot be inverted");
}

void checkTiles(const FieldPieces& pieces) {
    for (const ConstantTile& tile : pieces.tiles) {
        const bool power = tile.edge >= kBlockEdge && std::has_single_bit(static_cast<unsigned>(tile.edge));
        if (!power || !aligned(tile.origin, tile.edge))
            refuse(pieces.name, fmt::format("a tile of edge {} at {}: the edge must be 8 times a power of two and "
                                            "the origin a multiple of it",
                                            tile.edge, toText(tile.origin)));
    }
}

/// Blocks and tiles lie on nested lattices, so two of them overlap only where the lattice cell of
/// the smaller one lies in that of the larger.
void checkOverlap(const std::string& name, const std::vector<Int3>& sortedBlocks,
                  const std::vector<ConstantTile>& tiles) {
    for (std::size_t i = 1; i < sortedBlocks.size(); ++i)
        if (sortedBlocks[i] == sortedBlocks[i - 1]) refuse(name, "two blocks at " + toText(sortedBlocks[i]));
    if (tiles.empty()) return;

    const auto hash = [](const ConstantTile& t) {
        const auto part = [](int v) { return static_cast<std::uint32_t>(v); };
        std::uint64_t h = part(t.origin.x) * 0x9E3779B97F4A7C15ull;
        h = (h ^ (h >> 29) ^ part(t.origin.y)) * 0xBF58476D1CE4E5B9ull;
        h = (h ^ (h >> 29) ^ part(t.origin.z)) * 0x94D049BB133111EBull;
        return std::size_t(h ^ (h >> 31) ^ part(t.edge));
    };
    const auto equal = [](const ConstantTile& a, const ConstantTile& b) {
        return a.origin == b.origin && a.edge == b.edge;
    };
    std::unordered_set<ConstantTile, decltype(hash), decltype(equal)> cells(2 * tiles.size(), hash, equal);
    std::set<int> edges;
    for (const ConstantTile& tile : tiles) {
        if (!cells.insert(tile).second) refuse(name, "two tiles at " + toText(tile.origin));
        edges.insert(tile.edge);
    }
    const auto check = [&](const Int3& origin, int edge) {
        for (auto e = edges.upper_bound(edge); e != edges.end(); ++e) {
            const int mask = ~(*e - 1);
            const Int3 cell(origin.x & mask, origin.y & mask, origin.z & mask);
            if (cells.contains(ConstantTile{cell, *e, 0}))
                refuse(name, fmt::format("values at {} lie inside the tile at {}", toText(origin), toText(cell)));
        }
    };
    for (const Int3& origin : sortedBlocks) check(origin, kBlockEdge - 1);
    for (const ConstantTile& tile : tiles) check(tile.origin, tile.edge);
}

// Repeatedly joins eight tiles of one value that fill a cube; the inside of a level set of radius
// 500 comes as 400,000 small tiles. The result ascends by origin.
void joinTiles(std::vector<ConstantTile>& tiles) {
    const auto byOrigin = [](const ConstantTile& a, const ConstantTile& b) { return originLess(a.origin, b.origin); };
    constexpr int kLargest = 4096;  // as in OpenVDB
    std::map<int, std::vector<ConstantTile>> byEdge;
    for (const ConstantTile& tile : tiles) byEdge[tile.edge].push_back(tile);
    tiles.clear();
    // A joined tile is added later in the map, so the loop still reaches it.
    for (auto now = byEdge.begin(); now != byEdge.end(); ++now) {
        auto& [edge, own] = *now;
        if (edge >= kLargest) {
            tiles.insert(tiles.end(), own.begin(), own.end());
            continue;
        }
        const auto cubeOf = [half = edge](const ConstantTile& tile) { return tile.origin & ~(2 * half - 1); };
        std::sort(own.begin(), own.end(), [&](const ConstantTile& a, const ConstantTile& b) {
            const Int3 cubeA = cubeOf(a), cubeB = cubeOf(b);
            return originLess(cubeA, cubeB) || (cubeA == cubeB && a.value < b.value);
        });
        for (std::size_t i = 0; i < own.size();) {
            const bool joins =
                i + 8 <= own.size() && cubeOf(own[i]) == cubeOf(own[i + 7]) && own[i].value == own[i + 7].value;
            if (joins)
                byEdge[2 * edge].push_back({cubeOf(own[i]), 2 * edge, own[i].value});
            else
                tiles.push_back(own[i]);
            i += joins ? 8 : 1;
        }
    }
    std::sort(tiles.begin(), tiles.end(), byOrigin);
}

/// For each of `origins`, its place in lattice order. Sorts them.
std::vector<std::uint32_t> sortOrigins(const std::string& name, std::vector<Int3>& origins) {
    if (origins.size() > std::numeric_limits<std::uint32_t>::max()) refuse(name, "it has too many blocks");
    std::vector<std::pair<Int3, std::uint32_t>> sorted(origins.size());
    for (std::uint32_t i = 0; i < sorted.size(); ++i) sorted[i] = {origins[i], i};
    std::sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return originLess(a.first, b.first); });
    std::vector<std::uint32_t> places(origins.size());
    for (std::uint32_t i = 0; i < sorted.size(); ++i) {
        origins[i] = sorted[i].first;
        places[sorted[i].second] = i;
    }
    return places;
}

}  // namespace

bool originLess(const Int3& a, const Int3& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

bool haveOneTopology(const SparseField& field, const SparseField& other) {
    if (!field.tiles.empty() || !other.tiles.empty() || field.wsFromIs != other.wsFromIs) return false;
    // Both lists are in lattice order.
    return std::includes(field.blockOrigins.begin(), field.blockOrigins.end(), other.blockOrigins.begin(),
                         other.blockOrigins.end(), originLess);
}

std::string toText(const Int3& p) {
    return fmt::format("{}, {}, {}", p.x, p.y, p.z);
}

void checkPieces(const FieldPieces& pieces) {
    checkTransform(pieces.name, pieces.wsFromIs);
    checkTiles(pieces);
    for (const Int3& origin : pieces.blockOrigins)
        if (!aligned(origin, kBlockEdge))
            refuse(pieces.name, "a block at " + toText(origin) + ": origins must be multiples of 8");
    checkOverlap(pieces.name, pieces.blockOrigins, pieces.tiles);
}

FieldFill::FieldFill(FieldPieces pieces, BlockMemory& memory)
    : m_pieces(std::move(pieces)), m_memory(memory), m_places(sortOrigins(m_pieces.name, m_pieces.blockOrigins)) {
    checkPieces(m_pieces);
    m_values = m_memory.take(blockCount());
    m_counts.resize(blockCount());
}

FieldFill::~FieldFill() {
    if (m_values) m_memory.shrink(m_values.get(), blockCount(), 0);  // it was never finished
}

void FieldFill::Counts::add(const Counts& c) {
    active += c.active;
    nonFinite += c.nonFinite;
    negative += c.negative;
    maxValue = std::max(maxValue, c.maxValue);
}

FieldFill::Counts FieldFill::clean(float* values) {
    // Written so that compilers vectorise it: no branches, 32-bit counts, and the maximum taken
    // over the bits of the values, whose order is that of non-negative floats.
    constexpr float kLargest = std::numeric_limits<float>::max();
    std::int32_t active = 0, nonFinite = 0, negative = 0, largest = 0;
    for (int i = 0; i < kBlockVoxels; ++i) {
        const float v = values[i];
        const bool positive = (v >= kSmallest) & (v <= kLargest);
        active += positive;
        nonFinite += !((v >= -kLargest) & (v <= kLargest));
        negative += (v >= -kLargest) & (v <= -kSmallest);
        const float kept = positive ? v : 0.0f;  // also turns -0 into 0
        values[i] = kept;
        largest = std::max(largest, std::bit_cast<std::int32_t>(kept));
    }
    Counts counts;
    counts.active = static_cast<std::uint64_t>(active);
    counts.nonFinite = static_cast<std::uint64_t>(nonFinite);
    counts.negative = static_cast<std::uint64_t>(negative);
    counts.maxValue = std::bit_cast<float>(largest);
    return counts;
}

void FieldFill::filled(std::size_t i) {
    m_counts[m_places[i]] = clean(block(i));
}

void FieldFill::addTiles(SparseField& field, Counts& counts) const {
    for (const ConstantTile& tile : m_pieces.tiles) {
        const auto edge = static_cast<std::uint64_t>(tile.edge);
        const std::uint64_t voxels = edge * edge * edge;
        Counts one;
        if (!std::isfinite(tile.value))
            one.nonFinite = voxels;
        else if (tile.value <= -kSmallest)
            one.negative = voxels;
        else if (tile.value >= kSmallest) {
            one.active = voxels;
            one.maxValue = tile.value;
            field.tiles.push_back(tile);
        }
        counts.add(one);
    }
    joinTiles(field.tiles);
}

SparseField FieldFill::finish() {
    // Closes the gaps that blocks without any value leave.
    SparseField field;
    Counts total;
    const std::size_t count = blockCount();
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count; ++i) {
        total.add(m_counts[i]);
        if (m_counts[i].active == 0) continue;
        if (kept != i)
            std::memcpy(m_values.get() + kept * kBlockVoxels, m_values.get() + i * kBlockVoxels,
                        kBlockVoxels * sizeof(float));
        m_pieces.blockOrigins[kept++] = m_pieces.blockOrigins[i];
    }
    m_pieces.blockOrigins.resize(kept);
    if (kept < count) m_memory.shrink(m_values.get(), count, kept);
    addTiles(field, total);

    field.name = m_pieces.name;
    field.wsFromIs = m_pieces.wsFromIs;
    field.blockOrigins = std::move(m_pieces.blockOrigins);
    field.blockValues = std::shared_ptr<const float>(m_values, m_values.get());
    m_values.reset();
    field.activeVoxels = total.active;
    field.nonFinite = total.nonFinite;
    field.negative = total.negative;
    field.maxValue = total.maxValue;
    return field;
}

SparseField buildField(FieldPieces pieces) {
    BlockMemory memory;
    return buildField(std::move(pieces), memory);
}

SparseField buildField(FieldPieces pieces, BlockMemory& memory) {
    const auto fill = std::move(pieces.fill);
    FieldFill field(std::move(pieces), memory);
    parallelFor((field.blockCount() + kBlocksPerTask - 1) / kBlocksPerTask, [&](std::size_t task) {
        const std::size_t end = std::min(field.blockCount(), (task + 1) * kBlocksPerTask);
        for (std::size_t i = task * kBlocksPerTask; i < end; ++i) {
            fill(i, field.block(i));
            field.filled(i);
        }
    });
    return field.finish();
}

void reportCleaning(const SparseField& field, const std::string& where, const MessageSink& messages) {
    if (field.nonFinite == 0 && field.negative == 0) return;
    const std::uint64_t all = field.activeVoxels + field.nonFinite + field.negative;
    std::string what;
    if (field.negative > 0) what = fmt::format("{} are below 0", field.negative);
    if (field.nonFinite > 0) what += fmt::format("{}{} are not finite", what.empty() ? "" : " and ", field.nonFinite);
    // Scans have units that begin below 0, such as Hounsfield's; their source has parameters to deal with that.
    const bool scan = field.negative > 0 && where.starts_with("source 'scan'");
    notify(messages, Severity::warning,
           shortened(fmt::format("{}: grid '{}': of {} voxels with a value {}, and count as empty{}", where,
                                 shortened(field.name, 80), all, what,
                                 scan ? "; the parameter window = \"LOW, HIGH\" makes them visible: LOW becomes 0, "
                                        "HIGH 1"
                                      : "")));
}

FieldBuilder::FieldBuilder(std::string name, const Mat4& wsFromIs) {
    m_pieces.name = std::move(name);
    m_pieces.wsFromIs = wsFromIs;
}

void FieldBuilder::addBlock(const Int3& origin, const float* values) {
    const std::size_t at = m_pieces.blockOrigins.size() % kBlocksPerChunk;
    if (at == 0) m_chunks.push_back(m_memory.take(kBlocksPerChunk));
    m_pieces.blockOrigins.push_back(origin);
    std::memcpy(m_chunks.back().get() + at * kBlockVoxels, values, kBlockVoxels * sizeof(float));
}

void FieldBuilder::addTile(const ConstantTile& tile) {
    m_pieces.tiles.push_back(tile);
}

SparseField FieldBuilder::finish() {
    BlockMemory memory;
    return finish(memory);
}

SparseField FieldBuilder::finish(BlockMemory& memory) {
    const FieldPieces empty{
        .name = m_pieces.name, .wsFromIs = m_pieces.wsFromIs, .blockOrigins = {}, .fill = {}, .tiles = {}};
    FieldFill field(std::exchange(m_pieces, empty), memory);
    const std::vector<std::shared_ptr<float[]>> chunks = std::exchange(m_chunks, {});
    parallelFor(chunks.size(), [&](std::size_t chunk) {
        const std::size_t first = chunk * kBlocksPerChunk;
        float* const values = chunks[chunk].get();
        for (std::size_t i = first; i < std::min(field.blockCount(), first + kBlocksPerChunk); ++i) {
            std::memcpy(field.block(i), values + (i - first) * kBlockVoxels, kBlockVoxels * sizeof(float));
            field.filled(i);
        }
        m_memory.shrink(values, kBlocksPerChunk, 0);
    });
    return field.finish();
}

}  // namespace scrim
