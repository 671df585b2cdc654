// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/plane_stack.h>

#include <algorithm>
#include <cstring>

namespace scrim {
namespace {

// Floats after the last row, which a vector read or a padded footprint row may touch.
constexpr std::size_t kTail = 64;

std::size_t planeFloats(int width, int height, int channels) {
    return rasterArea(width, height, "texels (a larger 'texel' needs fewer)") * std::size_t(channels) + kTail;
}

}  // namespace

std::size_t PlaneStack::bytes(int planes, int width, int height, int channels) {
    return planeFloats(width, height, channels) * std::size_t(planes) * sizeof(Real);
}

PlaneStack::PlaneStack(int planes, int width, int height, int channels)
    : m_planes(planes),
      m_width(width),
      m_height(height),
      m_channels(channels),
      m_planeStride(static_cast<std::ptrdiff_t>(planeFloats(width, height, channels))),
      m_data(bytes(planes, width, height, channels) / sizeof(Real)) {
    m_state.resize(std::size_t(planes) * std::size_t(tilesX()) * std::size_t(tilesY()));
}

bool PlaneStack::anyActive(int p, const Box2<int>& tiles) const {
    const Box2<int> box = intersection(tiles, {0, 0, tilesX(), tilesY()});
    for (int ty = box.y0; ty < box.y1; ++ty)
        for (int tx = box.x0; tx < box.x1; ++tx)
            if (active(p, tx, ty)) return true;
    return false;
}

Box2<int> PlaneStack::activeBounds(int p) const {
    Box2<int> box;
    for (int ty = 0; ty < tilesY(); ++ty)
        for (int tx = 0; tx < tilesX(); ++tx)
            if (active(p, tx, ty)) box.include({tx, ty, tx + 1, ty + 1});
    return box;
}

void PlaneStack::begin(int p) {
    const auto first = m_state.begin() + static_cast<std::ptrdiff_t>(tileIndex(p, 0, 0));
    std::replace(first, first + static_cast<std::ptrdiff_t>(tilesX()) * tilesY(), kActive, kStale);
}

void PlaneStack::activate(int p, int tx, int ty) {
    std::uint8_t& state = m_state[tileIndex(p, tx, ty)];
    if (state == kStale) clearTile(p, tx, ty);
    state = kActive;
}

void PlaneStack::finish(int p) {
    for (int ty = 0; ty < tilesY(); ++ty) finishRow(p, ty);
}

void PlaneStack::finishRow(int p, int ty) {
    for (int tx = 0; tx < tilesX(); ++tx) {
        std::uint8_t& state = m_state[tileIndex(p, tx, ty)];
        if (state != kStale) continue;
        clearTile(p, tx, ty);
        state = kClean;
    }
}

void PlaneStack::prefilter(int p, Simd simd) {
    constexpr Real kTwelfth = Real(1) / 12;
    forPrefilteredTiles(
        plane(p), tilesX(), tilesY(), rowStride(), [&](int tx, int ty) { return active(p, tx, ty); },
        [&](int tx, int ty, const HaloTile& halo, Real* out) {
            if (prefilterTile(halo, kTwelfth, HaloTile::Limit::zero, simd, out, rowStride()) == 0)
                m_state[tileIndex(p, tx, ty)] = kClean;
        });
}

void PlaneStack::raiseToZero(int p) {
    for (int ty = 0; ty < tilesY(); ++ty)
        for (int tx = 0; tx < tilesX(); ++tx) {
            if (!active(p, tx, ty)) continue;
            const int floats = kTileEdge * m_channels;
            Real* row = plane(p) + static_cast<std::ptrdiff_t>(ty * kTileEdge) * rowStride() + tx * floats;
            for (int y = 0; y < kTileEdge; ++y, row += rowStride())
                for (int x = 0; x < floats; ++x) row[x] = std::max(row[x], Real(0));
        }
}

void PlaneStack::dropEmpty(int p) {
    for (int ty = 0; ty < tilesY(); ++ty)
        for (int tx = 0; tx < tilesX(); ++tx) {
            std::uint8_t& state = m_state[tileIndex(p, tx, ty)];
            if (state != kActive) continue;
            const Real* row = plane(p) + static_cast<std::ptrdiff_t>(ty * kTileEdge) * rowStride() + tx * kTileEdge;
            Real largest = 0;
            for (int y = 0; y < kTileEdge && largest == 0; ++y, row += rowStride())
                for (int x = 0; x < kTileEdge; ++x) largest = std::max(largest, row[x]);
            if (largest == 0) state = kClean;
        }
}

void PlaneStack::clearTile(int p, int tx, int ty) {
    const std::size_t rowFloats = std::size_t(kTileEdge * m_channels);
    Real* row = plane(p) + static_cast<std::ptrdiff_t>(ty * kTileEdge) * rowStride() +
                static_cast<std::ptrdiff_t>(tx) * kTileEdge * m_channels;
    for (int y = 0; y < kTileEdge; ++y, row += rowStride()) std::memset(row, 0, rowFloats * sizeof(Real));
}

}  // namespace scrim
