// SPDX-License-Identifier: Apache-2.0
// A scene for an asset that comes without one: a camera that frames it, a key light, a fill, a rim light and a little
// ambient light, and a density that reads well. Written as the text of a scene, so that what is rendered, what
// `--print-scene` shows and what a user starts to edit are the same thing.
#pragma once

#include <scrim/geometry/spaces.h>
#include <scrim/volume/sparse_field.h>

#include <optional>
#include <string>

namespace scrim {

/// How an asset stands in its own world. Columns: right, up and back as whoever stands before it sees them.
Mat3 wsFromUpright(const Vec3& wsUp);

/// A grid of the asset that glows by its temperature.
struct FramedFire {
    std::string grid;
    const SparseField* field = nullptr;
    double hottest = 0;  ///< its largest value, in all frames that were looked at
};

/// What to show.
struct FramedAsset {
    std::string file;                    ///< a path or a sequence's pattern, as the scene is to name it
    std::string name = "volume";         ///< of the volume
    std::string grid = {};               ///< as `density.grid` of a scene takes it; "": let the reader choose
    const SparseField* field = nullptr;  ///< of that grid, in the asset's own world space
    std::optional<FramedFire> fire = {};
    std::string albedoGrid = {};  ///< of colours; "": none
    /// In place of the file, the density and the medium: what a volume of another kind says, ready to be put into the
    /// scene's text.
    std::string volumeText = {};
    Mat3 wsFromUpright{1};
};

/// The TOML text of a scene with one volume: a perspective camera three-quarter from the front, fitted to the voxels
/// that make up the volume (faintValue of field_rays.h); extinction such that half of the rays that meet it have an
/// optical depth above 3.5. Where it burns the extinction is less, the lights are dimmed, and the fire is as bright as
/// the picture takes. Where all is empty the camera frames the unit cube around the origin. Deterministic.
std::string framingScene(const FramedAsset& asset, Int2 resolution);

}  // namespace scrim
