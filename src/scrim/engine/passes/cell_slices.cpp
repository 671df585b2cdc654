// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/passes/cell_slices.h>

#include <scrim/base/parallel.h>
#include <scrim/engine/passes/sharpen.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

// Sharpens a row of `count` - 2 cells into `to`. `rows`: itself, those beside it, and those in the
// slices below and above, `count` values each.
void sharpenRow(const std::vector<Real>& rows, std::size_t count, bool steep, Real* to) {
    const Real* own = rows.data();
    for (std::size_t i = 1; i + 1 < count; ++i) {
        Sharpened sharp(own[i], steep);
        sharp.along(kBendAcross, own[i - 1], own[i + 1]);
        sharp.along(kBendAcross, own[count + i], own[2 * count + i]);
        sharp.along(kBendAlong, own[3 * count + i], own[4 * count + i]);
        to[i - 1] = sharp.light();
    }
}

// The step from a cell of a block to the next one along an axis.
constexpr std::size_t strideOf(int axis) {
    constexpr std::array<std::size_t, 3> kStride{1, kCellEdge, std::size_t(kCellEdge) * kCellEdge};
    return kStride[std::size_t(axis)];
}

// The stored blocks of a grid in columns along the rows of slices, which `axes` are those of.
class BlockColumns {
  public:
    BlockColumns(const CellGrid& grid, const std::array<int, 3>& axes)
        : m_size{grid.blocks()[axes[1]], grid.blocks()[axes[2]]} {
        const std::vector<Int3>& places = grid.storedBlocks();
        const auto column = [&](std::size_t b) {
            return std::size_t(places[b][axes[2]]) * std::size_t(m_size[0]) + std::size_t(places[b][axes[1]]);
        };
        m_first.assign(std::size_t(m_size[0]) * std::size_t(m_size[1]) + 1, 0);
        for (std::size_t b = 0; b < places.size(); ++b) ++m_first[column(b) + 1];
        for (std::size_t c = 1; c < m_first.size(); ++c) m_first[c] += m_first[c - 1];
        m_blocks.resize(places.size());
        std::vector<std::uint32_t> next(m_first.begin(), m_first.end() - 1);
        for (std::size_t b = 0; b < places.size(); ++b) m_blocks[next[column(b)]++] = static_cast<std::uint32_t>(b);
    }
    // The blocks that the row of cells (j, k) of the grid passes, by their numbers; empty outside.
    std::span<const std::uint32_t> at(int j, int k) const {
        if (j < 0 || k < 0 || j >= m_size[0] * kCellEdge || k >= m_size[1] * kCellEdge) return {};
        const std::size_t c = std::size_t(k / kCellEdge) * std::size_t(m_size[0]) + std::size_t(j / kCellEdge);
        return std::span(m_blocks).subspan(m_first[c], m_first[c + 1] - m_first[c]);
    }

  private:
    int m_size[2];
    std::vector<std::uint32_t> m_first, m_blocks;
};

constexpr auto kAllBlocks = [](const Vec3&) { return true; };

void append(std::span<const CellSpan> some, std::vector<CellSpan>& spans) {
    spans.insert(spans.end(), some.begin(), some.end());
}

// Fills `values` with zeros; does not keep the old memory while it gets more.
void clear(std::vector<Real>& values, std::size_t count) {
    if (values.capacity() < count) std::vector<Real>().swap(values);
    values.assign(count, Real(0));
}

}  // namespace

void CellSlices::layAlong(int axis) {
    axes = {axis == 0 ? 1 : 0, axis == 2 ? 1 : 2, axis};
    for (std::size_t a = 0; a < 3; ++a) size[a] = m_grid.blocks()[axes[a]] * kCellEdge + 2;
}

Vec3 CellSlices::wsPlace(const Vec3& at) const {
    Vec3 cs;
    for (int a = 0; a < 3; ++a) cs[axes[std::size_t(a)]] = at[a] - 1;
    return m_grid.wsFromCs(cs);
}

std::tuple<double, Vec3, Mat3> CellSlices::seriesOf(const Light& light, const Bounds& wsVolumes) const {
    constexpr int kRows = 16, kColumns = 32;
    const Mat3 frame = lightFrame(light);
    double even = 0;
    Vec3 linear(0);
    Mat3 quadratic(0);
    for (int i = 0; i < kRows * kColumns; ++i) {
        const double z = 2 * (i / kColumns + 0.5) / kRows - 1, turn = 2 * std::numbers::pi * (i + 0.5) / kColumns;
        const Vec3 ws(std::sqrt(1 - z * z) * Vec2(std::cos(turn), std::sin(turn)), z), way = reordered(ws);
        const double sent = luminairePart(light, frame, ws) / (kRows * kColumns);
        even += sent;
        linear += 3 * sent * way;
        quadratic += 7.5 * sent * (glm::outerProduct(way, way) - Mat3(1.0 / 3));
    }
    double exact = 0, series = 1e-300;
    for (const Vec3& corner : wsVolumes.corners()) {
        const Vec3 ws = glm::normalize(corner - light.wsPosition), way = reordered(ws);
        exact += luminairePart(light, frame, ws);
        series += std::max(even + glm::dot(linear, way) + glm::dot(way, quadratic * way), 0.0);
    }
    const double scale = std::clamp(exact / series, 0.5, 2.0);
    return {scale * even, scale * linear, scale * quadratic};
}

template <class Visit>
void CellSlices::visitRows(const CellGrid& grid, const Visit& visit) const {
    parallelFor(grid.storedBlocks().size(), [&](std::size_t b) {
        const Int3 first = grid.storedBlocks()[b] * kCellEdge + firstOf(grid);
        for (int k = 0; k < kCellEdge; ++k)
            for (int j = 0; j < kCellEdge; ++j)
                visit(paddedRow(first[axes[1]] + j, first[axes[2]] + k), first[axes[0]],
                      b * kBlockCells + std::size_t(j) * strideOf(axes[1]) + std::size_t(k) * strideOf(axes[2]),
                      strideOf(axes[0]));
    });
}

void CellSlices::fill(const std::vector<Real>& perWorldUnit, int reach, bool values,
                      const std::vector<const CellGrid*>& shown) {
    const BlockColumns columns(m_grid, axes);
    const std::size_t step = strideOf(axes[0]), perSlice = std::size_t(size[1] + 2);
    const std::size_t rows = perSlice * std::size_t(size[2]);
    m_full = RowSpans::of(rows, [&](std::size_t row, std::vector<CellSpan>& spans) {
        // The box is one cell larger than the grid.
        const int j = placeOf(row, 1).j - 1, k = placeOf(row, 1).k - 1;
        for (const std::uint32_t b : columns.at(j, k)) {
            const Real* cells = perWorldUnit.data() + std::size_t(b) * kBlockCells +
                                std::size_t(j % kCellEdge) * strideOf(axes[1]) +
                                std::size_t(k % kCellEdge) * strideOf(axes[2]);
            const int i = m_grid.storedBlocks()[b][axes[0]] * kCellEdge + 1;
            int begin = 0, end = kCellEdge;
            while (begin < end && cells[std::size_t(begin) * step] == 0) ++begin;
            while (begin < end && cells[std::size_t(end - 1) * step] == 0) --end;
            spans.push_back({i + begin, i + end});
        }
    });
    crossed = RowSpans::of(rows, [&](std::size_t row, std::vector<CellSpan>& spans) {
        append(m_full.row(row), spans);
        if ((row + 1) % perSlice != 0) append(m_full.row(row + 1), spans);
    });
    wanted = reach == kEverywhere ? everywhere() : near(reach);
    beside = {};
    if (values)
        beside = RowSpans::of(rows, [&](std::size_t row, std::vector<CellSpan>& spans) {
            const auto [j, k] = placeOf(row, 1);
            for (int one = std::max(j, 0); one <= std::min(j + 1, size[1] - 1); ++one)
                append(wanted.row(rowIndex(one, k)), spans);
        });
    if (!shown.empty()) wanted = within(shown);
    wantedBox = boxOfWanted();
    crossedRows = crossed.usedRows(perSlice);
    besideRows = beside.usedRows(perSlice);
    wantedRows = wanted.usedRows(std::size_t(size[1]));
    keepRows();
    refill(perWorldUnit);
}

void CellSlices::refill(const std::vector<Real>& perWorldUnit) {
    const auto edge = static_cast<Real>(m_grid.edge());
    visitRows(m_grid, [&](std::size_t row, int i, std::size_t cell, std::size_t step) {
        const CellSpan span = m_full.around(row);
        Real* to = m_extinction.data() + m_rowAt[row];
        for (int at = std::max(i, span.begin); at < std::min(i + kCellEdge, span.end); ++at)
            to[at] = edge * perWorldUnit[cell + std::size_t(at - i) * step];
    });
}

void CellSlices::face(const CellGrid& of, const SurfaceNormals& normals) {
    for (std::vector<Real>& part : m_facing) clear(part, m_sliceAt.back());
    visitRows(of, [&](std::size_t row, int i, std::size_t cell, std::size_t step) {
        const auto [j, k] = placeOf(row, 1);
        for (const CellSpan& span : wanted.row(rowIndex(j, k)))
            for (std::size_t part = 0; part < m_facing.size(); ++part) {
                const std::vector<Real>& from = normals[part < 3 ? std::size_t(axes[part]) : part];
                Real* to = m_facing[part].data() + m_sumAt[rowIndex(j, k)];
                for (int at = std::max(i, span.begin); at < std::min(i + kCellEdge, span.end); ++at)
                    to[at] = from[cell + std::size_t(at - i) * step];
            }
    });
}

void CellSlices::classify(const SurfaceCells* surfaces, const ExtinctionIntegral* integral) {
    m_integral = integral;
    if (!integral) return;
    clear(m_values, m_extinction.size());
    visitRows(m_grid, [&](std::size_t row, int i, std::size_t cell, std::size_t step) {
        const CellSpan& span = m_kept[row];
        Real* to = m_values.data() + m_rowAt[row];
        for (int at = std::max(i, span.begin); at < std::min(i + kCellEdge, span.end); ++at)
            to[at] = surfaces->value[cell + std::size_t(at - i) * step];
    });
}

RowSpans CellSlices::everywhere() const {
    return RowSpans::of(std::size_t(size[1]) * std::size_t(size[2]), [&](std::size_t, std::vector<CellSpan>& spans) {
        spans.push_back({0, size[0]});
    });
}

CellBox CellSlices::boxOfWanted() const {
    CellBox box{size, {}};
    for (std::size_t row = 0; row < wanted.rows(); ++row) {
        const CellSpan span = wanted.around(row);
        if (span.empty()) continue;
        const auto [j, k] = placeOf(row);
        const std::array<int, 3> first{span.begin, j, k}, last{span.end, j + 1, k + 1};
        for (std::size_t a = 0; a < 3; ++a) {
            box.begin[a] = std::min(box.begin[a], first[a]);
            box.end[a] = std::max(box.end[a], last[a]);
        }
    }
    return box;
}

// The spans up to `reach` cells from `full`.
RowSpans CellSlices::near(int reach) const {
    const std::size_t rows = std::size_t(size[1]) * std::size_t(size[2]);
    const RowSpans along = RowSpans::of(rows, [&](std::size_t row, std::vector<CellSpan>& spans) {
        const auto [j, k] = placeOf(row);
        for (int one = std::max(j - reach, 0); one <= std::min(j + reach, size[1] - 1); ++one)
            for (const CellSpan& span : m_full.row(paddedRow(one, k)))
                spans.push_back({std::max(span.begin - reach, 0), std::min(span.end + reach, size[0])});
    });
    return RowSpans::of(rows, [&](std::size_t row, std::vector<CellSpan>& spans) {
        const auto [j, k] = placeOf(row);
        for (int one = std::max(k - reach, 0); one <= std::min(k + reach, size[2] - 1); ++one)
            append(along.row(rowIndex(j, one)), spans);
    });
}

// What of `wanted` lies in the blocks of these grids, or beside them.
RowSpans CellSlices::within(const std::vector<const CellGrid*>& shown) const {
    constexpr int kBeside = 2;  // cells: one to look up between, one to sharpen by
    std::vector<BlockColumns> columns;
    std::vector<Int3> firsts;
    for (const CellGrid* grid : shown) {
        columns.emplace_back(*grid, axes);
        firsts.push_back(firstOf(*grid));
    }
    // The spans that the blocks of grid g have in the row (j, k), or in one beside it.
    const auto blocksAt = [&](std::size_t g, int j, int k, std::vector<CellSpan>& spans) {
        const std::vector<Int3>& places = shown[g]->storedBlocks();
        for (const int atK : {k - kBeside, k + kBeside})
            for (const int atJ : {j - kBeside, j + kBeside})
                for (const std::uint32_t b : columns[g].at(atJ - firsts[g][axes[1]], atK - firsts[g][axes[2]])) {
                    const int i = places[b][axes[0]] * kCellEdge + firsts[g][axes[0]];
                    spans.push_back({i - kBeside, i + kCellEdge + kBeside});
                }
    };
    return RowSpans::of(std::size_t(size[1]) * std::size_t(size[2]),
                        [&](std::size_t row, std::vector<CellSpan>& spans) {
                            if (wanted.empty(row)) return;
                            const auto [j, k] = placeOf(row);
                            std::vector<CellSpan> blocks;
                            for (std::size_t g = 0; g < shown.size(); ++g) blocksAt(g, j, k, blocks);
                            for (const CellSpan& own : wanted.row(row))
                                for (const CellSpan& block : blocks)
                                    spans.push_back({std::max(own.begin, block.begin), std::min(own.end, block.end)});
                        });
}

// Finds the places of rows in memory. Cell 0 of the first one would be before the first that is kept.
void CellSlices::keepRows() {
    const std::size_t lead = std::size_t(size[0]) + 1;
    std::size_t at = lead;
    m_kept.assign(std::size_t(size[1] + 2) * std::size_t(size[2]), {});
    m_rowAt.assign(m_kept.size(), 0);
    const std::size_t rows = std::size_t(size[1]) * std::size_t(size[2]);
    m_sumAt.assign(rows, 0);
    m_sliceAt.clear();
    for (int k = 0; k < size[2]; ++k)
        for (int j = -1; j <= size[1]; ++j) {
            const std::size_t row = paddedRow(j, k);
            CellSpan& kept = m_kept[row];
            for (int near = std::max(j - 1, -1); near <= std::min(j + 1, size[1]); ++near)
                kept = kept.with(m_full.around(paddedRow(near, k)));
            if (j >= 0 && j < size[1]) kept = kept.with(wanted.around(rowIndex(j, k)));
            // Rays find values between the cells of two rows.
            for (int near = std::max(j - 1, -1); beside.rows() > 0 && near <= j; ++near) {
                const CellSpan span = beside.around(paddedRow(near, k));
                if (!span.empty()) kept = kept.with({span.begin - 2, span.end + 2});
            }
            if (kept.empty()) continue;
            m_rowAt[row] = at + 1 - std::size_t(kept.begin);
            at += std::size_t(kept.end - kept.begin) + 1 + kRowSlack;
        }
    clear(m_extinction, at);
    at = lead;
    for (std::size_t row = 0; row < rows; ++row) {
        if (row % std::size_t(size[1]) == 0) m_sliceAt.push_back(at);
        const CellSpan own = wanted.around(row);
        if (own.empty()) continue;
        m_sumAt[row] = at - std::size_t(own.begin);
        at += std::size_t(own.end - own.begin) + kRowSlack;
    }
    m_sliceAt.push_back(at);
}

std::vector<std::pair<std::size_t, Real>> CellSlices::hollow(const Vec3& ws, double radius) {
    std::vector<std::pair<std::size_t, Real>> before;
    const Vec3 center = place(ws) - 0.5, count(size[0], size[1], size[2]);
    // Rays find extinction interpolated across them. Beside a hollow that bends away from them this
    // adds as much to their depth as if the hollow were smaller by half the variance, across, of a
    // cell and of the interpolation: 1/12 and 1/6 along each of two axes.
    constexpr double kVariance = 0.25;
    const double given = radius / m_grid.edge(), cells = given + kVariance / given;
    const Int3 first(glm::clamp(glm::floor(center - cells), Vec3(0), count)),
        end(glm::clamp(glm::ceil(center + cells) + 1.0, Vec3(0), count));
    for (int k = first.z; k < end.z; ++k)
        for (int j = first.y; j < end.y; ++j)
            for (int i = first.x; i < end.x; ++i) {
                const double kept = std::clamp(glm::distance(Vec3(i, j, k), center) - cells + 0.5, 0.0, 1.0);
                const std::size_t row = paddedRow(j, k), at = m_rowAt[row] + std::size_t(i);
                if (kept == 1 || i < m_kept[row].begin || i >= m_kept[row].end) continue;
                before.emplace_back(at, m_extinction[at]);
                m_extinction[at] *= static_cast<Real>(kept);
            }
    return before;
}

void CellSlices::restore(const std::vector<std::pair<std::size_t, Real>>& before) {
    for (const auto& [at, extinction] : before) m_extinction[at] = extinction;
}

void CellSlices::clearSums(std::size_t sums) {
    for (std::size_t c = 0; c < sums; ++c) clear(m_sums[c], m_sliceAt.back());
}

template <class Visit, class Wanted>
void CellSlices::visitCells(CellField& field, const Visit& visit, const Wanted& wantsBlock) const {
    const CellGrid& grid = field.grid();
    const Int3 shift = firstOf(grid) - 1;  // the border of the block and that of the box are one cell each
    const std::array<std::ptrdiff_t, 3> steps{1, kPaddedEdge, std::ptrdiff_t(kPaddedEdge) * kPaddedEdge};
    const auto step = steps[std::size_t(axes[0])] * static_cast<std::ptrdiff_t>(field.colours());
    parallelFor(grid.storedBlocks().size(), [&](std::size_t b) {
        const Int3 first = grid.storedBlocks()[b] * kCellEdge, own = first + shift;
        if (!wantsBlock(Vec3(first) + 0.5 * kCellEdge)) return;
        Int3 place(0);
        for (place[axes[2]] = 0; place[axes[2]] < kPaddedEdge; ++place[axes[2]])
            for (place[axes[1]] = 0; place[axes[1]] < kPaddedEdge; ++place[axes[1]]) {
                const std::size_t row = rowIndex(own[axes[1]] + place[axes[1]], own[axes[2]] + place[axes[2]]);
                const int from = own[axes[0]];
                for (const CellSpan& span : wanted.row(row)) {
                    const int begin = std::max(span.begin - from, 0), end = std::min(span.end - from, kPaddedEdge);
                    if (begin >= end) continue;
                    place[axes[0]] = begin;
                    Real* out = field.block(b) + std::size_t(paddedOffset(place.x, place.y, place.z)) * field.colours();
                    for (; place[axes[0]] < end; ++place[axes[0]], out += step)
                        visit(first + place, m_sumAt[row] + std::size_t(from + place[axes[0]]), out);
                }
                place[axes[0]] = 0;
            }
    });
}

void CellSlices::sharpen(std::size_t count, bool steep) {
    for (std::size_t c = 0; c < count; ++c) {
        // This slice and the one below it, as they were.
        std::vector<Real> here, below;
        for (int k = 0; k < size[2]; ++k) {
            const std::size_t first = m_sliceAt[std::size_t(k)];
            here.assign(m_sums[c].begin() + static_cast<std::ptrdiff_t>(first),
                        m_sums[c].begin() + static_cast<std::ptrdiff_t>(m_sliceAt[std::size_t(k) + 1]));
            const auto sharpenSpan = [&](int j, const CellSpan& span) {
                // Rows as from one cell before the span to one behind it: 0 where they are not wanted.
                const auto length = std::size_t(span.end - span.begin) + 2;
                std::vector<Real> rows(5 * length, Real(0));
                const auto take = [&](std::size_t number, const std::vector<Real>& from, int atJ, int atK) {
                    if (atJ < 0 || atJ >= size[1] || atK < 0 || atK >= size[2]) return;
                    const std::size_t index = rowIndex(atJ, atK),
                                      offset = &from == &m_sums[c] ? 0 : m_sliceAt[std::size_t(atK)];
                    for (const CellSpan& other : wanted.row(index)) {
                        const int begin = std::max(other.begin, span.begin - 1),
                                  end = std::min(other.end, span.end + 1);
                        for (int i = begin; i < end; ++i)
                            rows[number * length + std::size_t(i - span.begin + 1)] =
                                from[m_sumAt[index] + std::size_t(i) - offset];
                    }
                };
                take(0, here, j, k);
                take(1, here, j - 1, k);
                take(2, here, j + 1, k);
                take(3, below, j, k - 1);
                take(4, m_sums[c], j, k + 1);
                sharpenRow(rows, length, steep, sums(c, j, k) + span.begin);
            };
            parallelFor(std::size_t(size[1]), [&](std::size_t j) {
                for (const CellSpan& span : wanted.row(rowIndex(static_cast<int>(j), k)))
                    sharpenSpan(static_cast<int>(j), span);
            });
            std::swap(here, below);
        }
    }
}

void CellSlices::addTo(std::size_t first, std::size_t count, std::size_t to, CellField& field) const {
    visitCells(
        field,
        [&](const Int3&, std::size_t from, Real* out) {
            for (std::size_t c = 0; c < count; ++c) out[to + c] += m_sums[first + c][from];
        },
        kAllBlocks);
}

void CellSlices::markBlocks(Real least, std::vector<bool>& marked) const {
    visitRows(m_grid, [&](std::size_t row, int i, std::size_t cell, std::size_t) {
        const std::size_t b = cell / kBlockCells;
        if (marked[b]) return;
        const auto [j, k] = placeOf(row, 1);
        const std::size_t own = rowIndex(j, k);
        for (const CellSpan& span : wanted.row(own))
            for (int at = std::max(i, span.begin); at < std::min(i + kCellEdge, span.end); ++at)
                if (m_sums[0][m_sumAt[own] + std::size_t(at)] > least) marked[b] = true;
    });
}

void CellSlices::addFarLight(const LampField& lamp, std::size_t knot, int colour, CellField& far) const {
    const CellGrid& grid = far.grid();
    // Along this axis a lamp lights the cells to which the way is longest along it.
    const Vec3 source = grid.csFromWs(lamp.lamp().wsPosition);
    const double reach = lamp.lamp().area() ? lamp.lamp().area()->radius / grid.edge() : 0;
    const auto lit = [&](const Vec3& center) {
        constexpr double kHalf = 0.5 * kPaddedEdge + 1;
        const Vec3 way = glm::abs(reordered(center - source));
        return std::max(way.x, way.y) - kHalf - reach <= way.z + kHalf + reach;
    };
    double near = 0;
    const std::optional<Rgb> even = lamp.evenFarLight(knot, near);
    const auto add = [&](const Int3& at, std::size_t from, Real* out) {
        if (m_sums[0][from] == 0) return;
        const Vec3 ws = grid.wsFromCs(Vec3(at) - 0.5), way = ws - lamp.lamp().wsPosition;
        const double r2 = glm::dot(way, way), arrives = double(m_sums[0][from]);
        const Rgb light = even && r2 > near * near ? arrives / r2 * *even : lamp.farLight(knot, ws, arrives);
        if (far.colours() == 1)
            out[0] += static_cast<Real>(largest(light));
        else
            for (int c = 0; c < 3; ++c)
                if (colour < 0 || colour == c) out[c] += static_cast<Real>(light[c]);
    };
    visitCells(far, add, lit);
}

std::size_t CellSlices::bytes() const {
    std::size_t values = m_extinction.size() + m_values.size() + 4 * m_facing[0].size();
    for (const std::vector<Real>& sums : m_sums) values += sums.size();
    return values * sizeof(Real) + m_kept.size() * (sizeof(CellSpan) + sizeof(std::size_t)) +
           m_sumAt.size() * sizeof(std::size_t) + m_full.bytes() + crossed.bytes() + beside.bytes() + wanted.bytes();
}

}  // namespace scrim
