// SPDX-License-Identifier: Apache-2.0
// The dials of the moments that motion blur averages. A preset's dials leave room for scenes that are worse than most.
// Many renders pay for measuring the scene at hand, so that its moments get dials as coarse as the promise allows.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/scene/view_scene.h>
#include <scrim/verify/tolerance.h>

namespace scrim {

/// The error that texels and sheets leave in `moment`, from three small pictures of it. It does not
/// depend on crops, threads or memory. Throws Error.
ToleranceModel momentModel(const ViewScene& moment, const ProgressSink& progress = {});

/// The dials of `moment` with the texels and sheets that take the least time among those whose
/// error by `model` is at most `allowed` (relative RMSE), and none finer than they are.
Dials momentDials(const ViewScene& moment, const ToleranceModel& model, double allowed,
                  const ProgressSink& progress = {});

}  // namespace scrim
