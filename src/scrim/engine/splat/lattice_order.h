// SPDX-License-Identifier: Apache-2.0
// The depth order of the voxels inside a block. A block is 8^3 voxels on a lattice and a grid has one affine
// map, so the 512 offsets from the block's origin, bucketed along the sweep's axis, serve every block of the grid:
// the voxels that touch a sheet are a contiguous range. This is what ZC02's bucket sort (Fig. 5, line 2) comes
// down to here: nothing per voxel, and no memory.
#pragma once

#include <scrim/geometry/spaces.h>
#include <scrim/volume/sparse_field.h>

#include <array>
#include <cstdint>
#include <vector>

namespace scrim {

class LatticeOrder {
  public:
    // Offsets from the block's first voxel in texel space, bucket by bucket in ascending floor(N). Within a
    // bucket neighbours in the list lie apart in (U, V): a voxel that adds to texels which the one before has
    // just written would wait for them.
    alignas(64) std::array<float, kBlockVoxels> offsetU;
    alignas(64) std::array<float, kBlockVoxels> offsetV;
    alignas(64) std::array<float, kBlockVoxels> offsetN;
    alignas(64) std::array<std::int32_t, kBlockVoxels> index;  ///< into a block's values

    explicit LatticeOrder(const Mat4& tsFromIs);

    /// Positions [first, second) that hold all voxels with lower < offsetN < upper, and perhaps some others of
    /// the same buckets.
    std::pair<int, int> between(double lower, double upper) const;

  private:
    int m_firstBucket = 0;           // floor(N) of the first bucket
    std::vector<int> m_bucketBegin;  // position of each bucket's first voxel, and the end
};

}  // namespace scrim
