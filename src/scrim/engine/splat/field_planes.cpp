// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/field_planes.h>

#include <scrim/engine/splat/unblur.h>

#include <algorithm>
#include <limits>

#include <glm/matrix.hpp>

namespace scrim {
namespace {

// Consecutive sheets that one task splats: voxels reach into about four, so fewer would locate them more often.
constexpr int kSheetsPerTask = 4;

struct Limits {
    float low, high;
};

// Least and greatest value of a tile and the texels next to it on some planes.
Limits limitsAround(const std::initializer_list<const float*>& planes, int width, int height, int tx, int ty) {
    const int x0 = std::max(0, tx * kTileEdge - 1), x1 = std::min(width, (tx + 1) * kTileEdge + 1);
    const int y0 = std::max(0, ty * kTileEdge - 1), y1 = std::min(height, (ty + 1) * kTileEdge + 1);
    Limits limits{(*planes.begin())[y0 * width + x0], 0};
    for (const float* plane : planes)
        for (int y = y0; y < y1; ++y) {
            const float* row = plane + static_cast<std::ptrdiff_t>(y) * width;
            for (int x = x0; x < x1; ++x) {
                limits.low = std::min(limits.low, row[x]);
                limits.high = std::max(limits.high, row[x]);
            }
        }
    return limits;
}

// The largest voxel that is told from larger ones: sums and products of floats must not overflow. Of a medium an
// extinction of 1e9 optical depths a voxel, of a classified volume a million times the last value of the transfer
// function: beyond them a voxel's tent is opaque to its rim but for a millionth of a voxel, which no raster resolves.
float mostOf(const ViewVolume& volume, double voxel) {
    const double most = volume.classified ? 1e6 * volume.classified->transfer.back().value : 1e9 / voxel;
    return static_cast<float>(std::min<double>(most, std::numeric_limits<float>::max()));
}

std::variant<FieldSplatter, WarpedSplatter> splatterFor(const ViewVolume& volume, const Dials& dials,
                                                        const Sheets& sheets, const ViewRaster& raster, double voxel) {
    const Mat4 tsFromIs = sheets.tsFrom(volume.wsFromIs);
    const int steps = VolumePlanes::footprintStepsOf(volume, dials);
    const float scale = volume.classified ? 1.0f : static_cast<float>(volume.medium.mostExtinction());
    const float most = mostOf(volume, voxel);
    if (!raster.parallel) return WarpedSplatter(*volume.field, tsFromIs, raster, dials.kernel, steps, scale, most);
    return FieldSplatter(*volume.field, raster.rsFromTs * tsFromIs, dials.kernel, steps, scale, FootprintLookup::sloped,
                         most, Simd(dials.simd));
}

}  // namespace

VolumePlanes::VolumePlanes(const ViewVolume& volume, const Dials& dials, const Sheets& sheets, const ViewRaster& raster,
                           int batchSheets, double voxel)
    : m_volume(volume),
      m_simd(dials.simd),
      m_sheets(sheets),
      m_raster(raster),
      m_shared(raster.rsFromTs == Mat4(1.0)),
      m_halo(halo(volume, sheets)),
      m_splatter(splatterFor(volume, dials, sheets, raster, voxel)),
      m_values(batchSheets + 2 * m_halo, raster.width, raster.height, 1) {
    if (!volume.classified) return;
    m_surface.emplace(Surface{TransferTable(*volume.classified),
                              stepFor(raster.rsFromTs),
                              scrim::vagueGradient(*volume.classified, voxel),
                              {batchSheets, raster.width, raster.height, 1}});
}

int VolumePlanes::footprintStepsOf(const ViewVolume& volume, const Dials& dials) {
    constexpr int kMostSteps = 128;
    return volume.classified ? std::min(2 * dials.footprintSteps, kMostSteps) : dials.footprintSteps;
}

int VolumePlanes::halo(const ViewVolume& volume, const Sheets& sheets) {
    if (!volume.classified) return 0;
    return gradientStep(sheets.tsFrom(volume.wsFromIs), sheets.ssFromWs, volume.wsFromIs).reach;
}

int VolumePlanes::beginBatch(int firstSheet, int count) {
    m_firstSheet = firstSheet;
    if (m_origin < 0) {
        m_origin = firstSheet;
        m_readySheet = firstSheet - m_halo;
    }
    m_runs.clear();
    const int end = firstSheet + count + m_halo;
    while (m_readySheet < end) {
        const int wrap = m_values.planes() - planeOf(m_readySheet);
        const int run = std::min({kSheetsPerTask, end - m_readySheet, wrap});
        m_runs.push_back({m_readySheet, run});
        m_readySheet += run;
    }
    return static_cast<int>(m_runs.size());
}

SplatWork VolumePlanes::splat(int task, const NeededTiles* needed, const TileCull& cull) {
    const Run& run = m_runs[static_cast<std::size_t>(task)];
    const int first = planeOf(run.sheet);
    TileCull leaveOut = cull;
    if (needed)
        leaveOut = [box = needed->over(run.sheet, run.sheet + run.count), &cull](int x0, int y0, int x1, int y1) {
            return x1 < box.x0 || y1 < box.y0 || x0 > box.x1 || y0 > box.y1 || (cull && cull(x0, y0, x1, y1));
        };
    for (int p = first; p < first + run.count; ++p) m_values.begin(p);
    const SplatWork work = std::visit(
        [&](const auto& splatter) {
            return splatter.splat(run.sheet, run.sheet + run.count, m_values, first, leaveOut);
        },
        m_splatter);
    for (int p = first; p < first + run.count; ++p) {
        m_values.finish(p);
        if (m_shared)
            unblur(m_values, p);
        else if (m_raster.parallel)
            m_values.raiseToZero(p);  // slopes of footprints go below 0 around what is the field's rim
        m_values.dropEmpty(p);
    }
    return work;
}

void VolumePlanes::classify(int p) {
    if (!m_surface) return;
    const ValuePlanes around = values(p);
    const float *before = around.at(-1), *here = around.at(0), *behind = around.at(1);
    PlaneStack& out = m_surface->extinction;
    const int sheet = m_firstSheet + p;
    const int planes[3] = {planeOf(sheet - 1), planeOf(sheet), planeOf(sheet + 1)};
    alignas(64) float front[kTileSize], middle[kTileSize], back[kTileSize], sigma[kTileSize];
    out.begin(p);
    for (int ty = 0; ty < out.tilesY(); ++ty)
        for (int tx = 0; tx < out.tilesX(); ++tx) {
            // A tile counts as active where its texels, or anything between them and their neighbours, may show
            // something: pixels look there, too.
            if (std::none_of(planes, planes + 3,
                             [&](int q) { return m_values.anyActive(q, tx - 1, ty - 1, tx + 1, ty + 1); }))
                continue;
            const Limits limits = limitsAround({before, here, behind}, around.width, around.height, tx, ty);
            if (!m_surface->table.anyBetween(limits.low, limits.high)) continue;
            out.replace(p, tx, ty);
            const std::ptrdiff_t corner = static_cast<std::ptrdiff_t>(ty * kTileEdge) * around.width + tx * kTileEdge;
            for (int k = 0; k < kTileSize; ++k) {
                const std::ptrdiff_t at =
                    corner + static_cast<std::ptrdiff_t>(k / kTileEdge) * around.width + k % kTileEdge;
                const SheetRun run = runThroughSheet(before[at], here[at], behind[at]);
                front[k] = run.front;
                middle[k] = run.middle;
                back[k] = run.back;
            }
            m_surface->table.meanExtinction(front, middle, back, kTileSize, sigma, around.simd);
            float* to = out.plane(p) + corner;
            for (int y = 0; y < kTileEdge; ++y, to += out.rowStride())
                std::copy_n(sigma + y * kTileEdge, kTileEdge, to);
        }
    out.finish(p);
}

GradientStep VolumePlanes::stepFor(const Mat4& rsFromTs) const {
    return gradientStep(rsFromTs * m_sheets.tsFrom(m_volume.wsFromIs), m_sheets.ssFromWs, m_volume.wsFromIs);
}

GradientStep VolumePlanes::step(int p, int tx, int ty) const {
    if (m_raster.parallel) return m_surface->step;
    // The middle of the tile, on its ray.
    const double n = m_firstSheet + p + 0.5;
    const Vec3 middle((tx + 0.5) * kTileEdge, (ty + 0.5) * kTileEdge, 1);
    const Vec3 onPlane = glm::inverse(m_raster.fromPlane(n)) * middle;
    return stepFor(m_raster.linearised({onPlane.x / onPlane.z, onPlane.y / onPlane.z, n}));
}

ValuePlanes VolumePlanes::values(int p) const {
    return {m_values.plane(0),
            m_values.planeStride(),
            m_values.planes(),
            planeOf(m_firstSheet + p),
            m_values.width(),
            m_values.height(),
            m_simd};
}

std::size_t VolumePlanes::bytes() const {
    const auto planes = [](const PlaneStack& s) { return PlaneStack::bytes(s.planes(), s.width(), s.height(), 1); };
    const std::size_t table = std::visit([](const auto& splatter) { return splatter.table().bytes(); }, m_splatter);
    return table + planes(m_values) + (m_surface ? planes(m_surface->extinction) : 0);
}

std::size_t VolumePlanes::bytes(const ViewVolume& volume, const Dials& dials, const Sheets& sheets,
                                const ViewRaster& raster, int batch) {
    const auto planes = [&](int count) { return PlaneStack::bytes(count, raster.width, raster.height, 1); };
    const std::size_t sum = planes(batch + 2 * halo(volume, sheets)) + (volume.classified ? planes(batch) : 0) +
                            volume.field->blockCount() * 8;
    if (!raster.parallel) return sum;  // one small table
    const Mat4 rsFromIs = raster.rsFromTs * sheets.tsFrom(volume.wsFromIs);
    const FootprintSteps steps = footprintSteps(rsFromIs, footprintStepsOf(volume, dials));
    return sum + FootprintTable::bytes(dials.kernel, rsFromIs, steps.texel, steps.sheet, FootprintLookup::sloped);
}

}  // namespace scrim
