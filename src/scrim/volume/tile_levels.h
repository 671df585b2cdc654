// SPDX-License-Identifier: Apache-2.0
// Represents constant tiles by a few large voxels. B-splines on voxels of edge 2 are sums of B-splines on voxels of
// edge 1 (the two-scale relation), so voxels of edge 2, 4, 8, ... can splat the inside of a large constant region, and
// smaller voxels add the remainder towards its rim. The sum is the same field up to rounding: a level set of radius 500
// has 5 10^8 voxels and needs 10^7 footprints.
#pragma once

#include <scrim/volume/sparse_field.h>

#include <array>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace scrim {

/// Some of a field's constant voxels in an index space of their own: voxel i of level k lies at
/// voxel 2^k i of the field.
struct TileLevel {
    /// Constant tiles, and blocks next to voxels of another level. Only the origins of the blocks are stored in it.
    std::shared_ptr<const SparseField> field;
    std::vector<const float*> values;  ///< pointer to the 512 values of each block
};

class TileLevels {
  public:
    /// Makes at most `levels` levels beside the field's own; none at all where no region is large
    /// enough, in which case the tiles must be splatted as they are. `weights`: the two-scale
    /// weights of voxels at distance 0, 1, ... from a coarser voxel along an axis; fewer than 4.
    TileLevels(const SparseField& field, std::span<const double> weights, int levels);
    TileLevels(TileLevels&&) = default;

    /// The levels; element k is level k. Their sum equals the field's tiles.
    const std::vector<TileLevel>& levels() const { return m_levels; }

  private:
    using Block = std::array<float, kBlockVoxels>;
    class Split;

    std::vector<TileLevel> m_levels;
    // The rest that a coarser level leaves of a block, shared by all blocks with the same value and
    // the same arrangement of coarser cubes; keyed by these two.
    std::map<std::pair<float, int>, std::unique_ptr<const Block>> m_blocks;
};

}  // namespace scrim
