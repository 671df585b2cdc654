// SPDX-License-Identifier: Apache-2.0
// The narrowest cone around a set of directions. A sweep's axis is the axis of the cone around all rays that it serves;
// the half-way vector of ZC02 section 6 is the case of one parallel eye and one parallel light.
#pragma once

#include <scrim/geometry/spaces.h>

#include <cstddef>
#include <vector>

namespace scrim {

struct Cone {
    Vec3 axis{0, 0, 1};   ///< unit
    double cosAngle = 1;  ///< cosine of the half angle; <= 0 where no cone narrower than 90 degrees exists
};

/// The smallest cone with its apex at the origin that contains all `directions` (unit, at least
/// one). Exact up to rounding, and independent of their order up to rounding. Where the directions
/// do not fit into an open hemisphere, cosAngle is <= 0 and the axis is meaningless.
Cone enclosingCone(const std::vector<Vec3>& directions);

/// Those of `directions` that may touch a cone around them and any others: the corners of their
/// convex hull. All of them where they do not lie well within a hemisphere.
std::vector<Vec3> cornersOf(const std::vector<Vec3>& directions);

/// The cone around a growing set. Finding the cone with a few more directions takes a single pass
/// over the existing ones, and none where they cannot matter.
class GrowingCone {
  public:
    explicit GrowingCone(std::vector<Vec3> directions);

    const Cone& cone() const { return m_cone; }
    /// True if all of these directions lie within the cone.
    bool holds(const std::vector<Vec3>& directions) const;
    /// The cone around all directions and `more`. Where its half angle has a cosine below
    /// `cosMost`, any such cone may be returned instead.
    Cone with(const std::vector<Vec3>& more, double cosMost) const;
    void add(const std::vector<Vec3>& more);

  private:
    void findRim();

    std::vector<Vec3> m_directions;  // once there are many, those that cannot touch the cone are dropped
    std::size_t m_most;              // number of directions at which such directions are dropped next
    Cone m_cone;
    std::vector<Vec3> m_rim;  // the directions that touch the cone and determine it
};

}  // namespace scrim
