// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/between_files.h>

#include <scrim/base/error.h>
#include <scrim/shot/values_at.h>
#include <scrim/shot/velocity_parts.h>
#include <scrim/volume/field_builder.h>

#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

/// Most blocks that a field may get, which take 4 GB.
constexpr std::size_t kMostBlocks = std::size_t{1} << 21;

/// The places linear * (-time * velocity) away from the voxels of a block, and the box around them; both count from the
/// first voxel.
Bounds cameFrom(const Mat3& linear, double time, const BlockVectors& velocities, BlockVectors& at) {
    Bounds box;
    for (std::size_t i = 0; i < kBlockVoxels; ++i) {
        const Vec3 v(velocities[0][i], velocities[1][i], velocities[2][i]);
        const Vec3 from = Vec3(kVoxels[0][i], kVoxels[1][i], kVoxels[2][i]) - time * (linear * v);
        for (int axis = 0; axis < 3; ++axis) at[std::size_t(axis)][i] = static_cast<float>(from[axis]);
        box.include(from);
    }
    return box;
}

Bounds movedBy(const Bounds& box, const Vec3& way) {
    return {box.lower + way, box.upper + way};
}

}  // namespace

/// One of both files: how its fields come to the moment.
class BetweenFields::Side {
  public:
    Side(double weight, double time, const std::vector<FieldPointer>& velocity) : m_weight(weight), m_time(time) {
        if (!velocity.empty() && time != 0) m_velocity = std::make_shared<const VelocityParts>(velocity);
    }

    /// The first voxels of the blocks of the lattice `wsFromIs` that the field may touch at the moment.
    std::vector<Int3> blocksOf(const FieldMap& field, const Mat4& wsFromIs) const;

    /// Adds to `to` the field's part in the values of the block whose first voxel is `origin`.
    void add(const FieldMap& field, const Mat4& wsFromIs, const Int3& origin, float* to) const;

  private:
    double m_weight, m_time;
    std::shared_ptr<const VelocityParts> m_velocity;  // null: nothing is carried
};

std::vector<Int3> BetweenFields::Side::blocksOf(const FieldMap& field, const Mat4& wsFromIs) const {
    std::vector<Int3> own;
    if (m_velocity) {
        const Mat3 linear(field.isFromWs());
        own = m_velocity->blocksOf(
            field, field.wsFromIs(), [&](const Bounds& range) { return mapped(linear, range); }, m_time, true);
    } else {
        forCubes(field.field(), [&](const Bounds& is) {
            visitBlocks(is, [&](const Int3& block) { own.push_back(block * kBlockEdge); });
        });
    }
    const Mat4 otherFromIs = glm::inverse(wsFromIs) * field.wsFromIs();
    if (otherFromIs == Mat4(1.0)) return own;
    std::vector<Int3> found;
    for (const Int3& origin : own) {
        const Bounds box = boxOf(origin >> 3);
        visitBlocks(transformed(otherFromIs, {box.lower - 1.0, box.upper + 1.0}),
                    [&](const Int3& block) { found.push_back(block * kBlockEdge); });
    }
    return found;
}

void BetweenFields::Side::add(const FieldMap& field, const Mat4& wsFromIs, const Int3& origin, float* to) const {
    BlockVectors at = kVoxels;
    Bounds box = boxOf(Int3(0));
    FieldBrick brick;
    if (m_velocity) {
        const Mat3 linear(glm::inverse(wsFromIs));
        BlockVectors velocities{};
        m_velocity->addVelocities(wsFromIs, origin, brick, velocities);
        box = cameFrom(linear, 0.5 * m_time, velocities, at);
        velocities = m_velocity->velocitiesAt(wsFromIs, origin, at, movedBy(box, Vec3(origin)), brick);
        box = cameFrom(linear, m_time, velocities, at);
    }
    const Mat4 ownFromIs = field.isFromWs() * wsFromIs;
    const Bounds own = transformed(ownFromIs, movedBy(box, Vec3(origin)));
    if (field.most(own) == 0) return;
    const bool same = ownFromIs == Mat4(1.0);
    const bool copied = brick.fill(field.sampler(), {own.lower - 1.0, own.upper + 1.0});
    for (std::size_t i = 0; i < kBlockVoxels; ++i) {
        const Vec3 place = Vec3(origin) + Vec3(at[0][i], at[1][i], at[2][i]);
        const Vec3 from = same ? place : transformPoint(ownFromIs, place);
        to[i] += static_cast<float>(m_weight * (copied ? brick.value(from) : field.at(from)));
    }
}

BetweenFields::BetweenFields(BetweenMoment moment) : m_moment(std::move(moment)) {
    const auto& [part, time, velocity] = m_moment;
    m_sides.emplace_back(1 - part, part * time, velocity[0]);
    m_sides.emplace_back(part, (part - 1) * time, velocity[1]);
}

BetweenFields::~BetweenFields() = default;

FieldPointer BetweenFields::at(const FieldPointer& first, const FieldPointer& second) const {
    const SparseField& lattice = first->empty() ? *second : *first;
    FieldPieces pieces;
    pieces.name = lattice.name;
    pieces.wsFromIs = lattice.wsFromIs;
    const std::array<FieldMap, 2> maps{FieldMap(*first), FieldMap(*second)};
    for (std::size_t i = 0; i < maps.size(); ++i) {
        if (maps[i].field().empty()) continue;
        if (dividedBlocks(maps[i].field()) > double(kMostBlocks))
            throw Error(ErrorKind::memory,
                        fmt::format("grid '{}' has constant regions that are too large to be mixed with those of "
                                    "another file: these need voxels, more than {} million",
                                    lattice.name, kMostBlocks * kBlockVoxels / 1000000));
        const std::vector<Int3> blocks = m_sides[i].blocksOf(maps[i], pieces.wsFromIs);
        pieces.blockOrigins.insert(pieces.blockOrigins.end(), blocks.begin(), blocks.end());
    }
    std::sort(pieces.blockOrigins.begin(), pieces.blockOrigins.end(), originLess);
    pieces.blockOrigins.erase(std::unique(pieces.blockOrigins.begin(), pieces.blockOrigins.end()),
                              pieces.blockOrigins.end());
    const std::vector<Int3> origins = pieces.blockOrigins;
    pieces.fill = [&, wsFromIs = pieces.wsFromIs](std::size_t b, float* to) {
        std::fill_n(to, kBlockVoxels, 0.0f);
        for (std::size_t i = 0; i < maps.size(); ++i)
            if (!maps[i].field().empty()) m_sides[i].add(maps[i], wsFromIs, origins[b], to);
    };
    return std::make_shared<SparseField>(buildField(std::move(pieces)));
}

FieldPointer BetweenStore::at(const BetweenFields& fields, const FieldPointer& first, const FieldPointer& second) {
    for (Made& made : m_all)
        if (made.first == first && made.second == second && made.moment == fields.moment()) {
            made.used = true;
            return made.field;
        }
    return m_all.emplace_back(Made{fields.moment(), first, second, fields.at(first, second)}).field;
}

void BetweenStore::forgetUnused() {
    std::erase_if(m_all, [](const Made& made) { return !made.used; });
    for (Made& made : m_all) made.used = false;
}

}  // namespace scrim
