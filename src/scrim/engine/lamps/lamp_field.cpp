// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/lamps/lamp_field.h>

#include <scrim/base/parallel.h>
#include <scrim/engine/cells/cell_media.h>
#include <scrim/engine/lamps/lamp.h>
#include <scrim/engine/lamps/path_past_lamp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

// Optical depths from this on are those of no light that could be seen.
constexpr double kDarkDepth = 60;
// The least way that a mean extinction is for, in cells.
constexpr double kLeastWay = 1e-3;

// Factors on extinction, the largest first, between which those of all octaves lie. Behind the edge
// of a shadow the mean over a sphere's ways of exp(-factor * depth) is no exponential; its
// logarithm over the factor bends little between factors that are kRatio apart.
std::vector<double> knotsFor(const std::vector<Octave>& octaves) {
    constexpr double kRatio = 32, kLeast = 1e-3;  // below which a transmittance has too few digits
    const double most = std::max(octaves.front().extinction, kLeast),
                 least = std::max(octaves.back().extinction, kLeast);
    const int steps = static_cast<int>(std::ceil(std::log(most / least) / std::log(kRatio) - 1e-9));
    std::vector<double> knots{most};
    for (int i = 1; i <= steps; ++i) knots.push_back(most * std::pow(least / most, double(i) / steps));
    return knots;
}

}  // namespace

LampField::LampField(const LampView& view, std::shared_ptr<const CellGrid> cells, int channels) : m_view(view) {
    for (const double extinction : knotsFor(view.octaves)) m_knots.push_back({extinction, CellField(cells, channels)});
    for (const Octave& octave : view.octaves) {
        Part part{octave, 0, 0, 1, 0, nullptr};
        const double e = octave.extinction;
        while (part.knot + 2 < m_knots.size() && m_knots[part.knot + 1].extinction > e) ++part.knot;
        const double first = m_knots[part.knot].extinction;
        part.low = e / first;
        part.nearest = part.knot;
        if (m_knots.size() > 1) {
            const double next = m_knots[part.knot + 1].extinction;
            const double beyond = std::clamp((first - e) / (first - next), 0.0, 1.0);
            part.low *= 1 - beyond;
            part.high = e / next * beyond;
            part.nearest += beyond > 0.5 ? 1 : 0;
        }
        if (radiusOfSphere(lamp()) > 0 && !octave.phase.isotropic())
            part.caps = std::make_shared<const PhaseOverCaps>(octave.phase, 0.5 * std::numbers::pi);
        m_even = m_even && octave.phase.isotropic();
        m_lobe = std::min(m_lobe, lobeWidth(octave.phase));
        m_parts.push_back(std::move(part));
    }
    if (lamp().luminaire) m_frame = lightFrame(lamp());
    m_hollow = hollowOnCells(lamp(), grid().edge());
    if (view.nearby) m_near = nearestFar(lamp(), grid().edge());
}

// The way that the mean extinction of a cell is for.
double LampField::wayTo(const Int3& cell) const {
    const double r = glm::distance(grid().wsFromCs(Vec3(cell) + 0.5), lamp().wsPosition);
    return std::max(m_hollow ? wayFrom(lamp(), r) : r, kLeastWay * grid().edge());
}

void LampField::makeMean(const MediaTogether& media, std::shared_ptr<const CellField> open) {
    m_open = std::move(open);
    for (Knot& knot : m_knots) makeMean(knot, media);
}

void LampField::makeMean(Knot& knot, const MediaTogether& media) const {
    const double radius = m_hollow ? radiusOfSphere(lamp()) : 0;
    knot.values.forCells([&](const Int3& cell, Real* values) {
        const double way = wayTo(cell);
        for (std::size_t c = 0; c < colours(); ++c) {
            const double depth = -std::log(std::max(double(values[c]), 1e-30));
            values[c] = static_cast<Real>((radius > 0 ? depth + shellOverDisk(radius / way * depth) : depth) / way);
        }
    });
    if (!m_view.attenuated) return;
    sharpenMeans(knot.values, [&](const Int3& cell) { return wayTo(cell); });
    if (m_hollow)
        knot.values.forCells([&](const Int3& cell, Real* values) {
            if (wayTo(cell) * double(values[0]) < kDarkDepth)
                keepNearSphere(knot, media, grid().wsFromCs(Vec3(cell) + 0.5), values);
        });
}

// Replaces the mean extinction close to a sphere. Cells at its surface and within continue what is just outside.
void LampField::keepNearSphere(const Knot& knot, const MediaTogether& media, const Vec3& ws, Real* values) const {
    // Cells; optical depths behind which little is left, and of a radius whose light is nearly that of its middle.
    constexpr double kInside = 3, kOutside = 4, kDark = 6, kThin = 1;
    const Vec3& center = lamp().wsPosition;
    const double edge = grid().edge(), radius = radiusOfSphere(lamp()), r = glm::distance(ws, center);
    const double k = double(values[0]), dense = k * radius < kThin ? 0 : std::min(radius, kDark / k);
    const double share = std::clamp(2 * (1 - (r - radius) / std::max(kOutside * edge, dense)), 0.0, 1.0);
    if (share == 0 || r < std::max(radius - kInside * edge, 1e-9 * edge)) return;
    const double outside = std::max(r, radius + 0.25 * edge), way = wayFrom(lamp(), outside);
    const Rgb depth = depthFromSphere(media, knot.extinction, center, radius, center + outside / r * (ws - center));
    for (std::size_t c = 0; c < colours(); ++c)
        values[c] += static_cast<Real>(share * (depth[static_cast<int>(c)] / way - double(values[c])));
}

// The part of the lamp's light that its own cells keep. The rest starts at the lamp as r^2 does, so
// that it bends little between the cells that it is kept on: at a reach of R, its mean over them is
// at most 0.4 (12 edge / R)^2 % of the lamp's light off.
double LampField::nearShare(double r) const {
    if (m_near == 0) return 1;
    const double radius = radiusOfSphere(lamp()), t = std::clamp((r - radius) / (m_near - radius), 0.0, 1.0);
    return 1 - t * t * t * t * (15 - 24 * t + 10 * t * t);
}

LampField::Arrival LampField::arrivalAt(const Vec3& ws) const {
    const Vec3 way = ws - lamp().wsPosition;
    const double r = glm::length(way);
    const Vec3 travel = r > 0 ? way / r : Vec3(0, 0, 1);
    // A sphere fills a cone of the solid angle 2 pi (1 - cosine).
    const double radius = radiusOfSphere(lamp());
    const double cosine = r > radius ? std::sqrt(1 - radius * radius / (r * r)) : 0;
    Arrival arrival{0, 0, 1, wayFrom(lamp(), r), 1};
    if (!m_even) arrival.toEye = glm::dot(travel, travelToEye(m_view.camera, ws));
    if (radius > 0) {
        arrival.solidAngle = 2 * std::numbers::pi * radius * radius / (1 + cosine);
        if (!m_even) arrival.halfAngle = std::acos(cosine);
    }
    if (m_open) {
        Real open[3];
        m_open->sample(ws, open);
        arrival.open = double(open[0]);
    }
    return arrival;
}

// What the lamp's light is scattered by towards the eye, times r^2, without attenuation.
double LampField::scattered(const Part& part, const Arrival& arrival) const {
    constexpr double kEven = 1 / (4 * std::numbers::pi);
    const Phase& phase = part.octave.phase;
    return arrival.solidAngle * (phase.isotropic() ? kEven
                                 : part.caps       ? part.caps->at(arrival.toEye, arrival.halfAngle)
                                                   : phaseValue(phase, arrival.toEye));
}

Rgb LampField::farLight(std::size_t knot, const Vec3& ws, double transmittance) const {
    const double r = glm::distance(ws, lamp().wsPosition);
    if (r < 1e-6 * m_near) return Rgb(0);
    const Arrival arrival = arrivalAt(ws);
    // Cells too coarse to resolve a sphere know the transmittance from within.
    const double within = !m_hollow && radiusOfSphere(lamp()) > 0 ? arrival.length / r : 1;
    double sum = 0;
    for (const Part& part : m_parts) {
        if (part.nearest != knot) continue;
        const double power = within * part.octave.extinction / m_knots[knot].extinction;
        const double arrives = power == 1 ? transmittance : std::pow(transmittance, power);
        sum += part.octave.share * scattered(part, arrival) * arrives;
    }
    const double profile = luminairePart(lamp(), m_frame, (ws - lamp().wsPosition) / r);
    return lamp().intensity * (profile * sum * (1 - nearShare(r)) * decay(r * r));
}

std::optional<Rgb> LampField::evenFarLight(std::size_t knot, double& reach) const {
    if (lamp().area() || lamp().luminaire || !lamp().point().decay || !m_even) return std::nullopt;
    double share = 0;
    for (const Part& part : m_parts) {
        if (part.nearest != knot) continue;
        if (part.octave.extinction != m_knots[knot].extinction) return std::nullopt;
        share += part.octave.share;
    }
    reach = std::max(m_near, lamp().point().radius);
    return lamp().intensity * share / (4 * std::numbers::pi);
}

double LampField::decay(double r2) const {
    // At its very place a lamp shines through nothing: 0 times infinity.
    r2 = std::max(r2, 1e-12 * grid().edge() * grid().edge());
    if (lamp().area()) return 1 / r2;
    return lamp().point().decay ? 1 / std::max(r2, std::pow(lamp().point().radius, 2)) : 1;
}

// Turns the mean extinctions on the way from the lamp, of a part's two knots, into the part's light times r^2.
void LampField::lightOf(const Part& part, const Arrival& arrival, double profile, Real (&rgb)[3]) const {
    const double sent = part.octave.share * (profile * scattered(part, arrival)) * arrival.open;
    const auto length = static_cast<Real>(arrival.length);
    Real arrives = 1;
    for (std::size_t c = 0; c < 3; ++c) {
        if (c < colours()) arrives = std::exp(-rgb[c] * length);
        rgb[c] = static_cast<Real>(lamp().intensity[static_cast<int>(c)] * sent) * arrives;
    }
}

// Within it a point's light is constant. A sample at the very place of a lamp must not be infinite.
double LampField::leastRadius() const {
    return lamp().area() ? 0 : std::max(lamp().point().radius, 1e-2 * grid().edge());
}

// The mean of 1 / max(r^2, radius^2) over a path from z = d - t/2 to d + t/2, with r^2 = b^2 + z^2 and b the distance
// of the eye's ray from the lamp. The integral of 1 / (b^2 + z^2) is atan(z / b) / b. The value in the middle of the
// sheet alone is wrong by any amount in sheets close to the lamp, where much of its light is.
double LampField::meanDecay(const Vec3& way, const Vec3& path) const {
    const double t2 = glm::dot(path, path), r2 = glm::dot(way, way);
    const double radius = leastRadius(), least = 1e-2 * grid().edge();
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

void LampField::sampleAll(const Vec3& ws, CellField::LastBlock& last, Means& means) const {
    for (std::size_t k = 0; k < m_knots.size(); ++k) m_knots[k].values.sample(ws, last, means[k]);
}

void LampField::meanOf(const Part& part, const Means& means, Real (&mean)[3]) {
    for (int c = 0; c < 3; ++c) mean[c] = static_cast<Real>(part.low) * means[part.knot][c];
    for (int c = 0; c < 3 && part.high > 0; ++c) mean[c] += static_cast<Real>(part.high) * means[part.knot + 1][c];
}

void LampField::addTo(const Vec3& ws, Real (&rgb)[3]) const {
    const Vec3 way = ws - lamp().wsPosition;
    const double r = glm::length(way), profile = r > 0 ? luminairePart(lamp(), m_frame, way / r) : 0;
    CellField::LastBlock last;
    Means means;
    sampleAll(ws, last, means);
    const Arrival arrival = arrivalAt(ws);
    for (const Part& part : m_parts) {
        Real own[3];
        meanOf(part, means, own);
        lightOf(part, arrival, profile, own);
        for (int c = 0; c < 3; ++c) rgb[c] += own[c] * static_cast<Real>(nearShare(r) * decay(r * r));
    }
}

bool LampField::reaches(const Bounds& ws) const {
    return m_near == 0 || ws.distance(lamp().wsPosition) < m_near;
}

// Adds the light at a sample close to the lamp, by points of its path. What is nearer to the eye shows more.
void LampField::addNear(const SamplePlane& plane, const SheetPath& path, double extinction, CellField::LastBlock& last,
                        Real (&rgb)[3]) const {
    constexpr double kMostTau = 30;  // over a path: a clamp for what no light passes
    const Vec3& center = lamp().wsPosition;
    const double tau = plane.towardsEye * std::min(extinction * glm::length(path.ws), kMostTau);
    const double even = std::abs(tau) > 1e-4 ? 0.5 * tau / std::sinh(0.5 * tau) : 1;
    const bool sphere = radiusOfSphere(lamp()) > 0;
    const PathPastLamp points(path.wsMiddle - center, path.ws, sphere ? radiusOfSphere(lamp()) : leastRadius(), sphere,
                              m_lobe);
    points.forPoints([&](double place, double weight) {
        const Vec3 ws = path.wsMiddle + place * path.ws, way = ws - center;
        const double r = glm::length(way), seen = even * std::exp(tau * place);
        const double profile = luminairePart(lamp(), m_frame, way / std::max(r, 1e-300));
        const auto factor = static_cast<Real>(weight * seen * nearShare(r));
        const Arrival arrival = arrivalAt(ws);
        Means means;
        sampleAll(ws, last, means);
        for (const Part& part : m_parts) {
            Real found[3];
            meanOf(part, means, found);
            lightOf(part, arrival, profile, found);
            for (int c = 0; c < 3; ++c) rgb[c] += factor * found[c];
        }
    });
}

void LampField::addTo(const SamplePlane& plane, const SampleTile& samples, const Real* extinction,
                      Real* const rgb[3]) const {
    const bool decays = radiusOfSphere(lamp()) > 0 || lamp().point().decay;
    CellField::LastBlock last;
    for (int k = 0; k < kTileSize; ++k) {
        if (extinction[k] == 0) continue;
        const Vec3 way = plane.wsSample(samples, k) - lamp().wsPosition;
        const Real share = m_near > 0 ? static_cast<Real>(nearShare(glm::length(way))) : Real(1);
        if (share == 0) continue;
        const SheetPath path(plane, samples, k, extinction[k]);
        if (decays && PathPastLamp::isNear(way, path.ws, radiusOfSphere(lamp()), lamp().luminaire.has_value())) {
            Real found[3] = {0, 0, 0};
            addNear(plane, path, double(extinction[k]), last, found);
            for (int c = 0; c < 3; ++c) rgb[c][k] += found[c];
            continue;
        }
        const double profile = luminairePart(lamp(), m_frame, way / std::max(glm::length(way), 1e-300));
        const Real factor = share * static_cast<Real>(decays ? meanDecay(way, path.ws) : 1);
        Means means, farther;
        sampleAll(path.wsNear + path.wsSeen, last, means);
        const Arrival arrival = arrivalAt(path.wsNear);
        Arrival behindIt = arrival;
        if (path.thick) {
            sampleAll(path.wsFar + path.wsSeen, last, farther);
            behindIt = arrivalAt(path.wsFar);
        }
        for (const Part& part : m_parts) {
            Real found[3];
            meanOf(part, means, found);
            lightOf(part, arrival, profile, found);
            if (path.thick) {
                Real behind[3];
                meanOf(part, farther, behind);
                lightOf(part, behindIt, profile, behind);
                for (int c = 0; c < 3; ++c) found[c] += path.farther * (behind[c] - found[c]);
            }
            for (int c = 0; c < 3; ++c) rgb[c][k] += factor * found[c];
        }
    }
}

std::size_t LampField::bytes() const {
    std::size_t bytes = 0;
    for (const Knot& knot : m_knots) bytes += knot.values.bytes();
    return bytes;
}

void sharpenMeans(CellField& field, const std::function<double(const Int3& cell)>& wayTo) {
    constexpr double kPerBend = 1.0 / 6;
    constexpr std::array<std::size_t, 3> kStep{1, kPaddedEdge, std::size_t(kPaddedEdge) * kPaddedEdge};
    const CellGrid& grid = field.grid();
    const std::size_t colours = field.colours();
    const double least = kLeastWay * grid.edge();
    const auto placeIn = [&](std::size_t block, int i) {
        return grid.storedBlocks()[block] * kCellEdge - 1 + paddedCell(i);
    };
    parallelFor(grid.storedBlocks().size(), [&](std::size_t b) {
        std::array<double, kPaddedCells> way, mean;
        for (std::size_t i = 0; i < kPaddedCells; ++i) way[i] = wayTo(placeIn(b, static_cast<int>(i)));
        const auto known = [&](std::size_t i) { return way[i] > least && way[i] * mean[i] < kDarkDepth; };
        for (std::size_t c = 0; c < colours; ++c) {
            Real* values = field.block(b) + c;
            for (std::size_t i = 0; i < kPaddedCells; ++i) mean[i] = double(values[i * colours]);
            for (int n = 0; n < kBlockCells; ++n) {
                const auto i = std::size_t(
                    paddedOffset(n % kCellEdge + 1, n / kCellEdge % kCellEdge + 1, n / (kCellEdge * kCellEdge) + 1));
                if (!known(i)) continue;
                double bend = 0, low = mean[i], high = mean[i];
                for (const std::size_t step : kStep) {
                    const double before = mean[i - step], after = mean[i + step];
                    if (!known(i - step) || !known(i + step)) continue;
                    bend += before + after - 2 * mean[i];
                    low = std::min({low, before, after});
                    high = std::max({high, before, after});
                }
                values[i * colours] = static_cast<Real>(std::clamp(mean[i] - kPerBend * bend, low, high));
            }
        }
    });
    field.fillAround();
}

}  // namespace scrim
