// SPDX-License-Identifier: Apache-2.0
// Which volumes share sheets. One lattice for all would have the smallest voxels' sheets and texels
// over the box around everything; so volumes of much larger voxels get coarser sheets of their own,
// and a picture costs about the sum of its volumes.
#pragma once

#include <scrim/scene/view_scene.h>

#include <string>
#include <vector>

namespace scrim {

/// Volumes with sheets of their own.
struct VolumeLevel {
    double voxel = 1;           ///< the unit of the dials, world units; those of two levels differ by a power of two
    std::vector<bool> volumes;  ///< for each of ViewScene::volumes; none are in a level between others
    std::vector<bool> around;   ///< volumes that its texels lie around
};

/// The levels of a scene, coarsest first. A scene of like voxels has one, and so has one with what
/// several levels do not serve.
std::vector<VolumeLevel> volumeLevels(const ViewScene& scene);
/// One level with all volumes.
std::vector<VolumeLevel> oneLevel(const ViewScene& scene);

/// The corners of the volumes that a level's texels lie around.
std::vector<Vec3> wsCorners(const ViewScene& scene, const VolumeLevel& level);

}  // namespace scrim
