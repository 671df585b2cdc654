// SPDX-License-Identifier: Apache-2.0
// A scene for an asset that comes without one: a camera that frames it, a key light, a fill and a little
// ambient light, and a density that reads well. Written as the text of a scene, so that what is rendered,
// what
// `--print-scene` shows and what a user starts to edit are the same thing.
#pragma once

#include <scrim/geometry/spaces.h>
#include <scrim/volume/sparse_field.h>

#include <string>
#include <vector>

namespace scrim {

/// One grid of the asset to show.
struct FramedGrid {
    std::string grid;                    ///< as `density.grid` of a scene takes it; "": let the reader choose
    const SparseField* field = nullptr;  ///< in the asset's own world space
};

/// The TOML text of a scene with one volume a grid of `assetFile` (a path or a sequence's pattern, as the
/// scene is to name it): a perspective camera three-quarter from the front, y up, fitted to the voxels above
/// 0; extinction such that half of the rays that meet the volume have an optical depth above 3.5. Where all
/// grids are empty the camera frames the unit cube around the origin. Deterministic.
std::string framingScene(const std::string& assetFile, const std::vector<FramedGrid>& grids, Int2 resolution);

}  // namespace scrim
