// SPDX-License-Identifier: Apache-2.0
// Volumes in cells: means of extinction, scattering and emission over each cell.
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/simd.h>
#include <scrim/engine/cells/cell_grid.h>
#include <scrim/engine/cells/ordinates.h>
#include <scrim/scene/view_scene.h>

#include <algorithm>
#include <functional>
#include <vector>

namespace scrim {

/// Volumes that scatter light in the same way and are lit by the same lights.
struct ScatterClass {
    Phase phase;
    /// Light scatters once in these volumes, which are not scattersFully: on its way between
    /// lights, volumes that scatter fully, and the eye.
    bool once = false;
    SplitPhase split;          ///< of `phase`
    std::vector<bool> lights;  ///< for each light of the scene, whether it lights these volumes; empty: all do
    std::vector<int> volumes;  ///< indices into ViewScene::volumes

    bool litBy(std::size_t light) const { return scrim::litBy(lights, light); }
    /// The moments by which light from lights is scattered, and the part of the scattering that counts as none.
    const std::vector<double>& first() const { return once ? split.whole() : split.first(); }
    double straight() const { return once ? 0 : split.straight(); }
};

/// Indices of those volumes that `wanted` holds for, by class: those of one scatter in the same way
/// and are lit by the same lights.
std::vector<std::vector<int>> alikeVolumes(const ViewScene& scene,
                                           const std::function<bool(const ViewVolume&)>& wanted);

/// The classes of the volumes that scatter light more than once, for a solve with `ordinates`
/// directions, and after them those of all other media, if there are any of the first.
std::vector<ScatterClass> scatterClasses(const ViewScene& scene, int ordinates);

/// Rows of values, one value for each cell of `grid`, per world unit. Light that scatters straight
/// on counts as not scattered; extinction and scattering are reduced accordingly.
struct CellMedia {
    CellGrid grid;
    std::vector<std::vector<Real>> extinction;  ///< for one colour that represents all, or for three
    std::vector<std::vector<Real>> straight;    ///< the part of extinction that scatters straight on; empty: none
    std::vector<std::vector<std::vector<Real>>> scattering;  ///< [class][colour]
    std::vector<std::vector<Real>> emission;  ///< radiance per world unit, for three colours; empty: nothing glows

    const std::vector<Real>& extinctionOf(std::size_t colour) const {
        return extinction[extinction.size() == 1 ? 0 : colour];
    }
    const std::vector<Real>& scatteringOf(std::size_t cls, std::size_t colour) const {
        return scattering[cls][scattering[cls].size() == 1 ? 0 : colour];
    }
    /// True if the cell scatters light, or glows.
    bool sends(std::size_t cell) const {
        const auto any = [&](const auto& rows) {
            return std::any_of(rows.begin(), rows.end(), [&](const std::vector<Real>& row) { return row[cell] > 0; });
        };
        return any(emission) || std::any_of(scattering.begin(), scattering.end(), any);
    }
    std::size_t bytes() const;
};

/// For each volume of the scene, whether it has voxels.
inline std::vector<bool> withVoxels(const ViewScene& scene) {
    std::vector<bool> all;
    for (const ViewVolume& volume : scene.volumes) all.push_back(!volume.field->empty());
    return all;
}
/// For each volume of the scene, whether it holds back the light of light `light`.
inline std::vector<bool> castersIn(const ViewScene& scene, std::size_t light) {
    std::vector<bool> casters;
    for (const ViewVolume& volume : scene.volumes)
        casters.push_back(scene.lights[light].shadows && !volume.field->empty() && litBy(volume.shadows, light));
    return casters;
}
inline bool isHeldBack(const ViewScene& scene, std::size_t light) {
    const std::vector<bool> casters = castersIn(scene, light);
    return std::find(casters.begin(), casters.end(), true) != casters.end();
}
/// Whether solids block the light of light `light`.
inline bool isBlocked(const ViewScene& scene, std::size_t light) {
    return scene.lights[light].shadows && solidsBlock(scene);
}

/// The corner at which cells begin. It is a corner of a voxel, so that cells of one voxel are the voxels, and their
/// centres are where the field's values are. If cells are smaller, one in each voxel has its centre there, so that what
/// is interpolated between cells has the field's own kinks.
inline Vec3 cornerOfVoxels(const ViewScene& scene, double edge) {
    for (const ViewVolume& volume : scene.volumes)
        if (!volume.field->empty())
            return transformPoint(volume.wsFromIs, Vec3(0)) - 0.5 * std::min(edge, voxelUnit(scene));
    return Vec3(0);
}

/// The boxes that cells must cover: around each block of voxels of `scene`, with a margin of `margin` world units.
std::vector<Bounds> cellBoxes(const ViewScene& scene, double margin);

/// World units by which kernels that are wider than linear ones reach beyond the cubes of their voxels; 0: none does.
double reachOfWideKernels(const ViewScene& scene);

/// Where cells are, and what is in them.
struct CellPlaces {
    Vec3 wsCorner{0};   ///< a cell has a corner there
    double margin = 0;  ///< world units that cells reach beyond the blocks of voxels; at least one edge
    /// Solids that stop light stand in the grid, whose cells then also reach those that send light
    /// back, up to half of the volumes' size beyond these.
    bool walls = false;
    /// For each volume of the scene, whether its values are added to the cells (castersIn); empty:
    /// all are. The grid does not depend on it.
    std::vector<bool> dense = {};
    std::vector<Bounds> more = {};  ///< world boxes that cells cover, too
    /// For each volume of the scene, whether cells cover it; empty: all.
    std::vector<bool> covered = {};
};

/// The cells of `edge` world units at these places.
CellGrid cellGrid(const ViewScene& scene, double edge, const CellPlaces& places);

/// All volumes of the scene in cells of `edge` world units. A voxel counts as a cube of constant value, and each cell
/// gets its share, so that sums are preserved. In cells smaller than voxels that reach as far as kernels do, and of
/// turned volumes, cells have means of the interpolated field. Turned volumes with voxels much smaller than cells, and
/// classified ones, are deposited as boxes along the world's axes.
/// Throws Error(memory) as CellGrid does.
CellMedia cellMedia(const ViewScene& scene, const std::vector<ScatterClass>& classes, double edge, Simd simd,
                    const CellPlaces& places = {});

/// Adds to media those of larger cells, interpolated linearly between the centres of these. Both
/// are of the same classes.
void addLarger(CellMedia& media, const CellMedia& larger);

/// Subtracts the light that scatters straight on from extinction and scattering, by how `classes` split it.
void goStraight(CellMedia& media, const std::vector<ScatterClass>& classes);

/// The media in cells twice as large: means over 2^3 cells each.
CellMedia coarser(const CellMedia& fine);

/// Adds to the rows of the finer cells, `values` numbers each, the values of the coarser cells (CellGrid::coarser)
/// there, interpolated linearly between their centres. `coarseRows` and `fineRows` hold the number of each cell's row
/// in `from` and `to`; cells with the number -1 have none and do not count.
void addInterpolated(const CellGrid& coarse, const std::vector<std::int32_t>& coarseRows, const std::vector<Real>& from,
                     const CellGrid& fine, const std::vector<std::int32_t>& fineRows, std::size_t values,
                     std::vector<Real>& to);

}  // namespace scrim
