// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/transport/cell_levels.h>

#include <scrim/base/parallel.h>

#include <algorithm>
#include <array>
#include <utility>

#include <glm/common.hpp>

namespace scrim {
namespace {

// Coarser cells along an edge of a finer block, including one around it on each side.
constexpr int kAround = kCellEdge / 2 + 2;
constexpr std::size_t kNear = std::size_t(kAround) * kAround * kAround;
// Of two neighbours along an axis, the nearer one has the weight three quarters.
constexpr Real kNearer = Real(0.75), kFarther = Real(0.25);

// The indices of the two coarser cells beside cell i of an edge: the nearer one, and the other.
constexpr int nearer(int i) {
    return i / 2 + 1;
}
constexpr int farther(int i) {
    return nearer(i) + ((i & 1) != 0 ? 1 : -1);
}

using Rows = std::array<const Real*, kNear>;

// Interpolates one value per row, along one axis after the other: sums of values, and how many cells they have.
void addOne(const Rows& near, const std::int32_t* rows, Real* to) {
    constexpr int kE = kCellEdge, kA = kAround;
    using Pair = std::array<Real, 2>;  // value, weight
    const auto mix = [](const Pair& a, const Pair& b) {
        return Pair{kNearer * a[0] + kFarther * b[0], kNearer * a[1] + kFarther * b[1]};
    };
    std::array<Pair, kNear> cells;
    for (std::size_t i = 0; i < kNear; ++i) cells[i] = near[i] ? Pair{*near[i], 1} : Pair{0, 0};
    std::array<Pair, std::size_t(kE) * kA * kA> alongX;
    for (int i = 0; i < kA * kA; ++i)
        for (int x = 0; x < kE; ++x)
            alongX[std::size_t(i * kE + x)] =
                mix(cells[std::size_t(i * kA + nearer(x))], cells[std::size_t(i * kA + farther(x))]);
    std::array<Pair, std::size_t(kE) * kE * kA> alongY;
    for (int z = 0; z < kA; ++z)
        for (int y = 0; y < kE; ++y)
            for (int x = 0; x < kE; ++x)
                alongY[std::size_t((z * kE + y) * kE + x)] = mix(alongX[std::size_t((z * kA + nearer(y)) * kE + x)],
                                                                 alongX[std::size_t((z * kA + farther(y)) * kE + x)]);
    for (int z = 0; z < kE; ++z)
        for (int i = 0; i < kE * kE; ++i) {
            const std::int32_t row = rows[z * kE * kE + i];
            const Pair sum =
                mix(alongY[std::size_t(nearer(z) * kE * kE + i)], alongY[std::size_t(farther(z) * kE * kE + i)]);
            if (row >= 0 && sum[1] > 0) to[row] += sum[0] / sum[1];
        }
}

void addMany(const Rows& near, const Int3& cell, std::size_t values, Real* to) {
    std::array<std::pair<const Real*, Real>, 8> parts;
    std::size_t count = 0;
    Real sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        Int3 at;
        Real weight = 1;
        for (int axis = 0; axis < 3; ++axis) {
            const bool other = (corner >> axis & 1) != 0;
            at[axis] = other ? farther(cell[axis]) : nearer(cell[axis]);
            weight *= other ? kFarther : kNearer;
        }
        const Real* row = near[std::size_t((at.z * kAround + at.y) * kAround + at.x)];
        if (!row) continue;
        sum += weight;
        parts[count++] = {row, weight};
    }
    for (std::size_t i = 0; i < count; ++i) {
        const Real weight = parts[i].second / sum;
        for (std::size_t m = 0; m < values; ++m) to[m] += weight * parts[i].first[m];
    }
}

}  // namespace

void addInterpolated(const CellRows& coarse, const std::vector<Real>& from, const CellRows& fine, std::size_t values,
                     std::vector<Real>& to) {
    const Int3 shift(glm::round(coarse.grid->csFromWs(fine.grid->wsFromCs(Vec3(0)))));
    parallelFor(fine.grid->storedBlocks().size(), [&](std::size_t block) {
        Rows near;
        const Int3 first = shift + fine.grid->storedBlocks()[block] * (kCellEdge / 2) - 1;
        for (std::size_t i = 0; i < near.size(); ++i) {
            const auto n = static_cast<int>(i);
            const std::ptrdiff_t cell =
                coarse.grid->index(first + Int3(n % kAround, n / kAround % kAround, n / (kAround * kAround)));
            const std::int32_t row = cell < 0 ? -1 : (*coarse.rows)[std::size_t(cell)];
            near[i] = row < 0 ? nullptr : from.data() + std::size_t(row) * values;
        }
        const std::int32_t* rows = fine.rows->data() + block * kBlockCells;
        if (values == 1) return addOne(near, rows, to.data());
        for (int i = 0; i < kBlockCells; ++i)
            if (rows[i] >= 0)
                addMany(near, {i % kCellEdge, i / kCellEdge % kCellEdge, i / (kCellEdge * kCellEdge)}, values,
                        to.data() + std::size_t(rows[i]) * values);
    });
}

}  // namespace scrim
