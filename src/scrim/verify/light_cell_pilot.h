// SPDX-License-Identifier: Apache-2.0
// Chooses larger cells for extended lights where the picture hardly shows them: beside a bright sun, or in volumes that
// are smaller than the cells were measured for. And smaller ones where volumes of unlike voxels share the light of a
// lamp, and the shadow of one has detail that the cells of the other miss.
#pragma once

#include <scrim/scene/view_scene.h>

#include <optional>

namespace scrim {

struct LightCellChoice {
    double cell = 0;      ///< dial light_cell, voxels of the volumes with the smallest cells
    double others = 1;    ///< dial light_cell_others
    double expected = 0;  ///< relative RMSE of the picture
};

/// Cells larger than those of the plan that should leave no more than `error`, or smaller ones where those leave more
/// than twice that; if even the smallest that are worth their time do, `expected` is larger. No value: the plan's serve
/// best, the scene states the dials, or there is one level of cells whose light takes less than `worthwhile` seconds on
/// one thread, so that a pilot would save little. Scenes with classified volumes or with full scattering keep theirs.
std::optional<LightCellChoice> chosenLightCells(const ViewScene& scene, double error, double worthwhile = 0.5);

}  // namespace scrim
