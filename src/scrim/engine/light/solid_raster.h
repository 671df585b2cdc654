// SPDX-License-Identifier: Apache-2.0
// Where a light's rays first meet a solid: a raster of rays whose cells are divided where an edge passes.
//
// Between two rays that end at the same surface nothing is to be learned from a third. Where one passes a solid and its
// neighbour does not, an edge lies between them, whose place they only tell to half a cell: shadows of straight edges
// would have scallops. Such cells have finer rays of their own, the more the closer to the edge.
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/simd.h>
#include <scrim/geometry/sheets.h>
#include <scrim/geometry/spaces.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace scrim {

/// Straight paths of 256 points across a raster: positions in cells, and the ends that they ask
/// for, where they begin and where they end.
struct RasterPaths {
    struct Places {
        alignas(64) Real x[kTileSize], y[kTileSize], n[kTileSize];
    };
    Places first, last;
};

/// Distances, of any unit, at which rays end; infinity where they do not. Immutable once made.
class SolidRaster {
  public:
    static constexpr int kMostParts = 16;
    using EndAt = std::function<Real(double x, double y)>;

    /// Takes the ends of the rays at (i, j), i < width, j < height, both at least 2, and of finer ones where these
    /// differ: `parts` times as many along an edge of a cell, a power of two up to kMostParts, 1: none, or less where
    /// so many cells are divided that they would take more memory than bytes() says. `endAt` gives the end of the ray
    /// at (x, y) and is called from many threads. Ends that differ by less than `same` are those of one surface.
    SolidRaster(Int2 size, int parts, Real same, const EndAt& endAt);

    /// Multiplies `light` by the part of each path, in [0, 1], on which the ends are not before
    /// those asked for. Positions outside of the raster are moved to its border.
    void pass(const RasterPaths& paths, Simd simd, Real* light) const;

    /// That part at a point, 0 or 1 but for interpolation between rays.
    Real passed(Real x, Real y, Real n) const;

    /// The least and largest end in a box of positions, or in a slightly larger one.
    struct Range {
        Real least, most;
    };
    Range range(Real x0, Real y0, Real x1, Real y1) const;

    std::uint64_t rays() const { return m_rays; }  ///< that were traced
    std::size_t bytes() const;
    /// Upper bound on the bytes of a raster of this size that is divided into so many parts.
    static std::size_t bytes(const Int2& size, int parts);

    /// What loops over samples read.
    struct Table {
        const Real* ends;
        const RealIndex* first;
        int width, height, parts;  ///< width and height in rays
    };
    Table table() const { return {m_ends.data(), m_first.data(), m_width, m_height, m_parts}; }

  private:
    // Ranges of squares of 2^level cells.
    struct Level {
        int width, height;
        std::vector<Range> ranges;
    };

    // The ends of a cell's rays, in rows of `stride`, and the number of parts along its edge.
    struct Rays {
        const Real* ends;
        std::size_t stride;
        int parts;
    };

    Rays raysOf(int column, int row) const;
    bool divides(int x, int y) const;
    void divide(const EndAt& endAt);
    void stack();
    Real at(int x, int y) const { return m_ends[std::size_t(y) * std::size_t(m_width) + std::size_t(x)]; }
    bool agree(Real a, Real b, Real c, Real d) const;
    std::size_t blockSize() const { return std::size_t(m_parts + 1) * std::size_t(m_parts + 1); }

    int m_width, m_height, m_parts;
    Real m_same;
    // The ends of the raster's own rays, and then, for each divided cell, of (parts + 1)^2 rays,
    // those on its border included.
    std::vector<Real> m_ends;
    // For each of (width - 1) x (height - 1) cells where the ends of its finer rays begin in
    // m_ends; of an undivided one the bitwise complement of where the end of its first corner is.
    std::vector<RealIndex> m_first;
    std::vector<Level> m_levels;
    std::uint64_t m_rays = 0;
};

}  // namespace scrim
