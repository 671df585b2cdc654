// SPDX-License-Identifier: Apache-2.0
// The decisions about multiply scattered light that are made before any voxel is read.
#pragma once

#include <scrim/engine/model/plan.h>
#include <scrim/engine/model/served_lights.h>
#include <scrim/scene/view_scene.h>

#include <string>
#include <vector>

namespace scrim {

/// Sets those of `reasons` (why each light of the scene has no sweep) that concern lights on cells,
/// and skies which shine through the border of the cells.
void nameLightsOnCells(const ViewScene& scene, const CellLightPlan& cells, const std::vector<ServedLight>& served,
                       std::vector<std::string>& reasons);

/// Chooses the lights that are kept on cells, and the cells.
CellLightPlan planCellLights(const ViewScene& scene);

/// The number of the level with the smallest cells. Some light must be on cells.
std::size_t finestLevel(const CellLightPlan& cells);

/// The edge of the smallest cells, in voxels of the volumes that they are for, as the dial
/// light_cell states it. Some light must be on cells.
double smallestCell(const ViewScene& scene, const CellLightPlan& cells);

/// The error of the light on surfaces that is left where cells are larger than they should be for
/// want of memory, relative to that light; 0 elsewhere.
double errorOfLargeCells(const ViewScene& scene, const CellLightPlan& cells);

/// "; 2 sets of media ..." where some volumes do not cast shadows in all lights on cells; otherwise empty.
std::string setsText(const ViewScene& scene, const CellLightPlan& cells);

/// "'sky': 43 % of its light comes from spots ..." for each sky whose light the plan's directions
/// blur, separated by ", "; empty if there is none.
std::string blurredSkies(const ViewScene& scene, const TransportPlan& plan);

/// Throws Error(memory) if cells of the dial's size exceed the memory limit, or cannot be numbered. `flux`: for
/// scatteredMoments with flux, for which cells keep all directions, whatever the phase functions.
TransportPlan planTransport(const ViewScene& scene, bool flux = false);

/// The plan of what the backdrop's surfaces get of light that scatters more than once
/// (VolumeShine); without targets if they get none.
TransportPlan planForBackdrop(const ViewScene& scene);

/// The largest optical depth of a voxel, above 0; where boxes of volumes overlap, of their sum.
double depthOfVoxel(const ViewScene& scene);

}  // namespace scrim
