// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/field_rays.h>

#include <scrim/base/parallel.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

constexpr int kMostSteps = 4096;

/// Unique for origins that are multiples of 8 within +-2^23, which covers 2^24 voxels an axis.
std::uint64_t keyOf(const Int3& origin) {
    const auto part = [](int v) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(v >> 3)) & 0x1fffff; };
    return part(origin.x) << 42 | part(origin.y) << 21 | part(origin.z);
}

/// The multiple of `edge` at or below `v`.
int floorTo(int v, int edge) {
    return v >= 0 ? v - v % edge : -((edge - 1 - v) / edge * edge);
}

constexpr std::size_t kBlocksPerTask = 256;

std::size_t taskCount(const SparseField& field) {
    return (field.blockCount() + kBlocksPerTask - 1) / kBlocksPerTask;
}

/// Calls `visit(task, block)` for all blocks, those of a task in order.
template <typename Visit>
void visitBlocks(const SparseField& field, const Visit& visit) {
    parallelFor(taskCount(field), [&](std::size_t task) {
        const std::size_t end = std::min(field.blockCount(), (task + 1) * kBlocksPerTask);
        for (std::size_t i = task * kBlocksPerTask; i < end; ++i) visit(task, i);
    });
}

/// Box around the centres of the voxels above 0 and not below `least`.
Bounds occupiedIn(const float* values, const Int3& origin, float least = 0) {
    Bounds b;
    for (int x = 0; x < kBlockEdge; ++x)
        for (int y = 0; y < kBlockEdge; ++y)
            for (int z = 0; z < kBlockEdge; ++z)
                if (const float v = values[blockOffset(x, y, z)]; v > 0 && v >= least)
                    b.include(Vec3(origin) + Vec3(x, y, z));
    return b;
}

/// How many voxels there are of values within a quarter of a power of two, and their sum.
struct ValueBins {
    static constexpr int kPerOctave = 4, kCount = 256 * kPerOctave;
    std::vector<double> count = std::vector<double>(kCount), sum = std::vector<double>(kCount);

    static int of(float value) {
        const double octave = std::log2(double(value)) + 128;
        return std::clamp(static_cast<int>(octave * kPerOctave), 0, kCount - 1);
    }
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

float faintValue(const SparseField& field) {
    constexpr double kFaint = 0.002;  // of the sum
    std::vector<ValueBins> parts(taskCount(field));
    visitBlocks(field, [&](std::size_t task, std::size_t i) {
        for (int k = 0; k < kBlockVoxels; ++k)
            if (const float v = field.block(i)[k]; v > 0) parts[task].add(v, 1);
    });
    ValueBins all;
    for (const ValueBins& part : parts) all.add(part);
    for (const ConstantTile& tile : field.tiles) all.add(tile.value, std::pow(double(tile.edge), 3));
    double voxels = 0, sum = 0;
    for (std::size_t i = 0; i < all.count.size(); ++i) {
        voxels += all.count[i];
        sum += all.sum[i];
    }
    double voxelsBelow = 0, sumBelow = 0;
    std::size_t bin = 0;
    for (; bin + 1 < all.count.size(); ++bin) {
        voxelsBelow += all.count[bin];
        sumBelow += all.sum[bin];
        if (sumBelow > kFaint * sum || 2 * voxelsBelow > voxels) break;
    }
    return static_cast<float>(std::exp2(double(bin) / ValueBins::kPerOctave - 128));
}

FieldRays::FieldRays(const SparseField& field)
    : m_field(&field), m_isBounds(isOccupied(field)), m_isFromWs(glm::inverse(field.wsFromIs)) {
    m_blocks.reserve(field.blockCount());
    for (std::size_t i = 0; i < field.blockCount(); ++i) m_blocks.emplace(keyOf(field.blockOrigins[i]), i);
    for (const ConstantTile& tile : field.tiles) m_tiles[tile.edge].emplace(keyOf(tile.origin), tile.value);
}

double FieldRays::valueAt(const Vec3& isPoint) const {
    if (!m_isBounds.contains(isPoint)) return 0;  // nor need it be anywhere near a whole number
    const Int3 voxel(static_cast<int>(std::floor(isPoint.x + 0.5)), static_cast<int>(std::floor(isPoint.y + 0.5)),
                     static_cast<int>(std::floor(isPoint.z + 0.5)));
    const Int3 origin(floorTo(voxel.x, kBlockEdge), floorTo(voxel.y, kBlockEdge), floorTo(voxel.z, kBlockEdge));
    if (const auto found = m_blocks.find(keyOf(origin)); found != m_blocks.end()) {
        const Int3 p = voxel - origin;
        return m_field->block(found->second)[blockOffset(p.x, p.y, p.z)];
    }
    for (const auto& [edge, tiles] : m_tiles) {
        const Int3 corner(floorTo(voxel.x, edge), floorTo(voxel.y, edge), floorTo(voxel.z, edge));
        if (const auto found = tiles.find(keyOf(corner)); found != tiles.end()) return found->second;
    }
    return 0;
}

double FieldRays::integral(const Vec3& wsOrigin, const Vec3& wsDirection) const {
    if (m_isBounds.empty()) return 0;
    const Vec3 o = transformPoint(m_isFromWs, wsOrigin), d = transformVector(m_isFromWs, wsDirection);
    const auto [t0, t1] = m_isBounds.clip(o, d, 0, std::numeric_limits<double>::infinity());
    if (!(t1 > t0)) return 0;
    const double isLength = glm::length(d) * (t1 - t0);
    // Rounding must not add a step to a ray along an axis, whose samples then hit the middles of voxels.
    constexpr double kRounding = 1e-6;
    const int steps = static_cast<int>(std::clamp(std::ceil(isLength - kRounding), 1.0, double(kMostSteps)));
    const double step = (t1 - t0) / steps;
    double sum = 0;
    for (int i = 0; i < steps; ++i) sum += valueAt(o + (t0 + (i + 0.5) * step) * d);
    return sum * step * glm::length(wsDirection);
}

}  // namespace scrim
