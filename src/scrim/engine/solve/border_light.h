// SPDX-License-Identifier: Apache-2.0
// Light that enters cells from outside, for a solve of the transport equation.
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/cells/cell_media.h>
#include <scrim/engine/cells/cell_walk.h>
#include <scrim/engine/cells/ordinates.h>
#include <scrim/geometry/bounds.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace scrim {

/// The two axes across `axis`, in ascending order.
constexpr std::array<int, 2> axesAcross(int axis) {
    return {axis == 0 ? 1 : 0, axis == 2 ? 1 : 2};
}

/// Radiance along ordinates that enters the box around all cells of a grid: the same everywhere, or by place.
struct Inflow {
    /// One value for each ordinate; empty: it differs by place, or there is none.
    std::vector<Real> even;
    /// By place: nodes along each axis of the box, at least 2, and for each side (2 axis, + 1 for the upper one) their
    /// rows of ordinates, with the first of axesAcross fastest. Between nodes it is interpolated.
    Int3 nodes{0};
    std::array<std::vector<Real>, 6> byNode;

    bool any() const { return !even.empty() || nodes.x > 0; }
    /// Four nodes of a side, and their weights.
    struct Place {
        std::array<std::size_t, 4> node;
        std::array<Real, 4> weight;
    };
    /// `across`: a place on a side, from 0 to 1 along its axes.
    Place placeOn(int side, const Vec2& across) const;
    /// The radiance along ordinate `m` of `count` that enters at a point of the box's surface.
    double at(const Bounds& wsBox, const Vec3& ws, const Vec3& direction, std::size_t m, std::size_t count) const;
};

/// What enters along the ordinates of a solve, and of each part of its last sweep.
struct PassInflow {
    Inflow ofSolve;
    std::vector<Inflow> ofParts;
};

/// The box around all cells.
Bounds wsBoxOf(const CellGrid& grid);

/// What lies around the cells of a part of space: larger cells, without what is in the smaller ones.
struct Around {
    CellMedia media;                        ///< for the solve
    CellMedia split;                        ///< with phase functions split for its last sweep; empty: they are the same
    std::shared_ptr<const Around> further;  ///< what lies around these cells; null: nothing

    const CellMedia& last() const { return split.extinction.empty() ? media : split; }
    /// What a ray passes that leaves `grid`, whose cells all this surrounds: from there on, up to `distance` from `ws`.
    Depths beyond(const CellGrid& grid, bool ofLast, const Vec3& ws, const Vec3& direction, double distance) const;
};

/// Around::beyond on the way to one light, from all cells of a grid: interpolated between nodes,
/// since what lies around differs from one larger cell to the next.
class DepthsBeyond {
  public:
    /// `toLight`: the direction to the light (unit) and its distance from a point.
    DepthsBeyond(const Around& around, const CellGrid& grid, bool ofLast,
                 const std::function<std::pair<Vec3, double>(const Vec3& ws)>& toLight);
    Depths at(std::size_t cell) const;

  private:
    std::vector<Depths> m_nodes;  // for each block those of its corners, and half-way between them
};

/// What larger cells send along ordinates.
struct SentLight {
    const CellMedia& media;  ///< which send it
    const CellMedia& left;   ///< the same cells without what the smaller ones hold
    std::size_t colour;
    const std::vector<std::int32_t>& rows;  ///< the row of each cell, -1: it sends nothing
    std::size_t valuesPerRow;               ///< 1: the same along all ordinates
    const std::vector<Real>& sent;          ///< radiance per world unit
    bool glows;                             ///< emission is part of it
    const Inflow& inflow;                   ///< what enters the larger cells
};

/// The light of larger cells that enters the box around smaller ones, by rays that are followed back from its surface.
Inflow inflowFrom(const SentLight& light, const CellGrid& smaller, const Ordinates& ordinates);

}  // namespace scrim
