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

void PlaneStack::Release::operator()(void* memory) const noexcept {
    std::free(memory);
}

std::size_t PlaneStack::bytes(int planes, int width, int height, int channels) {
    return planeFloats(width, height, channels) * static_cast<std::size_t>(planes) * sizeof(float);
}

PlaneStack::PlaneStack(int planes, int width, int height, int channels)
    : m_planes(planes),
      m_width(width),
      m_height(height),
      m_channels(channels),
      m_planeStride(static_cast<std::ptrdiff_t>(planeFloats(width, height, channels))),
      // calloc hands out untouched pages, which take no memory until they are written.
      m_memory(std::calloc(bytes(planes, width, height, channels) + kAlignment, 1)) {
    if (!m_memory) throw Error(ErrorKind::memory, "no memory for the buffers of a batch of sheets");
    const auto address = reinterpret_cast<std::uintptr_t>(m_memory.get());
    m_data = reinterpret_cast<float*>((address + kAlignment - 1) / kAlignment * kAlignment);
    m_state.resize(static_cast<std::size_t>(planes) * static_cast<std::size_t>(tilesX()) *
                   static_cast<std::size_t>(tilesY()));
}

bool PlaneStack::anyActive(int p, int tx0, int ty0, int tx1, int ty1) const {
    tx0 = std::max(tx0, 0);
    ty0 = std::max(ty0, 0);
    tx1 = std::min(tx1, tilesX() - 1);
    ty1 = std::min(ty1, tilesY() - 1);
    for (int ty = ty0; ty <= ty1; ++ty)
        for (int tx = tx0; tx <= tx1; ++tx)
            if (active(p, tx, ty)) return true;
    return false;
}

PlaneStack::TileBounds PlaneStack::activeBounds(int p) const {
    TileBounds box{tilesX(), tilesY(), -1, -1};
    for (int ty = 0; ty < tilesY(); ++ty)
        for (int tx = 0; tx < tilesX(); ++tx)
            if (active(p, tx, ty))
                box = {std::min(box.x0, tx), std::min(box.y0, ty), std::max(box.x1, tx), std::max(box.y1, ty)};
    return box;
}

void PlaneStack::begin(int p) {
    const auto first = m_state.begin() + static_cast<std::ptrdiff_t>(tileIndex(p, 0, 0));
    std::replace(first, first + tilesX() * tilesY(), static_cast<std::uint8_t>(kActive),
                 static_cast<std::uint8_t>(kStale));
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

void PlaneStack::raiseToZero(int p) {
    for (int ty = 0; ty < tilesY(); ++ty)
        for (int tx = 0; tx < tilesX(); ++tx) {
            if (!active(p, tx, ty)) continue;
            const int floats = kTileEdge * m_channels;
            float* row = plane(p) + static_cast<std::ptrdiff_t>(ty * kTileEdge) * rowStride() + tx * floats;
            for (int y = 0; y < kTileEdge; ++y, row += rowStride())
                for (int x = 0; x < floats; ++x) row[x] = std::max(row[x], 0.0f);
        }
}

void PlaneStack::dropEmpty(int p) {
    for (int ty = 0; ty < tilesY(); ++ty)
        for (int tx = 0; tx < tilesX(); ++tx) {
            std::uint8_t& state = m_state[tileIndex(p, tx, ty)];
            if (state != kActive) continue;
            const float* row = plane(p) + static_cast<std::ptrdiff_t>(ty * kTileEdge) * rowStride() + tx * kTileEdge;
            float largest = 0;
            for (int y = 0; y < kTileEdge && largest == 0; ++y, row += rowStride())
                for (int x = 0; x < kTileEdge; ++x) largest = std::max(largest, row[x]);
            if (largest == 0) state = kClean;
        }
}

void PlaneStack::clearTile(int p, int tx, int ty) {
    const std::size_t rowFloats = static_cast<std::size_t>(kTileEdge * m_channels);
    float* row = plane(p) + static_cast<std::ptrdiff_t>(ty * kTileEdge) * rowStride() +
                 static_cast<std::ptrdiff_t>(tx) * kTileEdge * m_channels;
    for (int y = 0; y < kTileEdge; ++y, row += rowStride()) std::memset(row, 0, rowFloats * sizeof(float));
}

}  // namespace scrim
