// SPDX-License-Identifier: Apache-2.0
// What tests ask of fields that were read from files.
#pragma once

#include <scrim/guard/load_options.h>
#include <scrim/volume/block_index.h>
#include <scrim/volume/sparse_field.h>

#include <vector>

namespace scrim::test {

/// In this process, and in a child.
inline const std::vector<LoadOptions> kWays{{VolumeLoading::plain}, {VolumeLoading::guarded}};

/// The value of a voxel in a block; 0 elsewhere.
inline double valueAt(const SparseField& field, const Int3& at) {
    for (std::size_t b = 0; b < field.blockCount(); ++b) {
        const Int3 in = at - field.blockOrigins[b];
        if (in.x >= 0 && in.y >= 0 && in.z >= 0 && in.x < 8 && in.y < 8 && in.z < 8)
            return double(field.block(b)[blockOffset(in.x, in.y, in.z)]);
    }
    return 0;
}

}  // namespace scrim::test
