// SPDX-License-Identifier: Apache-2.0
// What is decided of light that scatters more than once, before any voxel is read.
#pragma once

#include <scrim/engine/plan/outputs.h>
#include <scrim/scene/view_scene.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace scrim {

/// What is solved for at once, because it ends up in the same layer.
struct ScatterTarget {
    std::optional<Output> output;  ///< none: the beauty
    std::vector<int> lights;       ///< indices into ViewScene::lights
    bool ambient = false, emission = false;
};

struct TransportPlan {
    std::vector<ScatterTarget> targets;  ///< empty: nothing scatters light more than once
    double edge = 0;                     ///< of the finest cells, world units
    double cells = 0;                    ///< about so many of them
    int ordinates = 64;
    bool isotropic = true;
    bool coarse = false;    ///< cells are larger than is asked for, to see what that changes
    int colours = 1;        ///< solved for one by one
    std::size_t bytes = 0;  ///< at most, about

    bool any() const { return !targets.empty(); }
};

/// Is extinction the same in all colours? And what is scattered of it?
bool greyExtinction(const ViewScene& scene);
bool greyScattering(const ViewScene& scene);

/// Of all targets: indices into ViewScene::lights.
std::vector<int> lightsOf(const TransportPlan& plan);

/// Do skies shine into all that they light through the border of the cells, so that no sub-lights stand for them?
bool skiesFromBorder(const ViewScene& scene);

/// Gives those of `reasons` why lights are culled, one a light of the scene, that are of such skies.
void nameSkiesFromBorder(const ViewScene& scene, std::vector<std::string>& reasons);

/// "'sky': 43 % of its light comes from spots ..." for each sky whose light the plan's directions blur; ", " between.
/// Empty where none is.
std::string blurredSkies(const ViewScene& scene, const TransportPlan& plan);

/// Throws Error(memory) where cells of the dial's size are too many for the memory limit, or to be numbered.
TransportPlan planTransport(const ViewScene& scene);

}  // namespace scrim
