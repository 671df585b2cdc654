// SPDX-License-Identifier: Apache-2.0
// The sheets' algorithm once more, in double precision, plainly and slowly: what a picture would be if floats did not
// round. Same plan, same sheets and texels, same footprint table, the same look-ups; no tiles, no vectors, no threads.
#pragma once

#include <scrim/engine/plan/plan.h>

#include <array>
#include <vector>

namespace scrim::test {

/// Premultiplied RGBA, row by row. Only for what it was written for: parallel rays (an orthographic camera, distant
/// lights without slides), media without tiles, shared sheets shaded at texels, one ray a pixel, no opacity cut-off.
std::vector<std::array<double, 4>> renderInDouble(const ViewScene& scene, const Plan& plan);

}  // namespace scrim::test
