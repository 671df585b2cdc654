// SPDX-License-Identifier: Apache-2.0
// Multiply scattered light: light that has scattered before it reaches a point and is scattered there towards the eye.
// The transport solver computes it as radiance in cells, which shading looks up like an environment that differs from
// place to place.
#pragma once

#include <scrim/base/simd.h>
#include <scrim/engine/model/plan.h>
#include <scrim/engine/transport/cell_field.h>
#include <scrim/engine/transport/solver.h>
#include <scrim/scene/view_scene.h>

#include <cstddef>
#include <functional>
#include <vector>

namespace scrim {

/// Solves for all of the plan's targets; returns one light for each, and volumes that scatter light only once have none
/// of it. Slides must be loaded. Adds the solves to `solved`, and the peak of the memory, in bytes, to `bytes`.
/// `checkpoint` is called between sweeps, and throws to stop. Throws Error(memory) if there are too many cells to
/// number.
std::vector<CellLight> scatteredLight(const ViewScene& scene, const TransportPlan& plan, Simd simd,
                                      const std::function<void()>& checkpoint, Solved& solved, std::size_t& bytes);

}  // namespace scrim
