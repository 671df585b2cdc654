// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/coarser.h>

#include <scrim/volume/block_index.h>
#include <scrim/volume/field_builder.h>

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

namespace scrim {

namespace {

/// One octant of a coarse block: a fine block, or a part of a tile.
struct Part {
    Int3 coarseOrigin;
    int octant;           ///< 4 x + 2 y + z
    const float* values;  ///< null: `constant` everywhere
    float constant;
};

/// Finds the coarse block that contains the fine block at `origin`, a multiple of 8. The arithmetic shift divides by 16
/// and rounds down, also below zero.
Part partAt(const Int3& origin, const float* values, float constant) {
    const Int3 block(origin.x >> 3, origin.y >> 3, origin.z >> 3);
    const Int3 coarse(block.x >> 1, block.y >> 1, block.z >> 1);
    return {coarse * kBlockEdge, 4 * (block.x & 1) + 2 * (block.y & 1) + (block.z & 1), values, constant};
}

void addPart(const Part& part, float* coarse) {
    constexpr int kHalf = kBlockEdge / 2;
    const int x0 = part.octant & 4 ? kHalf : 0;
    const int y0 = part.octant & 2 ? kHalf : 0;
    const int z0 = part.octant & 1 ? kHalf : 0;
    for (int x = 0; x < kHalf; ++x)
        for (int y = 0; y < kHalf; ++y) {
            float* out = coarse + blockOffset(x0 + x, y0 + y, z0);
            if (part.values == nullptr) {
                std::fill(out, out + kHalf, part.constant);
                continue;
            }
            const float* a = part.values + blockOffset(2 * x, 2 * y, 0);
            const float* b = part.values + blockOffset(2 * x, 2 * y + 1, 0);
            const float* c = part.values + blockOffset(2 * x + 1, 2 * y, 0);
            const float* d = part.values + blockOffset(2 * x + 1, 2 * y + 1, 0);
            // Each value is divided by eight first, because the sum of eight large values could overflow.
            std::array<float, kBlockEdge> row;
            for (std::size_t z = 0; z < row.size(); ++z)
                row[z] = (0.125f * a[z] + 0.125f * b[z]) + (0.125f * c[z] + 0.125f * d[z]);
            for (int z = 0; z < kHalf; ++z) {
                const auto n = std::size_t(2 * z);
                out[z] = row[n] + row[n + 1];
            }
        }
}

bool even(const ConstantTile& tile) {
    constexpr int kMask = 2 * kBlockEdge - 1;
    return ((tile.origin.x | tile.origin.y | tile.origin.z | tile.edge) & kMask) == 0;
}

/// Collects the parts of coarse blocks. Tiles that remain tiles go to `tiles`.
std::vector<Part> collectParts(const SparseField& fine, std::vector<ConstantTile>& tiles) {
    std::vector<Part> parts;
    parts.reserve(fine.blockCount() + fine.tiles.size());
    for (std::size_t i = 0; i < fine.blockCount(); ++i) parts.push_back(partAt(fine.blockOrigins[i], fine.block(i), 0));
    for (const ConstantTile& tile : fine.tiles) {
        if (even(tile)) {
            tiles.push_back(
                {Int3(tile.origin.x >> 1, tile.origin.y >> 1, tile.origin.z >> 1), tile.edge / 2, tile.value});
            continue;
        }
        for (int x = 0; x < tile.edge; x += kBlockEdge)
            for (int y = 0; y < tile.edge; y += kBlockEdge)
                for (int z = 0; z < tile.edge; z += kBlockEdge)
                    parts.push_back(partAt(tile.origin + Int3(x, y, z), nullptr, tile.value));
    }
    std::sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) {
        if (a.coarseOrigin != b.coarseOrigin) return originLess(a.coarseOrigin, b.coarseOrigin);
        return a.octant < b.octant;
    });
    return parts;
}

SparseField meansOf(const SparseField& fine) {
    FieldPieces pieces;
    const std::vector<Part> parts = collectParts(fine, pieces.tiles);
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
        pieces.wsFromIs[3] += 0.5 * fine.wsFromIs[axis];
        pieces.wsFromIs[axis] = 2.0 * fine.wsFromIs[axis];
    }
    pieces.fill = [&](std::size_t i, float* values) {
        std::fill(values, values + kBlockVoxels, 0.0f);
        for (std::size_t p = begins[i]; p < begins[i + 1]; ++p) addPart(parts[p], values);
    };
    return buildField(std::move(pieces));
}

// Interpolated linearly, means over two voxels lose amplitude: at w radians a fine voxel, w^2 / 8 in the mean and w^2 /
// 3 between the means, of which the fine voxels lose w^2 / 12 themselves. Subtracting 3/32 of the second differences
// gives that back to second order.
constexpr float kSharper = 3.0f / 32;

// What a voxel takes from one of its six neighbours for that. None gives more than a sixth of what it has, so no value
// becomes negative, nothing appears where there was nothing, and the sum stays the same.
float taken(float value, float beside) {
    const float wanted = kSharper * (value - beside);
    return value > beside ? std::min(wanted, beside / 6) : std::max(wanted, -value / 6);
}

/// A row of a block along z.
using Row = std::array<float, kBlockEdge>;

/// Sharpens the row (x, y) of a block. `sides`: the blocks below and above it along each axis; null: its voxels take
/// nothing from there.
void sharpenRow(const float* own, const std::array<const float*, 6>& sides, int x, int y, float* out) {
    const float* const values = own + blockOffset(x, y, 0);
    Row sharp;
    std::copy_n(values, kBlockEdge, sharp.begin());
    const auto take = [&](const float* beside) {
        for (std::size_t z = 0; z < kBlockEdge; ++z) sharp[z] += taken(values[z], beside[z]);
    };
    for (int axis = 0; axis < 2; ++axis)
        for (int up = 0; up < 2; ++up) {
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
    take(below.data());
    take(above.data());
    for (int z = 0; z < kBlockEdge; ++z) out[z] = std::min(sharp[std::size_t(z)], std::numeric_limits<float>::max());
}

SparseField sharpened(const SparseField& field) {
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
            for (int y = 0; y < kBlockEdge; ++y) sharpenRow(own, sides, x, y, values + blockOffset(x, y, 0));
    };
    return buildField(std::move(pieces));
}

}  // namespace

SparseField coarser(const SparseField& fine) {
    SparseField coarse = sharpened(meansOf(fine));
    coarse.nonFinite = fine.nonFinite;
    coarse.negative = fine.negative;
    return coarse;
}

std::shared_ptr<const SparseField> CoarserLevels::below(const std::shared_ptr<const SparseField>& fine) {
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
    std::shared_ptr<const SparseField>& found = m_below[fine];
    if (!found) found = std::make_shared<SparseField>(coarser(*fine));
    return found;
}

}  // namespace scrim
