// SPDX-License-Identifier: Apache-2.0
// Multiply scattered light: light that has scattered before it reaches a point and is scattered
// there towards the eye. The transport solver computes it as radiance in cells, which shading looks
// up like an environment that differs from place to place.
#pragma once

#include <scrim/base/simd.h>
#include <scrim/engine/model/plan.h>
#include <scrim/engine/lamps/cell_light.h>
#include <scrim/engine/solve/solver.h>
#include <scrim/scene/view_scene.h>

#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace scrim {

/// True if some classified volume that scatters light more than once has surfaces, in which a voxel has an optical
/// depth of more than one: light enters them within a cell, so that the error of cells is of first order.
bool scattersInSurfaces(const ViewScene& scene);

/// The number of solves for all of the plan's targets.
std::size_t solvesOf(const ViewScene& scene, const TransportPlan& plan);

/// Solves for all of the plan's targets; returns one light for each, and volumes that scatter light
/// only once have none of it. Slides must be loaded. Adds the solves to `solved`, and the peak of
/// the memory, in bytes, to `bytes`. `checkpoint` is called between sweeps, and throws to stop.
/// Throws Error(memory) if there are too many cells to number.
std::vector<CellLight> scatteredLight(const ViewScene& scene, const TransportPlan& plan, Simd simd,
                                      const std::function<void()>& checkpoint, Solved& solved, std::size_t& bytes);

/// The same light for no eye: the lights are the mean of radiance over all directions. The second part, if `flux` is
/// true, is the vector flux of the light that has scattered before, over 4 pi: the mean of radiance times direction of
/// travel in world space, a field of red, green and blue for each of x, y and z. It is no longer than the mean, and the
/// same for all volumes that scatter light more than once.
std::pair<std::vector<CellLight>, std::array<std::shared_ptr<CellField>, 3>> scatteredMoments(
    const ViewScene& scene, const TransportPlan& plan, bool flux, Simd simd, const std::function<void()>& checkpoint,
    Solved& solved);

}  // namespace scrim
