// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/between_files.h>

#include <scrim/base/error.h>
#include <scrim/geometry/cubic_weights.h>
#include <scrim/shot/values_at.h>
#include <scrim/shot/velocity_parts.h>
#include <scrim/volume/field_builder.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>

#include <fmt/format.h>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

/// Most blocks that a field may get, which take 4 GB.
constexpr std::size_t kMostBlocks = std::size_t{1} << 21;

/// The places linear * (-time * velocity) away from the voxels of a block, and the box around them;
/// both count from the first voxel.
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

/// A copy of the voxels in a small box, interpolated by cubics, which keep what is as fine as a voxel. A value stays
/// between those of the eight voxels around it, so that edges do not ring, and smoke stays above 0.
class CubicBrick {
  public:
    /// Copies the voxels that look-ups within `is` need. Returns false, and copies nothing, if they are too many.
    bool fill(const BlockIndex& index, const Bounds& is) {
        constexpr double kMostVoxels = 1 << 15;
        const Vec3 lower = glm::floor(is.lower) - 1.0, size = glm::floor(is.upper) + 3.0 - lower;
        if (!(size.x * size.y * size.z <= kMostVoxels)) return false;
        m_lower = Int3(lower);
        m_size = Int3(size);
        m_values.clear();
        for (int x = 0; x < m_size.x; ++x)
            for (int y = 0; y < m_size.y; ++y)
                for (int z = 0; z < m_size.z; ++z)
                    m_values.push_back(static_cast<float>(index.voxel(m_lower + Int3(x, y, z))));
        return true;
    }

    double value(const Vec3& is) const {
        const Vec3 floor = glm::floor(is), f = is - floor;
        const Int3 first = Int3(floor) - m_lower;
        const std::ptrdiff_t stepX = std::ptrdiff_t(m_size.y) * m_size.z, stepY = m_size.z;
        const float* const v = m_values.data() + first.x * stepX + first.y * stepY + first.z;
        float least = v[0], most = v[0];
        for (const std::ptrdiff_t row : {std::ptrdiff_t(0), stepY, stepX, stepX + stepY}) {
            least = std::min({least, v[row], v[row + 1]});
            most = std::max({most, v[row], v[row + 1]});
        }
        if (least == most) return double(least);
        const std::array<double, 4> wx = cubicWeights(f.x), wy = cubicWeights(f.y), wz = cubicWeights(f.z);
        double sum = 0;
        for (int x = 0; x < 4; ++x)
            for (int y = 0; y < 4; ++y) {
                const float* const row = v + (x - 1) * stepX + (y - 1) * stepY;
                sum += wx[std::size_t(x)] * wy[std::size_t(y)] *
                       (wz[0] * double(row[-1]) + wz[1] * double(row[0]) + wz[2] * double(row[1]) +
                        wz[3] * double(row[2]));
            }
        return std::clamp(sum, double(least), double(most));
    }

  private:
    Int3 m_lower{0}, m_size{0};
    std::vector<float> m_values;
};

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
    if (wsFromIs == field.wsFromIs()) return own;
    const Mat4 otherFromIs = glm::inverse(wsFromIs) * field.wsFromIs();
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
    const bool same = wsFromIs == field.wsFromIs();
    const Mat4 ownFromIs = same ? Mat4(1.0) : field.isFromWs() * wsFromIs;
    const Bounds own = transformed(ownFromIs, movedBy(box, Vec3(origin)));
    if (field.most(own) == 0) return;
    if (same && !m_velocity) {
        const BlockIndex::Place place = field.index().at(origin >> 3);
        for (int i = 0; i < kBlockVoxels; ++i)
            to[i] += static_cast<float>(m_weight * double(place.values ? place.values[i] : place.constant));
        return;
    }
    CubicBrick voxels;
    constexpr double kRounding = 1e-3;  // places are in floats
    const bool copied = voxels.fill(field.index(), {own.lower - kRounding, own.upper + kRounding});
    for (std::size_t i = 0; i < kBlockVoxels; ++i) {
        const Vec3 place = Vec3(origin) + Vec3(at[0][i], at[1][i], at[2][i]);
        const Vec3 from = same ? place : transformPoint(ownFromIs, place);
        to[i] += static_cast<float>(m_weight * (copied ? voxels.value(from) : field.at(from)));
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

bool BetweenStore::Made::isOf(const std::set<FieldPointer>& sources) const {
    const auto known = [&](const FieldPointer& source) { return sources.contains(source); };
    return known(first) && known(second) &&
           std::all_of(moment.velocity.begin(), moment.velocity.end(),
                       [&](const auto& of) { return std::all_of(of.begin(), of.end(), known); });
}

void BetweenStore::keepOnly(const std::set<FieldPointer>& sources) {
    std::erase_if(m_all, [&](const Made& made) { return !made.isOf(sources); });
}

void BetweenStore::forgetUnused() {
    std::erase_if(m_all, [](const Made& made) { return !made.used; });
    for (Made& made : m_all) made.used = false;
}

}  // namespace scrim
