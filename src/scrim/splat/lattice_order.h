// SPDX-License-Identifier: Apache-2.0
// The depth order of the voxels inside a block. A block is 8^3 voxels on a lattice and a grid has one affine
// map, so the 512 offsets from the block's origin, sorted along the sweep's axis, serve every block of the grid:
// the voxels that touch a sheet are a contiguous range. This is what ZC02's bucket sort (Fig. 5, line 2) comes
// down to here: nothing per voxel, and no memory.
#pragma once

#include <scrim/geometry/spaces.h>
#include <scrim/volume/sparse_field.h>

#include <array>
#include <cstdint>

namespace scrim {

struct LatticeOrder {
    // Offsets from the block's first voxel in texel space, ascending in N.
    alignas(64) std::array<float, kBlockVoxels> offsetU;
    alignas(64) std::array<float, kBlockVoxels> offsetV;
    alignas(64) std::array<float, kBlockVoxels> offsetN;
    alignas(64) std::array<std::int32_t, kBlockVoxels> index;  ///< into a block's values

    explicit LatticeOrder(const Mat4& tsFromIs);

    /// Positions [first, second) of the voxels with lower < offsetN < upper.
    std::pair<int, int> between(float lower, float upper) const;
};

}  // namespace scrim
