// SPDX-License-Identifier: Apache-2.0
// From a scene and the fields it names to what the engine renders.
#pragma once

#include <scrim/scene/view_scene.h>
#include <scrim/scene/scene.h>

#include <array>
#include <memory>
#include <optional>
#include <vector>

namespace scrim {

/// The grids of one volume, each in its asset's own world space; null where the volume shows nothing at this frame, or
/// needs none of it.
struct VolumeFields {
    std::shared_ptr<const SparseField> density;
    std::array<std::shared_ptr<const SparseField>, 3> albedo;       ///< red, green and blue, where the albedo is a grid
    std::vector<std::shared_ptr<const SparseField>> emission = {};  ///< one each of SceneVolume::emission
    /// Where the shutter sees it move: of x, y and z the parts above and below 0 (GridPart); else empty.
    std::vector<std::shared_ptr<const SparseField>> velocity = {};
    double time = 0;          ///< times the velocity is what they move by
    std::string culled = {};  ///< why the picture has no use for the volume; then it may not be loaded
};

/// Of a scene: those that the picture has a use for, or all, for a check of the picture that must not rely on which
/// those are.
enum class VolumesOf { picture, scene };

/// Of fields that a velocity moves: they are moved, to be rendered; or they keep their places and tell their velocity,
/// for the reference.
enum class Moved { byVoxels, byVelocity };

/// All pixels that a render of `scene` has, with its overscan.
PixelWindow pictureOf(const Scene& scene);

/// For each volume of `scene`, of which `wsCorners` tells the place (see VolumeBox), why the picture has no use for it;
/// empty where it may have.
std::vector<std::string> culledVolumes(const Scene& scene,
                                       const std::vector<std::optional<std::vector<Vec3>>>& wsCorners);

/// What moves the fields of a volume, for the reference; null where nothing does.
std::shared_ptr<const ViewVelocity> velocityOf(const SceneVolume& volume, const VolumeFields& fields);

/// `fields[i]` belongs to `scene.volumes[i]`. `crop` limits the region to pixels of it (display window coordinates).
/// Ramps are applied, and coarser levels built where the dial `lod` asks for them. Fields that are made of others come
/// out of `memoryLimit`; throws Error(memory) where they are more.
ViewScene assemble(const Scene& scene, const std::vector<VolumeFields>& fields, const std::optional<PixelWindow>& crop,
                   std::size_t memoryLimit, VolumesOf volumesOf = VolumesOf::picture, Moved moved = Moved::byVoxels);

}  // namespace scrim
