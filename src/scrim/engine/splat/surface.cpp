// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/surface.h>

#include <scrim/engine/splat/plane_stack.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <glm/matrix.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scrim/engine/splat/surface.cpp"
#include <hwy/foreach_target.h>
#include <scrim/engine/simd-inl.h>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

struct Lookup {
    const Real* table;
    int cells;
    Real beyond;  // slope beyond the last place

    // Linear between places; beyond the last one it continues with slope `beyond`.
    HWY_ATTR HWY_INLINE VF at(VF x) const {
        const DF d;
        const auto last = hn::Set(d, static_cast<Real>(cells));
        const auto inside = hn::Min(hn::Max(x, hn::Zero(d)), last);
        const auto floor = hn::Min(hn::Floor(inside), hn::Set(d, static_cast<Real>(cells - 1)));
        const auto index = hn::ConvertTo(DI(), floor);
        const auto lower = hn::GatherIndex(d, table, index), upper = hn::GatherIndex(d, table + 1, index);
        const auto value = hn::MulAdd(hn::Sub(inside, floor), hn::Sub(upper, lower), lower);
        return hn::MulAdd(hn::Max(hn::Sub(x, last), hn::Zero(d)), hn::Set(d, beyond), value);
    }
};

// The mean over [x, y], in cells. If that is shorter than a cell, the value at its middle is used, because the
// difference of two integrals would be rounding only.
HWY_ATTR HWY_INLINE VF meanBetween(const Lookup& value, VF x, VF y, VF integralX, VF integralY) {
    const DF d;
    const auto run = hn::Sub(y, x);
    const auto isShort = hn::Lt(hn::Abs(run), hn::Set(d, Real(1)));
    const auto safe = hn::IfThenElse(isShort, hn::Set(d, Real(1)), run);
    const auto quotient = hn::Div(hn::Sub(integralY, integralX), safe);
    if (hn::AllFalse(d, isShort)) return quotient;
    const auto middle = value.at(hn::Mul(hn::Set(d, Real(0.5)), hn::Add(x, y)));
    return hn::IfThenElse(isShort, middle, quotient);
}

HWY_ATTR void meanOnTarget(const Real* values, const Real* integrals, int cells, Real beyond, Real cellsPerValue,
                           const Real* a, const Real* b, const Real* c, int count, Real* out) {
    const DF d;
    // The tables of integrals are in units of cells, so that means are differences divided by differences of cells.
    const Lookup value{values, cells, 0}, integral{integrals, cells, beyond};
    const auto scale = hn::Set(d, cellsPerValue);
    for (int k = 0; k < count; k += static_cast<int>(hn::Lanes(d))) {
        const auto x = hn::Mul(hn::Load(d, a + k), scale), y = hn::Mul(hn::Load(d, b + k), scale),
                   z = hn::Mul(hn::Load(d, c + k), scale);
        const auto ix = integral.at(x), iy = integral.at(y), iz = integral.at(z);
        const auto sum = hn::Add(meanBetween(value, x, y, ix, iy), meanBetween(value, y, z, iy, iz));
        hn::Store(hn::Max(hn::Mul(hn::Set(d, Real(0.5)), sum), hn::Zero(d)), d, out + k);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scrim {

HWY_EXPORT(meanOnTarget);

namespace {

constexpr int kCells = 2048;  // over the range of values

}  // namespace

struct TransferTable::Function {
    std::vector<Real> value, integral;  // at kCells + 1 places
    Real beyond = 0;                    // value beyond the last place
};

TransferTable::~TransferTable() = default;

TransferTable::TransferTable(const Classified& classified) {
    const std::vector<TransferPoint>& points = classified.transfer;
    m_cell = std::max(points.back().value, std::numeric_limits<float>::min() * 1e6) / kCells;
    for (int f = 0; f < 4; ++f) {
        Function& function = m_functions.emplace_back();
        const auto at = [&](double value) {
            const ClassifiedValue c = classify(classified, value);
            return c.extinction * (f == 0 ? 1.0 : c.color[f - 1]);
        };
        // Between two neighbouring places or points, extinction times colour is a quadratic, for which Simpson's rule
        // is exact.
        double integral = 0;
        for (int i = 0; i <= kCells; ++i) {
            const double place = i * m_cell;
            function.value.push_back(static_cast<Real>(at(place)));
            function.integral.push_back(static_cast<Real>(integral));
            std::vector<double> cuts{place};
            for (const TransferPoint& p : points)
                if (p.value > place && p.value < place + m_cell) cuts.push_back(p.value);
            cuts.push_back(place + m_cell);
            for (std::size_t c = 1; c < cuts.size(); ++c) {
                const double width = cuts[c] - cuts[c - 1], inset = 1e-9 * width;
                if (width <= 0) continue;
                const double sum = at(cuts[c - 1] + inset) + 4 * at(cuts[c - 1] + 0.5 * width) + at(cuts[c] - inset);
                integral += sum / 6 * width / m_cell;
            }
        }
        function.beyond = static_cast<Real>(at(points.back().value + 1));
    }
    const double infinity = std::numeric_limits<double>::infinity();
    if (points.front().extinction > 0) m_opaque.emplace_back(-infinity, points.front().value);
    for (std::size_t i = 1; i < points.size(); ++i)
        if (points[i - 1].extinction > 0 || points[i].extinction > 0)
            m_opaque.emplace_back(points[i - 1].value, points[i].value);
    if (points.back().extinction > 0) m_opaque.emplace_back(points.back().value, infinity);
}

void TransferTable::mean(const Function& f, const Real* a, const Real* b, const Real* c, int count, Real* out,
                         Simd simd) const {
    SCRIM_ON_TARGET(simd, meanOnTarget)
    (f.value.data(), f.integral.data(), kCells, f.beyond, static_cast<Real>(1 / m_cell), a, b, c, count, out);
}

void TransferTable::meanExtinction(const Real* a, const Real* b, const Real* c, int count, Real* out, Simd simd) const {
    mean(m_functions[0], a, b, c, count, out, simd);
}

void TransferTable::meanEmission(int channel, const Real* a, const Real* b, const Real* c, int count, Real* out,
                                 Simd simd) const {
    mean(m_functions[1 + channel], a, b, c, count, out, simd);
}

bool TransferTable::anyBetween(Real low, Real high) const {
    return std::any_of(m_opaque.begin(), m_opaque.end(),
                       [&](const auto& range) { return high >= range.first && low <= range.second; });
}

namespace {

// The least and greatest value of a tile and its neighbouring texels, on some planes.
struct Limits {
    Real low, high;
};

Limits limitsAround(const std::array<FloatPlane, 3>& planes, int tx, int ty) {
    const int width = planes[0].width, height = planes[0].height;
    const int x0 = std::max(0, tx * kTileEdge - 1), x1 = std::min(width, (tx + 1) * kTileEdge + 1);
    const int y0 = std::max(0, ty * kTileEdge - 1), y1 = std::min(height, (ty + 1) * kTileEdge + 1);
    Limits limits{planes[0].data[y0 * width + x0], 0};
    for (const FloatPlane& plane : planes)
        for (int y = y0; y < y1; ++y) {
            const Real* row = plane.data + static_cast<std::ptrdiff_t>(y) * width;
            for (int x = x0; x < x1; ++x) {
                limits.low = std::min(limits.low, row[x]);
                limits.high = std::max(limits.high, row[x]);
            }
        }
    return limits;
}

// The field at both faces and in the middle of a sheet, from its values on the planes of sheets n - 1, n and n + 1.
//
// These values are means over sheets, and the field is taken to be linear between them. Both make it smoother: by a
// 24th of the second difference over a sheet, and by a twelfth on average between planes. An eighth of it is therefore
// subtracted (as PlaneStack::prefilter does within the sheet), which halves the error of sharp transfer functions.
void runThroughSheet(Real& before, Real& here, Real& behind) {
    const Real blur = Real(0.125) * (before - 2 * here + behind);
    const auto sharp = [blur](Real value) { return value > blur ? value - blur : Real(0); };
    const Real front = sharp(Real(0.5) * (before + here)), middle = sharp(here),
               back = sharp(Real(0.5) * (here + behind));
    before = front;
    here = middle;
    behind = back;
}

// The values of a plane at the first `count` samples, moved by (du, dv) cells.
void sampleMoved(const FloatPlane& plane, const SampleTile& at, int count, Real du, Real dv, Real* out) {
    alignas(64) Real u[kTileSize], v[kTileSize];
    for (int k = 0; k < count; ++k) {
        u[k] = at.u[k] + du;
        v[k] = at.v[k] + dv;
    }
    samplePoints(plane, u, v, false, count, out);
}

// The values of a plane where the eye's rays cross it; they move by `texels` per unit of slope.
void sampleAlongRays(const FloatPlane& plane, const SampleTile& at, Real texels, Real* out) {
    alignas(64) Real u[kTileSize], v[kTileSize];
    for (int k = 0; k < kTileSize; ++k) {
        u[k] = at.u[k] + texels * at.eyeA[k];
        v[k] = at.v[k] + texels * at.eyeB[k];
    }
    samplePoints(plane, u, v, false, kTileSize, out);
}

// Settings for splatting a surface's field. It uses twice the steps of the dial, because ripples show most in normals.
// Values above a million times the last value of the transfer function are clamped to that, because sums of floats must
// not overflow.
FieldPlanes::Settings settingsOf(const ViewVolume& volume, const Dials& dials, const Sheets& sheets) {
    constexpr int kMostSteps = 128;
    FieldPlanes::Settings settings;
    settings.most = static_cast<Real>(
        std::min<double>(1e6 * volume.classified->transfer.back().value, std::numeric_limits<float>::max()));
    settings.stepsPerVoxel = std::min(2 * dials.footprintSteps, kMostSteps);
    settings.halo = Surface::halo(volume, sheets);
    return settings;
}

}  // namespace

Surface::Surface(const ViewVolume& volume, const Dials& dials, const Sheets& sheets, const Lattice& lattice,
                 int batchSheets, double voxel)
    : m_sheets(sheets),
      m_lattice(lattice),
      m_wsFromIs(volume.wsFromIs),
      m_simd(dials.simd),
      m_table(*volume.classified),
      m_vagueGradient(vagueGradient(*volume.classified, voxel)),
      m_rsVoxels(voxelsIn(lattice.rsFromTs)),
      // A gradient is a covector, so differences are multiplied by the inverse transpose.
      m_ssFromDifference(sheets.ssFromWs * (0.5 * glm::transpose(glm::inverse(Mat3(volume.wsFromIs))))),
      m_field({{densityOf(volume)}}, settingsOf(volume, dials, sheets), dials, sheets, lattice, batchSheets),
      m_extinction(batchSheets, lattice.width, lattice.height, 1) {}

int Surface::halo(const ViewVolume& volume, const Sheets& sheets) {
    const Mat4 tsFromIs = sheets.tsFrom(volume.wsFromIs);
    int reach = 1;
    for (int axis = 0; axis < 3; ++axis)
        reach = std::max(reach, static_cast<int>(std::ceil(std::abs(tsFromIs[axis].z))));
    return reach;
}

FloatPlane Surface::plane(int p, int steps) const {
    return m_field.planes().view(m_field.planeOf(m_firstSheet + p + steps), m_simd);
}

void Surface::classifyTexels(int p, bool wanted) {
    const std::array<FloatPlane, 3> around{plane(p, -1), plane(p, 0), plane(p, 1)};
    const int sheet = m_firstSheet + p;
    const PlaneStack& values = m_field.planes();
    PlaneStack& out = m_extinction;
    alignas(64) Real front[kTileSize], middle[kTileSize], back[kTileSize], sigma[kTileSize];
    const auto anyActive = [&](int tx, int ty) {
        for (int steps = -1; steps <= 1; ++steps)
            if (values.anyActive(m_field.planeOf(sheet + steps), {tx - 1, ty - 1, tx + 2, ty + 2})) return true;
        return false;
    };
    out.begin(p);
    for (int ty = 0; ty < out.tilesY(); ++ty)
        for (int tx = 0; tx < out.tilesX(); ++tx) {
            // A tile is active if its texels, or anything between them and their neighbours, may show something,
            // because pixels look there, too.
            if (!anyActive(tx, ty)) continue;
            const Limits limits = limitsAround(around, tx, ty);
            if (!m_table.anyBetween(limits.low, limits.high)) continue;
            if (!wanted) {
                out.activate(p, tx, ty);
                continue;
            }
            out.replace(p, tx, ty);
            const std::ptrdiff_t corner = static_cast<std::ptrdiff_t>(ty * kTileEdge) * out.width() + tx * kTileEdge;
            for (int k = 0; k < kTileSize; ++k) {
                const std::ptrdiff_t at =
                    corner + static_cast<std::ptrdiff_t>(k / kTileEdge) * out.width() + k % kTileEdge;
                front[k] = around[0].data[at];
                middle[k] = around[1].data[at];
                back[k] = around[2].data[at];
                runThroughSheet(front[k], middle[k], back[k]);
            }
            m_table.meanExtinction(front, middle, back, kTileSize, sigma, m_simd);
            Real* to = out.tile(p, tx, ty);
            for (int y = 0; y < kTileEdge; ++y, to += out.rowStride())
                std::copy_n(sigma + y * kTileEdge, kTileEdge, to);
        }
    out.finish(p);
}

// The field along the rays' course through the sheet. Returns false if none of its values has extinction.
bool Surface::sampleRun(int p, const SampleTile& at, Real* front, Real* middle, Real* back) const {
    const auto texelsPerSlope = static_cast<Real>(m_sheets.thickness / m_sheets.texel);
    sampleAlongRays(plane(p, -1), at, -texelsPerSlope, front);
    sampleAlongRays(plane(p, 0), at, 0, middle);
    sampleAlongRays(plane(p, 1), at, texelsPerSlope, back);
    for (int k = 0; k < kTileSize; ++k) runThroughSheet(front[k], middle[k], back[k]);
    Real low = front[0], high = low;
    for (const Real* values : {front, middle, back})
        for (int k = 0; k < kTileSize; ++k) {
            low = std::min(low, values[k]);
            high = std::max(high, values[k]);
        }
    return m_table.anyBetween(low, high);
}

bool Surface::meanExtinction(int p, const SampleTile& at, Real* out) const {
    alignas(64) Real front[kTileSize], middle[kTileSize], back[kTileSize];
    std::fill(out, out + kTileSize, Real(0));
    if (!sampleRun(p, at, front, middle, back)) return false;
    m_table.meanExtinction(front, middle, back, kTileSize, out, m_simd);
    return true;
}

bool Surface::classify(int p, const SampleTile& at, const Int2& tile, const std::uint8_t* open,
                       ClassifiedTile& out) const {
    std::fill(out.extinction, out.extinction + kTileSize, Real(0));
    if (!sampleRun(p, at, out.front, out.middle, out.back)) return false;
    for (int k = 0; open && k < kTileSize; ++k)  // a value of 0 has no extinction
        if (!open[k]) out.front[k] = out.middle[k] = out.back[k] = 0;
    m_table.meanExtinction(out.front, out.middle, out.back, kTileSize, out.extinction, m_simd);
    if (std::none_of(out.extinction, out.extinction + kTileSize, [](Real sigma) { return sigma > 0; })) return false;
    for (int c = 0; c < 3; ++c)
        m_table.meanEmission(c, out.front, out.middle, out.back, kTileSize, out.emission[c], m_simd);
    findNormals(p, at, m_lattice.parallel() ? m_rsVoxels : voxelsAt(p, tile), out);
    return true;
}

// The values at the first `count` samples moved by `tsOffset`, interpolated linearly between planes.
void Surface::sampleBetween(int p, const SampleTile& at, int count, const Vec3& tsOffset, Real* out) const {
    const auto du = static_cast<Real>(tsOffset.x), dv = static_cast<Real>(tsOffset.y);
    const int whole = static_cast<int>(std::floor(tsOffset.z));
    const auto fraction = static_cast<Real>(tsOffset.z - whole);
    sampleMoved(plane(p, whole), at, count, du, dv, out);
    if (fraction == 0) return;
    alignas(64) Real further[kTileSize];
    sampleMoved(plane(p, whole + 1), at, count, du, dv, further);
    for (int k = 0; k < count; ++k) out[k] += fraction * (further[k] - out[k]);
}

void Surface::findNormals(int p, const SampleTile& at, const Mat3& rsVoxels, ClassifiedTile& out) const {
    // Few of a tile's rays meet something in one sheet. Only theirs are looked up, close together.
    SampleTile few;
    std::array<int, kTileSize> places;
    int count = 0;
    for (int k = 0; k < kTileSize; ++k) {
        if (out.extinction[k] == 0) continue;
        few.u[count] = at.u[k];
        few.v[count] = at.v[k];
        places[std::size_t(count++)] = k;
    }
    const int padded = (count + kTileEdge - 1) / kTileEdge * kTileEdge;
    std::fill(few.u + count, few.u + padded, few.u[0]);
    std::fill(few.v + count, few.v + padded, few.v[0]);
    alignas(64) Real lower[kTileSize], upper[kTileSize], normal[3][kTileSize];
    for (Real* axis : normal) std::fill(axis, axis + padded, Real(0));
    for (int axis = 0; axis < 3; ++axis) {
        sampleBetween(p, few, padded, -rsVoxels[axis], lower);
        sampleBetween(p, few, padded, rsVoxels[axis], upper);
        for (int c = 0; c < 3; ++c) {
            // The normal points out of the denser side, down the gradient. Gradients are in units of the vague
            // gradient, so that their squares neither overflow nor vanish, whatever the units of the field.
            const auto part = static_cast<Real>(-m_ssFromDifference[axis][c] / m_vagueGradient);
            for (int k = 0; k < padded; ++k) normal[c][k] += part * (upper[k] - lower[k]);
        }
    }
    for (Real* axis : out.normal) std::fill(axis, axis + kTileSize, Real(0));
    std::fill(out.weight, out.weight + kTileSize, Real(0));
    for (int i = 0; i < count; ++i) {
        const int k = places[std::size_t(i)];
        const Real x = normal[0][i], y = normal[1][i], z = normal[2][i];
        const Real g2 = x * x + y * y + z * z;
        out.weight[k] = g2 / (g2 + 1);
        const Real inverse = 1 / std::sqrt(std::max(g2, Real(1e-30)));  // a gradient of 0 has no weight
        for (int c = 0; c < 3; ++c) out.normal[c][k] = normal[c][i] * inverse;
    }
}

Mat3 Surface::voxelsIn(const Mat4& rsFromTs) const {
    return Mat3(rsFromTs * m_sheets.tsFrom(m_wsFromIs));
}

// The voxels at the middle of a tile of a perspective view, on its ray.
Mat3 Surface::voxelsAt(int p, const Int2& tile) const {
    const double n = m_firstSheet + p + 0.5;
    const Vec3 middle((tile.x + 0.5) * kTileEdge, (tile.y + 0.5) * kTileEdge, 1);
    const Vec3 onPlane = glm::inverse(m_lattice.fromPlane(n)) * middle;
    return voxelsIn(m_lattice.linearised({onPlane.x / onPlane.z, onPlane.y / onPlane.z, n}));
}

std::size_t Surface::bytes() const {
    return m_field.bytes() + m_extinction.bytes();
}

std::size_t Surface::bytes(const ViewVolume& volume, const Dials& dials, const Sheets& sheets, const Lattice& lattice,
                           int batchSheets) {
    return FieldPlanes::bytes({densityOf(volume)}, settingsOf(volume, dials, sheets), dials, sheets, lattice,
                              batchSheets) +
           PlaneStack::bytes(batchSheets, lattice.width, lattice.height, 1);
}

}  // namespace scrim
#endif
