// SPDX-License-Identifier: Apache-2.0
// Flat voxels, and the sheets that pilots' rays take a scene to have.
#pragma once

#include <scrim/scene/view_scene.h>
#include <scrim/verify/pilot_volume.h>

#include <vector>

namespace scrim {

/// The shortest edge of a volume's voxels, world units.
double shortestEdge(const ViewVolume& volume);

/// The longest edge of a volume's voxels over the shortest.
double flatness(const ViewVolume& volume);

/// True if a volume has voxels of more than 1 : 2.
bool anyFlat(const ViewScene& scene);

/// The sheets of the brightest light's sweep.
struct PilotSheets {
    Vec3 wsAxis;    ///< unit
    double across;  ///< how many times as long as the shortest edges of voxels the edges are that texels are for
};

/// Sheets lie half-way between eye and light, or along flat voxels (engine/plan/flat_voxels.h).
/// `lights`: of the pilots, brightest first. `wsCenter`: of all volumes.
PilotSheets pilotSheets(const ViewScene& scene, const std::vector<PilotLight>& lights, const Vec3& wsCenter);

/// True if sheets lie along flat voxels: such voxels cost no more than cubes.
bool sheetsAlongFlatVoxels(const ViewScene& scene);

}  // namespace scrim
