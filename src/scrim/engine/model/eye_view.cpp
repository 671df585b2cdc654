// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/model/eye_view.h>

#include <algorithm>
#include <type_traits>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scrim/engine/model/eye_view.cpp"
#include <hwy/foreach_target.h>
#include <scrim/engine/simd-inl.h>

// Definitions that do not depend on the target.
#ifndef SCRIM_EYE_VIEW_ONCE
#define SCRIM_EYE_VIEW_ONCE
namespace scrim {
namespace {

// A row of 16 rays in texel space, as affine functions of the pixel's index i: origin + i *
// originStep, and likewise for directions. In double precision, since an eye may be far away.
struct RayRow {
    double origin[3], originStep[3], direction[3], directionStep[3];
    double near;       // depth at which rays begin, in units of the direction
    double reference;  // N of the plane on which positions are needed
};

}  // namespace
}  // namespace scrim
#endif

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

// Fills row j of a tile.
HWY_ATTR void fillRays(const RayRow& row, int j, RayTile& tile) {
    const hn::CappedTag<double, kTileEdge> d;
    for (int i = 0; i < kTileEdge; i += static_cast<int>(hn::Lanes(d))) {
        const auto column = hn::Iota(d, static_cast<double>(i));
        const auto at = [&](const double* start, const double* step, int axis)
                            HWY_ATTR { return hn::MulAdd(column, hn::Set(d, step[axis]), hn::Set(d, start[axis])); };
        const auto directionN = at(row.direction, row.directionStep, 2);
        const auto inverse = hn::Div(hn::Set(d, 1.0), directionN);
        const auto away = hn::Sub(hn::Set(d, row.reference), at(row.origin, row.originStep, 2));
        const auto slopeU = hn::Mul(at(row.direction, row.directionStep, 0), inverse);
        const auto slopeV = hn::Mul(at(row.direction, row.directionStep, 1), inverse);
        const int k = j * kTileEdge + i;
        const auto store = [&](auto value, Real* to) HWY_ATTR {
            const hn::Rebind<Real, decltype(d)> dr;
            if constexpr (std::is_same_v<Real, double>)
                hn::StoreU(value, dr, to + k);
            else
                hn::StoreU(hn::DemoteTo(dr, value), dr, to + k);
        };
        store(hn::MulAdd(slopeU, away, at(row.origin, row.originStep, 0)), tile.u);
        store(hn::MulAdd(slopeV, away, at(row.origin, row.originStep, 1)), tile.v);
        store(slopeU, tile.stepU);
        store(slopeV, tile.stepV);
        store(hn::MulSub(hn::Set(d, row.near), directionN, away), tile.startN);
        store(hn::Mul(away, inverse), tile.depth);
        store(inverse, tile.stepDepth);
    }
}

// Fills a tile of texels from (x, y) on. The slopes of the eye's rays there are slopeA + i * step and slopesB[j].
HWY_ATTR void fillTexels(int x, int y, Real slopeA, Real step, const Real* slopesB, SampleTile& samples) {
    const DF d;
    for (int j = 0; j < kTileEdge; ++j)
        for (int i = 0; i < kTileEdge; i += static_cast<int>(hn::Lanes(d))) {
            const int k = j * kTileEdge + i;
            const auto column = hn::Iota(d, static_cast<Real>(i));
            hn::Store(hn::Add(column, constant(static_cast<Real>(x))), d, samples.u + k);
            hn::Store(constant(static_cast<Real>(y + j)), d, samples.v + k);
            hn::Store(hn::MulAdd(column, constant(step), constant(slopeA)), d, samples.eyeA + k);
            hn::Store(constant(slopesB[j]), d, samples.eyeB + k);
        }
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scrim {

HWY_EXPORT(fillRays);
HWY_EXPORT(fillTexels);

EyeView::EyeView(const Camera& camera, const Sheets& sheets, Simd simd)
    : m_orthographic(camera.type == CameraType::orthographic),
      m_simd(simd),
      m_texel(sheets.texel),
      m_thickness(sheets.thickness) {
    const RayFamily ws = wsRays(camera);
    m_ts.near = ws.near;
    m_ts.origin0 = sheets.tsPoint(ws.origin0);
    m_ts.originX = sheets.tsVector(ws.originX);
    m_ts.originY = sheets.tsVector(ws.originY);
    m_ts.direction0 = sheets.tsVector(ws.direction0);
    m_ts.directionX = sheets.tsVector(ws.directionX);
    m_ts.directionY = sheets.tsVector(ws.directionY);
    if (m_orthographic)
        m_rasterFromOffset = glm::inverse(Mat3(m_ts.originX, m_ts.originY, m_ts.direction0));
    else
        m_rasterFromOffset = glm::inverse(Mat3(m_ts.directionX, m_ts.directionY, m_ts.direction0));
}

EyeView::Ray EyeView::ray(double x, double y, double reference) const {
    const Vec3 o = m_ts.origin(x, y), d = m_ts.direction(x, y);
    const double slopeU = d.x / d.z, slopeV = d.y / d.z, stepDepth = 1 / d.z;
    const double away = reference - o.z;
    return {o.x + slopeU * away,   o.y + slopeV * away, slopeU,   slopeV,
            o.z + m_ts.near * d.z, away * stepDepth,    stepDepth};
}

RayTile EyeView::rays(int x0, int y0, double reference) const {
    RayTile tile;
    RayRow row{};
    row.near = m_ts.near;
    row.reference = reference;
    for (int j = 0; j < kTileEdge; ++j) {
        const Vec3 o = m_ts.origin(x0 + 0.5, y0 + j + 0.5), d = m_ts.direction(x0 + 0.5, y0 + j + 0.5);
        for (int axis = 0; axis < 3; ++axis) {
            row.origin[axis] = o[axis];
            row.originStep[axis] = m_ts.originX[axis];
            row.direction[axis] = d[axis];
            row.directionStep[axis] = m_ts.directionX[axis];
        }
        SCRIM_ON_TARGET(m_simd, fillRays)(row, j, tile);
    }
    return tile;
}

void EyeView::planesAt(int x0, int y0, const double* depths, double reference, Real* planes) const {
    for (int k = 0; k < kTileSize; ++k) {
        const double x = x0 + k % kTileEdge + 0.5, y = y0 + k / kTileEdge + 0.5;
        planes[k] = static_cast<Real>(m_ts.origin(x, y).z + m_ts.direction(x, y).z * depths[k] - reference);
    }
}

Lattice EyeView::lattice(const PixelWindow& region, int guardTiles) const {
    Lattice raster;
    raster.kind = m_orthographic ? Lattice::Kind::parallel : Lattice::Kind::perspective;
    raster.guardTiles = guardTiles;
    const PixelWindow tiles = tilesAround(region);
    raster.width = tiles.width() + 2 * guardTiles * kTileEdge;
    raster.height = tiles.height() + 2 * guardTiles * kTileEdge;
    // (x, y, t) or (x t, y t, t) of points relative to the rays' origin; the shift then puts pixel centres at integers.
    const Mat3& m = m_rasterFromOffset;
    const double shift[2] = {guardTiles * kTileEdge - tiles.x0 - 0.5, guardTiles * kTileEdge - tiles.y0 - 0.5};
    const auto row = [&](int i) {
        return glm::dvec4(m[0][i], m[1][i], m[2][i], -glm::dot(Vec3(m[0][i], m[1][i], m[2][i]), m_ts.origin0));
    };
    const glm::dvec4 w = m_orthographic ? glm::dvec4(0, 0, 0, 1) : row(2);
    const glm::dvec4 x = row(0) + shift[0] * w, y = row(1) + shift[1] * w;
    for (int c = 0; c < 4; ++c) raster.rsFromTs[c] = {x[c], y[c], c == 2 ? 1.0 : 0.0, w[c]};
    return raster;
}

void EyeView::setTexels(double middle, int texelX, int texelY, SampleTile& samples) const {
    setDepth(middle, samples);
    Real slopesB[kTileEdge];
    if (m_orthographic) {
        const double toSlope = m_texel / m_thickness;
        const Vec3& way = m_ts.direction0;
        std::fill_n(slopesB, kTileEdge, static_cast<Real>(way.y / way.z * toSlope));
        SCRIM_ON_TARGET(m_simd, fillTexels)
        (texelX, texelY, static_cast<Real>(way.x / way.z * toSlope), 0, slopesB, samples);
        return;
    }
    // For rays from a point, slope = offset / distance along w. Within half a sheet of the eye slopes grow without
    // bounds. Rays that have crossed a sheet do not see texels there, so these only need to stay finite.
    const Vec3& eye = m_ts.origin0;
    double away = middle - eye.z;
    if (away > -0.25 && away < 0.25) away = away < 0 ? -0.25 : 0.25;
    const double scale = m_texel / (m_thickness * away);
    for (int j = 0; j < kTileEdge; ++j) slopesB[j] = static_cast<Real>((texelY + j - eye.y) * scale);
    SCRIM_ON_TARGET(m_simd, fillTexels)
    (texelX, texelY, static_cast<Real>((texelX - eye.x) * scale), static_cast<Real>(scale), slopesB, samples);
}

SampleSpacing EyeView::pixelSpacing(double middle) const {
    SampleSpacing spacing;
    // For rays from the eye, a step of one pixel is a step of their direction, times the distance
    // of the sample along the ray, which the last row of the inverse gives.
    const Vec3 &x = m_orthographic ? m_ts.originX : m_ts.directionX,
               &y = m_orthographic ? m_ts.originY : m_ts.directionY;
    for (int axis = 0; axis < 3; ++axis) {
        spacing.x[axis] = static_cast<Real>(x[axis]);
        spacing.y[axis] = static_cast<Real>(y[axis]);
    }
    if (m_orthographic) return spacing;
    const double tu = m_rasterFromOffset[0].z, tv = m_rasterFromOffset[1].z;
    const Vec3 atOrigin = m_rasterFromOffset * (Vec3(0, 0, middle) - m_ts.origin0);
    spacing.t0 = static_cast<Real>(atOrigin.z);
    spacing.tu = static_cast<Real>(tu);
    spacing.tv = static_cast<Real>(tv);
    return spacing;
}

// The last row of the inverse gives the distance along a ray, and therefore the depth, of a point.
void EyeView::setDepth(double middle, SampleTile& samples) const {
    samples.depth = static_cast<Real>((m_rasterFromOffset * (Vec3(0, 0, middle) - m_ts.origin0)).z);
    samples.depthU = static_cast<Real>(m_rasterFromOffset[0].z);
    samples.depthV = static_cast<Real>(m_rasterFromOffset[1].z);
}

std::optional<Box2<double>> EyeView::seenBy(const Box2<double>& texels, double middle) const {
    auto box = Box2<double>::nothing();
    for (const double u : {texels.x0, texels.x1})
        for (const double v : {texels.y0, texels.y1}) {
            Vec3 p = m_rasterFromOffset * (Vec3(u, v, middle) - m_ts.origin0);
            if (!m_orthographic) {
                if (p.z <= 0) return std::nullopt;  // behind the eye: (x t, y t, t) with t <= 0
                p.x /= p.z;
                p.y /= p.z;
            }
            box.include(p.x, p.y);
        }
    return box;
}

}  // namespace scrim
#endif
