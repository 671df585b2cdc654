// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/light/solid_raster.h>

#include <scrim/base/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace scrim {
namespace {

using EndAt = SolidRaster::EndAt;

// The most finer rays of a raster with so many rays of its own: few a ray in large rasters, which are fine already.
std::size_t mostFiner(std::size_t own, int parts) {
    constexpr std::size_t kFew = 6, kEnough = std::size_t{1} << 22;
    const auto all = std::size_t(parts > 1 ? (parts + 1) * (parts + 1) : 0);
    return std::min(all * own, std::max(kFew * own, kEnough));
}

// The ends of a divided cell's rays. Squares whose corners agree are not divided further: their ends are interpolated.
class Block {
  public:
    Block(int parts, Real same, const EndAt& endAt, Vec2 corner)
        : m_parts(parts), m_same(same), m_endAt(endAt), m_corner(corner) {
        m_ends.fill(std::numeric_limits<Real>::quiet_NaN());
    }

    void set(int i, int j, Real end) { m_ends[index(i, j)] = end; }
    Real end(int i, int j) const { return m_ends[index(i, j)]; }

    void divide(int i, int j, int edge) {
        if (edge == 1) return;
        const Real a = end(i, j), b = end(i + edge, j), c = end(i, j + edge), d = end(i + edge, j + edge);
        // The first squares are divided in any case: what is at an edge may have parts that are smaller than a cell.
        constexpr int kInAnyCase = 4;  // parts of a cell's edge
        if (kInAnyCase * edge <= m_parts && endsAgree(a, b, c, d, m_same)) return fill(i, j, edge);
        const int half = edge / 2;
        for (const Int2& at : {Int2(half, 0), Int2(0, half), Int2(half), Int2(edge, half), Int2(half, edge)})
            find(i + at.x, j + at.y);
        for (int k = 0; k < 4; ++k) divide(i + half * (k & 1), j + half * (k >> 1), half);
    }

    static bool endsAgree(Real a, Real b, Real c, Real d, Real same) {
        const auto infinite = int(std::isinf(a)) + int(std::isinf(b)) + int(std::isinf(c)) + int(std::isinf(d));
        if (infinite > 0) return infinite == 4;
        // On a plane that leans the ends of four rays differ, but not from those of a plane.
        return std::max({a, b, c, d}) - std::min({a, b, c, d}) <= same;
    }

    std::uint64_t rays() const { return m_rays; }

  private:
    static std::size_t index(int i, int j) { return std::size_t(j * (SolidRaster::kMostParts + 1) + i); }

    void find(int i, int j) {
        if (!std::isnan(end(i, j))) return;
        set(i, j, m_endAt(m_corner.x + double(i) / m_parts, m_corner.y + double(j) / m_parts));
        ++m_rays;
    }

    void fill(int i, int j, int edge) {
        const Real a = end(i, j), b = end(i + edge, j), c = end(i, j + edge), d = end(i + edge, j + edge);
        for (int y = 0; y <= edge; ++y)
            for (int x = 0; x <= edge; ++x) {
                if (!std::isnan(end(i + x, j + y))) continue;
                const Real u = Real(x) / Real(edge), v = Real(y) / Real(edge);
                set(i + x, j + y, std::isinf(a) ? a : (1 - v) * (a + u * (b - a)) + v * (c + u * (d - c)));
            }
    }

    int m_parts;
    Real m_same;
    const EndAt& m_endAt;
    Vec2 m_corner;
    std::uint64_t m_rays = 0;
    std::array<Real, (SolidRaster::kMostParts + 1) * (SolidRaster::kMostParts + 1)> m_ends;
};

}  // namespace

SolidRaster::SolidRaster(Int2 size, int parts, Real same, const EndAt& endAt)
    : m_width(size.x), m_height(size.y), m_parts(parts), m_same(same) {
    m_ends.resize(std::size_t(m_width) * std::size_t(m_height));
    parallelFor(std::size_t(m_height), [&](std::size_t y) {
        for (int x = 0; x < m_width; ++x) m_ends[y * std::size_t(m_width) + std::size_t(x)] = endAt(x, double(y));
    });
    m_rays = m_ends.size();
    for (int y = 0; y + 1 < m_height; ++y)
        for (int x = 0; x + 1 < m_width; ++x) m_first.push_back(~(RealIndex(y) * m_width + x));
    if (m_parts > 1) divide(endAt);
    stack();
}

bool SolidRaster::agree(Real a, Real b, Real c, Real d) const {
    return Block::endsAgree(a, b, c, d, m_same);
}

// True if an edge passes cell (x, y), or one next to it: what is thinner than a cell may lie beside where rays met it.
bool SolidRaster::divides(int x, int y) const {
    for (int j = std::max(y - 1, 0); j <= std::min(y + 1, m_height - 2); ++j)
        for (int i = std::max(x - 1, 0); i <= std::min(x + 1, m_width - 2); ++i)
            if (!agree(at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1))) return true;
    return false;
}

void SolidRaster::divide(const EndAt& endAt) {
    const int columns = m_width - 1, rows = m_height - 1;
    std::vector<int> chosen;
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x)
            if (divides(x, y)) chosen.push_back(y * columns + x);
    const std::size_t own = m_ends.size(), most = mostFiner(own, m_parts);
    while (m_parts > 1 && chosen.size() * blockSize() > most) m_parts /= 2;
    if (m_parts == 1) return;

    m_ends.resize(own + chosen.size() * blockSize());
    std::vector<std::uint64_t> rays(chosen.size());
    parallelFor(chosen.size(), [&](std::size_t i) {
        const int x = chosen[i] % columns, y = chosen[i] / columns;
        Block block(m_parts, m_same, endAt, Vec2(x, y));
        for (int k = 0; k < 4; ++k) block.set(m_parts * (k & 1), m_parts * (k >> 1), at(x + (k & 1), y + (k >> 1)));
        block.divide(0, 0, m_parts);
        rays[i] = block.rays();
        const std::size_t first = own + i * blockSize();
        m_first[std::size_t(chosen[i])] = RealIndex(first);
        for (int k = 0; k < int(blockSize()); ++k)
            m_ends[first + std::size_t(k)] = block.end(k % (m_parts + 1), k / (m_parts + 1));
    });
    for (const std::uint64_t count : rays) m_rays += count;
}

// The rays of a cell: where the first one's end is, and how many there are along an edge.
SolidRaster::Rays SolidRaster::raysOf(int column, int row) const {
    const RealIndex first = m_first[std::size_t(row) * std::size_t(m_width - 1) + std::size_t(column)];
    return first < 0 ? Rays{m_ends.data() + ~first, std::size_t(m_width), 1}
                     : Rays{m_ends.data() + first, std::size_t(m_parts + 1), m_parts};
}

// Builds the ranges of larger and larger squares.
void SolidRaster::stack() {
    Level first{m_width - 1, m_height - 1, {}};
    first.ranges.resize(m_first.size());
    parallelFor(std::size_t(first.height), [&](std::size_t y) {
        for (int x = 0; x < first.width; ++x) {
            Range& range = first.ranges[y * std::size_t(first.width) + std::size_t(x)];
            range = {std::numeric_limits<Real>::infinity(), -std::numeric_limits<Real>::infinity()};
            const Rays rays = raysOf(x, int(y));
            for (int j = 0; j <= rays.parts; ++j)
                for (int i = 0; i <= rays.parts; ++i) {
                    const Real end = rays.ends[std::size_t(j) * rays.stride + std::size_t(i)];
                    range = {std::min(range.least, end), std::max(range.most, end)};
                }
        }
    });
    m_levels.push_back(std::move(first));
    while (m_levels.back().width > 1 || m_levels.back().height > 1) {
        const Level& fine = m_levels.back();
        Level next{(fine.width + 1) / 2, (fine.height + 1) / 2, {}};
        next.ranges.assign(std::size_t(next.width) * std::size_t(next.height),
                           {std::numeric_limits<Real>::infinity(), -std::numeric_limits<Real>::infinity()});
        for (int y = 0; y < fine.height; ++y)
            for (int x = 0; x < fine.width; ++x) {
                const Range& from = fine.ranges[std::size_t(y) * std::size_t(fine.width) + std::size_t(x)];
                Range& to = next.ranges[std::size_t(y / 2) * std::size_t(next.width) + std::size_t(x / 2)];
                to = {std::min(to.least, from.least), std::max(to.most, from.most)};
            }
        m_levels.push_back(std::move(next));
    }
}

SolidRaster::Range SolidRaster::range(Real x0, Real y0, Real x1, Real y1) const {
    const auto cell = [](Real position, int cells) {
        return static_cast<int>(std::clamp(position, 0.0f, static_cast<Real>(cells - 1)));
    };
    int left = cell(x0, m_width - 1), right = cell(x1, m_width - 1);
    int top = cell(y0, m_height - 1), bottom = cell(y1, m_height - 1);
    std::size_t level = 0;
    while (right - left > 1 || bottom - top > 1) {
        left >>= 1, right >>= 1, top >>= 1, bottom >>= 1;
        ++level;
    }
    const Level& in = m_levels[level];
    const Range* const upper = in.ranges.data() + std::size_t(top) * std::size_t(in.width);
    const Range* const lower = in.ranges.data() + std::size_t(bottom) * std::size_t(in.width);
    return {std::min({upper[left].least, upper[right].least, lower[left].least, lower[right].least}),
            std::max({upper[left].most, upper[right].most, lower[left].most, lower[right].most})};
}

Real SolidRaster::passed(Real x, Real y, Real n) const {
    x = std::clamp(x, Real(0), static_cast<Real>(m_width - 2));
    y = std::clamp(y, Real(0), static_cast<Real>(m_height - 2));
    const auto column = static_cast<int>(x), row = static_cast<int>(y);
    const Rays rays = raysOf(column, row);
    const Real fx = (x - static_cast<Real>(column)) * static_cast<Real>(rays.parts),
               fy = (y - static_cast<Real>(row)) * static_cast<Real>(rays.parts);
    const auto i = static_cast<int>(fx), j = static_cast<int>(fy);
    const Real* ends = rays.ends + std::size_t(j) * rays.stride + std::size_t(i);
    const auto lit = [n](Real end) { return end >= n ? Real(1) : Real(0); };
    const auto between = [](Real a, Real b, Real t) { return a + t * (b - a); };
    return between(between(lit(ends[0]), lit(ends[1]), fx - static_cast<Real>(i)),
                   between(lit(ends[rays.stride]), lit(ends[rays.stride + 1]), fx - static_cast<Real>(i)),
                   fy - static_cast<Real>(j));
}

std::size_t SolidRaster::bytes() const {
    std::size_t sum = m_ends.size() * sizeof(Real) + m_first.size() * sizeof(RealIndex);
    for (const Level& level : m_levels) sum += level.ranges.size() * sizeof(Range);
    return sum;
}

std::size_t SolidRaster::bytes(const Int2& size, int parts) {
    const auto cells = std::size_t(size.x) * std::size_t(size.y);
    // The stack of ranges has less than one and a half times as many as there are cells, and a few where it is narrow.
    return (cells + mostFiner(cells, parts)) * sizeof(Real) + cells * (sizeof(RealIndex) + 3 * sizeof(Range) / 2) +
           64 * sizeof(Range);
}

}  // namespace scrim
