// SPDX-License-Identifier: Apache-2.0
// Places the sheets of a sweep and the rasters of shadow buffers on them. Before that, divides the eye's frustum if it
// is too wide for one sweep. Every part is swept separately. Neighbouring parts overlap with smooth weights that sum to
// one, because two sweeps have different errors, which a hard edge would show.
#pragma once

#include <scrim/engine/model/plan.h>
#include <scrim/scene/view_scene.h>

#include <vector>

namespace scrim {

/// The parts of a scene's eye: one, unless its rays to the volume open wider than 45 degrees from
/// their middle. They do not depend on a crop, whose pixels must equal those of the whole picture.
std::vector<EyePart> eyeParts(const ViewScene& scene, const std::vector<Vec3>& wsCorners);

/// Edges of voxels, in world units: the units of the dials `sheet_thickness` and `texel`.
struct VoxelEdges {
    double through = 1;  ///< for the thickness of sheets
    double across = 1;   ///< for texels
};

/// The stack of sheets around the volumes' corners, perpendicular to `wsAxis`, for rays with a slant of up to `slant`
/// radians. Throws Error(render) if there are more sheets or texels than can be addressed.
Sheets sheetsAround(const ViewScene& scene, const std::vector<Vec3>& wsCorners, const Vec3& wsAxis, double slant,
                    const VoxelEdges& edges);

/// The part of a stack of sheets, with all of its sheets, whose texels lie around `wsCorners`.
Sheets narrowed(Sheets sheets, const std::vector<Vec3>& wsCorners);

/// How many times as large as `cell` the cells of a raster must be, to be at most 8,192 along a side of the extent.
double coarserFor(const Box2<double>& extent, double cell);

/// Completes a light of a group, which is `light`, by its view onto `sheets`. Where cells are largest they have the
/// size that the dial `shadow_texel` states, and there are as many as the rays that meet the volume need. With per-view
/// splatting the light also gets its own lattice (view_lattices.h), and errors are as there.
PlannedLight planLight(const ViewScene& scene, const Light& light, const std::vector<Vec3>& wsCorners,
                       const Sheets& sheets, double slant, PlannedLight planned);

}  // namespace scrim
