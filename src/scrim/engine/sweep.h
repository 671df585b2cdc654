// SPDX-License-Identifier: Apache-2.0
// Renders one frame as planned: one sweep a group, and the sum of what they left in the pixels.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/engine/model/frame.h>
#include <scrim/engine/plan/make_plan.h>

namespace scrim {

/// Renders `scene` as `plan` (made from it) says. The picture covers scene.region. Bit-identical for every
/// number of threads. Touches no state of the process: any number of renders may be under way at once, each with the
/// threads and vector instructions of its own plan. `shown` hears of the picture after each batch of sheets. Throws
/// Error: memory, interrupted (where `progress` said so).
Frame render(const ViewScene& scene, const Plan& plan, const ProgressSink& progress = {},
             const PictureSink& shown = {});

}  // namespace scrim
