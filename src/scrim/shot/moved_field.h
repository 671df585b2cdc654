// SPDX-License-Identifier: Apache-2.0
// Moves fields by a velocity (semi-Lagrangian, backwards): at time t a field f becomes f(x - t v(x)). Where v varies
// strongly over a voxel, or where its grid ends before f has moved that far, the result is not where the smoke would
// be; see examples/guide/motion-blur.md.
#pragma once

#include <scrim/geometry/bounds.h>
#include <scrim/shot/derived_fields.h>

#include <memory>
#include <vector>

namespace scrim {

/// The velocity fields of a volume: for each of x, y and z the fields of positive and negative values (GridPart), in
/// asset space. The displacement is time * velocity, in world units of the asset.
struct FieldPath {
    std::vector<FieldPointer> parts;
    double time = 0;

    bool moves() const { return !parts.empty() && time != 0; }
    /// A box around all displacements, in world units of the asset.
    Bounds range() const;
};

class FieldMover {
  public:
    /// `weight`: the field whose mean displacement shifts all fields of the volume as a whole. Only the difference from
    /// that mean is resampled.
    FieldMover(FieldPath path, const SparseField& weight);
    ~FieldMover();

    /// The field after the time has passed. Its lattice is shifted by the mean displacement.
    FieldPointer operator()(const FieldPointer& field) const;

  private:
    struct Parts;
    FieldPath m_path;
    std::unique_ptr<const Parts> m_parts;
    Vec3 m_mean{0};
};

}  // namespace scrim
