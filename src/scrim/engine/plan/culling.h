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

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace scrim {

/// The part of space that a picture shows.
class ViewFrustum {
  public:
    /// The space that the pixels of `window` show, including half a pixel around them.
    ViewFrustum(const Camera& camera, const PixelWindow& window);

    /// Points whose convex hull is the visible part of a parallelepiped, which is given by its corners in the order of
    /// Bounds::corners(). Empty if no part of it is visible.
    std::vector<Vec3> visiblePart(const std::array<Vec3, 8>& wsCorners) const;
    /// The same for several, eight corners each, in one list.
    std::vector<Vec3> visibleParts(const std::vector<Vec3>& wsCorners) const;

  private:
    struct Plane {
        Vec3 normal;  // points to the inside
        double offset;
        double side(const Vec3& ws) const;
    };
    std::vector<Plane> m_planes;
    std::vector<Vec3> m_corners;  // corners of the near plane, or the eye
};

/// For each light the reason why it is culled because it contributes nothing; empty if it may contribute.
std::vector<std::string> culledLights(const ViewScene& scene);

/// A volume that may not be loaded yet.
struct VolumeBox {
    /// Eight corners for each field, in the order of Bounds::corners(). An empty vector: the volume is empty; no
    /// vector: its place is unknown.
    std::optional<std::vector<Vec3>> wsCorners;
    std::vector<bool> lights;  ///< as in ViewVolume
};

/// For each volume the reason why it is culled: it is out of view, and casts no shadow on anything in view. Empty if it
/// is not culled.
std::vector<std::string> culledVolumes(const Camera& camera, const PixelWindow& picture,
                                       const std::vector<Light>& lights, const std::vector<VolumeBox>& volumes);

/// `window`: the pixels of the sweep. `shadowed`: the lights of the sweep that cast shadows.
NeededTiles neededTiles(
    const ViewScene& scene, const PixelWindow& window, const Sheets& sheets, const std::vector<const Light*>& shadowed,
    const Checkpoint& checkpoint = [] {});

}  // namespace scrim
