// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/plane_stack.h>

#include <scrim/base/error.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>

namespace scrim {
namespace {

constexpr std::size_t kAlignment = 64;  // bytes: a cache line and the widest vector
// Floats behind the last row that a vector read or a padded footprint row may touch.
constexpr std::size_t kTail = 64;

std::size_t planeFloats(int width, int height, int channels) {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * static_cast<std::size_t>(channels) +
           kTail;
}

}  // namespace

std::size_t PlaneStack::bytes(int planes, int width, int height, int channels) {
    return planeFloats(width, height, channels) * static_cast<std::size_t>(planes) * sizeof(Real);
}

PlaneStack::PlaneStack(int planes, int width, int height, int channels)
    : m_planes(planes),
      m_width(width),
      m_height(height),
      m_channels(channels),
      m_planeStride(static_cast<std::ptrdiff_t>(planeFloats(width, height, channels))),
      // calloc hands out untouched pages, which take no memory until they are written.
      m_memory(std::calloc(bytes(planes, width, height, channels) + kAlignment, 1), std::free) {
    if (!m_memory) throw Error(ErrorKind::memory, "no memory for the buffers of a batch of sheets");
    const auto address = reinterpret_cast<std::uintptr_t>(m_memory.get());
    m_data = reinterpret_cast<Real*>((address + kAlignment - 1) / kAlignment * kAlignment);
    m_state.resize(static_cast<std::size_t>(planes) * static_cast<std::size_t>(tilesX()) *
                   static_cast<std::size_t>(tilesY()));
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
    std::replace(first, first + tilesX() * tilesY(), kActive, kStale);
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

void PlaneStack::prefilter(int p) {
    constexpr Real kTwelfth = Real(1) / 12;
    forPrefilteredSpans(
        plane(p), tilesX(), tilesY(), rowStride(), [&](int tx, int ty) { return active(p, tx, ty); },
        [](int, int, const Real* above, const Real* here, const Real* below, Real* out) {
            for (int x = 0; x < kTileEdge; ++x) {
                const Real around = here[x - 1] + here[x + 1] + above[x] + below[x];
                out[x] = std::max(Real(0), here[x] - kTwelfth * (around - 4 * here[x]));
            }
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
    const std::size_t rowFloats = static_cast<std::size_t>(kTileEdge * m_channels);
    Real* row = plane(p) + static_cast<std::ptrdiff_t>(ty * kTileEdge) * rowStride() +
                static_cast<std::ptrdiff_t>(tx) * kTileEdge * m_channels;
    for (int y = 0; y < kTileEdge; ++y, row += rowStride()) std::memset(row, 0, rowFloats * sizeof(Real));
}

}  // namespace scrim
