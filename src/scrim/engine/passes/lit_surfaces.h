// SPDX-License-Identifier: Apache-2.0
// The surfaces that light on cells is for: those of all classified volumes, and the cells that keep what they reflect.
#pragma once

#include <scrim/engine/cells/cell_media.h>
#include <scrim/engine/cells/surface_cells.h>
#include <scrim/engine/passes/cell_slices.h>

#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace scrim {

class LitSurfaces {
  public:
    /// `grid` has the cells of all volumes of the scene that have voxels; both must outlive this object.
    LitSurfaces(const ViewScene& scene, const CellGrid& grid);

    /// The cells that keep what a volume reflects; null: it is none, is only a holdout, or `show` has not been called.
    const std::shared_ptr<const CellGrid>& grid(std::size_t volume) const { return m_grids[volume]; }
    /// Lets slices know which way the surfaces of a volume with such cells face.
    void face(int volume, CellSlices& slices) const;
    /// Makes these cells, in blocks from `wsCorner`, for those of the `volumes` that are surfaces:
    /// in the blocks of the scene's grid that are `seen`, and up to `margin` world units beyond.
    void show(const std::vector<bool>& seen, const std::vector<bool>& volumes, const Vec3& wsCorner, double margin);
    /// The grids that are not null.
    std::vector<const CellGrid*> grids() const;

    /// Adds the extinction of those that `volumes` has: a value for each cell of the scene's grid.
    void addTo(std::vector<Real>& extinction, const std::vector<bool>& volumes) const;
    void addTo(CellMedia& media, const std::vector<bool>& volumes) const {
        for (std::vector<Real>& row : media.extinction) addTo(row, volumes);
    }
    bool byValue() const { return m_integral.has_value(); }
    /// If a single volume, whose value alone counts, holds light back, its values do so more exactly than extinction.
    void classify(CellSlices& slices) const;
    std::size_t bytes() const;

  private:
    const ViewScene& m_scene;
    const CellGrid& m_grid;
    std::optional<ExtinctionIntegral> m_integral;  // of the only volume that has voxels, m_only
    std::size_t m_only = 0;
    std::vector<std::unique_ptr<const SurfaceCells>> m_cells;  // by volume; null: it is none
    std::vector<std::shared_ptr<const CellGrid>> m_grids;
    std::vector<SurfaceNormals> m_normals;  // in the cells of m_grids
};

}  // namespace scrim
