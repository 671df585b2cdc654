// SPDX-License-Identifier: Apache-2.0
// What a picture has no use for: lights, volumes and parts of sheets that neither its pixels see nor light passes on
// its way there. Judged by the whole picture and not by a crop, whose pixels must come out as in the whole.
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
    /// What the pixels of `window` show, half a pixel around them included.
    ViewFrustum(const Camera& camera, const PixelWindow& window);

    /// Points whose convex hull is the visible part of a parallelepiped, given by its corners in the order of
    /// Bounds::corners(). None where nothing of it is visible.
    std::vector<Vec3> visiblePart(const std::array<Vec3, 8>& wsCorners) const;
    /// The same of several, eight corners each, in one list.
    std::vector<Vec3> visibleParts(const std::vector<Vec3>& wsCorners) const;

  private:
    struct Plane {
        Vec3 normal;  // towards the inside
        double offset;
        double side(const Vec3& ws) const;
    };
    std::vector<Plane> m_planes;
    std::vector<Vec3> m_corners;  // of the near plane, or the eye
};

/// For each light why it is culled: it contributes nothing. Empty where it may contribute.
std::vector<std::string> culledLights(const ViewScene& scene);

/// A volume that is perhaps not loaded yet.
struct VolumeBox {
    /// Eight a field, in the order of Bounds::corners(); none: nothing is there; no vector: nobody knows.
    std::optional<std::vector<Vec3>> wsCorners;
    std::vector<bool> lights;  ///< as ViewVolume has them
};

/// For each volume why it is culled: it is out of view, and throws no shadow on what is in view. Empty where it is not.
std::vector<std::string> culledVolumes(const Camera& camera, const PixelWindow& picture,
                                       const std::vector<Light>& lights, const std::vector<VolumeBox>& volumes);

/// `window`: the pixels of the sweep. `lights`: of the sweep, those that throw shadows.
NeededTiles neededTiles(
    const ViewScene& scene, const PixelWindow& window, const Sheets& sheets, const std::vector<const Light*>& shadowed,
    const Checkpoint& checkpoint = [] {});

}  // namespace scrim
