// SPDX-License-Identifier: Apache-2.0
// A scalar field as the splatter needs it: the active voxels of one grid in blocks of 8^3, and nothing else.
//
// OpenVDB's trees are read once, cleaned, and released: a flat list of leaves streams faster than a tree, passes easily
// from one process to another, and keeps OpenVDB's headers out of the engine. Memory is that of the grid's leaves. The
// grid is never densified: empty space has no entry, and each constant region above leaf level remains a single entry.
#pragma once

#include <scrim/geometry/bounds.h>
#include <scrim/geometry/spaces.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace scrim {

constexpr int kBlockEdge = 8;                                       ///< voxels along a block's edge
constexpr int kBlockVoxels = kBlockEdge * kBlockEdge * kBlockEdge;  ///< 512

/// Position of voxel (x, y, z), each in [0, 8), within a block: z runs fastest, as in OpenVDB's leaves.
constexpr int blockOffset(int x, int y, int z) {
    return (x * kBlockEdge + y) * kBlockEdge + z;
}

/// One active region of constant value above leaf level: the voxels origin .. origin + edge - 1 on each axis.
/// Origin and edge are multiples of 8.
struct ConstantTile {
    Int3 origin{0};
    std::int32_t edge = 0;
    float value = 0;
};

struct SparseField {
    std::string name;                ///< name of the grid, for messages
    Mat4 wsFromIs{1.0};              ///< affine, invertible; voxel centres at integers in index space
    std::vector<Int3> blockOrigins;  ///< multiples of 8, without repetitions, in ascending (x, y, z) order
    /// The 512 values of each block in `blockOffset` order: finite, not negative, 0 where a voxel is inactive. The
    /// pointer is shared because the memory may have been filled by another process.
    std::shared_ptr<const float> blockValues;
    std::vector<ConstantTile> tiles;  ///< with values > 0

    std::uint64_t activeVoxels = 0;  ///< leaf voxels and tile voxels with a value > 0
    std::uint64_t nonFinite = 0;     ///< active voxels that were NaN or infinite and count as 0
    std::uint64_t negative = 0;      ///< active voxels that were below 0 and count as 0
    float maxValue = 0;

    std::size_t blockCount() const { return blockOrigins.size(); }
    const float* block(std::size_t i) const { return blockValues.get() + i * kBlockVoxels; }
    bool empty() const { return activeVoxels == 0; }
    /// Memory of blocks and tiles, bytes.
    std::size_t bytes() const {
        return blockCount() * (kBlockVoxels * sizeof(float) + sizeof(Int3)) + tiles.size() * sizeof(ConstantTile);
    }

    /// Box around the centres of all voxels of blocks and tiles, in index space.
    Bounds isBounds() const {
        Bounds b;
        if (!blockOrigins.empty()) {
            Int3 lower = blockOrigins.front(), upper = lower;
            for (const Int3& o : blockOrigins) lower = glm::min(lower, o), upper = glm::max(upper, o);
            b = {Vec3(lower), Vec3(upper) + double(kBlockEdge - 1)};
        }
        for (const ConstantTile& t : tiles) {
            b.include(Vec3(t.origin));
            b.include(Vec3(t.origin) + double(t.edge - 1));
        }
        return b;
    }
};

/// The shape of a voxel's contribution to the space around it (ZC02 section 2).
enum class Kernel {
    linear,    ///< trilinear tent: an exact partition of unity, as in ray marchers
    gaussian,  ///< exp(-2 r^2) cut off at radius 2 voxels, ZC02's usual choice; ripples by about 1 %
    bspline,   ///< cubic B-spline: an exact and smooth partition of unity, which blurs
};

/// Half the edge of the box (index space, voxels) outside of which the kernel is 0.
inline double kernelRadius(Kernel kernel) {
    return kernel == Kernel::linear ? 1.0 : 2.0;
}

}  // namespace scrim
