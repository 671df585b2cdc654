// SPDX-License-Identifier: Apache-2.0
// What is decided of light that scatters more than once, before any voxel is read.
#pragma once

#include <scrim/engine/model/plan.h>
#include <scrim/scene/view_scene.h>

#include <string>
#include <vector>

namespace scrim {

/// Gives those of `reasons` why lights are culled, one a light of the scene, that are of such skies.
void nameSkiesFromBorder(const ViewScene& scene, std::vector<std::string>& reasons);

/// "'sky': 43 % of its light comes from spots ..." for each sky whose light the plan's directions blur; ", " between.
/// Empty where none is.
std::string blurredSkies(const ViewScene& scene, const TransportPlan& plan);

/// Throws Error(memory) where cells of the dial's size are too many for the memory limit, or to be numbered.
TransportPlan planTransport(const ViewScene& scene);

}  // namespace scrim
