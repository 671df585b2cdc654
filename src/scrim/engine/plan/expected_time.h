// SPDX-License-Identifier: Apache-2.0
// How long a render will take, from its plan alone. Good for choosing between settings of one scene (which takes how
// many times as long as which); in seconds it is as good as this machine is like the one it was fitted on.
#pragma once

#include <scrim/engine/plan/plan.h>

namespace scrim {

double expectedSeconds(const ViewScene& scene, const Plan& plan, int threads);

}  // namespace scrim
