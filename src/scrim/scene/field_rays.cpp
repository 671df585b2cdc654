// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/field_rays.h>

#include <scrim/base/parallel.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

constexpr int kMostSteps = 4096;

constexpr std::size_t kBlocksPerTask = 256;

std::size_t taskCount(const SparseField& field) {
    return (field.blockCount() + kBlocksPerTask - 1) / kBlocksPerTask;
}

/// Calls `visit(task, block)` for all blocks in parallel; the blocks of one task are visited in order.
template <typename Visit>
void visitBlocks(const SparseField& field, const Visit& visit) {
    parallelFor(taskCount(field), [&](std::size_t task) {
        const std::size_t end = std::min(field.blockCount(), (task + 1) * kBlocksPerTask);
        for (std::size_t i = task * kBlocksPerTask; i < end; ++i) visit(task, i);
    });
}

/// Box around the centres of the voxels that are above 0 and at least `least`.
Bounds occupiedIn(const float* values, const Int3& origin, float least = 0) {
    const auto occupied = [&](int n) { return values[n] > 0 && values[n] >= least; };
    Bounds b;
    if (occupied(0) && occupied(kBlockVoxels - 1)) return {Vec3(origin), Vec3(origin + (kBlockEdge - 1))};
    for (int x = 0; x < kBlockEdge; ++x)
        for (int y = 0; y < kBlockEdge; ++y)
            for (int z = 0; z < kBlockEdge; ++z)
                if (occupied(blockOffset(x, y, z))) b.include(Vec3(origin) + Vec3(x, y, z));
    return b;
}

/// A histogram of voxels over values, with bins of a quarter of a power of two: number and sum of values in each.
struct ValueBins {
    static constexpr int kPerOctave = 4, kCount = 256 * kPerOctave;
    std::vector<double> count = std::vector<double>(kCount), sum = std::vector<double>(kCount);

    static int of(float value) {
        // A logarithm for each voxel would take longer than reading it: the exponent and three comparisons give the
        // same bin, since no float is so near to a root of two that a logarithm could not tell them apart.
        static_assert(kPerOctave == 4);
        constexpr std::int32_t kOne = 127 << 23, kMantissa = (1 << 23) - 1;
        const auto bits = std::bit_cast<std::int32_t>(value);
        if (bits < 1 << 23) return 0;                                     // denormal
        const auto in = std::bit_cast<float>((bits & kMantissa) | kOne);  // in [1, 2)
        const int quarters = (in > 0x1.306fep+0f) + (in > 0x1.6a09e6p+0f) + (in > 0x1.ae89f8p+0f);
        return ((bits >> 23) + 1) * kPerOctave + quarters;
    }
    /// The least value of a bin.
    static float lowest(std::size_t bin) { return static_cast<float>(std::exp2(double(bin) / kPerOctave - 128)); }
    void add(float value, double voxels) {
        const auto bin = static_cast<std::size_t>(of(value));
        count[bin] += voxels;
        sum[bin] += voxels * double(value);
    }
    void add(const ValueBins& other) {
        for (std::size_t i = 0; i < count.size(); ++i) {
            count[i] += other.count[i];
            sum[i] += other.sum[i];
        }
    }
};

double total(const std::vector<double>& bins) {
    return std::accumulate(bins.begin(), bins.end(), 0.0);
}

ValueBins binsOf(const SparseField& field) {
    std::vector<ValueBins> parts(taskCount(field));
    visitBlocks(field, [&](std::size_t task, std::size_t i) {
        for (int k = 0; k < kBlockVoxels; ++k)
            if (const float v = field.block(i)[k]; v > 0) parts[task].add(v, 1);
    });
    ValueBins all;
    for (const ValueBins& part : parts) all.add(part);
    for (const ConstantTile& tile : field.tiles) all.add(tile.value, std::pow(double(tile.edge), 3));
    return all;
}

Negligible negligibleIn(const ValueBins& all) {
    constexpr double kNegligible = 1e-4;  // of the value above which half of the sum lies
    const double voxels = total(all.count), sum = total(all.sum);
    if (voxels == 0) return {};
    double sumAbove = 0;
    std::size_t core = all.sum.size() - 1;
    for (; core > 0; --core) {
        sumAbove += all.sum[core];
        if (2 * sumAbove >= sum) break;
    }
    const double bins = -ValueBins::kPerOctave * std::log2(kNegligible);
    const std::size_t least = core - std::min(core, static_cast<std::size_t>(bins));
    Negligible negligible;
    negligible.below = all.lowest(least);
    for (std::size_t bin = 0; bin < least; ++bin) negligible.part += all.count[bin] / voxels;
    return negligible;
}

}  // namespace

Bounds isOccupied(const SparseField& field) {
    std::vector<Bounds> parts(taskCount(field));
    visitBlocks(field, [&](std::size_t task, std::size_t i) {
        parts[task].include(occupiedIn(field.block(i), field.blockOrigins[i]));
    });
    Bounds all;
    for (const Bounds& part : parts) all.include(part);
    for (const ConstantTile& tile : field.tiles) {
        all.include(Vec3(tile.origin));
        all.include(Vec3(tile.origin) + double(tile.edge - 1));
    }
    if (!all.empty()) {
        all.lower -= 0.5;
        all.upper += 0.5;
    }
    return all;
}

std::vector<Vec3> isOutline(const SparseField& field, float least, double reach) {
    std::vector<std::vector<Vec3>> parts(taskCount(field) + 1);
    const auto add = [reach](std::vector<Vec3>& points, Bounds centres) {
        if (centres.empty()) return;
        centres.lower -= 0.5 + reach;
        centres.upper += 0.5 + reach;
        for (const Vec3& corner : centres.corners()) points.push_back(corner);
    };
    visitBlocks(field, [&](std::size_t task, std::size_t i) {
        add(parts[task], occupiedIn(field.block(i), field.blockOrigins[i], least));
    });
    for (const ConstantTile& tile : field.tiles)
        if (tile.value >= least) add(parts.back(), {Vec3(tile.origin), Vec3(tile.origin) + double(tile.edge - 1)});
    std::vector<Vec3> all;
    for (const std::vector<Vec3>& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}

Negligible negligibleIn(const SparseField& field) {
    return negligibleIn(binsOf(field));
}

float faintValue(const SparseField& field) {
    constexpr double kFaint = 0.002;  // of the sum of all values
    const ValueBins all = binsOf(field);
    const Negligible negligible = negligibleIn(all);
    const double voxels = total(all.count) * (1 - negligible.part), sum = total(all.sum);
    auto bin = static_cast<std::size_t>(ValueBins::of(negligible.below));
    for (double voxelsBelow = 0, sumBelow = 0; bin + 1 < all.count.size(); ++bin) {
        voxelsBelow += all.count[bin];
        sumBelow += all.sum[bin];
        if (sumBelow > kFaint * sum || 2 * voxelsBelow > voxels) break;
    }
    return all.lowest(bin);
}

float usualMost(const SparseField& field) {
    constexpr double kFew = 1.0 / 5000;
    constexpr float kMuch = 4;
    const ValueBins all = binsOf(field);
    double above = 0;
    for (std::size_t bin = all.count.size(); bin-- > 0;) {
        above += all.count[bin];
        if (above <= kFew * double(field.activeVoxels)) continue;
        const float most = ValueBins::lowest(bin + 1);
        return field.maxValue > kMuch * most ? most : field.maxValue;
    }
    return field.maxValue;
}

FieldRays::FieldRays(const SparseField& field)
    : m_sampler(field), m_isBounds(isOccupied(field)), m_isFromWs(glm::inverse(field.wsFromIs)) {}

double FieldRays::integral(const Vec3& wsOrigin, const Vec3& wsDirection) const {
    if (m_isBounds.empty()) return 0;
    const Vec3 o = transformPoint(m_isFromWs, wsOrigin), d = transformVector(m_isFromWs, wsDirection);
    const auto [t0, t1] = m_isBounds.clip(o, d, 0, std::numeric_limits<double>::infinity());
    if (!(t1 > t0)) return 0;
    const double isLength = glm::length(d) * (t1 - t0);
    // A ray along an axis should sample the centres of voxels; rounding of its length must not add one more step.
    constexpr double kRounding = 1e-6;
    const int steps = static_cast<int>(std::clamp(std::ceil(isLength - kRounding), 1.0, double(kMostSteps)));
    const double step = (t1 - t0) / steps;
    double sum = 0;
    for (int i = 0; i < steps; ++i) sum += m_sampler.nearest(o + (t0 + (i + 0.5) * step) * d);
    return sum * step * glm::length(wsDirection);
}

}  // namespace scrim
