// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/cells/cell_walk.h>

#include <scrim/geometry/cubic_weights.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <glm/common.hpp>

namespace scrim {
namespace {

// The cells of one slice that a point is interpolated from, by Catmull and Rom's cubic across the slice's axis: linear
// interpolation would blur the medium.
class CellsOfSlice {
  public:
    CellsOfSlice(const CellGrid& grid, int axis) : m_grid(grid), m_across{(axis + 1) % 3, (axis + 2) % 3} {}

    // Calls visit(index, weight) for those that are stored; the weights of all have the sum 1. `cs`: in cells; the
    // slice is the one that holds it.
    template <class Visit>
    void visit(const Vec3& cs, const Visit& visit) {
        const int a = m_across[0], b = m_across[1];
        Vec3 low = cs;
        low[a] -= 1.5;
        low[b] -= 1.5;
        const Int3 first(glm::floor(low));
        const std::array<double, 4> along = cubicWeights(low[a] - first[a]), beside = cubicWeights(low[b] - first[b]);
        const Int3 block(first.x >> 3, first.y >> 3, first.z >> 3), inside = first - block * kCellEdge;
        if (inside[a] > kCellEdge - 4 || inside[b] > kCellEdge - 4) {
            for (int i = 0; i < 16; ++i) {
                Int3 cell = first;
                cell[a] += i & 3;
                cell[b] += i >> 2;
                const std::ptrdiff_t index = m_grid.index(cell);
                if (index >= 0) visit(std::size_t(index), along[std::size_t(i & 3)] * beside[std::size_t(i >> 2)]);
            }
            return;
        }
        if (block != m_block) {
            m_block = block;
            m_stored = m_grid.stored(block);
        }
        if (m_stored < 0) return;
        constexpr std::size_t kSteps[3] = {1, kCellEdge, std::size_t(kCellEdge) * kCellEdge};
        const std::size_t at =
            std::size_t(m_stored) * kBlockCells + std::size_t(cellOffset(inside.x, inside.y, inside.z));
        for (std::size_t i = 0; i < 16; ++i)
            visit(at + (i & 3) * kSteps[a] + (i >> 2) * kSteps[b], along[i & 3] * beside[i >> 2]);
    }

  private:
    const CellGrid& m_grid;
    int m_across[2];
    Int3 m_block{1 << 30};
    std::int32_t m_stored = -1;
};

}  // namespace

Rgb opticalDepth(const MediaTogether& media, const Vec3& ws, const Vec3& direction, double distance, double most) {
    Rgb tau(0);
    for (const CellMedia* one : media) tau += opticalDepths(*one, ws, direction, distance, most).tau;
    return tau;
}

Depths bundleDepths(const CellMedia& media, const Vec3& ws, const Vec3& direction, double distance) {
    const CellGrid& grid = media.grid;
    const int axis = axisOfLargest(glm::abs(direction));
    const bool up = direction[axis] > 0, grey = media.extinction.size() == 1;
    const Vec3 from = grid.csFromWs(ws), way = direction / std::abs(direction[axis]);  // `way`: to the next slice
    const double length = distance * std::abs(direction[axis]) / grid.edge();          // slices
    const int size = grid.blocks()[axis] * kCellEdge;
    const double edge = grid.edge() / std::abs(direction[axis]);
    CellsOfSlice cells(grid, axis);
    Depths out;
    Rgb variance(0);  // of tau across the bundle
    double most = kMostDepth;  // beyond the first slice, which may be thicker alone
    double begin = 0, end = up ? std::floor(from[axis]) + 1 - from[axis] : from[axis] - std::ceil(from[axis]) + 1;
    for (int slice = static_cast<int>(up ? std::floor(from[axis]) : std::ceil(from[axis]) - 1);
         begin < length && (up ? slice < size : slice >= 0); slice += up ? 1 : -1, begin = end, end += 1) {
        const double to = std::min(end, length), step = (to - begin) * edge;
        Vec3 at = from + 0.5 * (begin + to) * way;
        at[axis] = slice;
        Rgb mean(0), squares(0);
        cells.visit(at, [&](std::size_t cell, double weight) {
            for (std::size_t c = 0; c < media.extinction.size(); ++c) {
                const double own = step * double(media.extinction[c][cell]);
                mean[int(c)] += weight * own;
                squares[int(c)] += weight * own * own;
            }
            for (std::size_t c = 0; c < media.straight.size(); ++c)
                out.straight[int(c)] += weight * step * double(media.straight[c][cell]);
        });
        mean = glm::max(mean, Rgb(0));  // the cubic goes below 0 beside steep edges
        out.tau += mean;
        variance += glm::max(squares - mean * mean, Rgb(0));
        const double depth = grey ? out.tau.x : smallest(out.tau);
        if (begin == 0) most += depth;
        if (depth > most) break;
    }
    // Thin parts of the bundle let more light pass than thick ones take from it. Slices are taken for independent, so
    // that depths have about a gamma distribution of this mean and variance; its mean of e^-depth is known.
    constexpr double kEven = 1e-6;
    for (int c = 0; c < 3; ++c) {
        double& depth = out.tau[c];
        if (variance[c] > kEven * depth) depth *= depth / variance[c] * std::log1p(variance[c] / depth);
    }
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
