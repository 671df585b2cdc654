// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/sweep.h>

#include <scrim/base/parallel.h>
#include <scrim/engine/splat/extinction_sum.h>
#include <scrim/engine/light/light_sweep.h>
#include <scrim/engine/composite/compositor.h>
#include <scrim/engine/shade/sheet_shader.h>

#include <algorithm>
#include <chrono>
#include <optional>

namespace scrim {
namespace {

class Stopwatch {
  public:
    double lap() {
        const auto now = std::chrono::steady_clock::now();
        const double seconds = std::chrono::duration<double>(now - m_start).count();
        m_start = now;
        return seconds;
    }

  private:
    std::chrono::steady_clock::time_point m_start = std::chrono::steady_clock::now();
};

// Stage 4 at texels: shades the active tiles of a batch that an open pixel may see.
ShadeWork shadeBatch(const SheetShader& shader, const EyeView& eye, const ImageTiles& tiles, const PlaneStack& covered,
                     int firstSheet, int count, PlaneStack& shaded) {
    const int tilesY = shaded.tilesY();
    const int floats = shaded.channels();
    for (int p = 0; p < count; ++p) shaded.begin(p);
    std::vector<ShadeWork> work(static_cast<std::size_t>(count * tilesY));
    parallelFor(work.size(), [&](std::size_t task) {
        const int p = static_cast<int>(task) / tilesY, ty = static_cast<int>(task) % tilesY;
        const int sheet = firstSheet + p;
        std::vector<float> out(static_cast<std::size_t>(floats * kTileSize));
        for (int tx = 0; tx < shaded.tilesX(); ++tx) {
            if (!covered.active(p, tx, ty)) continue;
            // A texel serves bilinear look-ups up to one texel around it.
            const auto seen = eye.seenBy(tx * kTileEdge - 1, ty * kTileEdge - 1, (tx + 1) * kTileEdge,
                                         (ty + 1) * kTileEdge, sheet + 0.5);
            if (seen && !tiles.anyOpen(seen->x0, seen->y0, seen->x1, seen->y1)) continue;
            work[task] += shader.shadeTexels(p, sheet, tx, ty, out.data());
            shaded.replace(p, tx, ty);
            float* row = shaded.plane(p) + static_cast<std::ptrdiff_t>(ty * kTileEdge) * shaded.rowStride() +
                         tx * kTileEdge * floats;
            for (int y = 0; y < kTileEdge; ++y, row += shaded.rowStride())
                std::copy_n(out.data() + y * kTileEdge * floats, kTileEdge * floats, row);
        }
        shaded.finishRow(p, ty);
    });
    ShadeWork sum;
    for (const ShadeWork& w : work) sum += w;
    return sum;
}

// ZC02 Fig. 5, line 3: what falls on opaque pixels alone need not be splatted for the eye. (For lights it must: hidden
// voxels still cast shadows.) Normals look a little around a pixel, hence the guard.
TileCull occlusionMap(const ImageTiles& tiles, int guardTiles) {
    return [&tiles, guardTiles](int tx0, int ty0, int tx1, int ty1) {
        for (int ty = std::max(0, ty0 - 2 * guardTiles); ty <= std::min(tiles.tilesY() - 1, ty1); ++ty)
            for (int tx = std::max(0, tx0 - 2 * guardTiles); tx <= std::min(tiles.tilesX() - 1, tx1); ++tx)
                if (!tiles.opaque(ty * tiles.tilesX() + tx)) return false;
        return true;
    };
}

}  // namespace

void runSweep(const ViewScene& scene, const Camera& camera, const Plan& plan, const GroupPlan& group, ImageTiles& tiles,
              RenderWork& work, StageTimes& times, const SweepProgress& progress) {
    Stopwatch watch;
    const Sheets& sheets = group.sheets;
    const EyeView eye(camera, sheets, plan.simd);
    BatchFields fields(scene, plan.extinction, sheets, plan.perView ? group.eyeRaster : sharedRaster(sheets),
                       group.batchSheets, plan.voxel, sheetsForEye(group));
    BatchLights lights(scene, plan, group);
    const SheetShader shader(scene, plan, group, fields, lights, eye);
    EyeWalk walk(eye, tiles, group.sameSide, static_cast<float>(scene.dials.opacityCutoff));
    std::optional<PlaneStack> shaded;
    if (!plan.shadeAtPixels) shaded.emplace(group.batchSheets, sheets.width, sheets.height, group.layout.floats());
    const TileCull cull = plan.perView && group.sameSide ? occlusionMap(tiles, group.guardTiles) : TileCull{};
    work.voxelsFed += fields.voxels();
    times.prepare += watch.lap();

    // Rasters of views hold what they need and no more.
    const NeededTiles* needed = plan.perView ? nullptr : &group.needed;
    for (int first = group.needed.first; first < group.needed.last; first += group.batchSheets) {
        const int count = std::min(group.batchSheets, group.needed.last - first);
        work.sheets += static_cast<std::uint64_t>(count);
        work.footprints += fields.splat(first, count, needed, cull).footprints;
        times.splat += watch.lap();

        const BatchLights::Work light = lights.attenuate(first, count, fields);
        work.lightSamples += light.samples;
        work.footprints += light.footprints;
        times.attenuate += watch.lap();

        EyeWalk::Work seen;
        if (shaded) {
            const ShadeWork texels = shadeBatch(shader, eye, tiles, fields.covered(), first, count, *shaded);
            work.shade += texels;
            work.texelsShaded += texels.samples;
            times.shade += watch.lap();
            seen = walk.throughTexels(first, count, *shaded);
        } else {
            seen = plan.perView ? walk.throughCells(first, count, fields.covered(), group.guardTiles, shader)
                                : walk.throughPixels(first, count, fields.covered(), shader);
        }
        work.shade += seen.shade;
        work.pixelSheets += seen.pixelSheets;
        work.layerSamples += seen.pixelSheets * static_cast<std::uint64_t>(group.layout.quads() - 1);
        times.composite += watch.lap();

        progress(double(first + count - group.needed.first) / (group.needed.last - group.needed.first));
        // Front to back, once nothing is open to the eye, the lights' further way is of no interest either.
        if (group.sameSide && walk.allOpaque()) break;
    }
    RenderWork::Bytes bytes{fields.bytes(), lights.bytes(), 0, tiles.bytes()};
    if (shaded) bytes.shaded = PlaneStack::bytes(group.batchSheets, sheets.width, sheets.height, group.layout.floats());
    if (bytes.total() > work.bytes.total()) work.bytes = bytes;
}

}  // namespace scrim
