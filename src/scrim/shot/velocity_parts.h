// SPDX-License-Identifier: Apache-2.0
// What moves fields by a velocity is built from: a field that can be sampled and whose largest
// values are known, and the six fields of a velocity. moved_field.h moves fields while the shutter
// is open, between_files.h carries them from one file of a sequence towards the next.
#pragma once

#include <scrim/geometry/bounds.h>
#include <scrim/shot/derived_fields.h>
#include <scrim/volume/field_sampler.h>

#include <array>
#include <cstddef>
#include <functional>
#include <vector>

#include <glm/common.hpp>
#include <glm/matrix.hpp>

namespace scrim {

/// A field that can be sampled, with the largest value of each block and tile. It refers to the
/// field, which must outlive it. Safe to use from many threads at once.
class FieldMap {
  public:
    explicit FieldMap(const SparseField& field)
        : m_field(field), m_sampler(field), m_isFromWs(glm::inverse(field.wsFromIs)) {
        for (std::size_t b = 0; b < field.blockCount(); ++b)
            m_most.push_back(*std::max_element(field.block(b), field.block(b) + kBlockVoxels));
        for (const ConstantTile& tile : field.tiles) m_most.push_back(tile.value);
    }
    const SparseField& field() const { return m_field; }
    const Mat4& wsFromIs() const { return m_field.wsFromIs; }
    const Mat4& isFromWs() const { return m_isFromWs; }
    const FieldSampler& sampler() const { return m_sampler; }
    const BlockIndex& index() const { return m_sampler.index(); }
    double at(const Vec3& is) const { return m_sampler.value(is); }
    double atWs(const Vec3& ws) const { return at(transformPoint(m_isFromWs, ws)); }
    /// The largest value that samples in the box (index space) can have; 0 where all of them are 0.
    float most(const Bounds& is) const {
        float most = 0;
        m_sampler.index().visit(cubeOf(is.lower - 1.0), cubeOf(glm::ceil(is.upper) + 1.0),
                                [&](const BlockIndex::Place&, std::uint32_t i) { most = std::max(most, m_most[i]); });
        return most;
    }
    static Int3 cubeOf(const Vec3& is) {
        // However fast a field moves, coordinates beyond this are clamped, so that they fit an int.
        constexpr double kFar = 1 << 30;
        return Int3(glm::floor(glm::clamp(is, Vec3(-kFar), Vec3(kFar)))) >> 3;
    }

  private:
    const SparseField& m_field;
    FieldSampler m_sampler;
    Mat4 m_isFromWs;
    std::vector<float> m_most;
};

/// A vector for each voxel of a block, in blockOffset order.
using BlockVectors = std::array<std::array<float, kBlockVoxels>, 3>;

/// The places of the voxels from the first one on.
inline constexpr BlockVectors kVoxels = [] {
    BlockVectors all{};
    for (std::size_t i = 0; i < kBlockVoxels; ++i) {
        all[0][i] = static_cast<float>(i / (kBlockEdge * kBlockEdge));
        all[1][i] = static_cast<float>(i / kBlockEdge % kBlockEdge);
        all[2][i] = static_cast<float>(i % kBlockEdge);
    }
    return all;
}();

/// Visits the blocks that the box (index space) touches.
template <typename Visit>
void visitBlocks(const Bounds& is, const Visit& visit) {
    const Int3 lower = FieldMap::cubeOf(is.lower), upper = FieldMap::cubeOf(glm::ceil(is.upper));
    for (int x = lower.x; x <= upper.x; ++x)
        for (int y = lower.y; y <= upper.y; ++y)
            for (int z = lower.z; z <= upper.z; ++z) visit(Int3(x, y, z));
}

/// Visits boxes around the voxels of all blocks and tiles, in index space.
template <typename Visit>
void forCubes(const SparseField& field, const Visit& visit) {
    for (const Int3& origin : field.blockOrigins) visit(Bounds{Vec3(origin), Vec3(origin + (kBlockEdge - 1))});
    for (const ConstantTile& tile : field.tiles) visit(Bounds{Vec3(tile.origin), Vec3(tile.origin + (tile.edge - 1))});
}

/// The box around the voxels of a block, in index space; `block`: its first voxel divided by kBlockEdge.
inline Bounds boxOf(const Int3& block) {
    return {Vec3(block * kBlockEdge), Vec3(block * kBlockEdge + Int3(kBlockEdge - 1))};
}

/// The box around the images under a linear map of all offsets in `box`.
inline Bounds mapped(const Mat3& linear, const Bounds& box) {
    Bounds out;
    for (const Vec3& corner : box.corners()) out.include(linear * corner);
    return out;
}

/// The velocity of a volume. Safe to use from many threads at once.
class VelocityParts {
  public:
    /// `velocity`: for each of x, y and z the fields of positive and negative values (GridPart), in asset space.
    explicit VelocityParts(std::vector<FieldPointer> velocity);

    /// The velocity at a point of asset space.
    Vec3 at(const Vec3& ws) const;

    /// Adds to `velocities` the velocities at the voxels of the block whose first voxel is
    /// `origin`. `wsFromIs` belongs to the block.
    void addVelocities(const Mat4& wsFromIs, const Int3& origin, FieldBrick& brick, BlockVectors& velocities) const;

    /// The velocities at the points `at`, which count from voxel `origin` and are within `is`, in
    /// the index space whose place is `wsFromIs`.
    BlockVectors velocitiesAt(const Mat4& wsFromIs, const Int3& origin, const BlockVectors& at, const Bounds& is,
                              FieldBrick& brick) const;

    /// The first voxels of the blocks that the field may touch when it has moved for `time` and lies at `wsFromIs`.
    /// `ways` turns a box around displacements in asset space into one in index space, relative to that. `bent`: paths
    /// follow velocities on their way, too, and not only where they end.
    std::vector<Int3> blocksOf(const FieldMap& from, const Mat4& wsFromIs, const std::function<Bounds(Bounds)>& ways,
                               double time, bool bent = false) const;

    /// The mean velocity over the voxels of `field`, weighted by their values.
    Vec3 mean(const SparseField& field) const;

    /// A box around time * velocity for all samples that are taken within `ws` (asset space).
    Bounds range(const Bounds& ws, double time) const;
    /// The same for all samples.
    Bounds range(double time) const;

  private:
    std::vector<FieldPointer> m_velocity;
    std::vector<FieldMap> m_maps;  // in the order of m_velocity
};

}  // namespace scrim
