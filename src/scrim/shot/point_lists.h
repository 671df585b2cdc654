// SPDX-License-Identifier: Apache-2.0
// What a volume needs of its grids, as requests: components of an albedo and a velocity, and lists of its points.
#pragma once

#include <scrim/scene/scene.h>
#include <scrim/shot/assemble.h>
#include <scrim/shot/shaded_field.h>
#include <scrim/volume/grid_request.h>

#include <array>
#include <functional>
#include <memory>
#include <vector>

namespace scrim {

GridRequest albedoRequest(const SceneVolume& volume, int component);

/// The requests for both fields of velocity component `axis`: values above 0 and values below 0.
std::array<GridRequest, 2> velocityRequests(const Velocity& velocity, int axis);

/// The requests for all lists of a volume's points; `moving`: those of velocities, too.
std::vector<GridRequest> pointRequests(const SceneVolume& volume, bool moving);

/// The lists that `listOf` has for these requests, of which the density is shaded; null where voxels show the points.
std::shared_ptr<const PointFields> pointFields(const SceneVolume& volume, bool moving, FieldShader& shader,
                                               const std::function<FieldPointer(const GridRequest&)>& listOf);

}  // namespace scrim
