// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/coarser.h>

#include <scrim/volume/block_index.h>
#include <scrim/volume/field_builder.h>

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include <glm/geometric.hpp>

namespace scrim {

namespace {

/// A fine block, or a part of a tile, as it lies in a coarse block.
struct Part {
    Int3 coarseOrigin;
    Int3 first;           ///< the first voxel of the coarse block that it covers
    const float* values;  ///< null: `constant` everywhere
    float constant;
};

// Halves what is an index on the halved axes. The arithmetic shift rounds down, also below zero.
Int3 half(const Int3& index, const HalvedAxes& halved) {
    return {index.x >> int(halved[0]), index.y >> int(halved[1]), index.z >> int(halved[2])};
}

/// The part that the fine block at `origin`, a multiple of 8, is.
Part partAt(const Int3& origin, const float* values, float constant, const HalvedAxes& halved) {
    const Int3 coarse = half(origin, halved);
    const Int3 first(coarse.x & (kBlockEdge - 1), coarse.y & (kBlockEdge - 1), coarse.z & (kBlockEdge - 1));
    return {coarse - first, first, values, constant};
}

/// A row of a block along z.
using Row = std::array<float, kBlockEdge>;

void addPart(const Part& part, const HalvedAxes& halved, float* coarse) {
    Int3 size, covered;  // of the part in coarse voxels, and how many fine voxels each covers along an axis
    for (int axis = 0; axis < 3; ++axis) {
        covered[axis] = halved[std::size_t(axis)] ? 2 : 1;
        size[axis] = kBlockEdge / covered[axis];
    }
    // Each value is divided first, because the sum of eight large values could overflow.
    const float share = 1.0f / float(covered.x * covered.y * covered.z);
    for (int x = 0; x < size.x; ++x)
        for (int y = 0; y < size.y; ++y) {
            float* out = coarse + blockOffset(part.first.x + x, part.first.y + y, part.first.z);
            if (part.values == nullptr) {
                std::fill(out, out + size.z, part.constant);
                continue;
            }
            Row row{};
            for (int i = 0; i < covered.x; ++i) {
                Row along{};
                for (int j = 0; j < covered.y; ++j) {
                    const float* fine = part.values + blockOffset(covered.x * x + i, covered.y * y + j, 0);
                    for (std::size_t z = 0; z < row.size(); ++z) along[z] += share * fine[z];
                }
                for (std::size_t z = 0; z < row.size(); ++z) row[z] += along[z];
            }
            for (int z = 0; z < size.z; ++z) {
                const auto n = std::size_t(covered.z * z);
                out[z] = covered.z == 2 ? row[n] + row[n + 1] : row[n];
            }
        }
}

bool even(const ConstantTile& tile) {
    constexpr int kMask = 2 * kBlockEdge - 1;
    return ((tile.origin.x | tile.origin.y | tile.origin.z | tile.edge) & kMask) == 0;
}

/// Adds what an even tile becomes: one of half the edge, and along axes that are not halved two of them.
void addTile(const ConstantTile& tile, const HalvedAxes& halved, std::vector<ConstantTile>& tiles) {
    const Int3 origin = half(tile.origin, halved);
    const int edge = tile.edge / 2;
    const auto last = [&](int axis) { return halved[std::size_t(axis)] ? 0 : edge; };
    for (int x = 0; x <= last(0); x += edge)
        for (int y = 0; y <= last(1); y += edge)
            for (int z = 0; z <= last(2); z += edge) tiles.push_back({origin + Int3(x, y, z), edge, tile.value});
}

/// Collects the parts of coarse blocks. Tiles that remain tiles go to `tiles`.
std::vector<Part> collectParts(const SparseField& fine, const HalvedAxes& halved, std::vector<ConstantTile>& tiles) {
    std::vector<Part> parts;
    parts.reserve(fine.blockCount() + fine.tiles.size());
    for (std::size_t i = 0; i < fine.blockCount(); ++i)
        parts.push_back(partAt(fine.blockOrigins[i], fine.block(i), 0, halved));
    for (const ConstantTile& tile : fine.tiles) {
        if (even(tile)) {
            addTile(tile, halved, tiles);
            continue;
        }
        for (int x = 0; x < tile.edge; x += kBlockEdge)
            for (int y = 0; y < tile.edge; y += kBlockEdge)
                for (int z = 0; z < tile.edge; z += kBlockEdge)
                    parts.push_back(partAt(tile.origin + Int3(x, y, z), nullptr, tile.value, halved));
    }
    std::sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) {
        if (a.coarseOrigin != b.coarseOrigin) return originLess(a.coarseOrigin, b.coarseOrigin);
        return originLess(a.first, b.first);
    });
    return parts;
}

SparseField meansOf(const SparseField& fine, const HalvedAxes& halved) {
    FieldPieces pieces;
    const std::vector<Part> parts = collectParts(fine, halved, pieces.tiles);
    std::vector<std::size_t> begins;  // index of the first part of each coarse block
    for (std::size_t i = 0; i < parts.size(); ++i) {
        if (i > 0 && parts[i].coarseOrigin == parts[i - 1].coarseOrigin) continue;
        begins.push_back(i);
        pieces.blockOrigins.push_back(parts[i].coarseOrigin);
    }
    begins.push_back(parts.size());

    pieces.name = fine.name;
    // The centre of coarse voxel c lies half-way between those of the fine voxels 2c and 2c + 1.
    pieces.wsFromIs = fine.wsFromIs;
    for (int axis = 0; axis < 3; ++axis) {
        if (!halved[std::size_t(axis)]) continue;
        pieces.wsFromIs[3] += 0.5 * fine.wsFromIs[axis];
        pieces.wsFromIs[axis] = 2.0 * fine.wsFromIs[axis];
    }
    pieces.fill = [&](std::size_t i, float* values) {
        std::fill(values, values + kBlockVoxels, 0.0f);
        for (std::size_t p = begins[i]; p < begins[i + 1]; ++p) addPart(parts[p], halved, values);
    };
    return buildField(std::move(pieces));
}

// Interpolated linearly, means over two voxels lose amplitude: at w radians a fine voxel, w^2 / 8
// in the mean and w^2 / 3 between the means, of which the fine voxels lose w^2 / 12 themselves.
// Subtracting 3/32 of the second differences gives that back to second order.
constexpr float kSharper = 3.0f / 32;

// What a voxel takes from one of its six neighbours for that. None gives more than a sixth of what it has, so no value
// becomes negative, nothing appears where there was nothing, and the sum stays the same.
float taken(float value, float beside) {
    const float wanted = kSharper * (value - beside);
    return value > beside ? std::min(wanted, beside / 6) : std::max(wanted, -value / 6);
}

/// Sharpens the row (x, y) of a block along the axes that were halved. `sides`: the blocks below
/// and above it along each axis; null: its voxels take nothing from there.
void sharpenRow(const float* own, const std::array<const float*, 6>& sides, const HalvedAxes& halved, int x, int y,
                float* out) {
    const float* const values = own + blockOffset(x, y, 0);
    Row sharp;
    std::copy_n(values, kBlockEdge, sharp.begin());
    const auto take = [&](const float* beside) {
        for (std::size_t z = 0; z < kBlockEdge; ++z) sharp[z] += taken(values[z], beside[z]);
    };
    for (int axis = 0; axis < 2; ++axis)
        for (int up = 0; up < 2 && halved[std::size_t(axis)]; ++up) {
            Int3 beside(x, y, 0);
            beside[axis] += up ? 1 : -1;
            const bool outside = (beside[axis] & ~(kBlockEdge - 1)) != 0;
            const float* const from = outside ? sides[std::size_t(2 * axis + up)] : own;
            if (from != nullptr) take(from + blockOffset(beside.x & (kBlockEdge - 1), beside.y & (kBlockEdge - 1), 0));
        }
    constexpr int kLast = kBlockEdge - 1;
    // From a voxel of the same value, nothing is taken.
    Row below, above;
    std::copy_n(values, kLast, below.begin() + 1);
    std::copy_n(values + 1, kLast, above.begin());
    below.front() = sides[4] != nullptr ? sides[4][blockOffset(x, y, kLast)] : values[0];
    above.back() = sides[5] != nullptr ? sides[5][blockOffset(x, y, 0)] : values[kLast];
    if (halved[2]) {
        take(below.data());
        take(above.data());
    }
    for (int z = 0; z < kBlockEdge; ++z) out[z] = std::min(sharp[std::size_t(z)], std::numeric_limits<float>::max());
}

SparseField sharpened(const SparseField& field, const HalvedAxes& halved) {
    const BlockIndex index(field);
    FieldPieces pieces;
    pieces.name = field.name;
    pieces.wsFromIs = field.wsFromIs;
    pieces.blockOrigins = field.blockOrigins;
    pieces.tiles = field.tiles;
    pieces.fill = [&](std::size_t i, float* values) {
        const float* own = field.block(i);
        std::array<const float*, 6> sides;  // null: empty, or a tile, which stays as it is
        for (int axis = 0; axis < 3; ++axis)
            for (int up = 0; up < 2; ++up) {
                Int3 cube = field.blockOrigins[i] >> 3;
                cube[axis] += up ? 1 : -1;
                sides[std::size_t(2 * axis + up)] = index.at(cube).values;
            }
        for (int x = 0; x < kBlockEdge; ++x)
            for (int y = 0; y < kBlockEdge; ++y) sharpenRow(own, sides, halved, x, y, values + blockOffset(x, y, 0));
    };
    return buildField(std::move(pieces));
}

}  // namespace

Vec3 voxelEdges(const Mat4& wsFromIs) {
    const auto edge = [&](int axis) { return glm::length(Vec3(wsFromIs[axis])); };
    return {edge(0), edge(1), edge(2)};
}

HalvedAxes shortAxes(const Mat4& wsFromIs) {
    constexpr double kAlike = 1.5;
    const Vec3 edges = voxelEdges(wsFromIs);
    const double longest = kAlike * smallest(edges);
    return {edges.x < longest, edges.y < longest, edges.z < longest};
}

SparseField coarser(const SparseField& fine, const HalvedAxes& halved) {
    SparseField coarse = sharpened(meansOf(fine, halved), halved);
    coarse.nonFinite = fine.nonFinite;
    coarse.negative = fine.negative;
    return coarse;
}

std::shared_ptr<const SparseField> CoarserLevels::below(const std::shared_ptr<const SparseField>& fine,
                                                        const HalvedAxes& halved) {
    const std::lock_guard lock(m_mutex);
    for (bool again = true; again;) {  // a field that is dropped may have kept the next one
        again = false;
        for (auto i = m_below.begin(); i != m_below.end();)
            if (i->first.expired()) {
                i = m_below.erase(i);
                again = true;
            } else {
                ++i;
            }
    }
    std::shared_ptr<const SparseField>& found = m_below[fine][halved];
    if (!found) found = std::make_shared<SparseField>(coarser(*fine, halved));
    return found;
}

}  // namespace scrim
