// SPDX-License-Identifier: Apache-2.0
// The light on cells that a render computes before its sweeps: light that has scattered, and that
// of extended lights. Renders that differ in the camera alone, as those of a lens do, may share it.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/engine/lamps/cell_light.h>
#include <scrim/engine/model/frame.h>
#include <scrim/engine/model/plan.h>

#include <vector>

namespace scrim {

struct KeptLight {
    std::vector<CellLight> light;
    double scatterError = 0;       ///< as Frame has it
    bool scatterConverged = true;  ///< likewise
    RenderWork work;               ///< that it took
    double seconds = 0;            ///< likewise
};

/// The light on cells of `scene` that `plan` asks for. `progress` is asked between passes. Throws
/// Error: memory, interrupted.
KeptLight keepLight(const ViewScene& scene, const Plan& plan, const ProgressSink& progress = {});

/// Adds what the light took to a frame that shows it.
void account(const KeptLight& kept, Frame& frame);

/// True if the light of one scene serves the other: volumes, lights and solids are the same, both plans ask for the
/// same light, and either no medium scatters towards the eye otherwise than to all sides, or both eyes see each volume
/// from directions that are a tenth of its narrowest lobe apart at most. If many eyes lie evenly around the first
/// scene's, what they then miss is of the second order: at most 0.6 % of the light in the middle of a lobe.
bool lightServes(const ViewScene& scene, const Plan& plan, const ViewScene& other, const Plan& otherPlan);

}  // namespace scrim
