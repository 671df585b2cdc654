// SPDX-License-Identifier: Apache-2.0
// The innermost loop of Scrim: splats the voxels of one block into some consecutive sheets. It is
// vectorised, and compiled once for every instruction set that the processor may have.
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/simd.h>
#include <scrim/engine/splat/footprint.h>
#include <scrim/geometry/spaces.h>
#include <scrim/volume/sparse_field.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace scrim {

/// The depth order of the voxels inside of a block. A block has 8^3 voxels on a lattice, and a grid has one affine map.
/// Therefore the 512 offsets from the block's origin, bucketed along the sweep's axis, serve every block of the grid,
/// and the voxels that touch a sheet are a contiguous range. This replaces ZC02's bucket sort (Fig. 5, line 2), without
/// work or memory for single voxels.
class LatticeOrder {
  public:
    // Offsets from the block's first voxel in texel space, bucket by bucket in ascending floor(N).
    // Within a bucket, neighbours in the list are far apart in (U, V), since a voxel that adds to
    // texels just written by the preceding voxel would have to wait for them.
    alignas(64) std::array<Real, kBlockVoxels> offsetU;
    alignas(64) std::array<Real, kBlockVoxels> offsetV;
    alignas(64) std::array<Real, kBlockVoxels> offsetN;
    alignas(64) std::array<std::int32_t, kBlockVoxels> index;  ///< into a block's values

    explicit LatticeOrder(const Mat4& tsFromIs);

    /// The positions [first, second) that contain all voxels with lower < offsetN < upper, and
    /// possibly others of the same buckets.
    std::pair<int, int> between(double lower, double upper) const;

  private:
    int m_firstBucket = 0;           // floor(N) of the first bucket
    std::vector<int> m_bucketBegin;  // position of each bucket's first voxel, and the end
};

/// How the blocks of a field are splatted.
struct BlockSplat {
    const LatticeOrder* order;
    const FootprintTable* table;  ///< geometry of the footprints
    const FootprintPieces* pieces;
    const std::ptrdiff_t* offsets;  ///< offsets of the pieces' kinds in these planes
    /// For each of up to kMost fields that share their footprints, the plane of sheet `firstSheet`.
    static constexpr int kMost = 4;
    std::array<Real*, kMost> planes;
    int fields;
    std::ptrdiff_t planeStride;  ///< floats from one sheet's plane to the next
    std::int32_t rowStride;      ///< floats from one row of texels to the next
    std::int32_t firstSheet;     ///< sheets [firstSheet, lastSheet) are written
    std::int32_t lastSheet;
    Real scale;                  ///< factor on every value
    Real most;                   ///< scaled values are clamped to this
    std::int32_t width, height;  ///< of the planes, in texels
    bool clipped;                ///< footprints may extend beyond the planes; those that do are culled
    Simd simd = {};
};

/// Adds the footprints of the voxels [first, second) of the lattice order to the sheets, for each field with `values`
/// (512 floats in `blockOffset` order) times scale, clamped to `most`. Voxels of value 0 are skipped. `ts`: the block's
/// first voxel in texel space. Returns the number of footprints (voxel and sheet pairs), which all fields share.
std::uint64_t splatBlock(const BlockSplat& splat, const Vec3& ts, const float* const* values, int first, int second);

}  // namespace scrim
