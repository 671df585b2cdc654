// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/field_rays.h>

#include <scrim/base/parallel.h>

#include <algorithm>
#include <array>
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
    const auto occupied = [&](float value) { return value > 0 && value >= least; };
    Bounds b;
    if (occupied(values[0]) && occupied(values[kBlockVoxels - 1]))
        return {Vec3(origin), Vec3(origin + (kBlockEdge - 1))};
    unsigned inZ = 0;  // a bit for each z at which any voxel is occupied
    for (int x = 0; x < kBlockEdge; ++x)
        for (int y = 0; y < kBlockEdge; ++y) {
            const float* const row = values + blockOffset(x, y, 0);
            unsigned bits = 0;
            for (int z = 0; z < kBlockEdge; ++z) bits |= static_cast<unsigned>(occupied(row[z])) << z;
            inZ |= bits;
            if (bits != 0) b.include(Vec3(origin) + Vec3(x, y, 0));
        }
    if (inZ == 0) return b;
    b.lower.z = origin.z + std::countr_zero(inZ);
    b.upper.z = origin.z + static_cast<int>(std::bit_width(inZ)) - 1;
    return b;
}

/// A histogram of voxels over values, with bins of a quarter of a power of two: number and sum of values in each.
struct ValueBins {
    static constexpr int kPerOctave = 4, kCount = 256 * kPerOctave;
    static constexpr int kMantissaBits = 23;
    static constexpr std::int32_t kImplied = 1 << kMantissaBits, kMantissa = kImplied - 1;
    std::vector<double> count = std::vector<double>(kCount), sum = std::vector<double>(kCount);

    static int of(float value) { return ofBits(std::bit_cast<std::int32_t>(value)); }
    /// The bin of the value with these bits. A logarithm for each voxel would take longer than reading it: the exponent
    /// and three comparisons give the same bin, since no float is so near to a root of two that a logarithm could not
    /// tell them apart. Denormal values share a bin with 0, which no voxel above 0 is in.
    static int ofBits(std::int32_t bits) {
        static_assert(kPerOctave == 4);
        const std::int32_t mantissa = bits & kMantissa;
        const int quarters = (mantissa > 0x1837F0) + (mantissa > 0x3504F3) + (mantissa > 0x5744FC);
        return bits < kImplied ? 0 : ((bits >> kMantissaBits) + 1) * kPerOctave + quarters;
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

/// Counts the voxels of some blocks. All values of a bin have one exponent, so that their sum is
/// that of whole numbers, and exact; a bin is one number that holds both, the voxels above the sum.
class BlockBins {
  public:
    static constexpr std::size_t kMostBlocks = 64;  // the sum of so many mantissas stays below kVoxel

    void add(const float* values) {
        // Neighbours often fall into one bin, and the next addition to that would have to wait for the last.
        for (std::size_t i = 0; i < kBlockVoxels; i += m_bins.size())
            for (std::size_t k = 0; k < m_bins.size(); ++k) {
                const auto bits = std::bit_cast<std::int32_t>(values[i + k]);
                m_bins[k][std::size_t(ValueBins::ofBits(bits))] +=
                    kVoxel + std::uint64_t((bits & ValueBins::kMantissa) | ValueBins::kImplied);
            }
    }
    void moveTo(ValueBins& all) {
        for (std::size_t bin = ValueBins::kPerOctave; bin < ValueBins::kCount; ++bin) {
            std::uint64_t both = 0;
            for (auto& bins : m_bins) both += bins[bin];
            const int exponent = static_cast<int>(bin) / ValueBins::kPerOctave - 1;
            all.count[bin] += double(both / kVoxel);
            all.sum[bin] += std::ldexp(double(both % kVoxel), exponent - 127 - ValueBins::kMantissaBits);
        }
        m_bins = {};
    }

  private:
    static constexpr std::uint64_t kVoxel = std::uint64_t{1} << 40;
    std::array<std::array<std::uint64_t, ValueBins::kCount>, 2> m_bins{};
};

ValueBins binsOf(const SparseField& field) {
    std::vector<ValueBins> parts(taskCount(field));
    parallelFor(parts.size(), [&](std::size_t task) {
        BlockBins bins;
        const std::size_t end = std::min(field.blockCount(), (task + 1) * kBlocksPerTask);
        for (std::size_t i = task * kBlocksPerTask; i < end; ++i) {
            bins.add(field.block(i));
            if ((i + 1) % BlockBins::kMostBlocks == 0 || i + 1 == end) bins.moveTo(parts[task]);
        }
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
