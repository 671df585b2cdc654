// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/moved_field.h>

#include <scrim/base/parallel.h>
#include <scrim/volume/field_builder.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>
#include <utility>

#include <glm/common.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

// 21 bits an axis, as FieldProbe has them.
std::uint64_t keyOf(const Int3& block) {
    const auto part = [](int x) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(x) & 0x1fffffU); };
    return part(block.x) << 42 | part(block.y) << 21 | part(block.z);
}

// A field's blocks by their place, tiles cut into them.
class BlockMap {
  public:
    struct Entry {
        const float* values;
        float most;
    };
    explicit BlockMap(const SparseField& field) : m_wsFromIs(field.wsFromIs), m_isFromWs(glm::inverse(field.wsFromIs)) {
        for (std::size_t b = 0; b < field.blockCount(); ++b)
            add(field.blockOrigins[b], field.block(b),
                *std::max_element(field.block(b), field.block(b) + kBlockVoxels));
        for (const ConstantTile& tile : field.tiles) {
            const auto& constant =
                m_constants.emplace_back(std::make_unique<std::vector<float>>(kBlockVoxels, tile.value));
            for (int x = 0; x < tile.edge; x += kBlockEdge)
                for (int y = 0; y < tile.edge; y += kBlockEdge)
                    for (int z = 0; z < tile.edge; z += kBlockEdge)
                        add(tile.origin + Int3(x, y, z), constant->data(), tile.value);
        }
    }
    const std::vector<Int3>& blocks() const { return m_blocks; }  // coordinates: origins / 8
    const Mat4& wsFromIs() const { return m_wsFromIs; }
    const Mat4& isFromWs() const { return m_isFromWs; }
    const Entry* at(const Int3& block) const {
        const auto found = m_entries.find(keyOf(block));
        return found == m_entries.end() ? nullptr : &found->second;
    }
    // The largest value that samples in the box (index space) can have, or whether there is any.
    float most(const Bounds& is) const {
        const Int3 lower = Int3(glm::floor(is.lower - 1.0)) >> 3, upper = Int3(glm::ceil(is.upper + 1.0)) >> 3;
        float most = 0;
        for (int x = lower.x; x <= upper.x; ++x)
            for (int y = lower.y; y <= upper.y; ++y)
                for (int z = lower.z; z <= upper.z; ++z)
                    if (const Entry* entry = at({x, y, z})) most = std::max(most, entry->most);
        return most;
    }

  private:
    void add(const Int3& origin, const float* values, float most) {
        m_blocks.push_back(origin >> 3);
        m_entries.emplace(keyOf(origin >> 3), Entry{values, most});
    }
    Mat4 m_wsFromIs, m_isFromWs;
    std::vector<Int3> m_blocks;
    std::unordered_map<std::uint64_t, Entry> m_entries;
    std::vector<std::unique_ptr<std::vector<float>>> m_constants;
};

// Trilinear samples, which remember the block that the one before was in. For one thread.
class Sampler {
  public:
    explicit Sampler(const BlockMap& map) : m_map(map) {}

    double at(const Vec3& is) {
        const Vec3 floor = glm::floor(is), f = is - floor;
        const Int3 base(floor);
        double sum = 0;
        for (int corner = 0; corner < 8; ++corner) {
            const Int3 step(corner & 1, corner >> 1 & 1, corner >> 2);
            const Vec3 w = glm::mix(1.0 - f, f, Vec3(step));
            const double weight = w.x * w.y * w.z;
            if (weight > 0) sum += weight * voxel(base + step);
        }
        return sum;
    }
    double atWs(const Vec3& ws) { return at(transformPoint(m_map.isFromWs(), ws)); }

  private:
    float voxel(const Int3& at) {
        const Int3 block = at >> 3;
        if (!m_known || block != m_block) {
            const BlockMap::Entry* entry = m_map.at(block);
            m_values = entry ? entry->values : nullptr;
            m_block = block;
            m_known = true;
        }
        return m_values ? m_values[blockOffset(at.x & 7, at.y & 7, at.z & 7)] : 0.0f;
    }
    const BlockMap& m_map;
    Int3 m_block{0};
    const float* m_values = nullptr;
    bool m_known = false;
};

// The blocks that the box (index space) touches.
template <typename Visit>
void visitBlocks(const Bounds& is, const Visit& visit) {
    const Int3 lower = Int3(glm::floor(is.lower)) >> 3, upper = Int3(glm::ceil(is.upper)) >> 3;
    for (int x = lower.x; x <= upper.x; ++x)
        for (int y = lower.y; y <= upper.y; ++y)
            for (int z = lower.z; z <= upper.z; ++z) visit(Int3(x, y, z));
}

Bounds boxOf(const Int3& block) {
    return {Vec3(block * kBlockEdge), Vec3(block * kBlockEdge + Int3(kBlockEdge - 1))};
}

// Of what a linear map makes of offsets in a box.
Bounds mapped(const Mat3& linear, const Bounds& box) {
    Bounds out;
    for (const Vec3& corner : box.corners()) out.include(linear * corner);
    return out;
}

Bounds rangeOf(double time, const Vec3& positive, const Vec3& negative) {
    const Vec3 a = time * positive, b = -time * negative;
    return {glm::min(glm::min(a, b), Vec3(0)), glm::max(glm::max(a, b), Vec3(0))};
}

}  // namespace

struct FieldMover::Parts {
    std::vector<BlockMap> maps;  // as FieldPath::parts

    // What the velocity is, at most, where samples of the box (asset space) are taken.
    Bounds range(const Bounds& ws, double time) const {
        Vec3 positive, negative;
        for (int axis = 0; axis < 3; ++axis) {
            const BlockMap &above = maps[std::size_t(2 * axis)], &below = maps[std::size_t(2 * axis + 1)];
            positive[axis] = above.most(transformed(above.isFromWs(), ws));
            negative[axis] = below.most(transformed(below.isFromWs(), ws));
        }
        return rangeOf(time, positive, negative);
    }
};

namespace {

// Velocities at places, for one thread.
class VelocitySampler {
  public:
    explicit VelocitySampler(const std::vector<BlockMap>& maps) {
        for (const BlockMap& map : maps) m_samplers.emplace_back(map);
    }
    Vec3 at(const Vec3& ws) {
        Vec3 v;
        for (int axis = 0; axis < 3; ++axis)
            v[axis] = m_samplers[std::size_t(2 * axis)].atWs(ws) - m_samplers[std::size_t(2 * axis + 1)].atWs(ws);
        return v;
    }

  private:
    std::vector<Sampler> m_samplers;
};

Int3 voxelOf(int i) {
    return {i / (kBlockEdge * kBlockEdge), i / kBlockEdge % kBlockEdge, i % kBlockEdge};
}

// Of a field's velocity, weighted by its values.
Vec3 meanVelocity(const std::vector<BlockMap>& velocity, const SparseField& field) {
    const BlockMap map(field);
    struct Sum {
        Vec3 v{0};
        double weight = 0;
    };
    std::vector<Sum> sums(map.blocks().size());
    parallelFor(sums.size(), [&](std::size_t b) {
        VelocitySampler sampler(velocity);
        const Int3 block = map.blocks()[b];
        const float* values = map.at(block)->values;
        for (int i = 0; i < kBlockVoxels; ++i) {
            if (values[i] == 0) continue;
            sums[b].v +=
                double(values[i]) * sampler.at(transformPoint(field.wsFromIs, Vec3(block * kBlockEdge + voxelOf(i))));
            sums[b].weight += values[i];
        }
    });
    Sum all;
    for (const Sum& sum : sums) {
        all.v += sum.v;
        all.weight += sum.weight;
    }
    return all.weight > 0 ? all.v / all.weight : Vec3(0);
}

}  // namespace

Bounds FieldPath::range() const {
    Vec3 positive(0), negative(0);
    for (int axis = 0; axis < 3 && moves(); ++axis) {
        positive[axis] = parts[std::size_t(2 * axis)]->maxValue;
        negative[axis] = parts[std::size_t(2 * axis + 1)]->maxValue;
    }
    return rangeOf(time, positive, negative);
}

FieldMover::FieldMover(FieldPath path, const SparseField& weight) : m_path(std::move(path)) {
    auto parts = std::make_unique<Parts>();
    for (const FieldPointer& part : m_path.parts) parts->maps.emplace_back(*part);
    m_mean = m_path.time * meanVelocity(parts->maps, weight);
    m_parts = std::move(parts);
}

FieldMover::~FieldMover() = default;

FieldPointer FieldMover::operator()(const FieldPointer& field) const {
    if (field->empty()) return field;
    const BlockMap from(*field);
    Mat4 shift(1.0);
    shift[3] = glm::dvec4(m_mean, 1.0);
    FieldPieces pieces;
    pieces.name = field->name;
    pieces.wsFromIs = shift * field->wsFromIs;
    const Mat4 isFromWs = glm::inverse(pieces.wsFromIs);
    const Mat3 linear(isFromWs);
    // Ways beyond the mean one, index space: voxel i gets what is at i - way.
    const auto ways = [&](Bounds range) {
        range.lower -= m_mean;
        range.upper -= m_mean;
        return mapped(linear, range);
    };
    // Where the velocity is 0 all go the same way; elsewhere it has blocks.
    std::vector<Int3>& found = pieces.blockOrigins;
    const auto find = [&](const Int3& block) { found.push_back(block); };
    const Bounds still = ways({Vec3(0), Vec3(0)});
    for (const Int3& block : from.blocks())
        visitBlocks({boxOf(block).lower + still.lower - 1.0, boxOf(block).upper + still.upper + 1.0}, find);
    for (const BlockMap& part : m_parts->maps)
        for (const Int3& block : part.blocks()) {
            Bounds is = boxOf(block);
            is.lower -= 1.0;
            is.upper += 1.0;
            visitBlocks(transformed(isFromWs * part.wsFromIs(), is), find);
        }
    std::sort(found.begin(), found.end(), originLess);
    found.erase(std::unique(found.begin(), found.end()), found.end());
    std::erase_if(found, [&](const Int3& block) {
        const Bounds box = boxOf(block), way = ways(m_parts->range(transformed(pieces.wsFromIs, box), m_path.time));
        return from.most({box.lower - way.upper, box.upper - way.lower}) == 0;
    });
    for (Int3& origin : found) origin *= kBlockEdge;
    const std::vector<Int3> origins = found;
    pieces.fill = [&, wsFromIs = pieces.wsFromIs](std::size_t b, float* to) {
        Sampler values(from);
        VelocitySampler velocity(m_parts->maps);
        for (int i = 0; i < kBlockVoxels; ++i) {
            const Vec3 is(origins[b] + voxelOf(i));
            const Vec3 way = m_path.time * velocity.at(transformPoint(wsFromIs, is)) - m_mean;
            to[i] = static_cast<float>(values.at(is - linear * way));
        }
    };
    return std::make_shared<SparseField>(buildField(std::move(pieces)));
}

}  // namespace scrim
