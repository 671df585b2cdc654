// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/transport/cell_slices.h>

#include <scrim/base/parallel.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace scrim {

CellSlices::CellSlices(const CellGrid& grid, int axis)
    : axes{axis == 0 ? 1 : 0, axis == 2 ? 1 : 2, axis}, m_grid(grid) {
    for (std::size_t a = 0; a < 3; ++a) size[a] = grid.blocks()[axes[a]] * kCellEdge + 2;
    const std::size_t rows = std::size_t(size[1] + 2) * std::size_t(size[2]);
    extinction.assign(rows * stride(), Real(0));
    full.assign(rows, {});
    wanted.assign(std::size_t(size[1]) * std::size_t(size[2]), {});
}

Vec3 CellSlices::wsPlace(const Vec3& at) const {
    Vec3 cs;
    for (int a = 0; a < 3; ++a) cs[axes[std::size_t(a)]] = at[a] - 1;
    return m_grid.wsFromCs(cs);
}

void CellSlices::fill(const std::vector<Real>& perWorldUnit, int reach) {
    constexpr std::array<std::size_t, 3> kStep{1, kCellEdge, std::size_t(kCellEdge) * kCellEdge};
    const auto edge = static_cast<Real>(m_grid.edge());
    std::fill(full.begin(), full.end(), CellSpan{});
    for (std::size_t b = 0; b < m_grid.storedBlocks().size(); ++b) {
        const Int3 first = m_grid.storedBlocks()[b] * kCellEdge + 1;
        for (int z = 0; z < kCellEdge; ++z)
            for (int y = 0; y < kCellEdge; ++y) {
                const std::size_t row = paddedRow(first[axes[1]] + y, first[axes[2]] + z);
                std::size_t cell = b * kBlockCells + std::size_t(y) * kStep[std::size_t(axes[1])] +
                                   std::size_t(z) * kStep[std::size_t(axes[2])];
                const int begin = first[axes[0]];
                Real* to = extinction.data() + row * stride() + 1 + begin;
                for (int i = 0; i < kCellEdge; ++i, cell += kStep[std::size_t(axes[0])]) {
                    to[i] = edge * perWorldUnit[cell];
                    if (to[i] != 0) full[row] = full[row].with({begin + i, begin + i + 1});
                }
            }
    }
    findWanted(reach);
}

void CellSlices::findWanted(int reach) {
    std::vector<CellSpan> along(wanted.size());
    for (int k = 0; k < size[2]; ++k)
        for (int j = 0; j < size[1]; ++j)
            for (int near = std::max(j - reach, 0); near <= std::min(j + reach, size[1] - 1); ++near)
                along[rowIndex(j, k)] = along[rowIndex(j, k)].with(full[paddedRow(near, k)]);
    for (int k = 0; k < size[2]; ++k)
        for (int j = 0; j < size[1]; ++j) {
            CellSpan span;
            for (int near = std::max(k - reach, 0); near <= std::min(k + reach, size[2] - 1); ++near)
                span = span.with(along[rowIndex(j, near)]);
            CellSpan& here = wanted[rowIndex(j, k)];
            if (!span.empty()) here = here.with({std::max(span.begin - reach, 0), std::min(span.end + reach, size[0])});
        }
}

std::vector<std::pair<std::size_t, Real>> CellSlices::hollow(const Vec3& ws, double radius) {
    std::vector<std::pair<std::size_t, Real>> before;
    const Vec3 center = place(ws) - 0.5, count(size[0], size[1], size[2]);
    const double cells = radius / m_grid.edge();
    const Int3 first(glm::clamp(glm::floor(center - cells), Vec3(0), count)),
        end(glm::clamp(glm::ceil(center + cells) + 1.0, Vec3(0), count));
    for (int k = first.z; k < end.z; ++k)
        for (int j = first.y; j < end.y; ++j)
            for (int i = first.x; i < end.x; ++i) {
                const double kept = std::clamp(glm::distance(Vec3(i, j, k), center) - cells + 0.5, 0.0, 1.0);
                if (kept == 1) continue;
                const std::size_t at = paddedRow(j, k) * stride() + 1 + std::size_t(i);
                before.emplace_back(at, extinction[at]);
                extinction[at] *= static_cast<Real>(kept);
            }
    return before;
}

void CellSlices::clearSums(std::size_t colours) {
    for (std::size_t c = 0; c < colours; ++c)
        sums[c].assign(std::size_t(size[1]) * std::size_t(size[2]) * sumStride(), Real(0));
}

template <class Visit>
void CellSlices::visitCells(CellField& field, const Visit& visit) const {
    const int edge = kPaddedEdge;
    const CellGrid& grid = field.grid();
    const Int3 shift(glm::round(m_grid.csFromWs(grid.wsFromCs(Vec3(0)))));
    parallelFor(grid.storedBlocks().size(), [&](std::size_t b) {
        // The border of the block and that of the box are one cell each.
        const Int3 first = grid.storedBlocks()[b] * kCellEdge;
        Real* out = field.block(b);
        for (int z = 0; z < edge; ++z)
            for (int y = 0; y < edge; ++y)
                for (int x = 0; x < edge; ++x, out += field.colours()) {
                    const Int3 at = first + Int3(x, y, z), own = at + shift;
                    const std::size_t from =
                        rowIndex(own[axes[1]], own[axes[2]]) * sumStride() + std::size_t(own[axes[0]]);
                    visit(Vec3(at) - 0.5, from, out);
                }
    });
}

void CellSlices::sharpen(std::size_t colours) {
    constexpr std::array<Real, 3> kPerBend{Real(0.1), Real(0.1), Real(1.0 / 12)};
    const std::array<std::size_t, 3> steps{1, sumStride(), sumStride() * std::size_t(size[1])};
    for (std::size_t c = 0; c < colours; ++c) {
        const std::vector<Real> before = sums[c];
        parallelFor(std::size_t(size[2]), [&](std::size_t k) {
            for (int j = 0; j < size[1]; ++j) {
                const CellSpan& span = wanted[rowIndex(j, static_cast<int>(k))];
                for (int i = span.begin; i < span.end; ++i) {
                    const std::size_t at = rowIndex(j, static_cast<int>(k)) * sumStride() + std::size_t(i);
                    const std::array<int, 3> place{i, j, static_cast<int>(k)};
                    Real bend = 0, least = before[at], most = before[at];
                    for (std::size_t a = 0; a < 3; ++a) {
                        if (place[a] == 0 || place[a] + 1 == size[a]) continue;
                        const Real low = before[at - steps[a]], high = before[at + steps[a]];
                        if (low == 0 || high == 0) continue;
                        bend += kPerBend[a] * (low + high - 2 * before[at]);
                        least = std::min({least, low, high});
                        most = std::max({most, low, high});
                    }
                    sums[c][at] = std::clamp(before[at] - bend, least, most);
                }
            }
        });
    }
}

void CellSlices::addTo(std::size_t colours, std::size_t to, CellField& field) const {
    visitCells(field, [&](const Vec3&, std::size_t from, Real* out) {
        for (std::size_t c = 0; c < colours; ++c) out[to + c] += sums[c][from];
    });
}

void CellSlices::addFarLight(const CellField& lamp, int colour, CellField& far) const {
    visitCells(far, [&](const Vec3& cs, std::size_t from, Real* out) {
        if (sums[0][from] == 0) return;
        const Rgb light = lamp.farLight(far.grid().wsFromCs(cs), double(sums[0][from]));
        if (far.colours() == 1)
            out[0] += static_cast<Real>(std::max({light.x, light.y, light.z}));
        else
            for (int c = 0; c < 3; ++c)
                if (colour < 0 || colour == c) out[c] += static_cast<Real>(light[c]);
    });
}

std::size_t CellSlices::bytes() const {
    return (extinction.size() + sums[0].size() + sums[1].size() + sums[2].size()) * sizeof(Real);
}

}  // namespace scrim
