// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/lattice_order.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace scrim {
namespace {

struct Voxel {
    Vec3 ts;
    std::int32_t index;
    int bucket;   // floor of N
    int turn;     // which round through the quarters it is taken in
    int quarter;  // of the block's extent in (U, V)
};

// Deals the voxels of each bucket out in turns, one from each quarter of the block's extent in (U, V).
void dealOut(std::array<Voxel, kBlockVoxels>& voxels) {
    Vec3 middle(0);
    for (const Voxel& v : voxels) middle += v.ts / double(kBlockVoxels);
    for (auto first = voxels.begin(); first != voxels.end();) {
        const auto last = std::find_if(first, voxels.end(), [&](const Voxel& v) { return v.bucket != first->bucket; });
        int dealt[4] = {0, 0, 0, 0};
        for (auto v = first; v != last; ++v) {
            v->quarter = (v->ts.x < middle.x ? 0 : 1) + (v->ts.y < middle.y ? 0 : 2);
            v->turn = dealt[v->quarter]++;
        }
        std::stable_sort(first, last, [](const Voxel& a, const Voxel& b) {
            return std::tie(a.turn, a.quarter) < std::tie(b.turn, b.quarter);
        });
        first = last;
    }
}

}  // namespace

LatticeOrder::LatticeOrder(const Mat4& tsFromIs) {
    std::array<Voxel, kBlockVoxels> voxels;
    for (int x = 0; x < kBlockEdge; ++x)
        for (int y = 0; y < kBlockEdge; ++y)
            for (int z = 0; z < kBlockEdge; ++z) {
                const int i = blockOffset(x, y, z);
                const Vec3 ts = transformVector(tsFromIs, Vec3(x, y, z));
                voxels[static_cast<std::size_t>(i)] = {ts, i, static_cast<int>(std::floor(ts.z)), 0, 0};
            }
    std::stable_sort(voxels.begin(), voxels.end(), [](const Voxel& a, const Voxel& b) { return a.bucket < b.bucket; });
    dealOut(voxels);

    m_firstBucket = voxels.front().bucket;
    for (std::size_t k = 0; k < voxels.size(); ++k) {
        const Voxel& v = voxels[k];
        while (static_cast<int>(m_bucketBegin.size()) <= v.bucket - m_firstBucket)
            m_bucketBegin.push_back(static_cast<int>(k));
        offsetU[k] = static_cast<float>(v.ts.x);
        offsetV[k] = static_cast<float>(v.ts.y);
        offsetN[k] = static_cast<float>(v.ts.z);
        index[k] = v.index;
    }
    m_bucketBegin.push_back(kBlockVoxels);
}

std::pair<int, int> LatticeOrder::between(double lower, double upper) const {
    const int buckets = static_cast<int>(m_bucketBegin.size()) - 1;
    const auto begin = [&](double n) {
        const double bucket = std::clamp(std::floor(n) - m_firstBucket, 0.0, double(buckets));
        return m_bucketBegin[static_cast<std::size_t>(bucket)];
    };
    return {begin(lower), begin(upper + 1)};
}

}  // namespace scrim
