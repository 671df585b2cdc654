// SPDX-License-Identifier: Apache-2.0
// Chooses larger cells for extended lights where the picture hardly shows them: beside a bright sun, or in volumes that
// are smaller than the cells were measured for.
#pragma once

#include <scrim/scene/view_scene.h>

#include <optional>

namespace scrim {

struct LightCellChoice {
    double cell = 0;      ///< dial light_cell, voxels of the volumes with the smallest cells
    double others = 1;    ///< dial light_cell_others
    double expected = 0;  ///< relative RMSE of the picture
};

/// Cells larger than those of the plan that should leave no more than `error`. No value: there are none, the scene
/// states the dial, or the light on the plan's cells takes less than `worthwhile` seconds on one thread, so that a
/// pilot would save little. Scenes with classified volumes or with full scattering keep theirs.
std::optional<LightCellChoice> largerLightCells(const ViewScene& scene, double error, double worthwhile = 0.5);

}  // namespace scrim
