// SPDX-License-Identifier: Apache-2.0
// What a render is expected to cost, so that nobody waits for an hour unawares.
#pragma once

#include <scrim/engine/model/plan.h>
#include <scrim/scene/view_scene.h>

#include <cstddef>
#include <string>

namespace scrim {

/// About how many pixels a box would cover, of which the picture may have only a part; many where the eye is in it.
double pixelsOf(const Camera& camera, const Bounds& ws);

/// The number of renders that the picture averages, for motion blur or depth of field.
int renderCount(const ViewScene& scene);

/// A rough time of the passes of lights on cells, seconds on one thread.
double cellLightSeconds(const ViewScene& scene, const CellLightPlan& plan);

/// A rough time of the whole picture, seconds: expectedSeconds with the solves of scattered light
/// and the passes of lights on cells, for all renders that the picture averages. Right within a
/// factor of three on a machine like the one that it was fitted on.
double roughPictureSeconds(const ViewScene& scene, const Plan& plan, int threads);

/// "the picture is expected to take about 25 minutes and 6.1 GB; ..." where that is more than anybody wants to wait for
/// or give without being asked; otherwise "". `fieldBytes`: memory of the volumes.
std::string costWarning(const ViewScene& scene, const Plan& plan, std::size_t fieldBytes, int threads);

}  // namespace scrim
