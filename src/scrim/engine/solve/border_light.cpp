// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/solve/border_light.h>

#include <scrim/base/parallel.h>
#include <scrim/engine/cells/cell_walk.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/common.hpp>

namespace scrim {
namespace {

// Nodes are this far apart: cells of the smaller grid, or edges of the larger, whichever is more.
// Light of larger cells is no sharper.
constexpr double kSmallerCells = 4, kLargerCells = 0.5;
// Rays of a node and an ordinate, each way across the side, over an edge of the larger cells: these
// are constant inside, so that a single ray would show their sides.
constexpr int kRays = 2;

// What the larger cells send after what the smaller ones hold is taken out of them.
struct Left {
    std::vector<Real> factor, glow;  // for each cell

    explicit Left(const SentLight& light) : factor(light.media.grid.cells(), Real(1)) {
        const std::size_t cells = factor.size(), c = light.colour;
        const auto sum = [&](const CellMedia& media, std::size_t cell) {
            Real all = 0;
            for (std::size_t k = 0; k < media.scattering.size(); ++k) all += media.scatteringOf(k, c)[cell];
            return all;
        };
        const bool glows = light.glows && !light.media.emission.empty();
        if (glows) glow.assign(cells, Real(0));
        for (std::size_t cell = 0; cell < cells; ++cell) {
            if (const Real all = sum(light.media, cell); all > 0)
                factor[cell] = std::min(sum(light.left, cell) / all, Real(1));
            if (glows) glow[cell] = light.left.emission[c][cell] - factor[cell] * light.media.emission[c][cell];
        }
    }
    Real of(std::size_t cell, Real sent) const {
        return std::max(sent * factor[cell] + (glow.empty() ? Real(0) : glow[cell]), Real(0));
    }
};

// The radiance that arrives at `ws` along ordinate `m`.
double arriving(const SentLight& light, const Left& left, const Bounds& wsBox, const Vec3& ws, const Vec3& direction,
                std::size_t m, std::size_t count) {
    constexpr double kThin = 1e-4;
    const std::vector<Real>& extinction = light.left.extinctionOf(light.colour);
    double passed = 1, sum = 0, end = 0;
    walkCells(light.media.grid, ws, -direction, std::numeric_limits<double>::infinity(),
              [&](std::ptrdiff_t index, double from, double to) {
                  end = to;
                  if (index < 0) return true;
                  const auto cell = std::size_t(index);
                  const double depth = (to - from) * double(extinction[cell]), lost = -std::expm1(-depth);
                  if (const std::int32_t row = light.rows[cell]; row >= 0) {
                      const std::size_t value =
                          std::size_t(row) * light.valuesPerRow + (light.valuesPerRow == 1 ? 0 : m);
                      sum += passed * (depth > 1e-6 ? lost / depth : 1) * (to - from) *
                             double(left.of(cell, light.sent[value]));
                  }
                  passed *= 1 - lost;
                  return passed > kThin;
              });
    if (passed > kThin && light.inflow.any())
        sum += passed * light.inflow.at(wsBox, ws - end * direction, direction, m, count);
    return sum;
}

}  // namespace

Inflow::Place Inflow::placeOn(int side, const Vec2& across) const {
    const std::array<int, 2> axes = axesAcross(side / 2);
    Place place{};
    std::size_t first[2];
    double part[2];
    for (int i = 0; i < 2; ++i) {
        const int most = nodes[axes[std::size_t(i)]] - 1;
        const double at = std::clamp(across[i], 0.0, 1.0) * most;
        first[i] = std::size_t(std::min(static_cast<int>(at), most - 1));
        part[i] = at - double(first[i]);
    }
    const auto row = std::size_t(nodes[axes[0]]);
    for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t u = k & 1, v = k >> 1;
        place.node[k] = (first[1] + v) * row + first[0] + u;
        place.weight[k] = static_cast<Real>((u ? part[0] : 1 - part[0]) * (v ? part[1] : 1 - part[1]));
    }
    return place;
}

double Inflow::at(const Bounds& wsBox, const Vec3& ws, const Vec3& direction, std::size_t m, std::size_t count) const {
    if (!even.empty()) return double(even[m]);
    // The side that it is next to, of those by which light with this direction enters.
    const Vec3 at = (ws - wsBox.lower) / wsBox.size();
    int axis = 0;
    double least = std::numeric_limits<double>::infinity();
    for (int a = 0; a < 3; ++a)
        if (const double away = direction[a] > 0 ? at[a] : 1 - at[a]; direction[a] != 0 && away < least)
            least = away, axis = a;
    const int side = 2 * axis + (direction[axis] > 0 ? 0 : 1);
    const std::array<int, 2> axes = axesAcross(axis);
    const Place place = placeOn(side, {at[axes[0]], at[axes[1]]});
    double sum = 0;
    for (std::size_t k = 0; k < 4; ++k)
        sum += double(place.weight[k]) * double(byNode[std::size_t(side)][place.node[k] * count + m]);
    return sum;
}

Bounds wsBoxOf(const CellGrid& grid) {
    return {grid.wsFromCs(Vec3(0)), grid.wsFromCs(Vec3(grid.blocks() * kCellEdge))};
}

Depths Around::beyond(const CellGrid& grid, bool ofLast, const Vec3& ws, const Vec3& direction, double distance) const {
    const double leaves = wsBoxOf(grid).clip(ws, direction, 0, distance).second;
    if (!(leaves < distance)) return {};
    const CellMedia& larger = ofLast ? last() : media;
    const Vec3 from = ws + std::max(leaves, 0.0) * direction;
    const double left = distance - std::max(leaves, 0.0);
    Depths out = bundleDepths(larger, from, direction, left);
    if (further) out += further->beyond(larger.grid, ofLast, from, direction, left);
    return out;
}

namespace {

constexpr int kNodes = 3;  // along a block's edge

}  // namespace

DepthsBeyond::DepthsBeyond(const Around& around, const CellGrid& grid, bool ofLast,
                           const std::function<std::pair<Vec3, double>(const Vec3& ws)>& toLight)
    : m_nodes(grid.storedBlocks().size() * kNodes * kNodes * kNodes) {
    parallelFor(grid.storedBlocks().size(), [&](std::size_t block) {
        for (int i = 0; i < kNodes * kNodes * kNodes; ++i) {
            const Vec3 part = Vec3(i % kNodes, i / kNodes % kNodes, i / (kNodes * kNodes)) / (kNodes - 1.0);
            const Vec3 ws = grid.wsFromCs((Vec3(grid.storedBlocks()[block]) + part) * double(kCellEdge));
            const auto [direction, distance] = toLight(ws);
            m_nodes[block * kNodes * kNodes * kNodes + std::size_t(i)] =
                around.beyond(grid, ofLast, ws, direction, distance);
        }
    });
}

Depths DepthsBeyond::at(std::size_t cell) const {
    const auto inBlock = static_cast<int>(cell % kBlockCells);
    const Vec3 at =
        (Vec3(inBlock % kCellEdge, inBlock / kCellEdge % kCellEdge, inBlock / (kCellEdge * kCellEdge)) + 0.5) *
        ((kNodes - 1.0) / kCellEdge);
    const Int3 low = glm::min(Int3(at), Int3(kNodes - 2));
    const Vec3 part = at - Vec3(low);
    const Depths* nodes = m_nodes.data() + cell / kBlockCells * kNodes * kNodes * kNodes;
    Depths out;
    for (int corner = 0; corner < 8; ++corner) {
        const Int3 up(corner & 1, corner >> 1 & 1, corner >> 2), node = low + up;
        const Vec3 weights = glm::mix(1.0 - part, part, Vec3(up));
        const double weight = weights.x * weights.y * weights.z;
        const Depths& own = nodes[(node.z * kNodes + node.y) * kNodes + node.x];
        out.tau += weight * own.tau;
        out.straight += weight * own.straight;
    }
    return out;
}

Inflow inflowFrom(const SentLight& light, const CellGrid& smaller, const Ordinates& ordinates) {
    Inflow out;
    const Bounds box = wsBoxOf(smaller), around = wsBoxOf(light.media.grid);
    const double edge = light.media.grid.edge();
    const double apart = std::max(kSmallerCells * smaller.edge(), kLargerCells * edge);
    out.nodes = glm::max(Int3(glm::ceil(box.size() / apart)) + 1, Int3(2));
    const Left left(light);
    const auto count = std::size_t(ordinates.count());
    for (std::size_t side = 0; side < 6; ++side) {
        const auto axis = static_cast<int>(side / 2);
        const std::array<int, 2> axes = axesAcross(axis);
        const int nu = out.nodes[axes[0]], nv = out.nodes[axes[1]];
        std::vector<Real>& rows = out.byNode[side];
        rows.assign(std::size_t(nu) * std::size_t(nv) * count, Real(0));
        parallelFor(std::size_t(nu) * std::size_t(nv), [&](std::size_t node) {
            Vec3 at(0);
            at[axis] = side % 2 == 0 ? 0 : 1;
            at[axes[0]] = double(node % std::size_t(nu)) / (nu - 1);
            at[axes[1]] = double(node / std::size_t(nu)) / (nv - 1);
            const Vec3 ws = box.lower + at * box.size();
            for (std::size_t m = 0; m < count; ++m) {
                const Vec3& direction = ordinates.directions[m];
                if ((direction[axis] > 0) != (side % 2 == 0)) continue;
                double sum = 0;
                for (int ray = 0; ray < kRays * kRays; ++ray) {
                    Vec3 from = ws;
                    from[axes[0]] += edge * ((ray % kRays + 0.5) / kRays - 0.5);
                    from[axes[1]] += edge * ((ray / kRays + 0.5) / kRays - 0.5);
                    sum += arriving(light, left, around, from, direction, m, count);
                }
                rows[node * count + m] = static_cast<Real>(sum / (kRays * kRays));
            }
        });
    }
    return out;
}

}  // namespace scrim
