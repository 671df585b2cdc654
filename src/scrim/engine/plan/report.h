// SPDX-License-Identifier: Apache-2.0
// Describes a plan: as a table for people (`scrim plan`), and as JSON for programs and for the
// metadata of pictures. It is separate from plan.h because the JSON library is slow to compile.
#pragma once

#include <scrim/engine/plan/make_plan.h>

#include <string>

namespace scrim {

/// All of `plan`, made from `scene`, as one compact JSON object. Lengths in world units, angles in degrees.
std::string planAsJson(const ViewScene& scene, const Plan& plan);

/// The same as text of several lines, each with a newline.
std::string planAsTable(const ViewScene& scene, const Plan& plan);

}  // namespace scrim
