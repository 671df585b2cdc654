// SPDX-License-Identifier: Apache-2.0
// The plan: everything that is decided before the first voxel is read. A pure function of the scene, so that
// `scrim plan` shows exactly what a render will do.
#pragma once

#include <scrim/engine/model/plan.h>
#include <scrim/base/messages.h>
#include <scrim/scene/view_scene.h>

namespace scrim {

ExtinctionChannels extinctionChannels(const ViewScene& scene);

/// Plans a render for `threads` threads. Throws Error: usage (a slide without its image), render (field of view too
/// wide, more sheets or texels than can be addressed), memory (not one sheet and light fits the scene's memory limit,
/// or not the plan), interrupted (where `progress`, which is asked now and then, and always with 0, wished it).
Plan makePlan(const ViewScene& scene, int threads, const ProgressSink& progress = {});

/// How long a render will take, from its plan alone. Good for choosing between settings of one scene (which takes how
/// many times as long as which); in seconds it is as good as this machine is like the one it was fitted on.
double expectedSeconds(const ViewScene& scene, const Plan& plan, int threads);

}  // namespace scrim
