// SPDX-License-Identifier: Apache-2.0
// The part of space that a picture shows.
#pragma once

#include <scrim/geometry/bounds.h>
#include <scrim/geometry/camera.h>
#include <scrim/image/image.h>

#include <array>
#include <vector>

namespace scrim {

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

}  // namespace scrim
