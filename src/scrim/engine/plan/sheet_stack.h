// SPDX-License-Identifier: Apache-2.0
// Where the sheets of a sweep lie; and before that, how the eye's frustum is cut up where it is too wide for one sweep.
// Every part is swept on its own; neighbours overlap with smooth weights that sum to one, because two sweeps differ by
// their errors and a hard edge would show them.
#pragma once

#include <scrim/engine/model/plan.h>
#include <scrim/scene/view_scene.h>

#include <vector>

namespace scrim {

/// The parts of a scene's eye: one, unless its rays to the volume open wider than 45 degrees from their middle. Does
/// not depend on a crop, whose pixels must come out as in the whole picture.
std::vector<EyePart> eyeParts(const ViewScene& scene, const std::vector<Vec3>& wsCorners);

/// The stack of sheets around the volumes' corners, across `wsAxis`, for rays that lean up to `slant` radians from it.
/// `voxel`: unit of the dials. Throws Error(render) where there are more sheets or texels than can be addressed.
Sheets sheetsAround(const ViewScene& scene, const std::vector<Vec3>& wsCorners, const Vec3& wsAxis, double slant,
                    double voxel);

}  // namespace scrim
