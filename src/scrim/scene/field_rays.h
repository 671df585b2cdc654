// SPDX-License-Identifier: Apache-2.0
// Where a field has something, and how much of it a ray meets: enough to set up a camera and a density by,
// without the engine.
#pragma once

#include <scrim/geometry/bounds.h>
#include <scrim/volume/sparse_field.h>

#include <cstdint>
#include <map>
#include <unordered_map>

namespace scrim {

/// Box around the cells (centre +- half a voxel) of all voxels above 0, in index space; empty where there are
/// none.
Bounds isOccupied(const SparseField& field);

/// Integrates a field along rays, each voxel constant over its cell. Refers to the field it was made of.
class FieldRays {
  public:
    explicit FieldRays(const SparseField& field);

    /// The integral of the field over world-space length along the ray from `wsOrigin` along `wsDirection`,
    /// in steps of at most a voxel where the ray is not longer than some thousands of them.
    double integral(const Vec3& wsOrigin, const Vec3& wsDirection) const;

  private:
    double valueAt(const Vec3& isPoint) const;

    const SparseField* m_field;
    Bounds m_isBounds;
    Mat4 m_isFromWs{1.0};
    std::unordered_map<std::uint64_t, std::size_t> m_blocks;          ///< by origin
    std::map<int, std::unordered_map<std::uint64_t, float>> m_tiles;  ///< by edge, then by origin
};

}  // namespace scrim
