// SPDX-License-Identifier: Apache-2.0
// Culling of what a picture does not need: lights, volumes and parts of sheets that neither its pixels see nor light
// passes on the way there. The whole picture decides and not a crop, whose pixels must equal those of the whole.
#pragma once

#include <scrim/engine/model/plan.h>
#include <scrim/base/messages.h>
#include <scrim/geometry/box2.h>
#include <scrim/geometry/camera.h>
#include <scrim/geometry/sheets.h>
#include <scrim/image/image.h>
#include <scrim/scene/view_scene.h>

#include <optional>
#include <string>
#include <vector>

namespace scrim {

/// Points whose convex hull is the part that the pixels of `window`, and half a pixel around them,
/// show of a parallelepiped, which is given by its corners in the order of Bounds::corners(). Of
/// several, eight corners each, all such points. Empty if nothing is visible.
std::vector<Vec3> visibleParts(const Camera& camera, const PixelWindow& window, const std::vector<Vec3>& wsCorners);

/// For each of `lights` the reason why it is culled because it contributes nothing; empty if it may contribute.
std::vector<std::string> culledLights(const ViewScene& scene, const SubLights& lights);

/// A volume that may not be loaded yet.
struct VolumeBox {
    /// Eight corners for each field, in the order of Bounds::corners(). An empty vector: the volume
    /// is empty; no vector: its place is unknown.
    std::optional<std::vector<Vec3>> wsCorners;
    std::vector<bool> lights, shadows;  ///< as in ViewVolume
};

/// For each volume the reason why it is culled: it is out of view, and casts no shadow on anything
/// in view. Empty if it is not culled.
std::vector<std::string> culledVolumes(const Camera& camera, const PixelWindow& picture,
                                       const std::vector<Light>& lights, const std::vector<VolumeBox>& volumes);

/// `window`: the pixels of the sweep. `shadowed`: the lights of the sweep that cast shadows.
NeededTiles neededTiles(
    const ViewScene& scene, const PixelWindow& window, const Sheets& sheets, const std::vector<const Light*>& shadowed,
    const Checkpoint& checkpoint = [] {});

}  // namespace scrim
