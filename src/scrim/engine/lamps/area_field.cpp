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
// Spacings of sub-lights beyond which their sum is that of the surface.
constexpr double kSpacings = 3;

// From 1 to 0, as t does from 0 to 1, with no bend at either end.
double fadeOut(double t) {
    t = std::clamp(t, 0.0, 1.0);
    return 1 - t * t * t * (10 - t * (15 - 6 * t));
}

double spacingOf(const Light& light, std::size_t elements) {
    return std::sqrt(light.area()->area() / double(std::max<std::size_t>(elements, 1)));
}

// The blocks of `all` that have a cell within a distance of the surface.
std::shared_ptr<const CellGrid> cellsWithin(const AreaShine& shine, double distance, const CellGrid& all,
                                            const Vec3& wsCorner) {
    const double reach = distance + all.edge(), half = 0.5 * kCellEdge * std::sqrt(3.0) * all.edge();
    return std::make_shared<const CellGrid>(
        blocksOf(all, wsCorner, [&](const Vec3& wsCenter) { return shine.distance(wsCenter) <= reach + half; }));
}

}  // namespace

AreaField::AreaField(const Light& light, std::span<const Light> elements, const CellGrid& all, const Vec3& wsCorner,
                     double sheet, std::size_t colours, const Rgb& tint)
    : m_shine(light),
      m_center(light.wsPosition),
      m_area(light.area()->area() / double(std::max<std::size_t>(elements.size(), 1))),
      m_near(std::max(kCells * all.edge(), kSheets * sheet)),
      m_mid(std::max(m_near, kSpacings * spacingOf(light, elements.size()))),
      m_lit(cellsWithin(m_shine, m_near, all, wsCorner), static_cast<int>(colours), tint),
      m_open(std::make_shared<const CellGrid>(m_lit.grid()), 1),
      m_far(any() ? cellsWithin(m_shine, m_mid, all, wsCorner) : std::make_shared<const CellGrid>(m_lit.grid()), 1) {
    const auto real = [](const Vec3& v) {
        return std::array<Real, 3>{static_cast<Real>(v.x), static_cast<Real>(v.y), static_cast<Real>(v.z)};
    };
    for (const Light& element : elements) {
        m_at.push_back(real(element.wsPosition - m_center));
        m_normal.push_back(real(element.wsDirection));
    }
    m_far.add([this](const Vec3& ws) { return Rgb(farShare(ws)); });
}

double AreaField::evenLight(const Vec3& ws) const {
    const Vec3 from = ws - m_center;
    const auto x = static_cast<Real>(from.x), y = static_cast<Real>(from.y), z = static_cast<Real>(from.z);
    const auto least = static_cast<Real>(m_area / (2 * std::numbers::pi));  // as that of elements (sub_lights)
    Real sum = 0;
    for (std::size_t i = 0; i < m_at.size(); ++i) {
        const Real dx = x - m_at[i][0], dy = y - m_at[i][1], dz = z - m_at[i][2];
        const Real r2 = std::max(dx * dx + dy * dy + dz * dz, Real(1e-30));
        const Real facing = dx * m_normal[i][0] + dy * m_normal[i][1] + dz * m_normal[i][2];
        sum += std::max(facing, Real(0)) / (std::sqrt(r2) * std::max(r2, least));
    }
    return m_area / (4 * std::numbers::pi) * double(sum);
}

double AreaField::nearShare(const Vec3& ws) const {
    return fadeOut(m_shine.distance(ws) / m_near);
}

double AreaField::farShare(const Vec3& ws) const {
    constexpr double kMost = 4;  // where sub-lights are aslant, what they show says little
    const double d = m_shine.distance(ws), far = 1 - fadeOut(d / m_near), differs = fadeOut(d / m_mid);
    if (far == 0 || differs == 0) return far;
    const double even = evenLight(ws), surface = m_shine.at(ws) / (4 * std::numbers::pi);
    const double brighter = even > 0 ? std::min(surface / even, kMost) : 1;
    return far * (1 + differs * (brighter - 1));
}

std::vector<const Real*> AreaField::farShares(const CellGrid& grid) const {
    std::vector<const Real*> shares;
    const Int3 shift = (grid.origin() - m_far.grid().origin()) / kCellEdge;
    for (const Int3& block : grid.storedBlocks()) {
        const std::int32_t own = m_far.grid().stored(block + shift);
        shares.push_back(own < 0 ? nullptr : m_far.block(std::size_t(own)));
    }
    return shares;
}

bool AreaField::reaches(const Bounds& ws) const {
    return m_shine.distance(ws.center()) - 0.5 * glm::length(ws.size()) < m_near + 2 * m_lit.grid().edge();
}

// What cells keep near each piece's place, times the piece's solid angle.
void AreaField::addPieces(const AreaShine::Pieces& pieces, double share, LastBlocks& last, Real (&rgb)[3]) const {
    for (const AreaShine::Piece& piece : pieces.used()) {
        Real lit[3], open[3];
        m_open.sample(piece.ws, last.open, open);
        if (open[0] <= 0) continue;
        m_lit.sample(piece.ws, last.lit, lit);
        const auto factor = static_cast<Real>(share * piece.solidAngle / (4 * std::numbers::pi)) / open[0];
        for (int c = 0; c < 3; ++c) rgb[c] += factor * lit[c];
    }
}

void AreaField::addTo(const Vec3& ws, Real (&rgb)[3]) const {
    AreaShine::Pieces one;
    one.all[one.count++] = {m_shine.at(ws), ws};
    LastBlocks last;
    addPieces(one, 1, last, rgb);
}

void AreaField::addTo(const SamplePlane& plane, const SampleTile& samples, const Real* extinction, Real* const rgb[3],
                      const Real* nearer) const {
    constexpr int kParts = 4;
    constexpr double kTurns = 2;
    LastBlocks last;
    for (int k = 0; k < kTileSize; ++k) {
        if (extinction[k] == 0) continue;
        const SheetPath path(plane, samples, k, extinction[k], nearer ? nearer[k] : Real(-1));
        const double length = glm::length(path.ws), away = m_shine.distance(path.wsMiddle);
        if (away > m_near + 2 * m_lit.grid().edge() + 0.5 * length) continue;
        const Vec3 way = plane.towardsEye > 0 ? -path.ws : path.ws, begin = path.wsMiddle - 0.5 * way;
        const double tau = plane.towardsEye == 0 ? 0 : double(extinction[k]) * length;
        // Close to the surface its light turns within a sheet, and with it what the eye sees of it: with g = 0.6, whole
        // sheets left 3.5 and 11 % beside a square and a tube, and four parts leave 1.7 and 4.7 %.
        const int parts = away < kTurns * length ? kParts : path.thick ? 2 : 1;
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
