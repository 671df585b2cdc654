// SPDX-License-Identifier: Apache-2.0
// Constant tiles as a few large voxels. What B-splines on voxels of edge 2 reconstruct, B-splines on voxels of edge 1
// reconstruct as well (their two-scale relation), so that the inside of a large constant region can be splatted by
// voxels of edge 2, 4, 8, ..., and what is missing towards its rim by smaller ones. The sum is the same field, but for
// rounding: a level set of radius 500 has 5 10^8 voxels, and needs 10^7 footprints.
#pragma once

#include <scrim/volume/sparse_field.h>

#include <array>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace scrim {

/// Some of a field's constant voxels, in an index space of its own: voxel i of level k stands at voxel 2^k i of the
/// field's.
struct TileLevel {
    /// Constant tiles, and blocks next to voxels of another level. Of the blocks it holds the origins alone.
    std::shared_ptr<const SparseField> field;
    std::vector<const float*> values;  ///< 512 of each block
};

class TileLevels {
  public:
    /// At most `levels` beside the field's own. None at all where no region is large enough: then the tiles have to be
    /// splatted as they are.
    /// `weights`: of the voxels 0, 1, ... away from a coarser one along an axis, with which their kernels add up to its
    /// kernel. Fewer than 4.
    TileLevels(const SparseField& field, std::span<const double> weights, int levels);
    TileLevels(TileLevels&&) = default;

    /// Level k is number k. Together they are the field's tiles.
    const std::vector<TileLevel>& levels() const { return m_levels; }

  private:
    using Block = std::array<float, kBlockVoxels>;
    class Split;

    std::vector<TileLevel> m_levels;
    // What a coarser level leaves of a block: the same for all that lie alike. By the value, and by how they lie.
    std::map<std::pair<float, int>, std::unique_ptr<const Block>> m_blocks;
};

}  // namespace scrim
