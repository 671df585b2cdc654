// SPDX-License-Identifier: Apache-2.0
// Fields that a velocity moves (semi-Lagrangian, backwards): at time t a field f is f(x - t v(x)). Where v varies much
// over a voxel, or reaches less far than f moves, that is not where the smoke would be; see
// examples/guide/motion-blur.md.
#pragma once

#include <scrim/geometry/bounds.h>
#include <scrim/shot/derived_fields.h>

#include <memory>
#include <vector>

namespace scrim {

/// Velocity fields of x, y and z: the parts above and below 0 (GridPart), asset space; and the time, so that what they
/// move by is time * velocity, in world units of the asset.
struct FieldPath {
    std::vector<FieldPointer> parts;
    double time = 0;

    bool moves() const { return !parts.empty() && time != 0; }
    /// Of what they move by, at most, in world units of the asset.
    Bounds range() const;
};

class FieldMover {
  public:
    /// `weight`: the field whose mean way all fields of the volume are shifted by as a whole; only what differs from it
    /// is sampled anew.
    FieldMover(FieldPath path, const SparseField& weight);
    ~FieldMover();

    /// `field` after the time. Its lattice is shifted by the mean way.
    FieldPointer operator()(const FieldPointer& field) const;

  private:
    struct Parts;
    FieldPath m_path;
    std::unique_ptr<const Parts> m_parts;
    Vec3 m_mean{0};
};

}  // namespace scrim
