// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/light/shadow_buffer.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

struct TileRange {
    int first = 0, last = -1;  // closed
};

// The raster tiles that the texels of one row or column of sheet tiles look up, with a margin of
// one cell and one texel, so that bilinear look-ups stay within tiles that take part.
TileRange cellTiles(int sheetTile, double offset, double scale, int rasterTiles) {
    const double lower = (sheetTile * kTileEdge - 1 - offset) / scale - 1;
    const double upper = (sheetTile * kTileEdge + kTileEdge - offset) / scale + 1;
    const double limit = rasterTiles * kTileEdge - 1.0;
    const auto tile = [&](double cell) {
        return static_cast<int>(std::floor(std::clamp(cell, 0.0, limit))) / kTileEdge;
    };
    return {tile(lower), tile(upper)};
}

// From texels of a sheet to the cells of a light there.
PlaneMap cellsFrom(const LightView::Cells& map) {
    return {static_cast<Real>(1 / map.scale), static_cast<Real>(-map.offsetU / map.scale),
            static_cast<Real>(-map.offsetV / map.scale)};
}

}  // namespace

ShadowBuffer::ShadowBuffer(const LightView& view, const Sheets& sheets, ShadowFilter filter, int lookUps,
                           int batchSheets, Simd simd, bool looksBefore)
    : m_view(view),
      m_simd(simd),
      m_thickness(sheets.thickness),
      m_nearest(filter == ShadowFilter::nearest),
      m_prefiltering(m_nearest ? Real(0) : static_cast<Real>(lookUps) / 12),
      m_looksBefore(looksBefore) {
    m_tau = ZeroedArray<Real>(std::size_t(view.width) * std::size_t(view.height));
    m_used.reserve(std::size_t(batchSheets));
}

// The part of its own sheet that light from a point light inside of the volume crosses. No raster
// resolves it, so every ray takes the extinction at the light.
void ShadowBuffer::leaveTheSource(double part, const FloatPlane& extinction) {
    alignas(64) Real u[kTileSize], v[kTileSize], sigma[kTileSize];
    std::fill(u, u + kTileSize, static_cast<Real>(m_view.tsSource.x));
    std::fill(v, v + kTileSize, static_cast<Real>(m_view.tsSource.y));
    samplePoints(extinction, u, v, false, kTileEdge, sigma);
    for (int y = 0; y < m_view.height; ++y)
        for (int x = 0; x < m_view.width; ++x) {
            const Vec2 slope = m_view.slopeAt(x, y);
            m_tau[std::size_t(y) * std::size_t(m_view.width) + std::size_t(x)] +=
                static_cast<Real>(part * m_thickness * std::sqrt(1 + glm::dot(slope, slope))) * sigma[0];
        }
}

void ShadowBuffer::keepLast() {
    for (int back = kBefore; back-- > 0 && m_looksBefore;) {
        const auto to = std::size_t(back);
        if (const int s = m_count - 1 - back; s < 0) {  // of a batch before the last one
            const auto from = std::size_t(back - m_count);
            m_beforeWindow[to] = m_beforeWindow[from];
            m_beforeEntry[to] = m_beforeEntry[from];
            m_beforeUsed[to] = m_beforeUsed[from];
        } else {
            m_beforeWindow[to] = m_window;
            m_beforeEntry[to].assign(entryPlane(s).data, entryPlane(s + 1).data);
            m_beforeUsed[to].assign(usedIn(s), usedIn(s + 1));
        }
    }
}

void ShadowBuffer::beginBatch(int firstSheet, int count, const PlaneStack& extinction, const PlaneStack& covered) {
    keepLast();
    m_firstSheet = firstSheet;
    m_count = count;
    for (int s = 0; s < count; ++s)
        if (const double part = m_view.litPart(firstSheet + s); part > 0 && part < 1)
            leaveTheSource(part, extinction.view(s, m_simd));
    const int tilesX = covered.tilesX(), tilesY = covered.tilesY();
    const int rasterX = m_view.width / kTileEdge, rasterY = m_view.height / kTileEdge;

    // The raster tiles that each column and row of sheet tiles looks up, for every sheet.
    const auto perSheet = std::size_t(tilesX + tilesY);
    std::vector<TileRange> ranges(std::size_t(count) * perSheet);
    const auto columns = [&](int s) { return ranges.data() + std::size_t(s) * perSheet; };
    const auto rows = [&](int s) { return columns(s) + tilesX; };
    TileRange windowX{rasterX, -1}, windowY{rasterY, -1};
    for (int s = 0; s < count; ++s) {
        if (!m_view.reaches(firstSheet + s)) continue;
        const LightView::Cells map = m_view.at(firstSheet + s);
        for (int tx = 0; tx < tilesX; ++tx) columns(s)[tx] = cellTiles(tx, map.offsetU, map.scale, rasterX);
        for (int ty = 0; ty < tilesY; ++ty) rows(s)[ty] = cellTiles(ty, map.offsetV, map.scale, rasterY);
        for (int ty = 0; ty < tilesY; ++ty)
            covered.forActive(s, ty, [&](int tx) {
                windowX = {std::min(windowX.first, columns(s)[tx].first), std::max(windowX.last, columns(s)[tx].last)};
                windowY = {std::min(windowY.first, rows(s)[ty].first), std::max(windowY.last, rows(s)[ty].last)};
            });
    }
    m_window = {windowX.first, windowY.first, std::max(windowX.first, windowX.last + 1),
                std::max(windowY.first, windowY.last + 1)};
    // Windows grow slowly towards the middle of a field. The buffer grows in larger steps, since new memory is slow.
    if (const std::size_t size = entryStride() * std::size_t(count); m_entry.size() < size)
        m_entry =
            ZeroedArray<Real>(std::max(size, std::min(m_entry.size() * 3 / 2, m_tau.size() * std::size_t(count))));

    const std::size_t tilesPerSheet = m_window.pixelCount();
    m_used.assign(tilesPerSheet * std::size_t(count), 0);
    for (int s = 0; s < count; ++s) {
        if (!m_view.reaches(firstSheet + s)) continue;
        for (int ty = 0; ty < tilesY; ++ty)
            covered.forActive(s, ty, [&](int tx) {
                for (int y = rows(s)[ty].first; y <= rows(s)[ty].last; ++y)
                    for (int x = columns(s)[tx].first; x <= columns(s)[tx].last; ++x)
                        m_used[std::size_t(s) * tilesPerSheet +
                               std::size_t((y - m_window.y0) * m_window.width() + x - m_window.x0)] = kUsed;
            });
    }
    listTasks();
    if (m_anywhere) meetTiles();
}

void ShadowBuffer::listTasks() {
    constexpr int kTilesPerTask = 8;
    m_tasks.clear();
    for (int row = 0; row < m_window.height(); ++row)
        for (int begin = 0; begin < m_window.width(); begin += kTilesPerTask) {
            const int end = std::min(begin + kTilesPerTask, m_window.width());
            const auto at = std::size_t(row * m_window.width() + begin);
            bool any = false;
            for (int s = 0; s < m_count && !any; ++s)
                any = std::memchr(usedIn(s) + at, kUsed, std::size_t(end - begin)) != nullptr;
            if (any) m_tasks.push_back({row, begin, end});
        }
}

// Remembers the tiles of the raster that take part in the batch.
void ShadowBuffer::meetTiles() {
    const int rasterX = m_view.width / kTileEdge, rasterY = m_view.height / kTileEdge;
    m_met.resize(std::size_t(rasterX) * std::size_t(rasterY));
    for (int s = 0; s < m_count; ++s)
        for (const Task& task : m_tasks)
            forUsed(s, task, [&](int x) {
                const int y = m_window.y0 + task.row;
                m_met[std::size_t(y) * std::size_t(rasterX) + std::size_t(m_window.x0 + x)] = 1;
            });
}

namespace {

// As attenuateTile, with the extinction that `surfaces` have along the light's rays through sheet s. The field is
// smooth between texels where its classification jumps, so edges of shadows stay sharp, and opaque matter does not leak
// into the texel beside it. `classified`: one for each surface, and the same ones from sheet to sheet.
void attenuateAlongRays(const AttenuateTile& tile, int s, const LightView& view, const Int2& cell,
                        const std::vector<const Surface*>& surfaces, std::vector<ClassifiedTile>& classified) {
    // Beyond this optical depth nothing is lit, and it does not matter how dark it is.
    constexpr Real kDark = 16;
    // Beyond this one, where 0.25 % of the light is left, the edges of surfaces need not be exact.
    constexpr Real kDim = 6;
    Real least = kDark;
    for (int y = 0; y < kTileEdge; ++y) {
        const Real* const row = tile.tau + y * tile.tauStride;
        std::copy_n(row, kTileEdge, tile.entry + y * tile.entryStride);
        least = std::min(least, *std::min_element(row, row + kTileEdge));
    }
    if (least == kDark) return;
    std::uint8_t open[kTileSize];
    for (int k = 0; k < kTileSize; ++k) open[k] = tile.tau[k / kTileEdge * tile.tauStride + k % kTileEdge] < kDim;
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
        if (!surfaces[i]->meanExtinction(s, view, cell, open, classified[i])) continue;
        const auto way = [&](int x, int y) {
            const Real a = tile.slopeA + static_cast<Real>(x) * tile.slopeStep,
                       b = tile.slopeB + static_cast<Real>(y) * tile.slopeStep;
            return tile.path * std::sqrt(1 + a * a + b * b);
        };
        const bool parallel = tile.slopeStep == 0;
        const Real one = way(0, 0);
        const Real* mean = classified[i].extinction;
        for (int y = 0; y < kTileEdge; ++y, mean += kTileEdge) {
            Real* const row = tile.tau + y * tile.tauStride;
            if (parallel)
                for (int x = 0; x < kTileEdge; ++x) row[x] += mean[x] * one;
            else
                for (int x = 0; x < kTileEdge; ++x) row[x] += mean[x] * way(x, y);
        }
    }
}

}  // namespace

std::uint64_t ShadowBuffer::attenuate(int task, const PlaneStack& extinction,
                                      const std::vector<const Surface*>& surfaces) {
    const Task& own = m_tasks[std::size_t(task)];
    const int row = own.row, tileY = m_window.y0 + row;
    std::uint64_t samples = 0;
    const auto isUsed = [&](int s, int x) { return usedIn(s)[row * m_window.width() + x] != 0; };
    const auto tileOf = [&](int s, int x, const LightView::Cells& map) {
        AttenuateTile tile{};
        tile.extinction = extinction.view(s, m_simd);
        tile.nearest = m_nearest;
        tile.path = static_cast<Real>(m_thickness);
        tile.step = static_cast<Real>(map.scale);
        tile.tauStride = m_view.width;
        tile.entryStride = windowWidth();
        const int cellX = (m_window.x0 + x) * kTileEdge, cellY = tileY * kTileEdge;
        tile.u = static_cast<Real>(map.offsetU + cellX * map.scale);
        tile.v = static_cast<Real>(map.offsetV + cellY * map.scale);
        const Vec2 slope = m_view.slopeAt(cellX, cellY);
        tile.slopeA = static_cast<Real>(slope.x);
        tile.slopeB = static_cast<Real>(slope.y);
        tile.slopeStep = static_cast<Real>(m_view.slopeStep());
        tile.tau = m_tau.data() + static_cast<std::ptrdiff_t>(cellY) * m_view.width + cellX;
        tile.entry = m_entry.data() + std::size_t(s) * entryStride() +
                     static_cast<std::ptrdiff_t>(row * kTileEdge) * windowWidth() + x * kTileEdge;
        samples += kTileSize;
        return tile;
    };
    // Texels are read plane by plane. Surfaces are followed along their rays, tile by tile.
    for (int s = 0; s < m_count && surfaces.empty(); ++s) {
        const LightView::Cells map = m_view.at(m_firstSheet + s);
        forUsed(s, own, [&](int x) { attenuateTile(tileOf(s, x, map)); });
    }
    std::vector<ClassifiedTile> classified(surfaces.size());
    for (int x = own.begin; x < own.end && !surfaces.empty(); ++x) {
        for (ClassifiedTile& through : classified) through.leave();
        for (int s = 0; s < m_count; ++s)
            if (isUsed(s, x))
                attenuateAlongRays(tileOf(s, x, m_view.at(m_firstSheet + s)), s, m_view,
                                   {(m_window.x0 + x) * kTileEdge, tileY * kTileEdge}, surfaces, classified);
    }
    return samples;
}

void ShadowBuffer::prefilter(int s) {
    if (m_prefiltering == 0 || !lit(s)) return;
    const std::uint8_t* used = usedIn(s);
    const auto isUsed = [&](int x, int y) {
        return x >= 0 && x < m_window.width() && y >= 0 && y < m_window.height() && used[y * m_window.width() + x] != 0;
    };
    // Values are limited to those of their neighbours, so that a lit cell at an opaque edge stays as it is.
    forPrefilteredTiles(
        m_entry.data() + std::size_t(s) * entryStride(), m_window.width(), m_window.height(), windowWidth(),
        [&](int ty, const auto& visit) { forTilesIn(used + ty * m_window.width(), m_window.width(), kUsed, visit); },
        [&](int tx, int ty, HaloTile& halo, Real* out) {
            // Tiles that take no part are empty; the cells that border on them replace theirs.
            constexpr int kLast = kTileEdge - 1;
            if (!isUsed(tx, ty - 1)) std::copy_n(halo.at(0, 0), kTileEdge, halo.at(0, -1));
            if (!isUsed(tx, ty + 1)) std::copy_n(halo.at(0, kLast), kTileEdge, halo.at(0, kTileEdge));
            for (int y = 0; y < kTileEdge; ++y) {
                if (!isUsed(tx - 1, ty)) *halo.at(-1, y) = *halo.at(0, y);
                if (!isUsed(tx + 1, ty)) *halo.at(kTileEdge, y) = *halo.at(kLast, y);
            }
            prefilterBetween(halo, m_prefiltering, m_simd, out, windowWidth());
        });
}

// Tau at entry into a sheet: a window of the whole raster.
FloatPlane ShadowBuffer::planeOf(const Real* entry, const Box2<int>& window) const {
    return {
        entry, window.width() * kTileEdge, window.height() * kTileEdge, window.x0 * kTileEdge, window.y0 * kTileEdge,
        m_simd};
}

void ShadowBuffer::lookUpTile(int s, int texelX, int texelY, Real* tau) const {
    if (!lit(s)) {
        std::fill(tau, tau + kTileSize, Real(0));
        return;
    }
    const LightView::Cells map = m_view.at(m_firstSheet + s);
    sampleLattice(entryPlane(s), static_cast<Real>((texelX - map.offsetU) / map.scale),
                  static_cast<Real>((texelY - map.offsetV) / map.scale), static_cast<Real>(1 / map.scale), m_nearest,
                  tau);
}

void ShadowBuffer::lookUpPoints(int s, const Real* u, const Real* v, int count, Real* tau) const {
    if (m_anywhere ? !m_view.reaches(m_firstSheet + s) : !lit(s)) {
        std::fill(tau, tau + count, Real(0));
        return;
    }
    const LightView::Cells map = m_view.at(m_firstSheet + s);
    if (m_anywhere) return lookUpPatch(s, map, u, v, count, tau);
    samplePoints(entryPlane(s), u, v, m_nearest, count, tau, cellsFrom(map));
}

void ShadowBuffer::lookUpNow(double plane, const Real* u, const Real* v, int count, Real* tau) const {
    if (!m_view.distant && plane <= m_view.tsSource.z) {
        std::fill(tau, tau + count, Real(0));
        return;
    }
    const LightView::Cells map = m_view.atPlane(plane);
    samplePoints({m_tau.data(), m_view.width, m_view.height, 0, 0, m_simd}, u, v, m_nearest, count, tau,
                 cellsFrom(map));
}

void ShadowBuffer::lookUpWithin(double plane, Real part, const Real* u, const Real* v, int count, Real* tau) const {
    lookUpNow(plane, u, v, count, tau);
    if (!m_view.distant && plane <= m_view.tsSource.z) return;
    alignas(64) Real entry[kTileSize];
    lookUpPatch(0, m_view.atPlane(plane), u, v, count, entry);
    for (int k = 0; k < count; ++k) tau[k] = entry[k] + part * (tau[k] - entry[k]);
}

// Tau at entry into sheet s of the batch, also in tiles that take no part in the sheet: it is that at entry into the
// next sheet in which the tile takes part, or behind the batch. The few tiles that are looked up are put together.
void ShadowBuffer::lookUpPatch(int s, const LightView::Cells& map, const Real* u, const Real* v, int count,
                               Real* tau) const {
    const auto perCell = static_cast<Real>(1 / map.scale), firstU = static_cast<Real>(-map.offsetU / map.scale),
               firstV = static_cast<Real>(-map.offsetV / map.scale);
    const auto [leastU, mostU] = std::minmax_element(u, u + count);
    const auto [leastV, mostV] = std::minmax_element(v, v + count);
    const auto tileOf = [](Real cell, int size) {
        return static_cast<int>(std::clamp(std::floor(cell), Real(-1), static_cast<Real>(size))) >> 4;
    };
    const int rasterX = m_view.width / kTileEdge, rasterY = m_view.height / kTileEdge;
    const Box2<int> box = intersection<int>(
        {tileOf(*leastU * perCell + firstU - 1, m_view.width), tileOf(*leastV * perCell + firstV - 1, m_view.height),
         tileOf(*mostU * perCell + firstU + 1, m_view.width) + 1,
         tileOf(*mostV * perCell + firstV + 1, m_view.height) + 1},
        {0, 0, rasterX, rasterY});
    std::fill(tau, tau + count, Real(0));
    if (box.empty()) return;
    thread_local std::vector<Real> patch;
    const int width = box.width() * kTileEdge;
    patch.resize(std::size_t(width) * std::size_t(box.height() * kTileEdge));
    for (int ty = box.y0; ty < box.y1; ++ty)
        for (int tx = box.x0; tx < box.x1; ++tx) {
            int from = m_count;
            if (m_window.contains(tx, ty)) {
                const auto at = std::size_t((ty - m_window.y0) * m_window.width() + tx - m_window.x0);
                for (from = s; from < m_count && usedIn(from)[at] == 0;) ++from;
            }
            const Real* source = m_tau.data() + std::ptrdiff_t(ty * kTileEdge) * m_view.width + tx * kTileEdge;
            std::ptrdiff_t stride = m_view.width;
            if (from < m_count) {
                stride = windowWidth();
                source = m_entry.data() + std::size_t(from) * entryStride() +
                         std::ptrdiff_t((ty - m_window.y0) * kTileEdge) * stride + (tx - m_window.x0) * kTileEdge;
            }
            Real* to = patch.data() + std::ptrdiff_t((ty - box.y0) * kTileEdge) * width + (tx - box.x0) * kTileEdge;
            for (int y = 0; y < kTileEdge; ++y, source += stride, to += width) std::copy_n(source, kTileEdge, to);
        }
    samplePoints({patch.data(), width, box.height() * kTileEdge, box.x0 * kTileEdge, box.y0 * kTileEdge, m_simd}, u, v,
                 m_nearest, count, tau, {perCell, firstU, firstV});
}

Box2<double> ShadowBuffer::cellsOf(const Box2<double>& texels, double plane) const {
    if (!m_view.distant && plane <= m_view.tsSource.z) return {};
    const LightView::Cells map = m_view.atPlane(plane);
    return {(texels.x0 - map.offsetU) / map.scale, (texels.y0 - map.offsetV) / map.scale,
            (texels.x1 - map.offsetU) / map.scale, (texels.y1 - map.offsetV) / map.scale};
}

bool ShadowBuffer::anyMet(const Box2<double>& cells) const {
    if (m_met.empty() || cells.x1 < cells.x0) return false;
    const int tilesX = m_view.width / kTileEdge, tilesY = m_view.height / kTileEdge;
    const auto tile = [](double cell, int tiles) {
        return static_cast<int>(std::clamp(std::floor(cell / kTileEdge), -1.0, double(tiles)));
    };
    const int x0 = std::max(tile(cells.x0 - 1, tilesX), 0), x1 = std::min(tile(cells.x1 + 1, tilesX), tilesX - 1);
    const int y0 = std::max(tile(cells.y0 - 1, tilesY), 0), y1 = std::min(tile(cells.y1 + 1, tilesY), tilesY - 1);
    for (int y = y0; y <= y1; ++y)
        for (int x = x0; x <= x1; ++x)
            if (m_met[std::size_t(y) * std::size_t(tilesX) + std::size_t(x)] != 0) return true;
    return false;
}

void ShadowBuffer::lookUpBefore(int s, int back, const Real* u, const Real* v, int count, Real* tau,
                                std::uint8_t* known) const {
    const bool own = s >= back;
    const auto before = std::size_t(own ? 0 : back - 1 - s);
    const Box2<int>& window = own ? m_window : m_beforeWindow[before];
    const std::uint8_t* used = own ? usedIn(s - back) : m_beforeUsed[before].data();
    std::fill_n(known, count, std::uint8_t{0});
    if (window.empty()) return;
    const LightView::Cells map = m_view.at(m_firstSheet + s);
    const auto isUsed = [&](double cellX, double cellY) {
        const int x = static_cast<int>(std::floor(cellX / kTileEdge)),
                  y = static_cast<int>(std::floor(cellY / kTileEdge));
        return window.contains(x, y) && used[(y - window.y0) * window.width() + x - window.x0] != 0;
    };
    for (int k = 0; k < count; ++k) {
        const double x = (u[k] - map.offsetU) / map.scale, y = (v[k] - map.offsetV) / map.scale;
        known[k] = isUsed(x, y) && isUsed(x + 1, y) && isUsed(x, y + 1) && isUsed(x + 1, y + 1);
    }
    const FloatPlane plane = own ? entryPlane(s - back) : planeOf(m_beforeEntry[before].data(), window);
    samplePoints(plane, u, v, m_nearest, count, tau, cellsFrom(map));
}

std::size_t ShadowBuffer::bytes() const {
    std::size_t floats = m_tau.size() + m_entry.size();
    for (const std::vector<Real>& entry : m_beforeEntry) floats += entry.size();
    return floats * sizeof(Real) + m_used.size() + m_met.size();
}

std::size_t ShadowBuffer::bytes(const LightView& view, const Sheets& sheets, int batchSheets, bool looksBefore) {
    const auto raster = std::size_t(view.width) * std::size_t(view.height);
    // The window of a batch in cells: the sheet's raster, shifted by the slant of the light.
    const double least = view.distant ? view.cell : view.cell * std::max(0.5, -view.tsSource.z + 0.5);
    const double drift = view.distant ? (std::abs(view.tsSource.x) + std::abs(view.tsSource.y)) * batchSheets : 0;
    const double window =
        (sheets.width + drift + 4 * kTileEdge) * (sheets.height + drift + 4 * kTileEdge) / (least * least);
    const auto entry = std::size_t(std::min(window, static_cast<double>(raster))) *
                       std::size_t(batchSheets + (looksBefore ? kBefore : 0));
    return (raster + entry) * sizeof(Real);
}

}  // namespace scrim
