// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/moved_field.h>

#include <scrim/base/parallel.h>
#include <scrim/scene/field_rays.h>
#include <scrim/volume/field_builder.h>
#include <scrim/volume/field_sampler.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <glm/common.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

// A field that can be sampled, with the largest value of each block and tile.
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
    double at(const Vec3& is) const { return m_sampler.value(is); }
    double atWs(const Vec3& ws) const { return at(transformPoint(m_isFromWs, ws)); }
    // The largest value that samples in the box (index space) can have; 0 where all of them are 0.
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

// Visits the blocks that the box (index space) touches.
template <typename Visit>
void visitBlocks(const Bounds& is, const Visit& visit) {
    const Int3 lower = FieldMap::cubeOf(is.lower), upper = FieldMap::cubeOf(glm::ceil(is.upper));
    for (int x = lower.x; x <= upper.x; ++x)
        for (int y = lower.y; y <= upper.y; ++y)
            for (int z = lower.z; z <= upper.z; ++z) visit(Int3(x, y, z));
}

// Visits boxes around the voxels of all blocks and tiles, in index space.
template <typename Visit>
void forCubes(const SparseField& field, const Visit& visit) {
    for (const Int3& origin : field.blockOrigins) visit(Bounds{Vec3(origin), Vec3(origin + (kBlockEdge - 1))});
    for (const ConstantTile& tile : field.tiles) visit(Bounds{Vec3(tile.origin), Vec3(tile.origin + (tile.edge - 1))});
}

Bounds boxOf(const Int3& block) {
    return {Vec3(block * kBlockEdge), Vec3(block * kBlockEdge + Int3(kBlockEdge - 1))};
}

// The box around the images under a linear map of all offsets in `box`.
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
    std::vector<FieldMap> maps;  // in the order of FieldPath::parts

    // The velocity at a point of asset space.
    Vec3 at(const Vec3& ws) const {
        Vec3 v;
        for (int axis = 0; axis < 3; ++axis)
            v[axis] = maps[std::size_t(2 * axis)].atWs(ws) - maps[std::size_t(2 * axis + 1)].atWs(ws);
        return v;
    }

    // The mean velocity over the voxels of `field`, weighted by their values.
    Vec3 mean(const SparseField& field) const;

    // A box around time * velocity for all samples that are taken within `ws` (asset space).
    Bounds range(const Bounds& ws, double time) const {
        Vec3 positive, negative;
        for (int axis = 0; axis < 3; ++axis) {
            const FieldMap &above = maps[std::size_t(2 * axis)], &below = maps[std::size_t(2 * axis + 1)];
            positive[axis] = above.most(transformed(above.isFromWs(), ws));
            negative[axis] = below.most(transformed(below.isFromWs(), ws));
        }
        return rangeOf(time, positive, negative);
    }
};

namespace {

Int3 voxelOf(int i) {
    return {i / (kBlockEdge * kBlockEdge), i / kBlockEdge % kBlockEdge, i % kBlockEdge};
}

}  // namespace

Vec3 FieldMover::Parts::mean(const SparseField& field) const {
    struct Sum {
        Vec3 v{0};
        double weight = 0;
    };
    // Outliers are left out: a voxel or two may be a million times as fast as all others, and must not shift the whole
    // lattice.
    Bounds usual;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        usual.upper[int(axis)] = usualMost(maps[2 * axis].field());
        usual.lower[int(axis)] = -usualMost(maps[2 * axis + 1].field());
    }
    // A tile is represented by its centre.
    std::vector<Sum> sums(field.blockCount() + field.tiles.size());
    parallelFor(sums.size(), [&](std::size_t b) {
        const auto add = [&](const Vec3& is, double weight) {
            sums[b].v += weight * glm::clamp(at(transformPoint(field.wsFromIs, is)), usual.lower, usual.upper);
            sums[b].weight += weight;
        };
        if (b < field.blockCount()) {
            for (int i = 0; i < kBlockVoxels; ++i)
                if (const float value = field.block(b)[i]; value != 0)
                    add(Vec3(field.blockOrigins[b] + voxelOf(i)), double(value));
        } else {
            const ConstantTile& tile = field.tiles[b - field.blockCount()];
            add(Vec3(tile.origin) + 0.5 * (tile.edge - 1), double(tile.value) * std::pow(double(tile.edge), 3));
        }
    });
    Sum all;
    for (const Sum& sum : sums) {
        all.v += sum.v;
        all.weight += sum.weight;
    }
    return all.weight > 0 ? all.v / all.weight : Vec3(0);
}

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
    m_mean = m_path.time * parts->mean(weight);
    m_parts = std::move(parts);
}

FieldMover::~FieldMover() = default;

FieldPointer FieldMover::operator()(const FieldPointer& field) const {
    if (field->empty()) return field;
    const FieldMap from(*field);
    Mat4 shift(1.0);
    shift[3] = glm::dvec4(m_mean, 1.0);
    FieldPieces pieces;
    pieces.name = field->name;
    pieces.wsFromIs = shift * field->wsFromIs;
    const Mat4 isFromWs = glm::inverse(pieces.wsFromIs);
    const Mat3 linear(isFromWs);
    // The displacements beyond the mean one, in index space: voxel i receives the value at i - displacement.
    const auto ways = [&](Bounds range) {
        range.lower -= m_mean;
        range.upper -= m_mean;
        return mapped(linear, range);
    };
    // Collects the blocks that the moved field may touch. Where the velocity is 0, all voxels move by the same
    // displacement; elsewhere the velocity has blocks. No block lies further away than the largest displacement.
    std::vector<Int3>& found = pieces.blockOrigins;
    const Bounds still = ways({Vec3(0), Vec3(0)}), furthest = ways(m_path.range()), all = field->isBounds();
    const Bounds reach{all.lower + furthest.lower - 1.0, all.upper + furthest.upper + 1.0};
    const auto find = [&](Bounds is) {
        is.lower = glm::max(is.lower, reach.lower);
        is.upper = glm::min(is.upper, reach.upper);
        visitBlocks(is, [&](const Int3& block) { found.push_back(block); });
    };
    forCubes(*field, [&](const Bounds& is) { find({is.lower + still.lower - 1.0, is.upper + still.upper + 1.0}); });
    for (const FieldMap& part : m_parts->maps)
        forCubes(part.field(), [&](const Bounds& is) {
            find(transformed(isFromWs * part.wsFromIs(), {is.lower - 1.0, is.upper + 1.0}));
        });
    std::sort(found.begin(), found.end(), originLess);
    found.erase(std::unique(found.begin(), found.end()), found.end());
    std::erase_if(found, [&](const Int3& block) {
        const Bounds box = boxOf(block), way = ways(m_parts->range(transformed(pieces.wsFromIs, box), m_path.time));
        return from.most({box.lower - way.upper, box.upper - way.lower}) == 0;
    });
    for (Int3& origin : found) origin *= kBlockEdge;
    const std::vector<Int3> origins = found;
    pieces.fill = [&, wsFromIs = pieces.wsFromIs](std::size_t b, float* to) {
        for (int i = 0; i < kBlockVoxels; ++i) {
            const Vec3 is(origins[b] + voxelOf(i));
            const Vec3 way = m_path.time * m_parts->at(transformPoint(wsFromIs, is)) - m_mean;
            to[i] = static_cast<float>(from.at(is - linear * way));
        }
    };
    return std::make_shared<SparseField>(buildField(std::move(pieces)));
}

}  // namespace scrim
