// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/transport/cell_grid.h>

#include <scrim/base/error.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <glm/common.hpp>

namespace scrim {
namespace {

// The most blocks of the box; their numbers take 64 MB.
constexpr double kMostBlocks = 1 << 24;
// The largest distance from the world's origin, in blocks, so that cells can be counted with an int.
constexpr double kFarthestBlock = 1 << 26;

int blockOf(int cell) {
    return cell >> 3;  // also rounds down below 0
}

}  // namespace

CellGrid::CellGrid(double edge, const std::vector<Bounds>& wsBoxes, const Vec3& wsCorner)
    : m_edge(edge), m_corner(wsCorner) {
    Bounds all;
    for (const Bounds& box : wsBoxes) all.include(box);
    if (wsBoxes.empty()) return;
    all.lower -= wsCorner;
    all.upper -= wsCorner;
    const double blockEdge = edge * kCellEdge;
    const Vec3 first = glm::floor(all.lower / blockEdge), last = glm::floor(all.upper / blockEdge);
    const Vec3 size = last - first + 1.0;
    const Vec3 farthest = glm::max(glm::abs(first), glm::abs(last));
    if (!(size.x * size.y * size.z <= kMostBlocks) || std::max({farthest.x, farthest.y, farthest.z}) > kFarthestBlock)
        throw Error(ErrorKind::memory, fmt::format("cells of {:.4g} world units for scattered light make {:.3g} x "
                                                   "{:.3g} x {:.3g} blocks, which is too many; raise scatter_cell",
                                                   edge, size.x, size.y, size.z));
    const Int3 origin(first);
    m_origin = origin * kCellEdge;
    m_blocks = Int3(size);
    std::vector<bool> wanted(numberInBox(m_blocks - 1) + 1, false);
    for (const Bounds& box : wsBoxes) {
        const Int3 from = Int3(glm::floor((box.lower - wsCorner) / blockEdge)) - origin;
        const Int3 to = Int3(glm::floor((box.upper - wsCorner) / blockEdge)) - origin;
        for (int z = from.z; z <= to.z; ++z)
            for (int y = from.y; y <= to.y; ++y)
                for (int x = from.x; x <= to.x; ++x) wanted[numberInBox({x, y, z})] = true;
    }
    number(std::move(wanted));
}

CellGrid CellGrid::coarser(const CellGrid& fine) {
    CellGrid out;
    out.m_edge = 2 * fine.m_edge;
    out.m_corner = fine.m_corner;
    if (fine.m_places.empty()) return out;
    const Int3 fineOrigin = fine.m_origin / kCellEdge;  // exact, since both are multiples of 8
    const Int3 first = fineOrigin >> 1, last = (fineOrigin + fine.m_blocks - 1) >> 1;
    out.m_origin = first * kCellEdge;
    out.m_blocks = last - first + 1;
    std::vector<bool> wanted(out.numberInBox(out.m_blocks - 1) + 1, false);
    for (const Int3& place : fine.m_places) wanted[out.numberInBox(((fineOrigin + place) >> 1) - first)] = true;
    out.number(std::move(wanted));
    return out;
}

void CellGrid::number(std::vector<bool>&& wanted) {
    m_stored.assign(wanted.size(), -1);
    std::size_t i = 0;
    for (int z = 0; z < m_blocks.z; ++z)
        for (int y = 0; y < m_blocks.y; ++y)
            for (int x = 0; x < m_blocks.x; ++x, ++i) {
                if (!wanted[i]) continue;
                m_stored[i] = static_cast<std::int32_t>(m_places.size());
                m_places.emplace_back(x, y, z);
            }
}

std::ptrdiff_t CellGrid::index(const Int3& cell) const {
    const std::int32_t block = stored({blockOf(cell.x), blockOf(cell.y), blockOf(cell.z)});
    if (block < 0) return -1;
    return std::ptrdiff_t(block) * kBlockCells + cellOffset(cell.x & 7, cell.y & 7, cell.z & 7);
}

Int3 CellGrid::place(std::size_t index) const {
    const auto inBlock = static_cast<int>(index % kBlockCells);
    return m_places[index / kBlockCells] * kCellEdge +
           Int3(inBlock % kCellEdge, inBlock / kCellEdge % kCellEdge, inBlock / (kCellEdge * kCellEdge));
}

}  // namespace scrim
