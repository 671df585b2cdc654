// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/transport/cell_field.h>

#include <scrim/base/parallel.h>
#include <scrim/engine/transport/cell_slices.h>
#include <scrim/engine/transport/light_sources.h>
#include <scrim/geometry/bounds.h>
#include <scrim/geometry/sheets.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace scrim {
CellField::CellField(std::shared_ptr<const CellGrid> grid, int colours, const Rgb& tint)
    : m_grid(std::move(grid)),
      m_colours(static_cast<std::size_t>(colours)),
      m_values(m_grid->storedBlocks().size() * kPaddedCells * m_colours, Real(0)) {
    for (int c = 0; c < 3; ++c) m_tint[c] = static_cast<Real>(tint[c]);
}

Real* CellField::cell(std::size_t index) {
    const std::size_t i = index % kBlockCells;
    const std::size_t x = i % kCellEdge + 1, y = i / kCellEdge % kCellEdge + 1, z = i / (kCellEdge * kCellEdge) + 1;
    return block(index / kBlockCells) + ((z * kPaddedEdge + y) * kPaddedEdge + x) * m_colours;
}

namespace {

const std::pair<Int3, std::int32_t> kNoBlock{Int3(1 << 30), -1};  // of sampleAt: none has been looked up
constexpr double kMostDepth = 60;                                 // of light that could be seen

}  // namespace

bool hollowOnCells(const Light& lamp, double edge) {
    return radiusOfSphere(lamp) > edge;
}

double nearestFar(const Light& lamp, double edge) {
    return 12 * edge + 3 * radiusOfSphere(lamp);
}

std::shared_ptr<const CellGrid> cellsNear(const Light& lamp, const CellGrid& all, const Vec3& wsCorner) {
    const double reach = nearestFar(lamp, all.edge()) + all.edge(), half = 0.5 * kCellEdge * all.edge();
    std::vector<Bounds> boxes;
    for (const Int3& block : all.storedBlocks()) {
        const Vec3 center = all.wsFromCs(Vec3(block * kCellEdge) + 0.5 * kCellEdge);
        const Vec3 beside = glm::max(glm::abs(lamp.wsPosition - center) - half, Vec3(0));
        if (glm::dot(beside, beside) <= reach * reach) boxes.push_back({center - all.edge(), center + all.edge()});
    }
    return std::make_shared<const CellGrid>(all.edge(), boxes, wsCorner);
}

void CellField::setLamp(const Light& lamp, const Phase& phase, const Camera& camera, bool attenuated, bool nearby) {
    m_lamp = lamp;
    m_attenuated = attenuated;
    if (lamp.luminaire) m_lampFrame = lightFrame(lamp);
    m_phase = phase;
    m_caps = nullptr;
    if (radiusOfSphere(lamp) > 0 && !phase.isotropic())
        m_caps = std::make_shared<const PhaseOverCaps>(phase, 0.5 * std::numbers::pi);
    m_camera = camera;
    m_hollow = hollowOnCells(lamp, m_grid->edge());
    m_near = nearby ? nearestFar(lamp, m_grid->edge()) : 0;
}

// Calls visit(place, values) for each cell of each block, and for those around it, in parallel.
template <class Visit>
void CellField::forCells(const Visit& visit) {
    parallelFor(m_grid->storedBlocks().size(), [&](std::size_t b) {
        const Int3 first = m_grid->storedBlocks()[b] * kCellEdge - 1;
        Real* values = block(b);
        for (int i = 0; i < static_cast<int>(kPaddedCells); ++i, values += m_colours)
            visit(first + Int3(i % kPaddedEdge, i / kPaddedEdge % kPaddedEdge, i / (kPaddedEdge * kPaddedEdge)),
                  values);
    });
}

void CellField::add(const std::function<Rgb(const Vec3& ws)>& light) {
    forCells([&](const Int3& cell, Real* values) {
        const Rgb more = light(m_grid->wsFromCs(Vec3(cell) + 0.5));
        for (std::size_t c = 0; c < m_colours; ++c) values[c] += static_cast<Real>(more[static_cast<int>(c)]);
    });
}

// The way that the mean extinction of a cell is for.
double CellField::wayTo(const Int3& cell) const {
    const double r = glm::distance(m_grid->wsFromCs(Vec3(cell) + 0.5), m_lamp->wsPosition);
    return std::max(m_hollow ? wayFrom(*m_lamp, r) : r, kLeastWay * m_grid->edge());
}

void CellField::makeMean(const CellMedia& media, std::shared_ptr<const CellField> open) {
    m_open = std::move(open);
    const double radius = m_hollow ? radiusOfSphere(*m_lamp) : 0;
    forCells([&](const Int3& cell, Real* values) {
        const double way = wayTo(cell);
        for (std::size_t c = 0; c < m_colours; ++c) {
            const double depth = -std::log(std::max(double(values[c]), 1e-30));
            values[c] = static_cast<Real>((radius > 0 ? depth + shellOverDisk(radius / way * depth) : depth) / way);
        }
    });
    if (!m_attenuated) return;
    sharpenMeans(*this, [&](const Int3& cell) { return wayTo(cell); });
    if (m_hollow)
        forCells([&](const Int3& cell, Real* values) {
            if (wayTo(cell) * double(values[0]) < kDarkDepth)
                keepNearSphere(media, m_grid->wsFromCs(Vec3(cell) + 0.5), values);
        });
}

// Replaces the mean extinction close to a sphere. Cells at its surface and within continue what is just outside.
void CellField::keepNearSphere(const CellMedia& media, const Vec3& ws, Real* values) const {
    // Cells; optical depths behind which little is left, and of a radius whose light is nearly that of its middle.
    constexpr double kInside = 3, kOutside = 4, kDark = 6, kThin = 1;
    const Vec3& center = m_lamp->wsPosition;
    const double edge = m_grid->edge(), radius = radiusOfSphere(*m_lamp), r = glm::distance(ws, center);
    const double k = double(values[0]), dense = k * radius < kThin ? 0 : std::min(radius, kDark / k);
    const double share = std::clamp(2 * (1 - (r - radius) / std::max(kOutside * edge, dense)), 0.0, 1.0);
    if (share == 0 || r < std::max(radius - kInside * edge, 1e-9 * edge)) return;
    const double outside = std::max(r, radius + 0.25 * edge), way = wayFrom(*m_lamp, outside);
    const Rgb depth = depthFromSphere(media, center, radius, center + outside / r * (ws - center));
    for (std::size_t c = 0; c < m_colours; ++c)
        values[c] += static_cast<Real>(share * (depth[static_cast<int>(c)] / way - double(values[c])));
}

// The part of the lamp's light that its own cells keep. The rest starts at the lamp as r^2 does, so that it bends
// little between the cells that it is kept on: at a reach of R, its mean over them is at most 0.4 (12 edge / R)^2 % of
// the lamp's light off.
double CellField::nearShare(double r) const {
    if (m_near == 0) return 1;
    const double radius = radiusOfSphere(*m_lamp), t = std::clamp((r - radius) / (m_near - radius), 0.0, 1.0);
    return 1 - t * t * t * t * (15 - 24 * t + 10 * t * t);
}

// What the lamp's light is scattered by towards the eye, times r^2, without attenuation.
double CellField::lampFactor(const Vec3& ws) const {
    const Vec3 way = ws - m_lamp->wsPosition;
    const double r = glm::length(way);
    const Vec3 travel = r > 0 ? way / r : Vec3(0, 0, 1);
    // A sphere fills a cone of the solid angle 2 pi (1 - cosine).
    const double radius = radiusOfSphere(*m_lamp);
    const double cosine = r > radius ? std::sqrt(1 - radius * radius / (r * r)) : 0;
    constexpr double kEven = 1 / (4 * std::numbers::pi);
    const double toEye = m_phase.isotropic() ? 0 : glm::dot(travel, travelToEye(m_camera, ws));
    const double factor = m_phase.isotropic() ? kEven
                          : m_caps            ? m_caps->at(toEye, std::acos(cosine))
                                              : phaseValue(m_phase, toEye);
    return radius > 0 ? factor * 2 * std::numbers::pi * radius * radius / (1 + cosine) : factor;
}

Rgb CellField::farLight(const Vec3& ws, double transmittance) const {
    const double r = glm::distance(ws, m_lamp->wsPosition);
    if (r < 1e-6 * m_near) return Rgb(0);
    // Cells too coarse to resolve a sphere know the transmittance from within.
    if (!m_hollow && radiusOfSphere(*m_lamp) > 0) transmittance = std::pow(transmittance, wayFrom(*m_lamp, r) / r);
    const double part = luminairePart(*m_lamp, m_lampFrame, (ws - m_lamp->wsPosition) / r);
    return m_lamp->intensity * (part * transmittance * (1 - nearShare(r)) * lampFactor(ws) * lampDecay(r * r));
}

std::optional<Rgb> CellField::evenFarLight(double& reach) const {
    if (m_lamp->area() || m_lamp->luminaire || !m_lamp->point().decay || !m_phase.isotropic()) return std::nullopt;
    reach = std::max(m_near, m_lamp->point().radius);
    return m_lamp->intensity / (4 * std::numbers::pi);
}

double CellField::lampDecay(double r2) const {
    // At its very place a lamp shines through nothing: 0 times infinity.
    r2 = std::max(r2, 1e-12 * m_grid->edge() * m_grid->edge());
    if (m_lamp->area()) return 1 / r2;
    return m_lamp->point().decay ? 1 / std::max(r2, std::pow(m_lamp->point().radius, 2)) : 1;
}

// The mean of the luminaire's profile over a path as meanDecay has it, weighted by 1/r^2: close to the lamp its
// direction turns within a sheet. The weight is even in the angle under which the lamp sees the path.
double CellField::meanProfile(const Vec3& way, const Vec3& path) const {
    if (!m_lamp->luminaire) return 1;
    const double t2 = glm::dot(path, path), r2 = glm::dot(way, way), t = std::sqrt(t2), d = glm::dot(way, path) / t;
    const auto at = [&](const Vec3& v) {
        return luminairePart(*m_lamp, m_lampFrame, v / std::max(glm::length(v), 1e-300));
    };
    if (r2 > 100 * t2) return at(way);  // to t^2 / (24 r^2) times the profile's curvature
    const double b = std::max(std::sqrt(std::max(r2 - d * d, 0.0)), 1e-4 * m_grid->edge());
    const double begin = std::atan((d - 0.5 * t) / b), end = std::atan((d + 0.5 * t) / b);
    double sum = 0;
    for (const auto& [u, w] : kFourPoints)
        sum += w * at(way + (b * std::tan(begin + u * (end - begin)) - d) / t * path);
    return sum;
}

// Turns the mean extinction on the way from the lamp to `ws` into light times r^2. `part`: the luminaire's.
void CellField::lampAt(const Vec3& ws, double part, Real (&rgb)[3]) const {
    double factor = part * lampFactor(ws);
    if (m_open) {
        Real open[3];
        m_open->sample(ws, open);
        factor *= double(open[0]);
    }
    const auto length = static_cast<Real>(wayFrom(*m_lamp, glm::distance(ws, m_lamp->wsPosition)));
    Real arrives = 1;
    for (std::size_t c = 0; c < 3; ++c) {
        if (c < m_colours) arrives = std::exp(-rgb[c] * length);
        rgb[c] = static_cast<Real>(m_lamp->intensity[static_cast<int>(c)] * factor) * arrives;
    }
}

// The mean of 1 / max(r^2, radius^2) over a path from z = d - t/2 to d + t/2, with r^2 = b^2 + z^2 and b the distance
// of the eye's ray from the lamp. The integral of 1 / (b^2 + z^2) is atan(z / b) / b. The value in the middle of the
// sheet alone is wrong by any amount in sheets close to the lamp, where much of its light is.
double CellField::meanDecay(const Vec3& way, const Vec3& path) const {
    const double t2 = glm::dot(path, path), r2 = glm::dot(way, way);
    const double least = 1e-2 * m_grid->edge();  // a sample at the very place of the lamp must not be infinite
    const double radius = m_lamp->area() ? 0 : std::max(m_lamp->point().radius, least);
    if (r2 > 300 * t2 && r2 > 4 * radius * radius) return 1 / r2;  // to t^2 / (4 r^2)
    const double t = std::sqrt(t2), d = glm::dot(way, path) / t;
    const double b2 = std::max(r2 - d * d, 0.0), b = std::max(std::sqrt(b2), 1e-3 * std::max(radius, least));
    const double inside = std::sqrt(std::max(radius * radius - b2, 0.0));  // half the way through the radius
    const double begin = d - 0.5 * t, end = d + 0.5 * t;
    const auto outside = [&](double from, double to) {
        return to > from ? (std::atan(to / b) - std::atan(from / b)) / b : 0.0;
    };
    const double within = std::max(std::min(end, inside) - std::max(begin, -inside), 0.0);
    const double sum = (within > 0 ? within / (radius * radius) : 0) + outside(begin, std::min(end, -inside)) +
                       outside(std::max(begin, inside), end);
    return sum / t;
}

// Near a sphere its solid angle and the way from it change within a sheet, too: the factor by which the mean over the
// eye's path through the sheet, of solid angle and attenuation, differs from those in its middle, times 1/r^2 there.
double CellField::meanNearSphere(const Vec3& way, const Vec3& path, double extinction) const {
    const double radius2 = std::pow(radiusOfSphere(*m_lamp), 2), t = glm::length(path), d = glm::dot(way, path) / t;
    const double b2 = std::max(glm::dot(way, way) - d * d, 1e-12 * radius2);
    const double inside = std::sqrt(std::max(radius2 - b2, 0.0));  // half the way through the sphere
    const auto light = [&](double r2) {                            // as lampAt has it, but for what the middle shares
        const double cosine = std::sqrt(std::max(1 - radius2 / r2, 0.0));
        return std::exp(-extinction * wayFrom(*m_lamp, std::sqrt(r2))) / (1 + cosine);
    };
    // Light changes as a square root does at the sphere, so Gauss-Legendre takes the root as its variable.
    const auto outside = [&](double nearest, double farthest) {
        if (farthest <= nearest) return 0.0;
        double sum = 0;
        for (const auto& [u, weight] : kFourPoints) {
            const double z = nearest + (farthest - nearest) * u * u, r2 = std::max(b2 + z * z, radius2);
            sum += 2 * u * weight * light(r2) / r2;
        }
        return sum * (farthest - nearest);
    };
    const double begin = d - 0.5 * t, end = d + 0.5 * t;
    const double sum = outside(std::max(begin, inside), end) + outside(std::max(-end, inside), -begin);
    return sum / (t * light(std::max(glm::dot(way, way), 1e-30)));
}

void CellField::sample(const Vec3& ws, Real (&rgb)[3]) const {
    std::pair<Int3, std::int32_t> last = kNoBlock;
    sampleAt(m_grid->csFromWs(ws) - 0.5, last, rgb);
    if (m_lamp) {
        const Vec3 way = ws - m_lamp->wsPosition;
        const double r = glm::length(way);
        lampAt(ws, r > 0 ? luminairePart(*m_lamp, m_lampFrame, way / r) : 0, rgb);
        for (Real& c : rgb) c *= static_cast<Real>(nearShare(r) * lampDecay(r * r));
    }
    for (const auto& lamp : m_lamps) {
        Real own[3];
        lamp->sample(ws, own);
        for (int c = 0; c < 3; ++c) rgb[c] += own[c];
    }
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

// `at` is relative to the centre of the first cell. `last`: the block that was looked up last, and which stored one it
// is; neighbouring samples are mostly in the same one.
void CellField::sampleAt(const Vec3& at, std::pair<Int3, std::int32_t>& last, Real (&rgb)[3]) const {
    const Int3 cell = wholeBelow(glm::clamp(at, -1e9, 1e9));
    const Int3 block(cell.x >> 3, cell.y >> 3, cell.z >> 3);
    if (block != last.first) last = {block, m_grid->stored(block)};
    std::int32_t stored = last.second;
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

namespace {

// The halves of a sheet count apart if its optical depth is above this, since light that fades within the sheet does so
// as an exponential and not evenly.
constexpr double kThick = 0.5;

// The eye sees more of the nearer part of a sheet. Light that changes evenly along its path, of optical depth `tau`,
// counts as it is at coth(tau / 2) / 2 - 1 / tau of the path before the middle.
double nearerThanMiddle(double tau) {
    const double t2 = tau * tau;  // the series is exact to 1e-7
    return tau < 1 ? tau / 12 * (1 - t2 / 60 * (1 - t2 / 42 * (1 - t2 / 40))) : 0.5 / std::tanh(0.5 * tau) - 1 / tau;
}

}  // namespace

void CellField::lookUp(const SamplePlane& plane, const SampleTile& samples, const Real* extinction,
                       Real* const rgb[3]) const {
    std::pair<Int3, std::int32_t> last = kNoBlock;
    for (int k = 0; k < kTileSize; ++k) {
        Real found[3];
        for (int c = 0; c < 3; ++c) rgb[c][k] = 0;
        if (extinction[k] == 0) continue;
        const double u = double(samples.u[k]), v = double(samples.v[k]);
        const Vec3 middle = plane.wsOrigin + u * plane.wsPerU + v * plane.wsPerV;
        const Vec3 way = m_lamp ? middle - m_lamp->wsPosition : Vec3(0);
        Real factor = m_near > 0 ? static_cast<Real>(nearShare(glm::length(way))) : Real(1);
        if (factor == 0) continue;
        const Vec3 path = plane.wsPerSheet + plane.toTexels * (double(samples.eyeA[k]) * plane.wsPerU +
                                                               double(samples.eyeB[k]) * plane.wsPerV);
        const Vec3 ahead = plane.towardsEye * path;
        const double tau = double(extinction[k]) * glm::length(path), half = 0.5 * tau;
        const bool thick = tau > kThick;
        const Vec3 center = thick ? middle + 0.25 * ahead : middle;
        const Vec3 seen = (thick ? 0.5 * nearerThanMiddle(half) : nearerThanMiddle(tau)) * ahead;
        sampleAt(m_grid->csFromWs(center + seen) - 0.5, last, found);
        double part = 1;
        if (m_lamp) {
            constexpr double kNear = 4;
            const double radius = radiusOfSphere(*m_lamp);
            if (radius > 0 && glm::dot(way, way) < kNear * kNear * (radius * radius + glm::dot(path, path)))
                factor *= static_cast<Real>(meanNearSphere(way, path, double(found[1])));
            else if (radius > 0 || m_lamp->point().decay)
                factor *= static_cast<Real>(meanDecay(way, path));
            part = meanProfile(way, path);
            lampAt(center, part, found);
        }
        if (thick) {
            Real behind[3];
            const Vec3 farther = center - 0.5 * ahead;
            sampleAt(m_grid->csFromWs(farther + seen) - 0.5, last, behind);
            if (m_lamp) lampAt(farther, part, behind);
            const auto share = static_cast<Real>(1 / (1 + std::exp(half)));  // of what the eye sees of the sheet
            for (int c = 0; c < 3; ++c) found[c] += share * (behind[c] - found[c]);
        }
        for (int c = 0; c < 3; ++c) rgb[c][k] = factor * found[c];
    }
    if (!m_lamps.empty()) addNearLamps(plane, samples, extinction, rgb);
}

// Adds the light of the lamps that any of the samples is near to.
void CellField::addNearLamps(const SamplePlane& plane, const SampleTile& samples, const Real* extinction,
                             Real* const rgb[3]) const {
    Bounds place;
    for (int k = 0; k < kTileSize; ++k)
        if (extinction[k] != 0)
            place.include(plane.wsOrigin + double(samples.u[k]) * plane.wsPerU + double(samples.v[k]) * plane.wsPerV);
    for (const auto& lamp : m_lamps) {
        const Vec3& at = lamp->m_lamp->wsPosition;
        if (glm::distance(at, glm::clamp(at, place.lower, place.upper)) >= lamp->m_near) continue;
        Real own[3][kTileSize];
        Real* const rows[3] = {own[0], own[1], own[2]};
        lamp->lookUp(plane, samples, extinction, rows);
        for (int i = 0; i < 3 * kTileSize; ++i) rgb[i / kTileSize][i % kTileSize] += own[i / kTileSize][i % kTileSize];
    }
}

}  // namespace scrim
