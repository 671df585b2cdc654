// SPDX-License-Identifier: Apache-2.0
// Makes the balls that the eye sees of lists of points, as voxels of fields become those of a view:
// the same maps, at points in place of voxels.
#pragma once

#include <scrim/scene/scene.h>
#include <scrim/shot/assemble.h>

#include <memory>

namespace scrim {

/// True if nothing is done to the volume's grids that is not done to each voxel by itself. Then
/// points can be seen by themselves, unless the scene says that they are not to be.
bool canSeeBalls(const SceneVolume& volume);

/// The balls at rest; null where there are none, or a mask of the density is not of the points.
std::shared_ptr<const ViewBalls> ballsOf(const SceneVolume& volume, const PointFields& points);

/// `balls` as they are while a moment lasts that begins and ends with the volume as `at` has it,
/// and with velocities that have moved them for `time`.
std::shared_ptr<const ViewBalls> movedBalls(const ViewBalls& balls, const std::array<const SceneVolume*, 2>& at,
                                            const std::array<double, 2>& time);

}  // namespace scrim
