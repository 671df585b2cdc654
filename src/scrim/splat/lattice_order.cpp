// SPDX-License-Identifier: Apache-2.0
#include <scrim/splat/lattice_order.h>

#include <algorithm>

namespace scrim {

LatticeOrder::LatticeOrder(const Mat4& tsFromIs) {
    struct Voxel {
        Vec3 ts;
        std::int32_t index;
    };
    std::array<Voxel, kBlockVoxels> voxels;
    for (int x = 0; x < kBlockEdge; ++x)
        for (int y = 0; y < kBlockEdge; ++y)
            for (int z = 0; z < kBlockEdge; ++z) {
                const int i = blockOffset(x, y, z);
                voxels[static_cast<std::size_t>(i)] = {transformVector(tsFromIs, Vec3(x, y, z)), i};
            }
    // Ties keep index order, so that the sum of footprints does not depend on the sort.
    std::stable_sort(voxels.begin(), voxels.end(),
                     [](const Voxel& a, const Voxel& b) { return a.ts.z < b.ts.z; });
    for (std::size_t k = 0; k < voxels.size(); ++k) {
        offsetU[k] = static_cast<float>(voxels[k].ts.x);
        offsetV[k] = static_cast<float>(voxels[k].ts.y);
        offsetN[k] = static_cast<float>(voxels[k].ts.z);
        index[k] = voxels[k].index;
    }
}

std::pair<int, int> LatticeOrder::between(float lower, float upper) const {
    const auto first = std::upper_bound(offsetN.begin(), offsetN.end(), lower);
    const auto last = std::lower_bound(first, offsetN.end(), upper);
    return {static_cast<int>(first - offsetN.begin()), static_cast<int>(last - offsetN.begin())};
}

}  // namespace scrim
