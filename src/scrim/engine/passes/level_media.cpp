// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/passes/level_media.h>

namespace scrim {
namespace {

// The boxes around the blocks of a grid, and `margin` world units beyond.
std::vector<Bounds> boxesOf(const CellGrid& grid, double margin) {
    std::vector<Bounds> boxes;
    for (const Int3& block : grid.storedBlocks())
        boxes.push_back(
            {grid.wsFromCs(Vec3(block * kCellEdge)) - margin, grid.wsFromCs(Vec3((block + 1) * kCellEdge)) + margin});
    return boxes;
}

}  // namespace

std::vector<bool> mediaAmong(const ViewScene& scene, std::vector<bool> volumes) {
    for (std::size_t v = 0; v < volumes.size(); ++v) volumes[v] = volumes[v] && !scene.volumes[v].classified;
    return volumes;
}

MediaTogether Holding::together() const {
    MediaTogether all{&own};
    for (const CellMedia& media : coarser) all.push_back(&media);
    return all;
}

std::size_t Holding::bytes() const {
    std::size_t sum = own.bytes();
    for (const CellMedia& media : coarser) sum += media.bytes();
    return sum;
}

LevelMedia::LevelMedia(const LevelScene& level, double edge, double margin, Simd simd)
    : m_level(level), m_edge(edge), m_margin(margin), m_corner(cornerOfVoxels(level.own, edge)), m_simd(simd) {}

Holding LevelMedia::of(const std::vector<bool>& casters, const CellGrid* own) const {
    const ViewScene& holding = m_level.holding;
    Holding out{casters, {}, {}};
    out.own = cellMedia(holding, {}, m_edge, m_simd,
                        {m_corner, m_margin, false, mediaAmong(holding, both(casters, withVoxels(holding)))});
    for (const auto& [scene, edge] : m_level.coarser)
        out.coarser.push_back(cellMedia(scene, {}, edge, m_simd,
                                        {cornerOfVoxels(scene, edge), edge, false, both(casters, withVoxels(scene)),
                                         boxesOf(own ? *own : out.own.grid, edge)}));
    return out;
}

CoarserSlices::CoarserSlices(const Holding& holding) {
    for (const CellMedia& media : holding.coarser)
        m_shown.emplace_back(media.grid.edge(), boxesOf(holding.own.grid, 0), media.grid.wsCorner());
}

std::vector<CellSlices> CoarserSlices::along(int axis, const Holding& holding, std::size_t colour) const {
    std::vector<CellSlices> all;
    for (std::size_t l = 0; l < m_shown.size(); ++l) {
        CellSlices& slices = all.emplace_back(holding.coarser[l].grid);
        slices.layAlong(axis);
        slices.fill(holding.coarser[l].extinctionOf(colour), CellSlices::kEverywhere, false, {&m_shown[l]});
    }
    return all;
}

}  // namespace scrim
