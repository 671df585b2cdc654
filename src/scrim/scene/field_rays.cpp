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

Bounds occupiedIn(const float* values, const Int3& origin) {
    Bounds b;
    for (int x = 0; x < kBlockEdge; ++x)
        for (int y = 0; y < kBlockEdge; ++y)
            for (int z = 0; z < kBlockEdge; ++z)
                if (values[blockOffset(x, y, z)] > 0) b.include(Vec3(origin) + Vec3(x, y, z));
    return b;
}

}  // namespace

Bounds isOccupied(const SparseField& field) {
    constexpr std::size_t kBlocksPerTask = 256;
    std::vector<Bounds> parts((field.blockCount() + kBlocksPerTask - 1) / kBlocksPerTask);
    parallelFor(parts.size(), [&](std::size_t task) {
        const std::size_t end = std::min(field.blockCount(), (task + 1) * kBlocksPerTask);
        for (std::size_t i = task * kBlocksPerTask; i < end; ++i)
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

FieldRays::FieldRays(const SparseField& field)
    : m_field(&field), m_isBounds(isOccupied(field)), m_isFromWs(glm::inverse(field.wsFromIs)) {
    m_blocks.reserve(field.blockCount());
    for (std::size_t i = 0; i < field.blockCount(); ++i) m_blocks.emplace(keyOf(field.blockOrigins[i]), i);
    for (const ConstantTile& tile : field.tiles) m_tiles[tile.edge].emplace(keyOf(tile.origin), tile.value);
}

double FieldRays::valueAt(const Vec3& isPoint) const {
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
    double t0 = 0, t1 = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
        if (d[axis] == 0) {
            if (o[axis] < m_isBounds.lower[axis] || o[axis] > m_isBounds.upper[axis]) return 0;
            continue;
        }
        const double a = (m_isBounds.lower[axis] - o[axis]) / d[axis], b = (m_isBounds.upper[axis] - o[axis]) / d[axis];
        t0 = std::max(t0, std::min(a, b));
        t1 = std::min(t1, std::max(a, b));
    }
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
