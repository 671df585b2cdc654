// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/surface.h>

#include <scrim/engine/splat/plane_stack.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

// How far the field of the splats may be from the volume's own, as a part of the range of values around it.
constexpr Real kVague = Real(0.25);
// A kink of the field matters where the transfer function begins within this part of the range of values beside it.
constexpr Real kAtOnce = Real(0.5);

using Range = std::pair<Real, Real>;

Range both(const Range& a, const Range& b) {
    return {std::min(a.first, b.first), std::max(a.second, b.second)};
}

// The least and greatest value of a tile and its neighbouring texels.
Range rangeAround(const FloatPlane& plane, int tx, int ty) {
    const int x0 = std::max(0, tx * kTileEdge - 1), x1 = std::min(plane.width, (tx + 1) * kTileEdge + 1);
    const int y0 = std::max(0, ty * kTileEdge - 1), y1 = std::min(plane.height, (ty + 1) * kTileEdge + 1);
    return rangeOf(plane.data + static_cast<std::ptrdiff_t>(y0) * plane.width + x0, x1 - x0, y1 - y0, plane.width,
                   plane.simd);
}

// Where a ray crosses the plane `away` sheets from the samples' own. The result is the same from
// whichever sheet the question comes, since planes and faces are looked up once for two sheets.
Vec2 crossing(const SampleTile& at, std::size_t k, double away, double texelsPerSlope) {
    if (at.rays == nullptr)
        return {at.u[k] + away * texelsPerSlope * double(at.eyeA[k]),
                at.v[k] + away * texelsPerSlope * double(at.eyeB[k])};
    const double step = double(at.step) + away;
    return {at.rays->u[k] + step * double(at.rays->stepU[k]), at.rays->v[k] + step * double(at.rays->stepV[k])};
}

SampleTile raysOf(const LightView& view, const Int2& cell, int sheet) {
    const LightView::Cells map = view.at(sheet);
    SampleTile rays{};
    for (int k = 0; k < kTileSize; ++k) {
        const Vec2 place(cell.x + k % kTileEdge, cell.y + k / kTileEdge);
        const Vec2 slope = view.slopeAt(place.x, place.y);
        rays.u[k] = static_cast<Real>(map.offsetU + place.x * map.scale);
        rays.v[k] = static_cast<Real>(map.offsetV + place.y * map.scale);
        rays.eyeA[k] = static_cast<Real>(slope.x);
        rays.eyeB[k] = static_cast<Real>(slope.y);
    }
    return rays;
}

// Values above a million times the last value of the transfer function are clamped to that, because
// sums of floats must not overflow.
Real mostValue(const Classified& look) {
    return static_cast<Real>(std::min<double>(1e6 * look.transfer.back().value, std::numeric_limits<float>::max()));
}

// Settings for splatting a surface's field. It uses twice the steps of the dial, because ripples show most in normals.
FieldPlanes::Settings settingsOf(const ViewVolume& volume, const Dials& dials) {
    constexpr int kMostSteps = 128;
    FieldPlanes::Settings settings;
    settings.most = mostValue(*volume.classified);
    settings.stepsPerVoxel = std::min(2 * dials.footprintSteps, kMostSteps);
    settings.before = Surface::kBefore;
    settings.behind = Surface::kBehind;
    return settings;
}

}  // namespace

Surface::Surface(const ViewVolume& volume, const Dials& dials, const Sheets& sheets, const Lattice& lattice,
                 int batchSheets, double voxel)
    : m_sheets(sheets),
      m_simd(dials.simd),
      m_look(volume.classified),
      m_table(*volume.classified),
      m_vagueGradient(vagueGradient(*volume.classified, voxel)),
      m_voxel(voxel),
      m_clip(volume.wsClip),
      m_exact(*volume.field, volume.kernel.value_or(dials.kernel)),
      m_most(mostValue(*volume.classified)),
      m_edge(m_table.edge(0, m_most)),
      m_rim(static_cast<Real>(std::max(2.0, 2 * sheets.texel / sheets.thickness))),
      // A gradient is a covector, so differences are multiplied by the inverse transpose.
      m_ssFromDifference(sheets.ssFromWs * (0.5 * glm::transpose(glm::inverse(Mat3(volume.wsFromIs))))),
      m_field({{densityOf(volume)}}, settingsOf(volume, dials), dials, sheets, lattice, batchSheets),
      m_extinction(batchSheets, lattice.width, lattice.height, 1) {
    const Mat4 tsFromRs = glm::inverse(lattice.rsFromTs);
    for (const HalfSpace& face : m_clip)
        m_faces.push_back(face.row() * glm::inverse(sheets.tsFrom(Mat4(1.0))) * tsFromRs);
    m_one = glm::dvec4(0, 0, 0, 1) * tsFromRs;
    m_isFromRs = glm::inverse(sheets.tsFrom(volume.wsFromIs)) * tsFromRs;
}

// Some of the samples of a tile, close together, with the field's slopes there.
struct Surface::Some {
    SampleTile at;
    std::array<int, kTileSize> places;
    int count = 0;
    alignas(64) Real slope[3][kTileSize];  // down the gradient, in sweep space, in units of the vague gradient

    // Those that have `extinction`.
    Some(const SampleTile& all, const Real* extinction) {
        for (int k = 0; k < kTileSize; ++k) {
            if (extinction[k] == 0) continue;
            at.u[count] = all.u[k];
            at.v[count] = all.v[k];
            places[std::size_t(count++)] = k;
        }
    }
    Real squared(int i) const {
        return slope[0][i] * slope[0][i] + slope[1][i] * slope[1][i] + slope[2][i] * slope[2][i];
    }
};

FloatPlane Surface::plane(int p, int steps) const {
    return m_field.planes().view(m_field.planeOf(m_firstSheet + p + steps), m_simd);
}

void Surface::classifyTexels(int p, bool wanted) {
    const std::array<FloatPlane, 3> around{plane(p, -1), plane(p, 0), plane(p, 1)};
    const int sheet = m_firstSheet + p;
    const PlaneStack& values = m_field.planes();
    PlaneStack& out = m_extinction;
    alignas(64) Real front[kTileSize], middle[kTileSize], back[kTileSize], share[kTileSize], sigma[kTileSize];
    const auto anyActive = [&](int tx, int ty) {
        for (int steps = -1; steps <= 1; ++steps)
            if (values.anyActive(m_field.planeOf(sheet + steps), {tx - 1, ty - 1, tx + 2, ty + 2})) return true;
        return false;
    };
    out.begin(p);
    for (int ty = 0; ty < out.tilesY(); ++ty)
        for (int tx = 0; tx < out.tilesX(); ++tx) {
            // A tile is active if its texels, or anything between them and their neighbours, may
            // show something, because pixels look there, too.
            if (!anyActive(tx, ty)) continue;
            if (!showsAround(around, tx, ty)) continue;
            if (!wanted) {
                out.activate(p, tx, ty);
                continue;
            }
            out.replace(p, tx, ty);
            const std::ptrdiff_t corner = static_cast<std::ptrdiff_t>(ty * kTileEdge) * out.width() + tx * kTileEdge;
            SampleTile texels{};
            for (int k = 0; k < kTileSize; ++k) {
                const std::ptrdiff_t at =
                    corner + static_cast<std::ptrdiff_t>(k / kTileEdge) * out.width() + k % kTileEdge;
                front[k] = around[0].data[at];
                middle[k] = around[1].data[at];
                back[k] = around[2].data[at];
                texels.u[k] = static_cast<Real>(tx * kTileEdge + k % kTileEdge);
                texels.v[k] = static_cast<Real>(ty * kTileEdge + k / kTileEdge);
            }
            runThroughSheet(front, middle, back, m_simd, front, middle, back);
            cut(p, texels, front, middle, back, share);
            m_table.meanExtinction(front, middle, back, kTileSize, sigma, m_simd);
            weigh(p, texels, share, sigma);
            Real* to = out.tile(p, tx, ty);
            for (int y = 0; y < kTileEdge; ++y, to += out.rowStride())
                std::copy_n(sigma + y * kTileEdge, kTileEdge, to);
        }
    out.finish(p);
}

// Shortens the rays' course through the sheet to what lies within the clip; `share` becomes the part that is left.
void Surface::cut(int p, const SampleTile& at, Real* front, Real* middle, Real* back, Real* share) const {
    if (m_faces.empty()) return;
    const double n = m_firstSheet + p, toFace = 0.5 * m_sheets.thickness / m_sheets.texel;
    for (int k = 0; k < kTileSize; ++k) {
        const double du = toFace * double(at.eyeA[k]), dv = toFace * double(at.eyeB[k]);
        double begin = 0, end = 1;
        for (std::size_t f = 0; f < m_faces.size(); ++f) {
            const double first = depthIn(f, at.u[k] - du, at.v[k] - dv, n),
                         last = depthIn(f, at.u[k] + du, at.v[k] + dv, n + 1);
            if (first < 0) begin = last > 0 ? std::max(begin, first / (first - last)) : 1;
            if (last < 0) end = first > 0 ? std::min(end, first / (first - last)) : 0;
        }
        share[k] = static_cast<Real>(std::max(end - begin, 0.0));
        const Real a = front[k], b = middle[k], c = back[k];
        const auto run = [&](double t) {
            return static_cast<Real>(t < 0.5 ? a + 2 * t * (b - a) : b + (2 * t - 1) * (c - b));
        };
        const bool any = end > begin;  // a value of 0 has no extinction
        front[k] = any ? run(begin) : Real(0);
        middle[k] = any ? run(0.5 * (begin + end)) : Real(0);
        back[k] = any ? run(end) : Real(0);
    }
}

// The voxels that look-ups within `is` need, for this thread until the next call; null: m_exact must be asked.
const FieldBrick* Surface::voxelsIn(const Bounds& is) const {
    thread_local FieldBrick brick;
    return brick.fill(m_exact, is) ? &brick : nullptr;
}

// Replaces the field of the splats by that of the volume itself, at the samples for which shows(least, most) is true of
// the values that their rays meet: between texels the field has the edges of voxels, which a surface shows as dents.
template <class Shows>
void Surface::sharpen(int p, const SampleTile& at, const std::uint8_t* open, ClassifiedTile& out,
                      const Shows& shows) const {
    const double n = m_firstSheet + p, texelsPerSlope = m_sheets.thickness / m_sheets.texel;
    std::array<int, kTileSize> places;
    std::array<std::array<Vec3, 3>, kTileSize> runs;
    std::size_t count = 0;
    Bounds box;
    const bool onward = out.exactSheet == m_firstSheet + p - 1;
    for (int k = 0; k < out.count; ++k) {
        if (open && !open[k]) continue;
        const auto [least, most] = std::minmax({out.front[k], out.middle[k], out.back[k]});
        if (!shows(least, most)) continue;
        for (std::size_t i = 0; i < 3; ++i) {
            const double away = 0.5 * double(i) - 0.5;
            const Vec2 place = crossing(at, std::size_t(k), away, texelsPerSlope);
            box.include(runs[count][i] = indexPoint(place.x, place.y, n + 0.5 + away));
        }
        places[count++] = k;
    }
    const FieldBrick* const brick = count > 0 ? voxelsIn(box) : nullptr;
    const auto exact = [&](const Vec3& is) {
        return std::min(static_cast<Real>(brick ? brick->value(is) : m_exact.value(is)), m_most);
    };
    out.exactSheet = m_firstSheet + p;
    std::array<Real, kTileSize> ends;
    for (std::size_t i = 0; i < count; ++i) {
        const int k = places[i];
        const Real front = onward && !std::isnan(out.leaves[k]) ? out.leaves[k] : exact(runs[i][0]),
                   middle = exact(runs[i][1]), back = ends[i] = exact(runs[i][2]);
        const auto before = withEdge(runs[i][0], runs[i][1], front, middle, exact);
        const auto behind = withEdge(runs[i][1], runs[i][2], middle, back, exact);
        out.front[k] = before.first;
        out.back[k] = behind.second;
        // A middle that one half moves must show nothing to the other.
        out.middle[k] = middle;
        if (before.second != middle && clearBetween(middle, back)) out.middle[k] = before.second;
        if (behind.first != middle && clearBetween(front, middle)) out.middle[k] = behind.first;
    }
    std::fill(out.leaves, out.leaves + kTileSize, std::numeric_limits<Real>::quiet_NaN());
    for (std::size_t i = 0; i < count; ++i) out.leaves[places[i]] = ends[i];
}

bool Surface::clearBetween(Real a, Real b) const {
    return m_table.clear(std::min(a, b), std::max(a, b));
}

// The values `a` and `b` of the field at the ends of a part of a ray's course, of which one is clear and one is not, so
// that a line between them crosses the edge of the clear values where the field does: the clear one is moved. Where the
// first trace of a value is opaque, a line would cross at its clear end, wherever the field has its kink.
template <class Exact>
std::pair<Real, Real> Surface::withEdge(const Vec3& from, const Vec3& to, Real a, Real b, const Exact& exact) const {
    constexpr int kParts = 16;
    constexpr Real kMost = Real(0.98);  // the moved value stays finite
    const bool clearFirst = m_table.clear(a);
    if (clearFirst == m_table.clear(b)) return {a, b};
    Real& end = clearFirst ? a : b;
    const Real opaque = clearFirst ? b : a, edge = m_table.edge(end, opaque);
    if (std::abs(edge - end) > kAtOnce * std::abs(opaque - end)) return {a, b};
    const Vec3& origin = clearFirst ? from : to;
    const Vec3 way = (clearFirst ? to : from) - origin;
    const bool up = end < opaque;
    int before = 0;  // parts on whose ends the field has not come to the edge
    Real near = end, far = opaque;
    for (int step = kParts / 2; step > 0; step /= 2) {
        const Real value = exact(origin + way * (double(before + step) / kParts));
        const bool isBefore = up ? value <= edge : value >= edge;
        before += isBefore ? step : 0;
        (isBefore ? near : far) = value;
    }
    const Real part = std::min((static_cast<Real>(before) + (edge - near) / (far - near)) / kParts, kMost);
    end = (edge - part * opaque) / (1 - part);
    return {a, b};
}

// The splatted field along the rays' course through the sheet. read(plane, away, to) reads a plane
// that is `away` sheets from the sheet's own where the rays cross it.
template <class Read>
void Surface::sampleRun(int p, ClassifiedTile& out, const Read& read) const {
    const int sheet = m_firstSheet + p;
    const auto on = [&](int away) { return out.planes[((sheet + away) % 3 + 3) % 3]; };
    const bool onward = out.sheet == sheet - 1;
    for (const int away : {-1, 0, 1})
        if (away == 1 || !onward) read(plane(p, away), away, on(away));
    out.sheet = sheet;
    runThroughSheet(on(-1), on(0), on(1), m_simd, out.front, out.middle, out.back);
}

void Surface::sampleAlong(int p, const SampleTile& at, ClassifiedTile& out) const {
    const double texelsPerSlope = m_sheets.thickness / m_sheets.texel;
    sampleRun(p, out, [&](const FloatPlane& from, int away, Real* to) {
        alignas(64) Real u[kTileSize], v[kTileSize];
        for (int k = 0; k < out.count; ++k) {
            const Vec2 place = crossing(at, std::size_t(k), away, texelsPerSlope);
            u[k] = static_cast<Real>(place.x);
            v[k] = static_cast<Real>(place.y);
        }
        samplePoints(from, u, v, false, out.count, to);
    });
}

// True if any texel of a tile, or a neighbour of one, has extinction on any of the planes, or between them.
bool Surface::showsAround(const std::array<FloatPlane, 3>& planes, int tx, int ty) const {
    const auto shows = [&](const Range& range) { return m_table.anyBetween(range.first, range.second); };
    Range range = rangeAround(planes[1], tx, ty);
    if (!shows(range)) range = both(range, rangeAround(planes[0], tx, ty));
    if (!shows(range)) range = both(range, rangeAround(planes[2], tx, ty));
    return shows(range);
}

// The least and greatest value that the rays of a tile meet.
std::pair<Real, Real> Surface::rangeAlong(const ClassifiedTile& run) const {
    const auto of = [&](const Real* values) { return rangeOf(values, run.count, 1, run.count, m_simd); };
    return both(of(run.front), both(of(run.middle), of(run.back)));
}

// True if any value of the rays' courses has extinction, or is nearer to one that has than
// `margin`, as a part of their range.
bool Surface::anyShows(const ClassifiedTile& run, Real margin) const {
    const auto [low, high] = rangeAlong(run);
    margin *= high - low;
    return m_table.anyBetween(low - margin, high + margin);
}

// True if the splats, which run from `least` to `most` within a sheet, may reach beyond the border of the field, and
// show there what the field does not: they are smoother than that. Where the first trace of a value is opaque, a
// surface would grow by half a texel and half a sheet, and its lit side would lie in its own shadow. (A box in which
// values jump by 1,000, opaque from 1 on, was 21 % too dark.)
bool Surface::isRim(Real least, Real most) const {
    const Real range = most - least;
    return most > m_edge && m_edge < kAtOnce * range && least < m_rim * range;
}

bool Surface::meanExtinction(int p, const SampleTile& at, ClassifiedTile& out) const {
    sampleAlong(p, at, out);
    return meanOfRun(
        p, nullptr, [&]() -> const SampleTile& { return at; }, out);
}

bool Surface::meanExtinction(int p, const LightView& view, const Int2& cell, const std::uint8_t* open,
                             ClassifiedTile& out) const {
    const int sheet = m_firstSheet + p;
    sampleRun(p, out, [&](const FloatPlane& from, int away, Real* to) {
        const LightView::Cells map = view.at(sheet + away);
        sampleLattice(from, static_cast<Real>(map.offsetU + cell.x * map.scale),
                      static_cast<Real>(map.offsetV + cell.y * map.scale), static_cast<Real>(map.scale), false, to);
    });
    return meanOfRun(
        p, open, [&] { return raysOf(view, cell, sheet); }, out);
}

// `rays`: asked for the samples only where something depends on places.
template <class Rays>
bool Surface::meanOfRun(int p, const std::uint8_t* open, const Rays& rays, ClassifiedTile& out) const {
    std::fill(out.extinction, out.extinction + kTileSize, Real(0));
    const auto [low, high] = rangeAlong(out);
    if (!m_table.anyBetween(low, high)) return false;
    const bool rim = isRim(low, high);
    if (!rim && m_faces.empty() && m_look->gradientRamp.empty()) {
        m_table.meanExtinction(out.front, out.middle, out.back, out.count, out.extinction, m_simd);
        return true;
    }
    const SampleTile& at = rays();
    alignas(64) Real share[kTileSize];
    if (rim) sharpen(p, at, open, out, [&](Real least, Real most) { return isRim(least, most); });
    cut(p, at, out.front, out.middle, out.back, share);
    m_table.meanExtinction(out.front, out.middle, out.back, out.count, out.extinction, m_simd);
    weigh(p, at, share, out.extinction);
    return true;
}

bool Surface::classify(int p, const SampleTile& at, const std::uint8_t* open, ClassifiedTile& out) const {
    alignas(64) Real share[kTileSize];
    std::fill(out.extinction, out.extinction + kTileSize, Real(0));
    sampleAlong(p, at, out);
    if (!anyShows(out, kVague)) return false;
    const auto [low, high] = std::minmax_element(out.middle, out.middle + kTileSize);
    const Real margin = kVague * (*high - *low);
    sharpen(p, at, open, out, [&](Real least, Real most) { return m_table.anyBetween(least - margin, most + margin); });
    cut(p, at, out.front, out.middle, out.back, share);
    if (!anyShows(out, 0)) return false;
    for (int k = 0; open && k < kTileSize; ++k)  // a value of 0 has no extinction
        if (!open[k]) out.front[k] = out.middle[k] = out.back[k] = 0;
    m_table.meanExtinction(out.front, out.middle, out.back, kTileSize, out.extinction, m_simd);
    if (std::none_of(out.extinction, out.extinction + kTileSize, [](Real sigma) { return sigma > 0; })) return false;
    if (out.halves) {
        alignas(64) Real quarter[kTileSize];
        for (int k = 0; k < kTileSize; ++k) quarter[k] = Real(0.5) * (out.front[k] + out.middle[k]);
        m_table.meanExtinction(out.front, quarter, out.middle, kTileSize, out.firstHalf, m_simd);
    }
    for (int c = 0; c < 3; ++c)
        m_table.meanEmission(c, out.front, out.middle, out.back, kTileSize, out.emission[c], m_simd);
    for (int k = 0; k < kTileSize && !m_faces.empty(); ++k) {
        out.extinction[k] *= share[k];
        if (out.halves) out.firstHalf[k] *= share[k];
        for (Real* channel : out.emission) channel[k] *= share[k];
    }
    findNormals(p, at, out);
    return true;
}

void Surface::findSlopes(int p, Some& some) const {
    std::array<Vec3, kTileSize> points;
    Bounds box;
    for (int i = 0; i < some.count; ++i) {
        const Vec3 is = indexPoint(double(some.at.u[i]), double(some.at.v[i]), m_firstSheet + p + 0.5);
        points[std::size_t(i)] = is;
        box.include(is - 1.0);
        box.include(is + 1.0);
    }
    if (some.count == 0) return;
    const FieldBrick* const brick = voxelsIn(box);
    const double most = m_most;
    for (int i = 0; i < some.count; ++i) {
        const Vec3& is = points[std::size_t(i)];
        const Vec3 difference = brick ? brick->difference(is) : m_exact.difference(is);
        // Gradients are in units of the vague gradient, so that their squares neither overflow nor
        // vanish, whatever the units of the field.
        const Vec3 slope = m_ssFromDifference * glm::clamp(difference, -most, most) / -m_vagueGradient;
        for (int c = 0; c < 3; ++c) some.slope[c][i] = static_cast<Real>(slope[c]);
    }
}

// Multiplies extinction by the share that the clip leaves, and by the factor for the gradient's length.
void Surface::weigh(int p, const SampleTile& at, const Real* share, Real* extinction) const {
    for (int k = 0; k < kTileSize && !m_faces.empty(); ++k) extinction[k] *= share[k];
    if (m_look->gradientRamp.empty()) return;
    Some some(at, extinction);
    findSlopes(p, some);
    for (int i = 0; i < some.count; ++i)
        extinction[some.places[std::size_t(i)]] *=
            static_cast<Real>(gradientFactor(*m_look, m_vagueGradient * std::sqrt(double(some.squared(i)))));
}

void Surface::findNormals(int p, const SampleTile& at, ClassifiedTile& out) const {
    // Few of a tile's rays meet something in one sheet. Only theirs are looked up.
    Some some(at, out.extinction);
    findSlopes(p, some);
    for (Real* axis : out.normal) std::fill(axis, axis + kTileSize, Real(0));
    std::fill(out.weight, out.weight + kTileSize, Real(0));
    const double toCut = cutGradient(*m_look, m_voxel) / m_vagueGradient;
    for (int i = 0; i < some.count; ++i) {
        const int k = some.places[std::size_t(i)];
        if (!m_look->gradientRamp.empty()) {
            const auto factor =
                static_cast<Real>(gradientFactor(*m_look, m_vagueGradient * std::sqrt(double(some.squared(i)))));
            out.extinction[k] *= factor;
            if (out.halves) out.firstHalf[k] *= factor;
            for (Real* channel : out.emission) channel[k] *= factor;
        }
        for (std::size_t f = 0; f < m_faces.size(); ++f) {  // see `facing` of half_space.h
            const double depth = depthIn(f, some.at.u[i], some.at.v[i], m_firstSheet + p + 0.5);
            const Vec3 add = toCut * std::clamp(1 - depth / m_voxel, 0.0, 1.0) * (m_sheets.ssFromWs * m_clip[f].normal);
            for (int c = 0; c < 3; ++c) some.slope[c][i] -= static_cast<Real>(add[c]);
        }
        const Real g2 = some.squared(i);
        out.weight[k] = g2 / (g2 + 1);
        const Real inverse = 1 / std::sqrt(std::max(g2, Real(1e-30)));  // a gradient of 0 has no weight
        // The normal points out of the denser side, down the gradient.
        for (int c = 0; c < 3; ++c) out.normal[c][k] = some.slope[c][i] * inverse;
    }
}

std::size_t Surface::bytes(const ViewVolume& volume, const Dials& dials, const Sheets& sheets, const Lattice& lattice,
                           int batchSheets) {
    return FieldPlanes::bytes({densityOf(volume)}, settingsOf(volume, dials), dials, sheets, lattice, batchSheets) +
           PlaneStack::bytes(batchSheets, lattice.width, lattice.height, 1);
}

}  // namespace scrim
