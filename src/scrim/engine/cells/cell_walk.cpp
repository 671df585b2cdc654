// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/cells/cell_walk.h>

#include <scrim/geometry/cubic_weights.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include <glm/common.hpp>

namespace scrim {
namespace {

// The cells of one slice that a point is interpolated from, by Catmull and Rom's cubic across the
// slice's axis: linear interpolation would blur the medium.
class CellsOfSlice {
  public:
    CellsOfSlice(const CellGrid& grid, int axis)
        : m_grid(grid),
          m_axes{axis, (axis + 1) % 3, (axis + 2) % 3},
          m_steps{kSteps[m_axes[0]], kSteps[m_axes[1]], kSteps[m_axes[2]]} {}

    // Turns to a point, in cells, of slice `slice`. False: none of the cells is stored.
    bool turnTo(int slice, double atA, double atB) {
        const int firstA = below(atA - 1.5), firstB = below(atB - 1.5);
        m_along = cubicWeights(atA - 1.5 - firstA);
        m_beside = cubicWeights(atB - 1.5 - firstB);
        const std::array<int, 3> block{slice >> 3, firstA >> 3, firstB >> 3};
        if (block != m_block) findBlocks(block);
        const std::size_t inA = std::size_t(firstA & 7), inB = std::size_t(firstB & 7),
                          before = std::size_t(slice & 7) * m_steps[0];
        m_inOneBlock = inA <= kCellEdge - 4 && inB <= kCellEdge - 4;
        if (m_inOneBlock) {
            m_first =
                std::size_t(std::max(m_stored[0], 0)) * kBlockCells + before + inA * m_steps[1] + inB * m_steps[2];
            return m_stored[0] >= 0;
        }
        for (std::size_t i = 0; i < 16; ++i) {
            const std::size_t ownA = inA + (i & 3), ownB = inB + (i >> 2);
            const std::int32_t stored = m_stored[(ownA >> 3) + 2 * (ownB >> 3)];
            m_cells[i] = stored < 0 ? -1
                                    : std::ptrdiff_t(std::size_t(stored) * kBlockCells + before +
                                                     (ownA & 7) * m_steps[1] + (ownB & 7) * m_steps[2]);
        }
        return std::ranges::any_of(m_stored, [](std::int32_t stored) { return stored >= 0; });
    }

    // The weighted sums of `values` and of their squares; cells that are not stored have 0.
    std::pair<double, double> sums(const std::vector<Real>& values) const {
        std::array<Real, 16> own{};
        for (std::size_t i = 0; i < 16; ++i) {
            if (m_inOneBlock)
                own[i] = values[m_first + (i & 3) * m_steps[1] + (i >> 2) * m_steps[2]];
            else if (m_cells[i] >= 0)
                own[i] = values[std::size_t(m_cells[i])];
        }
        double sum = 0, squares = 0;
        for (std::size_t b = 0; b < 4; ++b) {
            double row = 0, rowSquares = 0;
            for (std::size_t a = 0; a < 4; ++a) {
                const double value = own[4 * b + a], weighted = m_along[a] * value;
                row += weighted;
                rowSquares += weighted * value;
            }
            sum += m_beside[b] * row;
            squares += m_beside[b] * rowSquares;
        }
        return {sum, squares};
    }

  private:
    static constexpr std::size_t kSteps[3] = {1, kCellEdge, std::size_t(kCellEdge) * kCellEdge};
    // std::floor is a call where the machine is not known to round by itself.
    static int below(double x) {
        const int whole = static_cast<int>(x);
        return whole - (x < whole ? 1 : 0);
    }

    // `block`: along the slices' axis, and across. It and those beside it across the axis are looked up.
    void findBlocks(const std::array<int, 3>& block) {
        m_block = block;
        for (int i = 0; i < 4; ++i) {
            Int3 own;
            own[m_axes[0]] = block[0];
            own[m_axes[1]] = block[1] + (i & 1);
            own[m_axes[2]] = block[2] + (i >> 1);
            m_stored[std::size_t(i)] = m_grid.stored(own);
        }
    }

    const CellGrid& m_grid;
    std::array<int, 3> m_axes;           // the slices', and those across
    std::array<std::size_t, 3> m_steps;  // from cell to cell of a block along them
    std::array<double, 4> m_along{}, m_beside{};
    bool m_inOneBlock = false;  // the cells are in one block, from m_first on; otherwise they are m_cells
    std::size_t m_first = 0;
    std::array<std::ptrdiff_t, 16> m_cells{};
    std::array<int, 3> m_block{1 << 28, 0, 0};
    std::array<std::int32_t, 4> m_stored{};
};

}  // namespace

Rgb opticalDepth(const MediaTogether& media, const Vec3& ws, const Vec3& direction, double distance, double most) {
    Rgb tau(0);
    for (const CellMedia* one : media) tau += opticalDepths(*one, ws, direction, distance, most).tau;
    return tau;
}

Depths bundleDepths(const CellMedia& media, const Vec3& ws, const Vec3& direction, double distance) {
    constexpr double kDark = 16;    // a ten-millionth of the light is left
    constexpr double kEven = 1e-6;  // variance relative to depth
    const CellGrid& grid = media.grid;
    const int axis = axisOfLargest(glm::abs(direction)), a = (axis + 1) % 3, b = (axis + 2) % 3;
    const bool up = direction[axis] > 0, grey = media.extinction.size() == 1;
    const Vec3 from = grid.csFromWs(ws), way = direction / std::abs(direction[axis]);  // `way`: to the next slice
    const double length = distance * std::abs(direction[axis]) / grid.edge();          // slices
    const int size = grid.blocks()[axis] * kCellEdge;
    const double edge = grid.edge() / std::abs(direction[axis]);
    const double fromA = from[a], fromB = from[b], wayA = way[a], wayB = way[b];  // across the slices
    CellsOfSlice cells(grid, axis);
    Depths out;
    Rgb variance(0);  // of tau across the bundle
    // Thin parts of the bundle let more light pass than thick ones take from it. Slices are taken for independent, so
    // that depths have about a gamma distribution of this mean and variance; its mean of e^-depth is known.
    const auto through = [&](int c) {
        const double depth = out.tau[c];
        return variance[c] > kEven * depth ? depth * depth / variance[c] * std::log1p(variance[c] / depth) : depth;
    };
    double most = kDark;  // beyond the first slice, which may be thicker alone
    double begin = 0, end = up ? std::floor(from[axis]) + 1 - from[axis] : from[axis] - std::ceil(from[axis]) + 1;
    for (int slice = static_cast<int>(up ? std::floor(from[axis]) : std::ceil(from[axis]) - 1);
         begin < length && (up ? slice < size : slice >= 0); slice += up ? 1 : -1, begin = end, end += 1) {
        const double to = std::min(end, length), step = (to - begin) * edge;
        const double half = 0.5 * (begin + to);
        if (!cells.turnTo(slice, fromA + half * wayA, fromB + half * wayB)) continue;
        for (std::size_t c = 0; c < media.extinction.size(); ++c) {
            const auto [sum, squares] = cells.sums(media.extinction[c]);
            const double mean = std::max(step * sum, 0.0);  // the cubic goes below 0 beside steep edges
            out.tau[int(c)] += mean;
            variance[int(c)] += std::max(step * step * squares - mean * mean, 0.0);
        }
        for (std::size_t c = 0; c < media.straight.size(); ++c)
            out.straight[int(c)] += step * cells.sums(media.straight[c]).first;
        const double depth = grey ? out.tau.x : smallest(out.tau);
        if (begin == 0) most += depth;
        if (depth > most && (grey ? through(0) : std::min({through(0), through(1), through(2)})) > kDark) break;
    }
    for (int c = 0; c < 3; ++c) out.tau[c] = through(c);
    out.straight = glm::max(out.straight, Rgb(0));
    return grey ? Depths{Rgb(out.tau.x), Rgb(out.straight.x)} : out;
}

Depths opticalDepths(const CellMedia& media, const Vec3& ws, const Vec3& direction, double distance, double most) {
    const bool grey = media.extinction.size() == 1, straight = !media.straight.empty();
    Depths out;
    Rgb& tau = out.tau;
    walkCells(media.grid, ws, direction, distance, [&](std::ptrdiff_t index, double from, double to) {
        if (index < 0) return true;
        const double way = to - from;
        tau.x += way * media.extinction[0][std::size_t(index)];
        if (!grey) {
            tau.y += way * media.extinction[1][std::size_t(index)];
            tau.z += way * media.extinction[2][std::size_t(index)];
        }
        for (std::size_t c = 0; straight && c < media.straight.size(); ++c)
            out.straight[int(c)] += way * media.straight[c][std::size_t(index)];
        return (grey ? tau.x : smallest(tau)) <= most;
    });
    return grey ? Depths{Rgb(tau.x), Rgb(out.straight.x)} : out;
}

}  // namespace scrim
