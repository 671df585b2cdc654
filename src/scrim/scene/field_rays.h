// SPDX-License-Identifier: Apache-2.0
// Where a field has values and how much of it a ray meets. This is all that is needed to place a
// camera and to choose a density, and it does without the engine.
#pragma once

#include <scrim/geometry/bounds.h>
#include <scrim/volume/field_sampler.h>

#include <vector>

namespace scrim {

/// Index-space box around the cells (centre +- half a voxel) of all voxels above 0; empty where there are none.
Bounds isOccupied(const SparseField& field);

/// Points, in index space, whose convex hull contains the cells of all voxels of at least `least`
/// and above 0. They are the corners of a box for each block, enlarged by `reach` voxels.
std::vector<Vec3> isOutline(const SparseField& field, float least, double reach);

/// Voxels that show nothing beside the others, as simulations leave them around their smoke.
struct Negligible {
    float below = 0;  ///< a ten-thousandth of the value above which half of the field's sum lies
    double part = 0;  ///< fraction of the voxels above 0 that are below it
};
Negligible negligibleIn(const SparseField& field);

/// A value below which voxels hold next to nothing: at most a five-hundredth of the sum of all
/// values. At least half of the voxels that are not negligible are above it.
float faintValue(const SparseField& field);

/// The field's largest value without outliers: if fewer than one voxel in 5,000 exceeds all others
/// more than fourfold, the result is the largest of the others (rounded up by at most a fifth).
float usualMost(const SparseField& field);

/// Integrates a field along rays; each voxel is constant over its cell. It refers to the field, which must outlive it.
class FieldRays {
  public:
    explicit FieldRays(const SparseField& field);

    /// The integral of the field over world-space length along the ray from `wsOrigin` along `wsDirection`. Steps are
    /// at most one voxel long unless the ray crosses more than some thousands of voxels.
    double integral(const Vec3& wsOrigin, const Vec3& wsDirection) const;

    /// The value of the voxel whose cell contains the point; 0 outside of all.
    double value(const Vec3& wsPoint) const { return m_sampler.nearest(transformPoint(m_isFromWs, wsPoint)); }

  private:
    FieldSampler m_sampler;
    Bounds m_isBounds;
    Mat4 m_isFromWs{1.0};
};

}  // namespace scrim
