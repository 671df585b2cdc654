// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/velocity_parts.h>

#include <scrim/base/parallel.h>
#include <scrim/scene/field_rays.h>
#include <scrim/shot/values_at.h>
#include <scrim/volume/field_builder.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace scrim {
namespace {

Bounds rangeOf(double time, const Vec3& positive, const Vec3& negative) {
    const Vec3 a = time * positive, b = -time * negative;
    return {glm::min(glm::min(a, b), Vec3(0)), glm::max(glm::max(a, b), Vec3(0))};
}

}  // namespace

VelocityParts::VelocityParts(std::vector<FieldPointer> velocity) : m_velocity(std::move(velocity)) {
    for (const FieldPointer& part : m_velocity) m_maps.emplace_back(*part);
}

Vec3 VelocityParts::at(const Vec3& ws) const {
    Vec3 v;
    for (int axis = 0; axis < 3; ++axis)
        v[axis] = m_maps[std::size_t(2 * axis)].atWs(ws) - m_maps[std::size_t(2 * axis + 1)].atWs(ws);
    return v;
}

Bounds VelocityParts::range(const Bounds& ws, double time) const {
    Vec3 positive, negative;
    for (int axis = 0; axis < 3; ++axis) {
        const FieldMap &above = m_maps[std::size_t(2 * axis)], &below = m_maps[std::size_t(2 * axis + 1)];
        positive[axis] = above.most(transformed(above.isFromWs(), ws));
        negative[axis] = below.most(transformed(below.isFromWs(), ws));
    }
    return rangeOf(time, positive, negative);
}

Bounds VelocityParts::range(double time) const {
    Vec3 positive, negative;
    for (int axis = 0; axis < 3; ++axis) {
        positive[axis] = m_maps[std::size_t(2 * axis)].field().maxValue;
        negative[axis] = m_maps[std::size_t(2 * axis + 1)].field().maxValue;
    }
    return rangeOf(time, positive, negative);
}

Vec3 VelocityParts::mean(const SparseField& field) const {
    struct Sum {
        Vec3 v{0};
        double weight = 0;
    };
    // Outliers are left out: a voxel or two may be a million times as fast as all others, and must
    // not shift the whole lattice.
    Bounds usual;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        usual.upper[int(axis)] = usualMost(m_maps[2 * axis].field());
        usual.lower[int(axis)] = -usualMost(m_maps[2 * axis + 1].field());
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

void VelocityParts::addVelocities(const Mat4& wsFromIs, const Int3& origin, FieldBrick& brick,
                                  BlockVectors& velocities) const {
    for (std::size_t p = 0; p < m_maps.size(); ++p) {
        const Mat4 partFromIs = m_maps[p].isFromWs() * wsFromIs;
        const Bounds is = transformed(partFromIs, boxOf(origin >> 3));
        if (m_maps[p].most(is) == 0) continue;
        std::array<float, kBlockVoxels>& part = velocities[p / 2];
        const float sign = p % 2 == 0 ? 1 : -1;
        if (keepsAxes(partFromIs)) {
            // The lattices differ by a shift.
            const Vec3 first = transformPoint(partFromIs, Vec3(origin)), floor = glm::floor(first);
            brick.fill(m_maps[p].index(), Int3(floor), Int3(floor) + kBlockEdge);
            brick.addBlock(first - floor, sign, part.data());
        } else {
            for (std::size_t i = 0; i < kBlockVoxels; ++i) {
                const Vec3 place = Vec3(origin) + Vec3(kVoxels[0][i], kVoxels[1][i], kVoxels[2][i]);
                part[i] += sign * static_cast<float>(m_maps[p].at(transformPoint(partFromIs, place)));
            }
        }
    }
}

BlockVectors VelocityParts::velocitiesAt(const Mat4& wsFromIs, const Int3& origin, const BlockVectors& at,
                                         const Bounds& is, FieldBrick& brick) const {
    BlockVectors velocities{};
    for (std::size_t p = 0; p < m_maps.size(); ++p) {
        const FieldMap& map = m_maps[p];
        const Mat4 partFromIs = map.isFromWs() * wsFromIs;
        const Bounds box = transformed(partFromIs, is);
        if (map.most(box) == 0) continue;
        const bool copied = brick.fill(map.sampler(), {box.lower - 1.0, box.upper + 1.0});
        const float sign = p % 2 == 0 ? 1 : -1;
        for (std::size_t i = 0; i < kBlockVoxels; ++i) {
            const Vec3 place = transformPoint(partFromIs, Vec3(origin) + Vec3(at[0][i], at[1][i], at[2][i]));
            velocities[p / 2][i] += sign * static_cast<float>(copied ? brick.value(place) : map.at(place));
        }
    }
    return velocities;
}

// Where the velocity is 0, all voxels move by the same displacement; elsewhere the velocity has
// blocks. No block lies further away than the largest displacement.
std::vector<Int3> VelocityParts::blocksOf(const FieldMap& from, const Mat4& wsFromIs,
                                          const std::function<Bounds(Bounds)>& ways, double time, bool bent) const {
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
    for (std::size_t p = 0; p < m_maps.size(); ++p) {
        const FieldMap& part = m_maps[p];
        forCubes(part.field(), [&](const Bounds& is) { cubes.emplace_back(Int3(is.lower), Int3(is.upper)); });
        if (p + 1 < m_maps.size() && m_maps[p + 1].wsFromIs() == part.wsFromIs()) continue;
        std::sort(cubes.begin(), cubes.end(), before);
        cubes.erase(std::unique(cubes.begin(), cubes.end()), cubes.end());
        for (const auto& [lower, upper] : cubes)
            find(transformed(isFromWs * part.wsFromIs(), {Vec3(lower) - 1.0, Vec3(upper) + 1.0}));
        cubes.clear();
    }
    std::sort(found.begin(), found.end(), originLess);
    found.erase(std::unique(found.begin(), found.end()), found.end());
    std::erase_if(found, [&](const Int3& block) {
        const Bounds box = boxOf(block);
        Bounds way = ways(range(transformed(wsFromIs, box), time));
        if (bent) way = ways(range(transformed(wsFromIs, {box.lower - way.upper, box.upper - way.lower}), time));
        return from.most({box.lower - way.upper, box.upper - way.lower}) == 0;
    });
    for (Int3& origin : found) origin *= kBlockEdge;
    return found;
}

}  // namespace scrim
