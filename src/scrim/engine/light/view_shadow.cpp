// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/light/view_shadow.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace scrim {
namespace {

// World length of the ray through cell (x, y) from one plane of N to the next.
double pathThroughSheet(const Lattice& raster, const Sheets& sheets, double x, double y) {
    const Vec3 direction = raster.rayThrough(x, y) * Vec3(sheets.texel, sheets.texel, sheets.thickness);
    // A ray within the sheets would be infinitely long.
    return sheets.thickness * glm::length(direction) / std::max(std::abs(direction.z), 1e-6 * glm::length(direction));
}

}  // namespace

ViewShadow::ViewShadow(const Lattice& raster, const Sheets& sheets, ShadowFilter filter, int batchSheets, Simd simd)
    : m_raster(raster), m_simd(simd), m_nearest(filter == ShadowFilter::nearest) {
    const auto cells = std::size_t(raster.width) * std::size_t(raster.height);
    m_tau = ZeroedArray<Real>(cells);
    m_entry = ZeroedArray<Real>(cells * std::size_t(batchSheets));
    m_path.reserve(cells);
    for (int y = 0; y < raster.height; ++y)
        for (int x = 0; x < raster.width; ++x)
            m_path.push_back(static_cast<Real>(pathThroughSheet(raster, sheets, x, y)));
}

std::uint64_t ViewShadow::attenuate(int task, const PlaneStack& extinction, const std::vector<const Surface*>&) {
    const std::size_t first = std::size_t(task * kTileEdge) * std::size_t(m_raster.width);
    const std::size_t count = std::size_t(kTileEdge) * std::size_t(m_raster.width);
    for (int s = 0; s < m_count; ++s) {
        std::copy_n(m_tau.data() + first, count, m_entry.data() + std::size_t(s) * m_tau.size() + first);
        const Real* sigma = extinction.plane(s) + first;
        for (std::size_t i = 0; i < count; ++i) m_tau[first + i] += sigma[i] * m_path[first + i];
    }
    return static_cast<std::uint64_t>(count) * static_cast<std::uint64_t>(m_count);
}

void ViewShadow::lookUpTile(int s, int texelX, int texelY, Real* tau) const {
    alignas(64) Real u[kTileSize], v[kTileSize];
    for (int k = 0; k < kTileSize; ++k) {
        u[k] = static_cast<Real>(texelX + k % kTileEdge);
        v[k] = static_cast<Real>(texelY + k / kTileEdge);
    }
    lookUpPoints(s, u, v, kTileSize, tau);
}

void ViewShadow::lookUpPoints(int s, const Real* u, const Real* v, int count, Real* tau) const {
    const Mat3 rsFromPlane = m_raster.fromPlane(m_firstSheet + s + 0.5);
    alignas(64) Real x[kTileSize], y[kTileSize];
    for (int k = 0; k < count; ++k) {
        const Vec3 p = rsFromPlane * Vec3(u[k], v[k], 1);
        x[k] = static_cast<Real>(p.x / p.z);
        y[k] = static_cast<Real>(p.y / p.z);
    }
    samplePoints({entry(s), m_raster.width, m_raster.height, 0, 0, m_simd}, x, y, m_nearest, count, tau);
}

std::size_t ViewShadow::bytes(const Lattice& raster, int batchSheets) {
    return std::size_t(raster.width) * std::size_t(raster.height) * std::size_t(2 + batchSheets) * sizeof(Real);
}

}  // namespace scrim
