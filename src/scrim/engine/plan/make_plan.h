// SPDX-License-Identifier: Apache-2.0
// Makes the plan: everything that is decided before the first voxel is read. It depends only on the
// scene, so that `scrim plan` shows exactly what a render will do.
#pragma once

#include <scrim/engine/model/plan.h>
#include <scrim/base/messages.h>
#include <scrim/scene/view_scene.h>

namespace scrim {

/// Plans a render for `threads` threads. Throws Error: usage (a slide without its image), render (field of view too
/// wide, more sheets or texels than can be addressed), memory (the scene's memory limit is too small for one sheet and
/// light, or for the plan), interrupted (if `progress`, which is called now and then, and always with 0, asks for it).
/// `oneLattice`: all volumes share sheets, however unlike their voxels are (volumeLevels).
Plan makePlan(const ViewScene& scene, int threads, const ProgressSink& progress = {}, bool oneLattice = false);

/// Estimates how many seconds a render will take, from its plan alone. The estimate is meant for
/// choosing between settings of one scene, by the ratio of their times. The seconds themselves are
/// only right on a machine like the one that the estimate was fitted on.
double expectedSeconds(const ViewScene& scene, const Plan& plan, int threads);

}  // namespace scrim
