// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/moved_field.h>

#include <scrim/base/parallel.h>
#include <scrim/scene/field_rays.h>
#include <scrim/shot/values_at.h>
#include <scrim/volume/field_builder.h>
#include <scrim/volume/field_sampler.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <glm/vector_relational.hpp>

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
    const BlockIndex& index() const { return m_sampler.index(); }
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

// A vector for each voxel of a block, in blockOffset order.
using BlockVectors = std::array<std::array<float, kBlockVoxels>, 3>;

// The places of the voxels from the first one on.
constexpr BlockVectors kVoxels = [] {
    BlockVectors all{};
    for (std::size_t i = 0; i < kBlockVoxels; ++i) {
        all[0][i] = static_cast<float>(i / (kBlockEdge * kBlockEdge));
        all[1][i] = static_cast<float>(i / kBlockEdge % kBlockEdge);
        all[2][i] = static_cast<float>(i % kBlockEdge);
    }
    return all;
}();

// Where the values of a block come from, in index space from its first voxel on, when they have moved by `linear` times
// (time * velocity - mean). Returns the box around it.
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
    std::vector<FieldMap> maps;  // in the order of m_velocity

    // The velocity at a point of asset space.
    Vec3 at(const Vec3& ws) const {
        Vec3 v;
        for (int axis = 0; axis < 3; ++axis)
            v[axis] = maps[std::size_t(2 * axis)].atWs(ws) - maps[std::size_t(2 * axis + 1)].atWs(ws);
        return v;
    }

    // Adds to `velocities` the velocities at the voxels of the block whose first voxel is `origin`. `wsFromIs` belongs
    // to the block.
    void addVelocities(const Mat4& wsFromIs, const Int3& origin, FieldBrick& brick, BlockVectors& velocities) const;

    // The first voxels of the blocks that the field may touch when it has moved for `time` and lies at `wsFromIs`.
    // `ways` turns a box around displacements in asset space into one in index space, relative to that.
    std::vector<Int3> blocksOf(const FieldMap& from, const Mat4& wsFromIs, const std::function<Bounds(Bounds)>& ways,
                               double time) const;

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
    // The same for all samples.
    Bounds range(double time) const {
        Vec3 positive, negative;
        for (int axis = 0; axis < 3; ++axis) {
            positive[axis] = maps[std::size_t(2 * axis)].field().maxValue;
            negative[axis] = maps[std::size_t(2 * axis + 1)].field().maxValue;
        }
        return rangeOf(time, positive, negative);
    }
};

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
        const auto add = [&](const Vec3& velocity, double weight) {
            sums[b].v += weight * glm::clamp(velocity, usual.lower, usual.upper);
            sums[b].weight += weight;
        };
        if (b < field.blockCount()) {
            FieldBrick brick;
            BlockVectors v{};
            addVelocities(field.wsFromIs, field.blockOrigins[b], brick, v);
            for (std::size_t i = 0; i < kBlockVoxels; ++i) add({v[0][i], v[1][i], v[2][i]}, double(field.block(b)[i]));
        } else {
            const ConstantTile& tile = field.tiles[b - field.blockCount()];
            add(at(transformPoint(field.wsFromIs, Vec3(tile.origin) + 0.5 * (tile.edge - 1))),
                double(tile.value) * std::pow(double(tile.edge), 3));
        }
    });
    Sum all;
    for (const Sum& sum : sums) {
        all.v += sum.v;
        all.weight += sum.weight;
    }
    return all.weight > 0 ? all.v / all.weight : Vec3(0);
}

void FieldMover::Parts::addVelocities(const Mat4& wsFromIs, const Int3& origin, FieldBrick& brick,
                                      BlockVectors& velocities) const {
    for (std::size_t p = 0; p < maps.size(); ++p) {
        const Mat4 partFromIs = maps[p].isFromWs() * wsFromIs;
        const Bounds is = transformed(partFromIs, boxOf(origin >> 3));
        if (maps[p].most(is) == 0) continue;
        std::array<float, kBlockVoxels>& part = velocities[p / 2];
        const float sign = p % 2 == 0 ? 1 : -1;
        if (keepsAxes(partFromIs)) {
            // The lattices differ by a shift.
            const Vec3 first = transformPoint(partFromIs, Vec3(origin)), floor = glm::floor(first);
            brick.fill(maps[p].index(), Int3(floor), Int3(floor) + kBlockEdge);
            brick.addBlock(first - floor, sign, part.data());
        } else {
            for (std::size_t i = 0; i < kBlockVoxels; ++i) {
                const Vec3 place = Vec3(origin) + Vec3(kVoxels[0][i], kVoxels[1][i], kVoxels[2][i]);
                part[i] += sign * static_cast<float>(maps[p].at(transformPoint(partFromIs, place)));
            }
        }
    }
}

// Where the velocity is 0, all voxels move by the same displacement; elsewhere the velocity has blocks. No block lies
// further away than the largest displacement.
std::vector<Int3> FieldMover::Parts::blocksOf(const FieldMap& from, const Mat4& wsFromIs,
                                              const std::function<Bounds(Bounds)>& ways, double time) const {
    std::vector<Int3> found;
    const Mat4 isFromWs = glm::inverse(wsFromIs);
    const Bounds still = ways({Vec3(0), Vec3(0)}), furthest = ways(range(time)), all = from.field().isBounds();
    const Bounds reach{all.lower + furthest.lower - 1.0, all.upper + furthest.upper + 1.0};
    const auto find = [&](Bounds is) {
        is.lower = glm::max(is.lower, reach.lower);
        is.upper = glm::min(is.upper, reach.upper);
        visitBlocks(is, [&](const Int3& block) { found.push_back(block); });
    };
    forCubes(from.field(), [&](const Bounds& is) {
        find({is.lower + still.lower - 1.0, is.upper + still.upper + 1.0});
    });
    // Most parts have the same blocks.
    std::vector<std::pair<Int3, Int3>> cubes;
    const auto before = [](const auto& a, const auto& b) {
        return originLess(a.first, b.first) || (a.first == b.first && originLess(a.second, b.second));
    };
    for (std::size_t p = 0; p < maps.size(); ++p) {
        const FieldMap& part = maps[p];
        forCubes(part.field(), [&](const Bounds& is) { cubes.emplace_back(Int3(is.lower), Int3(is.upper)); });
        if (p + 1 < maps.size() && maps[p + 1].wsFromIs() == part.wsFromIs()) continue;
        std::sort(cubes.begin(), cubes.end(), before);
        cubes.erase(std::unique(cubes.begin(), cubes.end()), cubes.end());
        for (const auto& [lower, upper] : cubes)
            find(transformed(isFromWs * part.wsFromIs(), {Vec3(lower) - 1.0, Vec3(upper) + 1.0}));
        cubes.clear();
    }
    std::sort(found.begin(), found.end(), originLess);
    found.erase(std::unique(found.begin(), found.end()), found.end());
    std::erase_if(found, [&](const Int3& block) {
        const Bounds box = boxOf(block), way = ways(range(transformed(wsFromIs, box), time));
        return from.most({box.lower - way.upper, box.upper - way.lower}) == 0;
    });
    for (Int3& origin : found) origin *= kBlockEdge;
    return found;
}

FieldMover::FieldMover(std::vector<FieldPointer> velocity, const SparseField& weight)
    : m_velocity(std::move(velocity)) {
    auto parts = std::make_unique<Parts>();
    for (const FieldPointer& part : m_velocity) parts->maps.emplace_back(*part);
    m_mean = parts->mean(weight);
    m_parts = std::move(parts);
}

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
