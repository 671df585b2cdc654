// SPDX-License-Identifier: Apache-2.0
// Sheets for flat voxels. Texels as fine as the short edges of voxels resolve flat ones in every direction, but only
// across that edge is there anything so fine. Where sheets lie along flat voxels, only their thickness must follow the
// short edge, and a grid costs the same whatever the ratio of its voxels' edges is.
#pragma once

#include <scrim/engine/plan/levels.h>

#include <optional>
#include <vector>

namespace scrim {

/// The edge, in world units, which texels of sheets perpendicular to `wsAxis` (unit) must resolve
/// for a level's volumes: the smallest distance, within a sheet, between neighbouring voxels'
/// borders. It is level.voxel unless it is much larger.
double edgeAcross(const ViewScene& scene, const VolumeLevel& level, const Vec3& wsAxis);

/// Sheets along flat voxels, as a sweep has them.
struct FlatSheets {
    Vec3 wsAxis;    ///< unit; towards the side to which light runs, or the eye looks where there is none
    bool sameSide;  ///< GroupPlan::sameSide
    double slant;   ///< largest angle of a ray to the axis, radians
    double across;  ///< edgeAcross, in units of the dials
};

/// The flat voxels of a scene's finest level, if it has any.
class FlatVoxels {
  public:
    /// `scene` must outlive this object.
    explicit FlatVoxels(const ViewScene& scene);

    /// Sheets along them, where all rays cross these and where they have far fewer texels than sheets half-way between
    /// eye and light. `wsEye`, `wsLight`: directions around the rays of the eye and of a light; none: of no light.
    std::optional<FlatSheets> sheets(const std::vector<Vec3>& wsEye, const std::vector<Vec3>& wsLight) const;

  private:
    const ViewScene& m_scene;
    VolumeLevel m_finest;
    std::vector<Vec3> m_corners;   // of its volumes
    std::optional<Vec3> m_across;  // unit axis across the flattest voxels
    double m_ratio = 1;            // of their second edge to the shortest one
};

}  // namespace scrim
