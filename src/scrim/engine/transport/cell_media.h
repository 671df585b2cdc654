// SPDX-License-Identifier: Apache-2.0
// What volumes are in cells: means of extinction, scattering and emission over each cell.
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/transport/cell_grid.h>
#include <scrim/engine/transport/split_phase.h>
#include <scrim/scene/view_scene.h>

#include <vector>

namespace scrim {

/// Volumes that scatter light the same way, and that the same lights shine on.
struct ScatterClass {
    Phase phase;
    SplitPhase split;          ///< of `phase`
    std::vector<bool> lights;  ///< for each light of the scene, does it light these volumes? Empty: all do
    std::vector<int> volumes;  ///< indices into ViewScene::volumes

    bool litBy(std::size_t light) const { return lights.empty() || lights[light]; }
};

/// Of the volumes whose medium scatters more than once, for a solve with `ordinates` directions.
std::vector<ScatterClass> scatterClasses(const ViewScene& scene, int ordinates);

/// One row of values a quantity, one value a cell of `grid`, per world unit. Light that scatters straight on counts as
/// not scattered: extinction and scattering are less by it.
struct CellMedia {
    using Row = std::vector<Real>;

    CellGrid grid;
    std::vector<Row> extinction;               ///< of one colour that stands for all, or of three
    std::vector<Row> straight;                 ///< what of extinction scatters straight on; none: nothing does
    std::vector<std::vector<Row>> scattering;  ///< [class][colour]
    std::vector<Row> emission;                 ///< radiance per world unit, of three colours; none: nothing glows

    const Row& extinctionOf(std::size_t colour) const { return extinction[extinction.size() == 1 ? 0 : colour]; }
    const Row& scatteringOf(std::size_t cls, std::size_t colour) const {
        return scattering[cls][scattering[cls].size() == 1 ? 0 : colour];
    }
    std::size_t bytes() const;
};

/// The boxes that cells must be there for: around each block of voxels of `scene`, with `margin` world units around.
std::vector<Bounds> cellBoxes(const ViewScene& scene, double margin);

/// All volumes of the scene in cells of `edge` world units. A voxel counts as a cube of constant value (where a volume
/// is turned, as the box around it along the world's axes), each cell gets its share of it, so that sums are kept.
/// Throws Error(memory) as CellGrid does.
CellMedia cellMedia(const ViewScene& scene, const std::vector<ScatterClass>& classes, double edge);

/// The means over 2^3 cells each.
CellMedia coarser(const CellMedia& fine);

/// Of rows on `fine`'s grid, the means on `coarse`, which CellGrid::coarser made of it.
CellMedia::Row coarserRow(const CellGrid& fine, const CellGrid& coarse, const CellMedia::Row& row);

/// Is extinction the same in all colours? And what is scattered of it?
bool greyExtinction(const ViewScene& scene);
bool greyScattering(const ViewScene& scene);

}  // namespace scrim
