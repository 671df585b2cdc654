// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/passes/lit_surfaces.h>

#include <algorithm>
#include <utility>

namespace scrim {

LitSurfaces::LitSurfaces(const ViewScene& scene, const CellGrid& grid)
    : m_scene(scene),
      m_grid(grid),
      m_cells(scene.volumes.size()),
      m_grids(scene.volumes.size()),
      m_normals(scene.volumes.size()) {
    for (std::size_t v = 0; v < scene.volumes.size(); ++v) {
        const ViewVolume& volume = scene.volumes[v];
        if (!volume.classified || volume.field->empty()) continue;
        m_cells[v] =
            std::make_unique<const SurfaceCells>(surfaceCells(grid, volume, scene.dials.kernel, voxelUnit(scene)));
    }
    const auto filled = [](const ViewVolume& volume) { return !volume.field->empty(); };
    const auto only = std::ranges::find_if(scene.volumes, filled);
    if (std::ranges::count_if(scene.volumes, filled) != 1 || !only->classified || !isByValueAlone(*only)) return;
    m_only = std::size_t(only - scene.volumes.begin());
    m_integral.emplace(*only->classified, double(only->field->maxValue));
}

void LitSurfaces::show(const std::vector<bool>& seen, const std::vector<bool>& volumes, const Vec3& wsCorner,
                       double margin) {
    for (std::size_t v = 0; v < m_cells.size(); ++v) {
        const ViewVolume& volume = m_scene.volumes[v];
        if (!m_cells[v] || volume.holdout || !volumes[v]) continue;
        m_grids[v] = std::make_shared<const CellGrid>(m_grid.edge(), m_cells[v]->boxes(m_grid, seen, margin), wsCorner);
        m_normals[v] = surfaceNormals(*m_grids[v], volume, m_scene.dials.kernel, voxelUnit(m_scene));
    }
}

void LitSurfaces::face(int volume, CellSlices& slices) const {
    slices.face(*m_grids[std::size_t(volume)], m_normals[std::size_t(volume)]);
}

std::vector<const CellGrid*> LitSurfaces::grids() const {
    std::vector<const CellGrid*> all;
    for (const auto& grid : m_grids)
        if (grid) all.push_back(grid.get());
    return all;
}

void LitSurfaces::addTo(std::vector<Real>& extinction, const std::vector<bool>& volumes) const {
    for (std::size_t v = 0; v < m_cells.size(); ++v)
        for (std::size_t cell = 0; m_cells[v] && volumes[v] && cell < extinction.size(); ++cell)
            extinction[cell] += m_cells[v]->extinction[cell];
}

void LitSurfaces::classify(CellSlices& slices) const {
    if (m_integral) slices.classify(m_cells[m_only].get(), &*m_integral);
}

std::size_t LitSurfaces::bytes() const {
    std::size_t sum = 0;
    for (const auto& cells : m_cells) sum += cells ? cells->bytes() : 0;
    for (const SurfaceNormals& normals : m_normals) sum += normals.size() * normals[0].size() * sizeof(Real);
    return sum;
}

}  // namespace scrim
