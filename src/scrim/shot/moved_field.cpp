// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/moved_field.h>

#include <scrim/shot/velocity_parts.h>
#include <scrim/volume/field_builder.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <glm/vector_relational.hpp>

namespace scrim {
namespace {

// Where the values of a block come from, in index space from its first voxel on, when they have
// moved by `linear` times (time * velocity - mean). Returns the box around it.
Bounds cameFrom(const Mat3& linear, double time, const Vec3& mean, const BlockVectors& velocities, BlockVectors& at) {
    const auto& [vx, vy, vz] = velocities;
    const Vec3 shift = linear * mean;
    Bounds box;
    for (int axis = 0; axis < 3; ++axis) {
        const auto from = static_cast<float>(shift[axis]), perX = static_cast<float>(time * linear[0][axis]),
                   perY = static_cast<float>(time * linear[1][axis]), perZ = static_cast<float>(time * linear[2][axis]);
        const std::array<float, kBlockVoxels>& own = kVoxels[std::size_t(axis)];
        float* to = at[std::size_t(axis)].data();
        std::array<float, kBlockEdge> least, most;  // of all rows
        least.fill(std::numeric_limits<float>::max());
        most.fill(-std::numeric_limits<float>::max());
        for (std::size_t row = 0; row < kBlockVoxels; row += kBlockEdge)
            for (std::size_t z = 0; z < kBlockEdge; ++z) {
                const std::size_t i = row + z;
                to[i] = own[i] + from - (perX * vx[i] + perY * vy[i] + perZ * vz[i]);
                least[z] = std::min(least[z], to[i]);
                most[z] = std::max(most[z], to[i]);
            }
        box.lower[axis] = double(*std::min_element(least.begin(), least.end()));
        box.upper[axis] = double(*std::max_element(most.begin(), most.end()));
    }
    return box;
}

}  // namespace

FieldMover::FieldMover(std::vector<FieldPointer> velocity, const SparseField& weight)
    : m_parts(std::make_unique<const VelocityParts>(std::move(velocity))), m_mean(m_parts->mean(weight)) {}

FieldMover::~FieldMover() = default;

FieldPointer FieldMover::moved(const FieldPointer& field, double time) const {
    if (field->empty() || time == 0) return field;
    const FieldMap from(*field);
    const Vec3 mean = time * m_mean;
    Mat4 shift(1.0);
    shift[3] = glm::dvec4(mean, 1.0);
    FieldPieces pieces;
    pieces.name = field->name;
    pieces.wsFromIs = shift * field->wsFromIs;
    const Mat3 linear(glm::inverse(pieces.wsFromIs));
    // The displacements beyond the mean one, in index space: voxel i receives the value at i - displacement.
    const auto ways = [&](Bounds range) {
        range.lower -= mean;
        range.upper -= mean;
        return mapped(linear, range);
    };
    pieces.blockOrigins = m_parts->blocksOf(from, pieces.wsFromIs, ways, time);
    const std::vector<Int3> origins = pieces.blockOrigins;
    const Bounds all = field->isBounds();
    pieces.fill = [&, wsFromIs = pieces.wsFromIs](std::size_t b, float* to) {
        FieldBrick brick;
        BlockVectors velocities{}, at;
        m_parts->addVelocities(wsFromIs, origins[b], brick, velocities);
        const Bounds sampled = cameFrom(linear, time, mean, velocities, at);
        // Neighbours mostly move alike, and come from near the field.
        constexpr double kMostEdge = 32;
        const Vec3 edges = sampled.size(), origin(origins[b]);
        const bool near =
            glm::all(glm::lessThan(glm::abs(origin + sampled.center() - all.center()), all.size() + kMostEdge));
        if (near && largest(edges) < kMostEdge) {
            const Int3 lower(glm::floor(sampled.lower)), upper(glm::floor(sampled.upper));
            brick.fill(from.index(), origins[b] + lower, origins[b] + upper + 1);
            for (int axis = 0; axis < 3; ++axis) {
                const float most = std::nextafter(static_cast<float>(upper[axis] - lower[axis] + 1), 0.0f);
                for (float& x : at[std::size_t(axis)]) {
                    const float beyond = x - static_cast<float>(lower[axis]);
                    x = beyond > 0 ? std::min(beyond, most) : 0;  // also where displacements are beyond floats
                }
            }
            brick.values({at[0].data(), at[1].data(), at[2].data()}, kBlockVoxels, to);
        } else {
            for (std::size_t i = 0; i < kBlockVoxels; ++i)
                to[i] = static_cast<float>(from.at(origin + Vec3(at[0][i], at[1][i], at[2][i])));
        }
    };
    return std::make_shared<SparseField>(buildField(std::move(pieces)));
}

}  // namespace scrim
