// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/lamps/area_field.h>

#include <scrim/engine/lamps/lamp.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

namespace scrim {
namespace {

// Look-ups compute the light of a surface within so many cells and so many sheets from it. Beyond, cells show it as it
// is, and the middle of a sheet is like the whole. In haze beside a square of two voxels, with sheets of 1.4
// voxels, 2.8 and 5 of them left 1.3 and 0.4 %.
constexpr double kCells = 8, kSheets = 5;
// Spacings of sub-lights up to which their sum differs from the surface, and beyond which it does not.
constexpr double kDiffer = 4, kAlike = 8;

// From 1 to 0, as t does from 0 to 1, with no bend at either end.
double fadeOut(double t) {
    t = std::clamp(t, 0.0, 1.0);
    return 1 - t * t * t * (10 - t * (15 - 6 * t));
}

// The blocks of `all` that have a cell within a distance of the surface.
std::shared_ptr<const CellGrid> cellsWithin(const AreaShine& shine, double distance, const CellGrid& all,
                                            const Vec3& wsCorner) {
    const double reach = distance + all.edge(), half = 0.5 * kCellEdge * std::sqrt(3.0) * all.edge();
    return std::make_shared<const CellGrid>(
        blocksOf(all, wsCorner, [&](const Vec3& wsCenter) { return shine.distance(wsCenter) <= reach + half; }));
}

}  // namespace

AreaField::AreaField(const Light& light, const AreaView& view, std::span<const Light> elements, const CellGrid& all,
                     const Vec3& wsCorner, std::size_t colours, const Rgb& tint)
    : m_shine(light, view.octaves, view.camera),
      m_area(light.area()->area() / double(std::max<std::size_t>(elements.size(), 1))),
      m_near(std::max(kCells * all.edge(), kSheets * view.sheet)),
      m_spacing(std::sqrt(m_area)),
      m_lit(cellsWithin(m_shine, m_near, all, wsCorner), static_cast<int>(colours), tint),
      m_open(std::make_shared<const CellGrid>(m_lit.grid()), 1),
      m_far(any() ? cellsWithin(m_shine, std::max(m_near, kAlike * m_spacing), all, wsCorner)
                  : std::make_shared<const CellGrid>(m_lit.grid()),
            1) {
    for (const Light& element : elements) {
        m_at.push_back(element.wsPosition);
        m_normal.push_back(element.wsDirection);
    }
    m_far.add([this](const Vec3& ws) { return Rgb(farShare(ws)); });
}

// What arrives from the sub-lights at a place that sees a radiance of 1 through nothing.
double AreaField::evenLight(const Vec3& ws) const {
    const double least = m_area / (2 * std::numbers::pi);  // as that of elements (sub_lights)
    double sum = 0;
    for (std::size_t i = 0; i < m_at.size(); ++i) {
        const Vec3 way = ws - m_at[i];
        const double r2 = std::max(glm::dot(way, way), 1e-30), facing = glm::dot(way, m_normal[i]);
        if (facing > 0) sum += facing / (std::sqrt(r2) * std::max(r2, least));
    }
    return m_area * sum;
}

// The part of light that this field keeps, of that of a cell.
double AreaField::nearShare(const Vec3& ws) const {
    return fadeOut(m_shine.distance(ws) / m_near);
}

double AreaField::farShare(const Vec3& ws) const {
    constexpr double kMost = 4;  // where sub-lights are aslant, what they show says little
    const double d = m_shine.distance(ws), far = 1 - fadeOut(d / m_near),
                 differs = fadeOut((d / m_spacing - kDiffer) / (kAlike - kDiffer));
    if (far == 0 || differs == 0) return far;
    const double even = evenLight(ws), surface = m_shine.at(ws);
    const double brighter = even > 0 ? std::min(surface / even, kMost) : 1;
    return far * (1 + differs * (brighter - 1));
}

void AreaField::keepNear() {
    m_lit.forCells([&](const Int3& cell, Real* values) {
        const auto share = static_cast<Real>(nearShare(m_lit.grid().wsFromCs(Vec3(cell) + 0.5)));
        for (std::size_t c = 0; c < m_lit.colours(); ++c) values[c] *= share;
    });
}

void AreaField::keepFar(CellField& light) const {
    const CellGrid& grid = light.grid();
    const Int3 shift = (grid.origin() - m_far.grid().origin()) / kCellEdge;
    parallelFor(grid.storedBlocks().size(), [&](std::size_t b) {
        const std::int32_t own = m_far.grid().stored(grid.storedBlocks()[b] + shift);
        if (own < 0) return;
        const Real* shares = m_far.block(std::size_t(own));
        Real* values = light.block(b);
        for (std::size_t i = 0; i < kPaddedCells * light.colours(); ++i) values[i] *= shares[i / light.colours()];
    });
}

bool AreaField::reaches(const Bounds& ws) const {
    return m_shine.distance(ws.center()) - 0.5 * glm::length(ws.size()) < m_near + 2 * m_lit.grid().edge();
}

// What cells keep near each piece's place, times what the piece shows.
void AreaField::addPieces(const AreaShine::Pieces& pieces, double share, LastBlocks& last, Real (&rgb)[3]) const {
    for (const AreaShine::Piece& piece : pieces.used()) {
        Real lit[3], open[3];
        m_open.sample(piece.ws, last.open, open);
        if (open[0] <= 0) continue;
        m_lit.sample(piece.ws, last.lit, lit);
        const auto factor = static_cast<Real>(share * piece.shown) / open[0];
        for (int c = 0; c < 3; ++c) rgb[c] += factor * lit[c];
    }
}

void AreaField::addTo(const Vec3& ws, Real (&rgb)[3]) const {
    AreaShine::Pieces one;
    one.all[one.count++] = {m_shine.shown(ws), ws};
    LastBlocks last;
    addPieces(one, 1, last, rgb);
}

void AreaField::addTo(const SamplePlane& plane, const SampleTile& samples, const Real* extinction, Real* const rgb[3],
                      const Real* nearer) const {
    LastBlocks last;
    for (int k = 0; k < kTileSize; ++k) {
        if (extinction[k] == 0) continue;
        const SheetPath path(plane, samples, k, extinction[k], nearer ? nearer[k] : Real(-1));
        const double length = glm::length(path.ws);
        if (m_shine.distance(path.wsMiddle) > m_near + 2 * m_lit.grid().edge() + 0.5 * length) continue;
        const Vec3 way = plane.towardsEye > 0 ? -path.ws : path.ws, begin = path.wsMiddle - 0.5 * way;
        const double tau = plane.towardsEye == 0 ? 0 : double(extinction[k]) * length;
        const int parts = path.thick ? 2 : 1;
        Real found[3] = {0, 0, 0};
        const double through = std::exp(-tau / parts);
        double all = 0, seen = 1;
        for (int i = 0; i < parts; ++i, seen *= through) all += seen;
        seen = 1;
        for (int i = 0; i < parts; ++i, seen *= through)
            addPieces(m_shine.along(begin + double(i) / parts * way, way / double(parts), tau / parts), seen / all,
                      last, found);
        for (int c = 0; c < 3; ++c) rgb[c][k] += found[c];
    }
}

}  // namespace scrim
