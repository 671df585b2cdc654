// SPDX-License-Identifier: Apache-2.0
// Moves fields by a velocity (semi-Lagrangian, backwards): at time t a field f becomes f(x - t
// v(x)). Where v varies strongly over a voxel, or where its grid ends before f has moved that far,
// the result is not where the smoke would be; see examples/guide/motion-blur.md.
#pragma once

#include <scrim/geometry/bounds.h>
#include <scrim/shot/derived_fields.h>

#include <memory>
#include <vector>

namespace scrim {

class VelocityParts;

/// The velocity of a volume, ready to move the volume's fields to any moment. Safe to use from many threads at once.
class FieldMover {
  public:
    /// `velocity`: for each of x, y and z the fields of positive and negative values (GridPart), in
    /// asset space. `weight`: the field whose mean velocity moves all fields of the volume as a
    /// whole. Only the difference from that mean is resampled.
    FieldMover(std::vector<FieldPointer> velocity, const SparseField& weight);
    ~FieldMover();

    /// The field when it has moved for `time`, with displacements of time * velocity in world units
    /// of the asset. Its lattice is shifted by the mean displacement.
    FieldPointer moved(const FieldPointer& field, double time) const;

  private:
    std::unique_ptr<const VelocityParts> m_parts;
    Vec3 m_mean{0};  // velocity
};

}  // namespace scrim
