// SPDX-License-Identifier: Apache-2.0
// Where a field has something, and how much of it a ray meets: enough to set up a camera and a density by,
// without the engine.
#pragma once

#include <scrim/geometry/bounds.h>
#include <scrim/volume/field_sampler.h>

#include <vector>

namespace scrim {

/// Box around the cells (centre +- half a voxel) of all voxels above 0, in index space; empty where there are
/// none.
Bounds isOccupied(const SparseField& field);

/// Points, in index space, whose convex hull holds the cells of all voxels from `least` on (above 0): the corners of
/// what each block has of them, `reach` voxels further out.
std::vector<Vec3> isOutline(const SparseField& field, float least, double reach);

/// The value below which voxels hold next to nothing: a five-hundredth of the sum of all. At least half of the voxels
/// above 0 are above it.
float faintValue(const SparseField& field);

/// The largest value, but for outliers: where fewer than one voxel in 5,000 is more than four times as large as all
/// others, that of the others (up to a fifth more).
float usualMost(const SparseField& field);

/// Integrates a field along rays, each voxel constant over its cell. Refers to the field it was made of.
class FieldRays {
  public:
    explicit FieldRays(const SparseField& field);

    /// The integral of the field over world-space length along the ray from `wsOrigin` along `wsDirection`,
    /// in steps of at most a voxel where the ray is not longer than some thousands of them.
    double integral(const Vec3& wsOrigin, const Vec3& wsDirection) const;

    /// Of the voxel whose cell holds the point; 0 outside.
    double value(const Vec3& wsPoint) const { return m_sampler.nearest(transformPoint(m_isFromWs, wsPoint)); }

  private:
    FieldSampler m_sampler;
    Bounds m_isBounds;
    Mat4 m_isFromWs{1.0};
};

}  // namespace scrim
