// SPDX-License-Identifier: Apache-2.0
// Makes a scene for an asset that comes without one: a camera that frames it, a key light, a fill light, a rim light, a
// little ambient light, and a density at which the volume reads well. The scene is written as text, so that the picture
// that is rendered, the output of `--print-scene` and the file that a user starts to edit all agree.
#pragma once

#include <scrim/geometry/spaces.h>
#include <scrim/volume/sparse_field.h>

#include <optional>
#include <string>

namespace scrim {

/// The rotation from an upright frame to the asset's world. Its columns are the right, up and back
/// directions of a viewer in front of the asset.
Mat3 wsFromUpright(const Vec3& wsUp);

/// A grid of temperatures by which the asset glows.
struct FramedFire {
    std::string grid;
    const SparseField* field = nullptr;
    double hottest = 0;  ///< the grid's largest value over all frames that were examined
};

/// The asset that a scene is made for.
struct FramedAsset {
    std::string file;                    ///< a path or a sequence's pattern, as the scene will name it
    std::string name = "volume";         ///< name of the volume
    std::string grid = {};               ///< value of the scene's `density.grid`; "": the reader chooses
    const SparseField* field = nullptr;  ///< field of that grid, in the asset's own world space
    std::optional<FramedFire> fire = {};
    std::string albedoGrid = {};  ///< name of a grid of colours; "": none
    /// TOML text of the volume that replaces the file, the density and the medium, for volumes that are not files.
    std::string volumeText = {};
    Mat3 wsFromUpright{1};
};

/// The TOML text of a scene with one volume. A perspective camera looks at it from three-quarter front and is fitted to
/// the voxels that make up the volume (faintValue of field_rays.h). Extinction is such that half of the rays that meet
/// the volume have an optical depth above 3.5. Where there is fire, the extinction is lower, the lights are dimmed, and
/// the fire is made as bright as the picture can hold. Voxels wider than four pixels are interpolated smoothly. If all
/// fields are empty, the camera frames the unit cube around the origin. The result is deterministic.
std::string framingScene(const FramedAsset& asset, Int2 resolution);

}  // namespace scrim
