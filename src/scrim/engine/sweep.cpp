// SPDX-License-Identifier: Apache-2.0
// The algorithm on one page (ZC02 Fig. 5): sheets are swept batch by batch, away from the lights.
// Each stage runs in parallel; the end of a stage is the only barrier.
#include <scrim/engine/sweep.h>

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/engine/balls/ball_sheets.h>
#include <scrim/engine/composite/compositor.h>
#include <scrim/engine/level_sweep.h>
#include <scrim/engine/light/backdrop.h>
#include <scrim/engine/plan/transport_plan.h>
#include <scrim/engine/light/solid_shadow.h>
#include <scrim/engine/shade/sheet_shader.h>

#include <algorithm>
#include <chrono>
#include <memory>
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
ShadeWork shadeBatch(const SheetShader& shader, const EyeView& eye, const PixelTiles& tiles, const PlaneStack& covered,
                     int firstSheet, int count, PlaneStack& shaded) {
    const int tilesY = shaded.tilesY();
    const int floats = shaded.channels();
    for (int p = 0; p < count; ++p) shaded.begin(p);
    std::vector<ShadeWork> work(std::size_t(count) * tilesY);
    parallelFor(work.size(), [&](std::size_t task) {
        const int p = static_cast<int>(task) / tilesY, ty = static_cast<int>(task) % tilesY;
        const int sheet = firstSheet + p;
        std::vector<Real> out(std::size_t(floats) * kTileSize);
        covered.forActive(p, ty, [&](int tx) {
            const auto seen = eye.seenBy(texelsAround({tx, ty, tx + 1, ty + 1}), sheet + 0.5);
            if (seen && !tiles.anyOpen(*seen)) return;
            work[task] += shader.shadeTexels(p, sheet, tx, ty, out.data());
            shaded.replace(p, tx, ty);
            Real* row = shaded.tile(p, tx, ty);
            for (int y = 0; y < kTileEdge; ++y, row += shaded.rowStride())
                std::copy_n(out.data() + y * kTileEdge * floats, kTileEdge * floats, row);
        });
        shaded.finishRow(p, ty);
    });
    ShadeWork sum;
    for (const ShadeWork& w : work) sum += w;
    return sum;
}

// ZC02 Fig. 5, line 3: voxels that project to opaque pixels only need not be splatted for the eye.
// (They must be splatted for lights, since hidden voxels still cast shadows.) Normals use a
// neighbourhood of a pixel, hence the guard.
TileCull occlusionMap(const PixelTiles& tiles, int guardTiles) {
    return [&tiles, guard = 2 * guardTiles](const Box2<int>& box) {
        return !tiles.anyOpen(Box2<int>{box.x0 - guard, box.y0 - guard, box.x1, box.y1});
    };
}

// Distant lights and pixels ask surfaces themselves. A light within a volume begins with the extinction of a texel.
bool onlyRaysLook(const GroupPlan& group) {
    return group.lattice.shared() && std::all_of(group.lights.begin(), group.lights.end(),
                                                 [](const PlannedLight& light) { return light.view.distant; });
}

struct Swept {
    PixelTiles tiles;
    RenderWork work;
    StageTimes times;
    std::optional<DeepImage> deep;
};

// Null if nothing hides volumes.
std::unique_ptr<EyeEnds> eyeEnds(const ViewScene& scene, const EyePart& part) {
    if (!EyeEnds::any(scene)) return nullptr;
    return std::make_unique<EyeEnds>(scene, PixelTiles(supersampled(part.window, scene.dials.antialias)));
}

// Null if no deep picture is requested.
std::unique_ptr<DeepRays> deepRays(const ViewScene& scene, const GroupPlan& group, const PixelTiles& tiles,
                                   std::size_t mostBytes) {
    if (!scene.deep) return nullptr;
    return std::make_unique<DeepRays>(tiles, group.sameSide, scene.deep->tolerance, mostBytes);
}

void keepDeep(DeepRays& deep, const EyeView& eye, int n, Swept& swept) {
    swept.work.deepSamples = deep.added();
    swept.work.bytes.deep = deep.bytes();
    swept.deep = deep.resolve(eye, n);
}

// The texels that are shaded; none where pixels' rays are.
std::optional<PlaneStack> shadedTexels(const Plan& plan, const GroupPlan& group) {
    if (plan.shadeAtPixels) return std::nullopt;
    return PlaneStack(group.batchSheets, group.sheets.width, group.sheets.height, group.outputs.layout.floats());
}

// Null if the eye sees none.
std::unique_ptr<BallSheets> ballSheets(const ViewScene& scene, const Plan& plan, const LevelSheets& sheets,
                                       const EyeView& eye, const PixelWindow& region,
                                       const std::vector<CellLight>& cellLight) {
    if (!seesBalls(scene, plan)) return nullptr;
    return std::make_unique<BallSheets>(scene, plan, sheets, eye, region, cellLight);
}

Swept sweep(const ViewScene& scene, const Plan& plan, const GroupPlan& group, const EyeEnds* ends,
            const std::vector<CellLight>& cellLight, std::size_t mostDeepBytes,
            const std::function<void(double, const PixelTiles&)>& progress) {
    Stopwatch watch;
    const int n = scene.dials.antialias;
    const OutputLayout& layout = group.outputs.layout;
    Swept swept{
        PixelTiles(supersampled(plan.eyeParts[group.eyePart].window, n), layout, layout.depth.has_value()), {}, {}, {}};
    auto& [tiles, work, times, deepImage] = swept;
    const EyeView eye(supersampled(scene.camera, n), group.sheets, plan.simd);
    LevelSheets sheets(scene, plan, group);
    ExtinctionSum& extinction = sheets.extinction;
    LightSweep& lights = sheets.lights;
    if (onlyRaysLook(group)) extinction.leaveOutTexels();
    const SheetShader shader(scene, plan, sheets, eye, cellLight);
    const auto deep = deepRays(scene, group, tiles, mostDeepBytes);
    const auto balls = ballSheets(scene, plan, sheets, eye, tiles.region(), cellLight);
    Compositor compositor(eye, tiles, group.sameSide, static_cast<Real>(scene.dials.opacityCutoff), ends, deep.get(),
                          {}, balls.get());
    std::optional<PlaneStack> shaded = shadedTexels(plan, group);
    // The eye's own lattice contains only what it needs; tiles of the shared lattice are culled beforehand.
    const bool own = !group.lattice.shared();
    const TileCull cull = own && group.sameSide ? occlusionMap(tiles, group.lattice.guardTiles) : TileCull{};
    work.voxelsFed = extinction.voxels();
    times.prepare = watch.lap();
    for (int first = group.needed.first; first < group.needed.last; first += group.batchSheets) {
        const int count = std::min(group.batchSheets, group.needed.last - first);
        work.sheets += static_cast<std::uint64_t>(count);
        // Stages 1 and 2: splat voxels into sheets and classify them as extinction.
        work.footprints += extinction.splat(first, count, own ? nullptr : &group.needed, cull);
        times.splat += watch.lap();
        // Stage 3: attenuate light through the sheets.
        work += lights.attenuate(first, count, extinction);
        times.attenuate += watch.lap();
        // Stages 4 and 5: shade and composite the sheets, at texels or where pixels' rays meet them.
        if (balls) work.shade += balls->enter(first, count);
        RenderWork seen;
        if (shaded) {
            const ShadeWork texels = shadeBatch(shader, eye, tiles, extinction.seen(0), first, count, *shaded);
            work.shade += texels;
            work.texelsShaded += texels.samples;
            times.shade += watch.lap();
            seen = compositor.throughTexels(first, count, *shaded);
        } else {
            seen = own ? compositor.throughCells(first, count, extinction.seen(0), group.lattice.guardTiles, shader)
                       : compositor.throughPixels(first, count, extinction.seen(0), shader);
        }
        work += seen;
        work.layerSamples += seen.pixelSheets * static_cast<std::uint64_t>(layout.quads() - 1);
        times.composite += watch.lap();
        progress(double(first + count - group.needed.first) / (group.needed.last - group.needed.first), tiles);
        // Front to back, once no pixel is open, the rest of the lights' path does not matter either.
        if (group.sameSide && compositor.allOpaque()) break;
    }
    work.solidRays = lights.solidRays();
    work.bytes = {extinction.bytes(), lights.bytes(), shaded ? shaded->bytes() : 0,
                  tiles.bytes() + (ends ? ends->bytes() : 0) + (balls ? balls->bytes() : 0)};
    if (deep) keepDeep(*deep, eye, n, swept);
    return swept;
}

// The sweep of a group whose volumes have sheets of several levels.
Swept sweepOfLevels(const ViewScene& scene, const Plan& plan, const GroupPlan& group, const EyeEnds* ends,
                    const std::vector<CellLight>& cellLight, std::size_t mostDeepBytes,
                    const std::function<void(double, const PixelTiles&)>& progress) {
    Stopwatch watch;
    const OutputLayout& layout = group.outputs.layout;
    const int n = scene.dials.antialias;
    const PixelWindow window = supersampled(plan.eyeParts[group.eyePart].window, n);
    Swept swept{PixelTiles(window, layout, layout.depth.has_value()), {}, {}, {}};
    const auto deep = deepRays(scene, group, swept.tiles, mostDeepBytes);
    swept.work = sweepLevels(scene, plan, group, cellLight, {swept.tiles, ends, deep.get()},
                             [&](double done) { progress(done, swept.tiles); });
    if (deep) keepDeep(*deep, EyeView(supersampled(scene.camera, n), group.sheets, plan.simd), n, swept);
    swept.times.composite = watch.lap();
    return swept;
}

// The rest of the memory limit beside the deep pictures of earlier sweeps; 0: no limit.
std::size_t deepBytesLeft(const Plan& plan, const std::vector<DeepImage>& swept) {
    std::size_t taken = 0;
    for (const DeepImage& image : swept) taken += image.bytes();
    if (plan.mostDeepBytes == 0) return 0;
    return plan.mostDeepBytes > taken ? plan.mostDeepBytes - taken : 1;
}

Frame renderHere(const ViewScene& scene, const Plan& plan, const ProgressSink& progress, const PictureSink& shown,
                 const KeptLight* kept) {
    Frame frame = emptyFrame(scene);
    const auto goOn = [&](double done) {
        if (progress && !progress(done)) throw Error(ErrorKind::interrupted, "the render was interrupted");
    };
    std::unique_ptr<const BackdropRays> backdrop;
    if (hasBackdrop(scene))
        backdrop = std::make_unique<const BackdropRays>(scene, planForBackdrop(scene), [&] { goOn(0); });
    if (backdrop) beginBackdrop(*backdrop, frame);
    const auto add = [&](const GroupPlan& group, const PixelTiles& tiles, Frame& to) {
        resolve(scene, plan, group, tiles, to);
        if (backdrop) takeFromBackdrop(plan, group, tiles, *backdrop, to);
    };
    const auto show = [&](const GroupPlan& group, const PixelTiles& tiles) {
        const auto soFar = [&] {
            Frame now = frame;
            add(group, tiles, now);
            if (backdrop) finishBackdrop(now);
            return std::move(now.image);
        };
        if (shown) shown(soFar);
    };
    KeptLight own;
    if (!kept) {
        own = keepLight(scene, plan, progress);
        account(own, frame);
    }
    const std::vector<CellLight>& cellLight = (kept ? *kept : own).light;
    std::vector<DeepImage> deep;
    std::unique_ptr<EyeEnds> ends;  // shared by all sweeps of a part of the eye, which follow one another
    for (std::size_t g = 0; g < plan.groups.size(); ++g) {
        const std::size_t part = plan.groups[g].eyePart;
        if (g == 0 || part != plan.groups[g - 1].eyePart) {
            ends = eyeEnds(scene, plan.eyeParts[part]);
            if (ends) frame.work.solidRays += ends->rays();
        }
        const GroupPlan& group = plan.groups[g];
        const auto goesOn = [&](double done, const PixelTiles& tiles) {
            goOn((double(g) + done) / double(plan.groups.size()));
            show(group, tiles);
        };
        Swept swept = group.finer.empty()
                          ? sweep(scene, plan, group, ends.get(), cellLight, deepBytesLeft(plan, deep), goesOn)
                          : sweepOfLevels(scene, plan, group, ends.get(), cellLight, deepBytesLeft(plan, deep), goesOn);
        add(group, swept.tiles, frame);
        frame.work += swept.work;
        frame.times += swept.times;
        if (swept.deep) deep.push_back(std::move(*swept.deep));
    }
    finishLayers(frame);
    if (backdrop) finishBackdrop(frame);
    if (scene.deep) frame.deep = combined(scene, plan, deep);
    frame.work.caughtRays = catchShadows(scene, frame, [&] { goOn(1); });
    return frame;
}

}  // namespace

Frame render(const ViewScene& scene, const Plan& plan, const ProgressSink& progress, const PictureSink& shown,
             const KeptLight* kept) {
    Frame frame;
    TaskArena(plan.threads).run([&] { frame = renderHere(scene, plan, progress, shown, kept); });
    return frame;
}

}  // namespace scrim
