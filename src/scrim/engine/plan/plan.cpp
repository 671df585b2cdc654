// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/plan/plan.h>

#include <scrim/base/error.h>
#include <scrim/engine/light/view_shadow.h>
#include <scrim/engine/plan/addressable.h>
#include <scrim/engine/splat/extinction_sum.h>
#include <scrim/engine/composite/eye_rays.h>
#include <scrim/engine/plan/light_raster.h>
#include <scrim/engine/plan/light_use.h>
#include <scrim/engine/plan/shading_place.h>
#include <scrim/engine/plan/rasters.h>
#include <scrim/engine/splat/field_planes.h>
#include <scrim/engine/splat/plane_stack.h>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace scrim {
namespace {

// Buffers of a batch should stay near the caches: more only pays with more threads.
constexpr std::size_t kComfortableBytes = std::size_t{64} << 20;
constexpr int kLeastBatch = 16;

// Image-aligned sheets may be crossed at any slant (ZC02 Fig. 17); beyond this one thinner sheets no longer help.
// Radians.
constexpr double kSteepestSlant = 1.0472;  // 60 degrees

int roundUpToTile(int texels) {
    return (texels + kTileEdge - 1) / kTileEdge * kTileEdge;
}

// The stack of sheets around the volume. Planes lie at whole multiples of the thickness, texels at whole
// multiples of their size, from the middle of the volume: nothing hangs on where the camera stands.
Sheets sheetsAround(const ViewScene& scene, const std::vector<Vec3>& corners, const LightGroup& group, double voxel) {
    Bounds ws;
    for (const Vec3& corner : corners) ws.include(corner);

    Sheets sheets;
    sheets.wsAnchor = ws.center();
    sheets.ssFromWs = sweepRotation(group.wsAxis, scene.camera.wsFromCamera[1]);
    sheets.texel = scene.dials.texel * voxel;
    sheets.thickness = scene.dials.sheetThickness * voxel * std::cos(std::min(group.slant, kSteepestSlant));

    Bounds ts;  // with the origin at the anchor
    for (const Vec3& corner : corners) ts.include(sheets.tsPoint(corner));
    // Two texels of zeros around, so that bilinear look-ups that leave the raster find nothing there, and behind them
    // room for the rounded-up rows of footprints.
    const double left = std::floor(ts.lower.x) - 2, top = std::floor(ts.lower.y) - 2;
    const double front = std::floor(ts.lower.z);
    sheets.ssOrigin = Vec3(left * sheets.texel, top * sheets.texel, front * sheets.thickness);
    sheets.width = roundUpToTile(addressable(ts.upper.x - left + 8, "texels along the side of a sheet"));
    sheets.height = roundUpToTile(addressable(ts.upper.y - top + 8, "texels along the side of a sheet"));
    sheets.count = std::max(1, addressable(ts.upper.z - front, "sheets"));
    return sheets;
}

std::size_t groupBytes(const ViewScene& scene, const Plan& plan, const GroupPlan& group, int batch) {
    const Sheets& s = group.sheets;
    const ViewRaster raster = plan.perView ? group.eyeRaster : sharedRaster(s);
    std::size_t bytes = BatchFields::bytes(scene, plan.extinction, s, raster, batch, sheetsForEye(group)) +
                        (plan.shadeAtPixels ? 0 : PlaneStack::bytes(batch, s.width, s.height, group.layout.floats()));
    const auto rows = static_cast<std::size_t>(plan.extinction.count());
    for (const LightPlan& light : group.lights)
        if (light.shadowed && plan.perView)
            bytes += rows * ViewShadow::bytes(light.raster, batch) +
                     BatchFields::bytes(scene, plan.extinction, s, light.raster, batch, SheetsFor::light);
        else if (light.shadowed)
            bytes += rows * ShadowBuffer::bytes(light.view, s, batch);
    return bytes;
}

// Sheets a batch: enough for every thread to have some, few enough to stay in memory.
void chooseBatch(const ViewScene& scene, int threads, std::size_t frameBytes, const Plan& plan, GroupPlan& group) {
    const auto bytesFor = [&](int batch) { return groupBytes(scene, plan, group, batch); };
    const int wanted = std::min(group.sheets.count, std::max(kLeastBatch, 8 * threads));
    const std::size_t budget = std::min(
        kComfortableBytes,
        scene.memoryLimit == 0 ? kComfortableBytes : scene.memoryLimit - std::min(scene.memoryLimit, frameBytes));
    group.batchSheets = wanted;
    while (group.batchSheets > 1 && bytesFor(group.batchSheets) > budget) --group.batchSheets;
    group.bytes = bytesFor(group.batchSheets);
    if (scene.memoryLimit != 0 && group.bytes + frameBytes > scene.memoryLimit)
        throw Error(ErrorKind::memory,
                    fmt::format("one sheet at a time needs {} of buffers and {} for the picture, more than the {} that "
                                "the memory limit leaves",
                                bytesText(group.bytes), bytesText(frameBytes), bytesText(scene.memoryLimit)));
}

void estimateWork(const ViewScene& scene, Plan& plan) {
    double voxels = 0;
    for (const ViewVolume& volume : scene.volumes) {
        voxels += static_cast<double>(volume.field->activeVoxels);
        for (const ViewField& scatter : volume.scatter) voxels += static_cast<double>(scatter.field->activeVoxels);
        for (const ViewEmission& e : volume.emission) voxels += static_cast<double>(e.field.field->activeVoxels);
    }
    const double pixels = double(plan.region.width()) * plan.region.height();
    for (const GroupPlan& group : plan.groups) {
        const double share = group.needed.share(group.sheets);
        const double texels = share * group.sheets.width * group.sheets.height * group.sheets.count;
        // A voxel reaches all sheets within its kernel's extent: about one and its own width.
        const double reach = 1 + 2 * kernelRadius(scene.dials.kernel) * plan.voxel / group.sheets.thickness;
        plan.work.footprints += share * voxels * reach;
        plan.work.texels += texels;
        plan.work.pixelSheets += pixels * (group.needed.last - group.needed.first);
        for (const LightPlan& light : group.lights)
            if (light.shadowed)
                plan.work.lightSamples +=
                    plan.extinction.count() * texels / (scene.dials.shadowTexel * scene.dials.shadowTexel);
    }
}

bool wants(const ViewScene& scene, Layer layer) {
    return std::find(scene.layers.begin(), scene.layers.end(), layer) != scene.layers.end();
}

// Which pictures a group composites: what it has no part in costs nothing.
void choosePictures(const ViewScene& scene, const Plan& plan, GroupPlan& group) {
    const auto add = [&](Layer layer, int light = -1) {
        group.pictures.push_back({layer, light});
        return static_cast<int>(group.pictures.size());
    };
    const bool primary = group.primary > 0;
    if (wants(scene, Layer::light))
        for (LightPlan& light : group.lights) {
            const auto known = std::find_if(group.pictures.begin(), group.pictures.end(),
                                            [&](const PicturePlan& p) { return p.light == light.light; });
            light.picture = known == group.pictures.end() ? add(Layer::light, light.light)
                                                          : static_cast<int>(known - group.pictures.begin()) + 1;
        }
    if (primary && wants(scene, Layer::ambient) && scene.ambient != Rgb(0)) group.targets.ambient = add(Layer::ambient);
    if (primary && wants(scene, Layer::emission)) group.targets.emission = add(Layer::emission);
    group.targets.addends = static_cast<int>(group.pictures.size()) + 1;
    if (primary && wants(scene, Layer::albedo)) group.targets.albedo = add(Layer::albedo);
    if (primary && wants(scene, Layer::depth)) group.targets.depth = add(Layer::depth);
    group.layout.pictures = static_cast<int>(group.pictures.size()) + 1;
    group.layout.coloured = plan.extinction.coloured;
    // What consists of pictures that are there anyway needs none of its own.
    const bool emits = std::any_of(scene.volumes.begin(), scene.volumes.end(),
                                   [](const ViewVolume& volume) { return !volume.emission.empty(); });
    const bool ambientLeft = primary && scene.ambient != Rgb(0) && group.targets.ambient == 0;
    const bool emissionLeft = primary && emits && group.targets.emission == 0;
    const bool lightsLeft = !group.lights.empty() && !wants(scene, Layer::light);
    group.layout.beauty = group.targets.addends == 1 || ambientLeft || emissionLeft || lightsLeft;
    constexpr int kMostPictures = 250;
    if (group.layout.pictures > kMostPictures)
        throw Error(ErrorKind::usage, fmt::format("{} layers are asked for; at most {} can be rendered at once",
                                                  group.layout.pictures - 1, kMostPictures - 1));
}

std::vector<const Light*> shadowedLights(const ViewScene& scene, const GroupPlan& group) {
    std::vector<const Light*> shadowed;
    for (const LightPlan& light : group.lights)
        if (light.shadowed) shadowed.push_back(&scene.lights[static_cast<std::size_t>(light.light)]);
    return shadowed;
}

// What the plan itself takes, which is little unless there are very many sheets.
void checkPlanFits(const ViewScene& scene, const Plan& plan, int sheets) {
    std::size_t count = static_cast<std::size_t>(sheets);
    for (const GroupPlan& group : plan.groups) count += group.needed.sheets.size();
    const std::size_t bytes = count * sizeof(PlaneStack::TileBounds);
    if (scene.memoryLimit != 0 && bytes > scene.memoryLimit)
        throw Error(ErrorKind::memory,
                    fmt::format("planning {} sheets takes {}, more than the {} that the memory limit leaves", count,
                                bytesText(bytes), bytesText(scene.memoryLimit)));
}

GroupPlan planGroup(const ViewScene& scene, const std::vector<Vec3>& corners, const Plan& plan, const EyePart& part,
                    LightGroup& group, const Checkpoint& checkpoint) {
    GroupPlan g;
    g.eyePart = plan.eyeParts.size();
    g.primary = group.primary;
    g.sameSide = group.sameSide;
    g.slant = group.slant;
    g.sheets = sheetsAround(scene, corners, group, plan.voxel);
    for (LightPart& light : group.parts) {
        checkpoint();
        g.lights.push_back(planLight(scene, corners, g.sheets, group.slant, std::move(light)));
    }
    choosePictures(scene, plan, g);
    checkPlanFits(scene, plan, g.sheets.count);
    g.needed = neededTiles(scene, part.window, g.sheets, shadowedLights(scene, g), checkpoint);
    if (plan.perView) {
        const int n = scene.dials.antialias;
        const Camera camera = supersampled(scene.camera, n);
        g.guardTiles = guardTiles(scene, camera, g.sheets);
        g.eyeRaster = EyeView(camera, g.sheets).raster(supersampled(part.window, n), g.guardTiles);
    }
    return g;
}

// Where one sheet at a time, with the shadow buffers of all of a group's lights, is more than the limit leaves, the
// lights take turns: the sweep is repeated for a part of them at a time, along the same axis.
void splitIntoPasses(const ViewScene& scene, std::size_t frameBytes, Plan& plan) {
    if (scene.memoryLimit == 0) return;
    const auto fits = [&](const GroupPlan& group) {
        return groupBytes(scene, plan, group, 1) + frameBytes <= scene.memoryLimit;
    };
    std::vector<GroupPlan> all;
    for (GroupPlan& group : plan.groups) {
        std::vector<GroupPlan> passes;
        std::vector<GroupPlan> open{std::move(group)};  // the first lights last
        while (!open.empty()) {
            GroupPlan one = std::move(open.back());
            open.pop_back();
            if (one.lights.size() < 2 || fits(one)) {
                passes.push_back(std::move(one));
                continue;
            }
            const auto middle = one.lights.begin() + static_cast<std::ptrdiff_t>(one.lights.size() / 2);
            GroupPlan rest = one;
            rest.lights.assign(std::make_move_iterator(middle), std::make_move_iterator(one.lights.end()));
            rest.primary = 0;
            one.lights.erase(middle, one.lights.end());
            for (GroupPlan* half : {&rest, &one}) {
                half->pictures.clear();
                half->targets = {};
                half->layout = {};
                choosePictures(scene, plan, *half);
                open.push_back(std::move(*half));
            }
        }
        for (std::size_t i = 0; i < passes.size(); ++i) {
            passes[i].pass = static_cast<int>(i) + 1;
            passes[i].passes = static_cast<int>(passes.size());
            all.push_back(std::move(passes[i]));
        }
    }
    plan.groups = std::move(all);
}

}  // namespace

Plan makePlan(const ViewScene& scene, int threads, const ProgressSink& progress) {
    const Checkpoint checkpoint = [&] {
        if (progress && !progress(0)) throw Error(ErrorKind::interrupted, "the planning was interrupted");
    };
    Plan plan;
    plan.threads = threads;
    plan.simd = Simd(scene.dials.simd);
    plan.voxel = voxelUnit(scene);
    plan.region = supersampled(scene.region, scene.dials.antialias);
    plan.perView = scene.dials.splat == SplatMode::perView;
    plan.extinction = extinctionRows(scene);
    const std::vector<Vec3> corners = wsCorners(scene);
    if (corners.empty()) return plan;
    plan.uselessLights = uselessLights(scene);
    for (const Light& light : scene.lights)
        if (light.slide && !light.slide->image)
            throw Error(ErrorKind::usage,
                        fmt::format("the slide '{}' of light '{}' is not loaded", light.slide->file, light.name));

    for (EyePart& part : eyeParts(scene, corners)) {
        part.window = intersection(part.window, scene.region);
        if (part.window.empty()) continue;
        for (LightGroup& group : groupLights(scene, corners, part, plan.uselessLights, checkpoint))
            plan.groups.push_back(planGroup(scene, corners, plan, part, group, checkpoint));
        plan.eyeParts.push_back(std::move(part));
    }
    const ShadingPlace place = shadingPlace(scene, plan);
    plan.shadeAtPixels = place.atPixels;
    plan.shadeReason = place.reason;

    const std::size_t pixels = static_cast<std::size_t>(roundUpToTile(plan.region.width())) *
                               static_cast<std::size_t>(roundUpToTile(plan.region.height()));
    std::size_t floats = 4;
    for (const GroupPlan& group : plan.groups)
        floats = std::max(floats, static_cast<std::size_t>(group.layout.floats() + (group.targets.depth > 0 ? 1 : 0)));
    const std::size_t layers =
        scene.layers.size() + (wants(scene, Layer::light) ? scene.lights.size() : std::size_t{0});
    const std::size_t frameBytes =
        pixels * floats * sizeof(float) + static_cast<std::size_t>(scene.region.width()) *
                                              static_cast<std::size_t>(scene.region.height()) * (4 + 3 * layers) *
                                              sizeof(float);
    plan.bytes = frameBytes;
    splitIntoPasses(scene, frameBytes, plan);
    for (GroupPlan& group : plan.groups) {
        chooseBatch(scene, threads, frameBytes, plan, group);
        plan.bytes = std::max(plan.bytes, frameBytes + group.bytes);
    }
    estimateWork(scene, plan);
    return plan;
}

}  // namespace scrim
