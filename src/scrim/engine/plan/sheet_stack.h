// SPDX-License-Identifier: Apache-2.0
// Places the sheets of a sweep, and before that divides the eye's frustum if it is too wide for one sweep. Every part
// is swept separately. Neighbouring parts overlap with smooth weights that sum to one, because two sweeps have
// different errors, which a hard edge would show.
#pragma once

#include <scrim/engine/model/plan.h>
#include <scrim/scene/view_scene.h>

#include <vector>

namespace scrim {

/// The parts of a scene's eye: one, unless its rays to the volume open wider than 45 degrees from their middle. They do
/// not depend on a crop, whose pixels must equal those of the whole picture.
std::vector<EyePart> eyeParts(const ViewScene& scene, const std::vector<Vec3>& wsCorners);

/// The stack of sheets around the volumes' corners, perpendicular to `wsAxis`, for rays with a slant of up to `slant`
/// radians. `voxel`: unit of the dials. Throws Error(render) if there are more sheets or texels than can be addressed.
Sheets sheetsAround(const ViewScene& scene, const std::vector<Vec3>& wsCorners, const Vec3& wsAxis, double slant,
                    double voxel);

}  // namespace scrim
