// SPDX-License-Identifier: Apache-2.0
// A plan in words: as a table for people (`scrim plan`), as JSON for programs and for the metadata of
// pictures. Apart from plan.h, because the JSON library is slow to compile.
#pragma once

#include <scrim/engine/plan/make_plan.h>

#include <string>

namespace scrim {

/// All of `plan`, made from `scene`, as one compact JSON object. Lengths in world units, angles in degrees.
std::string planAsJson(const ViewScene& scene, const Plan& plan);

/// The same to read, several lines, each with a newline.
std::string planAsTable(const ViewScene& scene, const Plan& plan);

}  // namespace scrim
