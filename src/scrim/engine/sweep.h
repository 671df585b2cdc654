// SPDX-License-Identifier: Apache-2.0
// Renders one frame as planned: one sweep for each group, and the sum of their results in the pixels.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/engine/kept_light.h>
#include <scrim/engine/model/frame.h>
#include <scrim/engine/plan/make_plan.h>

namespace scrim {

/// Renders `scene` by `plan`, which was made from it. The picture covers scene.region. The result is bit-identical for
/// every number of threads. There is no global state: any number of renders may run at once, each with the threads and
/// vector instructions of its own plan. `shown` receives the picture after each batch of sheets. `kept`: light on cells
/// that serves this scene (lightServes), whose cost is accounted for elsewhere; null: it is computed here. Throws
/// Error: memory, interrupted (if `progress` asks for it).
Frame render(const ViewScene& scene, const Plan& plan, const ProgressSink& progress = {}, const PictureSink& shown = {},
             const KeptLight* kept = nullptr);

}  // namespace scrim
