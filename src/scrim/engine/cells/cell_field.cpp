// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/cells/cell_field.h>

#include <scrim/engine/cells/cell_look_up.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

namespace scrim {

CellField::CellField(std::shared_ptr<const CellGrid> grid, int colours, const Rgb& tint)
    : m_grid(std::move(grid)),
      m_colours(static_cast<std::size_t>(colours)),
      m_values(m_grid->storedBlocks().size() * kPaddedCells * m_colours) {
    for (int c = 0; c < 3; ++c) m_tint[c] = static_cast<Real>(tint[c]);
}

Real* CellField::cell(std::size_t index) {
    const std::size_t i = index % kBlockCells;
    const std::size_t x = i % kCellEdge + 1, y = i / kCellEdge % kCellEdge + 1, z = i / (kCellEdge * kCellEdge) + 1;
    return block(index / kBlockCells) + ((z * kPaddedEdge + y) * kPaddedEdge + x) * m_colours;
}

void CellField::add(const std::function<Rgb(const Vec3& ws)>& light) {
    forCells([&](const Int3& cell, Real* values) {
        const Rgb more = light(m_grid->wsFromCs(Vec3(cell) + 0.5));
        for (std::size_t c = 0; c < m_colours; ++c) values[c] += static_cast<Real>(more[static_cast<int>(c)]);
    });
}

void CellField::add(const CellField& other) {
    const std::size_t perBlock = kPaddedCells * m_colours;
    parallelFor(m_grid->storedBlocks().size(), [&](std::size_t b) {
        std::transform(block(b), block(b) + perBlock, other.block(b), block(b), std::plus<>());
    });
}

void CellField::fillAround() {
    const std::vector<Int3>& places = m_grid->storedBlocks();
    parallelFor(places.size(), [&](std::size_t b) {
        CellGrid::LastBlock last;
        Real* to = block(b);
        for (int i = 0; i < static_cast<int>(kPaddedCells); ++i, to += m_colours) {
            const Int3 cell = places[b] * kCellEdge - 1 + paddedCell(i);
            const std::ptrdiff_t index = cell >> 3 == places[b] ? -1 : m_grid->index(cell, last);
            if (index >= 0) std::copy_n(this->cell(std::size_t(index)), m_colours, to);
        }
    });
}

void CellField::sample(const Vec3& ws, Real (&rgb)[3]) const {
    LastBlock last;
    sample(ws, last, rgb);
}

namespace {

// Interpolates between eight cells; `corner` has the first one's values.
template <std::size_t colours>
void mixAll(const Real* corner, const Vec3& fraction, Real (&rgb)[3]) {
    const Real fx = static_cast<Real>(fraction.x), fy = static_cast<Real>(fraction.y),
               fz = static_cast<Real>(fraction.z);
    constexpr std::size_t x = colours, y = kPaddedEdge * x, z = kPaddedEdge * y;
    for (std::size_t c = 0; c < colours; ++c) {
        const Real* p = corner + c;
        const auto mix = [](Real a, Real b, Real t) { return a + t * (b - a); };
        const Real near = mix(mix(p[0], p[x], fx), mix(p[y], p[y + x], fx), fy);
        const Real far = mix(mix(p[z], p[z + x], fx), mix(p[z + y], p[z + y + x], fx), fy);
        rgb[c] = mix(near, far, fz);
    }
}

// The same for those cells alone that have a bit in `cells`.
void mixSome(const Real* corner, std::size_t colours, const Vec3& fraction, unsigned cells, Real (&rgb)[3]) {
    Real all = 0;
    for (int i = 0; i < 8; ++i) {
        if ((cells >> i & 1) == 0) continue;
        constexpr double kLeast = 1e-3;  // where none of them has a weight, they count the same
        double weight = 1;
        for (int axis = 0; axis < 3; ++axis)
            weight *= std::max((i >> axis & 1) != 0 ? fraction[axis] : 1 - fraction[axis], kLeast);
        const Real* p = corner + std::size_t(paddedOffset(i & 1, i >> 1 & 1, i >> 2)) * colours;
        for (std::size_t c = 0; c < colours; ++c) rgb[c] += static_cast<Real>(weight) * p[c];
        all += static_cast<Real>(weight);
    }
    for (std::size_t c = 0; c < colours; ++c) rgb[c] /= all;
}

}  // namespace

void CellField::sample(const Vec3& ws, LastBlock& last, Real (&rgb)[3]) const {
    const Vec3 at = m_grid->csFromWs(ws) - 0.5;  // relative to the centre of the first cell
    const Int3 cell = wholeBelow(glm::clamp(at, -1e9, 1e9));
    const Int3 block(cell.x >> 3, cell.y >> 3, cell.z >> 3);
    std::int32_t stored = m_grid->stored(block, last);
    Int3 inside = cell - block * kCellEdge + 1;
    // If the cell's own block is not stored, the centres of border cells may lie in the border of a stored neighbour.
    for (int side = 1; side < 8 && stored < 0; ++side) {
        const Int3 step(side & 1, side >> 1 & 1, side >> 2);
        const Int3 beside((cell.x + step.x) >> 3, (cell.y + step.y) >> 3, (cell.z + step.z) >> 3);
        inside = cell - beside * kCellEdge + 1;
        if (glm::all(glm::greaterThanEqual(inside, Int3(0)))) stored = m_grid->stored(beside);
    }
    for (Real& c : rgb) c = 0;
    if (stored < 0) return;
    const Vec3 fraction = at - Vec3(cell);
    const Real* corner =
        m_values.data() +
        (std::size_t(stored) * kPaddedCells + std::size_t(paddedOffset(inside.x, inside.y, inside.z))) * m_colours;
    const unsigned side =
        m_grid->hasWalls() ? m_grid->onSideOf(m_grid->wsFromCs(at + 0.5), std::size_t(stored), inside) : kAllSides;
    if (side == kAllSides)
        m_colours == 1 ? mixAll<1>(corner, fraction, rgb) : mixAll<3>(corner, fraction, rgb);
    else
        mixSome(corner, m_colours, fraction, side, rgb);
    for (std::size_t c = 3; c-- > 0;) rgb[c] = rgb[m_colours == 1 ? 0 : c] * m_tint[c];
}

void CellField::lookUp(const SamplePlane& plane, const SampleTile& samples, const Real* extinction, Real* const rgb[3],
                       const Real* nearer) const {
    LastBlock last;
    const auto lookUpOne = [&](int k) {
        Real found[3];
        const SheetPath path(plane, samples, k, extinction[k], nearer ? nearer[k] : Real(-1));
        sample(path.wsNear + path.wsSeen, last, found);
        if (path.thick) {
            Real behind[3];
            sample(path.wsFar + path.wsSeenFar, last, behind);
            for (int c = 0; c < 3; ++c) found[c] += path.farther * (behind[c] - found[c]);
        }
        for (int c = 0; c < 3; ++c) rgb[c][k] = found[c];
    };
    if (!nearer && !samples.part && !m_grid->hasWalls()) {
        int left[kTileSize];
        const CellValues own{m_grid.get(), m_values.data(), m_colours, {m_tint[0], m_tint[1], m_tint[2]}};
        const int count = lookUpThin(own, plane, samples, extinction, rgb, left);
        for (int i = 0; i < count; ++i) lookUpOne(left[i]);
        return;
    }
    for (int c = 0; c < 3; ++c) std::fill_n(rgb[c], kTileSize, Real(0));
    for (int k = 0; k < kTileSize; ++k)
        if (extinction[k] != 0) lookUpOne(k);
}

}  // namespace scrim
