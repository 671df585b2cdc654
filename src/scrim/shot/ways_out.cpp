// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/ways_out.h>

#include <scrim/volume/block_index.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <queue>
#include <utility>

namespace scrim {
namespace {

/// Cells are as small as their number allows, from 2 voxels on.
constexpr double kMostCells = 1 << 18;
constexpr int kLeastShift = 1, kMostShift = 3;

template <typename Visit>
void forNeighbours(const Int3& cell, const Visit& visit) {
    for (int i = 0; i < 27; ++i) visit(cell + Int3(i / 9, i / 3 % 3, i % 3) - 1);
}

/// The smallest of the values in a cube of `edge` voxels of a block.
float leastOf(const float* block, const Int3& first, int edge) {
    float least = std::numeric_limits<float>::max();
    for (int x = first.x; x < first.x + edge; ++x)
        for (int y = first.y; y < first.y + edge; ++y)
            for (int z = first.z; z < first.z + edge; ++z) least = std::min(least, block[blockOffset(x, y, z)]);
    return least;
}

}  // namespace

std::size_t WaysOut::Hash::operator()(const Int3& cell) const {
    const auto part = [](int x) { return std::uint64_t{static_cast<std::uint32_t>(x)}; };
    const std::uint64_t h = (part(cell.x) << 42 ^ part(cell.y) << 21 ^ part(cell.z)) * 0x9E3779B97F4A7C15ULL;
    return h ^ h >> 32;
}

void WaysOut::addCells(const SparseField& field) {
    const int edge = 1 << m_shift;
    const auto add = [&](const Int3& origin, const float* values, float constant) {
        for (int x = 0; x < kBlockEdge; x += edge)
            for (int y = 0; y < kBlockEdge; y += edge)
                for (int z = 0; z < kBlockEdge; z += edge) {
                    const float least = values != nullptr ? leastOf(values, {x, y, z}, edge) : constant;
                    if (least > 0) m_cells.emplace((origin + Int3(x, y, z)) >> m_shift, Cell{least});
                }
    };
    for (std::size_t b = 0; b < field.blockCount(); ++b) add(field.blockOrigins[b], field.block(b), 0);
    for (const ConstantTile& tile : field.tiles)
        for (int x = 0; x < tile.edge; x += kBlockEdge)
            for (int y = 0; y < tile.edge; y += kBlockEdge)
                for (int z = 0; z < tile.edge; z += kBlockEdge) add(tile.origin + Int3(x, y, z), nullptr, tile.value);
}

// A way into a cell comes in last from beyond the cells around it, and passes one of these. From
// there on it is at least a cell's edge long, and nowhere thinner than they are. So the shortest
// way to a cell is no shorter than that to some cell around it, and that edge.
double WaysOut::acrossAround(const Int3& cell, double depth) const {
    float thinnest = std::numeric_limits<float>::max();
    forNeighbours(cell, [&](const Int3& beside) {
        const auto found = m_cells.find(beside);
        thinnest = std::min(thinnest, found == m_cells.end() ? 0.0f : found->second.least);
    });
    return depth * (1 << m_shift) * double(thinnest);
}

WaysOut::WaysOut(const SparseField& field, double depth, const std::vector<Int3>& inside) {
    for (m_shift = kLeastShift; std::ldexp(dividedBlocks(field), 9 - 3 * m_shift) > kMostCells; ++m_shift)
        if (m_shift == kMostShift) return;
    addCells(field);
    using Step = std::pair<double, Int3>;
    const auto later = [](const Step& a, const Step& b) { return a.first > b.first; };
    std::priority_queue<Step, std::vector<Step>, decltype(later)> next(later);
    std::unordered_map<Int3, double, Hash> across;
    for (auto& [cell, own] : m_cells) {
        const double way = acrossAround(cell, depth);
        across.emplace(cell, way);
        own.way = way > 0 ? std::numeric_limits<double>::infinity() : 0;
        if (way == 0) next.emplace(0, cell);
    }
    const auto reach = [&](const Int3& cell, double way) {
        const auto found = m_cells.find(cell);
        if (found == m_cells.end() || !(way < found->second.way)) return;
        found->second.way = way;
        next.emplace(way, cell);
    };
    for (const Int3& voxel : inside) forNeighbours(voxel >> m_shift, [&](const Int3& beside) { reach(beside, 0); });
    while (!next.empty()) {
        const auto [way, cell] = next.top();
        next.pop();
        if (way > m_cells.at(cell).way) continue;
        forNeighbours(cell, [&, from = way](const Int3& beside) {
            if (const auto found = across.find(beside); found != across.end()) reach(beside, from + found->second);
        });
    }
}

double WaysOut::to(const Int3& lower, const Int3& upper) const {
    if (m_cells.empty()) return 0;
    double least = std::numeric_limits<double>::infinity();
    const Int3 first = lower >> m_shift, last = upper >> m_shift;
    for (int x = first.x; x <= last.x; ++x)
        for (int y = first.y; y <= last.y; ++y)
            for (int z = first.z; z <= last.z; ++z) {
                const auto found = m_cells.find({x, y, z});
                least = std::min(least, found == m_cells.end() ? 0.0 : found->second.way);
            }
    return least;
}

}  // namespace scrim
