// SPDX-License-Identifier: Apache-2.0
// The narrowest cone around a set of directions. A sweep's axis is the axis of the cone around all rays it
// serves (ZC02 section 6's half-way vector is the case of one parallel eye and one parallel light).
#pragma once

#include <scrim/geometry/spaces.h>

#include <cstddef>
#include <vector>

namespace scrim {

struct Cone {
    Vec3 axis{0, 0, 1};   ///< unit
    double cosAngle = 1;  ///< cosine of the half angle; <= 0 where no cone narrower than 90 degrees exists
};

/// The smallest cone with its apex at the origin that holds all `directions` (unit, at least one). Exact up to
/// rounding, and independent of their order up to rounding. Where the directions do not fit into an open
/// hemisphere, cosAngle is <= 0 and the axis is of no use.
Cone enclosingCone(const std::vector<Vec3>& directions);

/// Those of `directions` that a cone around all of them and any others may touch: the corners of their convex hull. All
/// of them where they do not lie well within a hemisphere.
std::vector<Vec3> cornersOf(const std::vector<Vec3>& directions);

/// The cone around a set that grows: asking what it would be with a few directions more takes one look at those that
/// are there, and none where they cannot matter.
class GrowingCone {
  public:
    explicit GrowingCone(std::vector<Vec3> directions);

    const Cone& cone() const { return m_cone; }
    /// Do all of these lie within the cone?
    bool holds(const std::vector<Vec3>& directions) const;
    /// The cone around all directions and `more`. Where it is wider than `cosMost` says, any cone that is.
    Cone with(const std::vector<Vec3>& more, double cosMost) const;
    void add(const std::vector<Vec3>& more);

  private:
    void findRim();

    std::vector<Vec3> m_directions;  // without those that cannot touch the cone, once there are many
    std::size_t m_most;              // that there may be until they are looked through again
    Cone m_cone;
    std::vector<Vec3> m_rim;  // directions that touch the cone and fix it
};

}  // namespace scrim
