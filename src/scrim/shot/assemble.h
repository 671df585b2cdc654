// SPDX-License-Identifier: Apache-2.0
// Assembles the scene that the engine renders from a scene and the fields that it names.
#pragma once

#include <scrim/scene/view_scene.h>
#include <scrim/volume/coarser.h>
#include <scrim/scene/scene.h>

#include <array>
#include <memory>
#include <optional>
#include <vector>

namespace scrim {

/// Lists of the points of a volume (PointRaster::list) for what voxels are in VolumeFields.
struct PointFields {
    std::array<std::shared_ptr<const SparseField>, 3> place, albedo;
    std::shared_ptr<const SparseField> radius, density;
    std::vector<std::shared_ptr<const SparseField>> emission, emissionMasks;  ///< empty ones: they are not of points
    std::vector<std::shared_ptr<const SparseField>> velocity;

    /// All of them, some of which may be null.
    std::vector<std::shared_ptr<const SparseField>> all() const;
};

/// The grids of one volume, each in its asset's own world space. A grid is null where the volume
/// shows nothing at this frame or does not need the grid.
struct VolumeFields {
    std::shared_ptr<const SparseField> density;
    std::array<std::shared_ptr<const SparseField>, 3> albedo;       ///< red, green and blue, where the albedo is a grid
    std::vector<std::shared_ptr<const SparseField>> emission = {};  ///< one for each of SceneVolume::emission
    std::vector<std::shared_ptr<const SparseField>> emissionMasks = {};  ///< likewise; null where it has no mask
    /// Where the volume moves while the shutter is open: for each of x, y and z the field of
    /// positive and the field of negative velocities (GridPart). Otherwise empty.
    std::vector<std::shared_ptr<const SparseField>> velocity = {};
    double time = 0;    ///< displacement = time * velocity
    double onward = 0;  ///< that until the next frame = onward * velocity
    /// Where the volume lies between two files: the fields of both that the others were made from, if they are kept.
    std::vector<std::shared_ptr<const SparseField>> sources = {};
    /// Why the picture has no use for the volume, which then may not be loaded; empty: it is used.
    std::string culled = {};
    /// Where shading is evaluated between voxels, too: the rest of the density, on finer voxels.
    /// Both have the ramp already. Null: there is no such detail.
    std::shared_ptr<const SparseField> finer = nullptr;
    std::shared_ptr<const PointFields> points = nullptr;  ///< null: the eye sees voxels
};

/// The volumes to assemble: those that the picture needs, or all of the scene, for a check of the
/// picture that must not rely on that selection.
enum class VolumesOf { picture, scene };

/// All pixels that a render of `scene` has, its overscan included.
PixelWindow pictureOf(const Scene& scene);

/// For each volume of `scene` why the picture has no use for it; empty where it may have.
/// `wsCorners` gives the corners of the volumes' boxes (see VolumeBox), where they are known.
std::vector<std::string> culledVolumes(const Scene& scene,
                                       const std::vector<std::optional<std::vector<Vec3>>>& wsCorners);

/// Places `out`, a volume of a view, where `volume` is after it was keyed, with its look: all but
/// what is derived from its grids. Its velocity is that of `fields`; null where nothing moves.
void place(const SceneVolume& volume, const VolumeFields& fields, ViewVolume& out);

/// The rest of a memory limit beside `bytes` that are derived from the volumes' grids; 0: no limit.
/// Throws Error(memory) where nothing is left.
std::size_t limitBeside(std::size_t limit, std::size_t bytes);

/// Takes from `view`, a view of `scene`, the volumes that the picture has no use for.
void cull(const Scene& scene, ViewScene& view);

/// `fields[i]` belongs to `scene.volumes[i]`. `crop` restricts the region to pixels of it (display window coordinates).
/// Ramps are applied, and coarser levels are built where the dial `lod` asks for them. Fields stay where the files have
/// them, beside the velocity that moves them. Fields that are derived from others count against `memoryLimit` (bytes);
/// throws Error(memory) where they exceed it.
/// `levels` keeps coarser levels for further views; null: they are made for this one.
ViewScene assemble(const Scene& scene, const std::vector<VolumeFields>& fields, const std::optional<PixelWindow>& crop,
                   std::size_t memoryLimit, VolumesOf volumesOf = VolumesOf::picture, CoarserLevels* levels = nullptr);

}  // namespace scrim
