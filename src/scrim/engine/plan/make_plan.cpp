// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/plan/make_plan.h>

#include <scrim/base/error.h>
#include <scrim/engine/balls/ball_sheets.h>
#include <scrim/engine/composite/pixel_tiles.h>
#include <scrim/engine/composite/deep_rays.h>
#include <scrim/engine/light/backdrop.h>
#include <scrim/engine/light/light_sweep.h>
#include <scrim/engine/model/sub_lights.h>
#include <scrim/scene/light_at.h>
#include <scrim/scene/slide_map.h>
#include <scrim/engine/plan/culling.h>
#include <scrim/engine/plan/expected_cost.h>
#include <scrim/engine/plan/flat_voxels.h>
#include <scrim/engine/plan/levels.h>
#include <scrim/engine/plan/light_groups.h>
#include <scrim/engine/plan/sheet_stack.h>
#include <scrim/engine/plan/view_lattices.h>
#include <scrim/engine/plan/transport_plan.h>
#include <scrim/engine/shade/level_sheets.h>
#include <scrim/engine/splat/extinction_sum.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <tuple>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

// The buffers of a batch should stay close to the caches. Larger ones only pay with more threads.
constexpr std::size_t kComfortableBytes = std::size_t{64} << 20, kForThread = kComfortableBytes / 2;
constexpr int kLeastBatch = 16;

std::size_t groupBytes(const ViewScene& scene, const Plan& plan, const GroupPlan& group, int batch) {
    const Sheets& s = group.sheets;
    std::size_t bytes =
        ExtinctionSum::bytes(scene, plan, s, group.lattice, batch, ExtinctionSum::eyeOf(group), group.volumes);
    bytes += BallSheets::bytes(scene, plan, group.outputs.layout);
    if (!plan.shadeAtPixels) bytes += PlaneStack::bytes(batch, s.width, s.height, group.outputs.layout.floats());
    for (const PlannedLight& light : group.lights) {
        if (!light.shadowed) continue;
        bytes += plan.extinction.count() * LightSweep::shadowBytes(scene, light, s, batch) +
                 (scene.solids ? SolidShadow::bytes(light.view, LightSweep::solidDetail(scene, plan, group)) : 0);
        if (!light.lattice.shared())
            bytes += ExtinctionSum::bytes(scene, plan, s, light.lattice, batch, ExtinctionSum::For::light);
    }
    return bytes;
}

// Chooses the number of sheets in a batch: enough to occupy every thread, few enough to stay in memory.
void chooseBatch(const ViewScene& scene, int threads, std::size_t frameBytes, const Plan& plan, GroupPlan& group) {
    const auto bytesFor = [&](int batch) { return groupBytes(scene, plan, group, batch); };
    const int wanted = std::min(group.sheets.count, std::max(kLeastBatch, 8 * threads));
    // If memory is short, a deep picture gets at least half of what the flat one leaves.
    const std::size_t left = scene.memoryLimit - std::min(scene.memoryLimit, frameBytes);
    const std::size_t comfortable = std::max(kComfortableBytes, std::size_t(threads) * kForThread);
    const std::size_t budget =
        scene.memoryLimit == 0 ? comfortable : std::min(comfortable, scene.deep ? left / 2 : left);
    // Memory grows with the batch. The largest that fits is at least batchSheets and less than tooMany.
    group.batchSheets = bytesFor(wanted) <= budget ? wanted : 1;
    for (int tooMany = wanted; group.batchSheets + 1 < tooMany;) {
        const int middle = (group.batchSheets + tooMany) / 2;
        (bytesFor(middle) <= budget ? group.batchSheets : tooMany) = middle;
    }
    group.bytes = bytesFor(group.batchSheets);
    for (GroupPlan& level : group.finer) {
        chooseBatch(scene, threads, frameBytes, plan, level);
        group.bytes += level.bytes;
    }
    if (scene.memoryLimit != 0 && group.bytes + frameBytes > scene.memoryLimit)
        throw Error(ErrorKind::memory,
                    fmt::format("one sheet at a time needs {} of buffers and {} for the picture, more than the {} that "
                                "the memory limit leaves",
                                bytesText(group.bytes), bytesText(frameBytes), bytesText(scene.memoryLimit)));
}

double voxelsOf(const ViewVolume& volume) {
    double voxels = static_cast<double>(volume.field->activeVoxels);
    for (const ViewField& scatter : volume.scatter) voxels += static_cast<double>(scatter.field->activeVoxels);
    for (const ViewEmission& e : volume.emission) voxels += static_cast<double>(e.field.field->activeVoxels);
    return voxels;
}

double pixelCount(const Camera& camera) {
    return double(camera.resolution.x) * camera.resolution.y;
}

// What the sheets of a level hold: the voxels of its volumes, the part that the boxes of these fill
// of the box around them, or of all sheets where these reach over the volumes of other levels, too,
// and the pairs of pixels and sheets that see them.
struct Held {
    double voxels = 0, filled = 0, pixelSheets = 0;

    Held(const ViewScene& scene, const GroupPlan& level) {
        Bounds all;
        double boxes = 0;
        for (std::size_t v = 0; v < scene.volumes.size(); ++v) {
            const ViewVolume& volume = scene.volumes[v];
            if ((!level.volumes.empty() && !level.volumes[v]) || volume.field->empty()) continue;
            voxels += voxelsOf(volume);
            const Bounds ts = transformed(level.sheets.tsFrom(volume.wsFromIs), volume.field->isBounds());
            boxes += volumeOf(ts);
            pixelSheets += std::min(pixelsOf(scene.camera, transformed(volume.wsFromIs, volume.field->isBounds())),
                                    pixelCount(scene.camera)) *
                           std::min(ts.size().z + 1, double(level.needed.last - level.needed.first));
            all.include(ts);
        }
        const Sheets& sheets = level.sheets;
        const double around =
            level.volumes.empty() ? volumeOf(all) : double(sheets.width) * sheets.height * sheets.count;
        if (boxes > 0) filled = std::min(boxes / around, 1.0);
    }

  private:
    static double volumeOf(const Bounds& box) {
        const Vec3 size = box.size() + 1.0;  // texels and sheets; no box is flat
        return size.x * size.y * size.z;
    }
};

void estimateWork(const ViewScene& scene, Plan& plan) {
    double footprints = 0, allTexels = 0, lightSamples = 0, pixelSheets = 0;
    const double seen = double(plan.region.pixelCount()) / pixelCount(scene.camera);
    const auto add = [&](const GroupPlan& group) {
        const Held held(scene, group);
        const double share = group.needed.share(group.sheets);
        const double texels = held.filled * share * group.sheets.width * group.sheets.height * group.sheets.count;
        // A voxel reaches all sheets within its kernel's extent: about one sheet more than its width.
        const double reach = 1 + 2 * kernelRadius(scene) * plan.voxel / group.sheets.thickness;
        footprints += share * held.voxels * reach;
        allTexels += texels;
        pixelSheets += seen * held.pixelSheets;
        for (const PlannedLight& light : group.lights)
            if (light.shadowed)
                lightSamples += plan.extinction.count() * texels / (scene.dials.shadowTexel * scene.dials.shadowTexel);
    };
    for (const GroupPlan& group : plan.groups) group.forLevels(add);
    const auto counted = [](double count) { return static_cast<std::uint64_t>(std::min(count, 1e18)); };
    plan.work.footprints = counted(footprints);
    plan.work.texelsShaded = counted(allTexels);
    plan.work.lightSamples = counted(lightSamples);
    plan.work.pixelSheets = counted(pixelSheets);
}

SweepOutputs outputsOf(const ViewScene& scene, const Plan& plan, const GroupPlan& group) {
    std::vector<int> owners;
    const auto layerOf = [&](int light) { return plan.layersOfLights[std::size_t(light)]; };
    for (const PlannedLight& light : group.lights) owners.push_back(layerOf(plan.subLights.ownerOf(light.light)));
    std::vector<int> onCells = plan.lightsOnCells();
    std::transform(onCells.begin(), onCells.end(), onCells.begin(), layerOf);
    return chooseOutputs(scene, plan.extinction.coloured, group.primary > 0, owners, onCells);
}

std::vector<const Light*> shadowedLights(const Plan& plan, const GroupPlan& group) {
    std::vector<const Light*> shadowed;
    for (const PlannedLight& light : group.lights)
        if (light.shadowed) shadowed.push_back(&plan.subLights.of(light.light));
    return shadowed;
}

// Plans the memory of a deep picture: what its samples may need at most, and the limit that they get. Samples are
// turned into curves of about their size, so they may take half of what the memory limit leaves.
void planDeep(const ViewScene& scene, Plan& plan) {
    if (!scene.deep) return;
    double bytes = 0;
    const int n = scene.dials.antialias;
    for (const GroupPlan& group : plan.groups)
        bytes += double(supersampled(plan.eyeParts[group.eyePart].window, n).pixelCount()) *
                 (group.needed.last - group.needed.first) * double(DeepRays::kSampleBytes);
    if (scene.memoryLimit > 0) {
        const std::size_t left = scene.memoryLimit - std::min(scene.memoryLimit, plan.bytes);
        plan.mostDeepBytes = std::max<std::size_t>(1, left / 2);
        bytes = std::min(bytes, double(plan.mostDeepBytes));
    }
    plan.deepBytes = static_cast<std::size_t>(2 * std::min(bytes, 4e18));
    plan.bytes += plan.deepBytes;
}

// Checks the memory of the plan itself, which is small unless there are very many sheets.
void checkPlanFits(const ViewScene& scene, const Plan& plan, int sheets) {
    std::size_t count = std::size_t(sheets);
    for (const GroupPlan& group : plan.groups)
        group.forLevels([&](const GroupPlan& level) { count += level.needed.sheets.size(); });
    const std::size_t bytes = count * sizeof(Box2<int>);
    if (scene.memoryLimit != 0 && bytes > scene.memoryLimit)
        throw Error(ErrorKind::memory,
                    fmt::format("planning {} sheets needs {}, more than the {} that the memory limit leaves", count,
                                bytesText(bytes), bytesText(scene.memoryLimit)));
}

// Plans the sheets and rasters of a group, or of one level of it, whose volumes have the corners `own`.
void planSheets(const ViewScene& scene, const std::vector<Vec3>& own, const Plan& plan, const EyePart& part,
                const Checkpoint& checkpoint, GroupPlan& g) {
    for (PlannedLight& light : g.lights) {
        checkpoint();
        light = planLight(scene, plan.subLights.of(light.light), own, g.sheets, g.slant, std::move(light));
    }
    checkPlanFits(scene, plan, g.sheets.count);
    g.needed = neededTiles(scene, part.window, g.sheets, shadowedLights(plan, g), checkpoint);
    g.lattice = plan.perView ? eyeLattice(scene, part.window, g.sheets) : sharedLattice(g.sheets);
}

// A level's sheets are walked within those of the level before, which must hold them, also where
// its own volumes are out of view, and their texels too.
void holdFiner(GroupPlan& group) {
    for (std::size_t i = group.finer.size(); i-- > 0;) {
        const GroupPlan& finer = group.finer[i];
        GroupPlan& level = i == 0 ? group : group.finer[i - 1];
        if (finer.needed.last == 0) continue;
        const LevelMap map(finer.sheets, level.sheets);
        const int first = std::max(0, static_cast<int>(std::floor(map.n(finer.needed.first) + 1e-6)));
        const int last = std::min(level.sheets.count, static_cast<int>(std::ceil(map.n(finer.needed.last) - 1e-6)));
        NeededTiles& needed = level.needed;
        needed.first = needed.last == 0 ? first : std::min(needed.first, first);
        needed.last = std::max(needed.last, last);
    }
}

// Plans a group of lights that share an axis: the places of its sheets and rasters, on each of the scene's levels.
GroupPlan planGroup(const ViewScene& scene, const std::vector<VolumeLevel>& levels, const Plan& plan,
                    const EyePart& part, GroupPlan g, const Checkpoint& checkpoint) {
    const std::vector<Vec3> corners = wsCorners(scene);
    g.eyePart = plan.eyeParts.size();
    g.outputs = outputsOf(scene, plan, g);
    GroupPlan out;
    for (const VolumeLevel& level : levels) {
        GroupPlan one = g;
        const std::vector<Vec3> own = levels.size() > 1 ? wsCorners(scene, level) : corners;
        one.sheets = sheetsAround(scene, corners, g.wsAxis, g.slant, {level.voxel, edgeAcross(scene, level, g.wsAxis)});
        if (levels.size() > 1) {
            one.sheets = narrowed(one.sheets, own);
            one.volumes = level.volumes;
        }
        planSheets(scene, own, plan, part, checkpoint, one);
        if (&level == &levels.front())
            out = std::move(one);
        else
            out.finer.push_back(std::move(one));
    }
    holdFiner(out);
    return out;
}

// Splits groups that exceed the memory limit even with one sheet at a time, because of the shadow buffers of all their
// lights. Their sweep is repeated along the same axis, each time with some of the lights.
void splitIntoPasses(const ViewScene& scene, std::size_t frameBytes, Plan& plan) {
    if (scene.memoryLimit == 0) return;
    const auto fits = [&](const GroupPlan& group) {
        return groupBytes(scene, plan, group, 1) + frameBytes <= scene.memoryLimit;
    };
    std::vector<GroupPlan> all;
    for (GroupPlan& group : plan.groups) {
        std::vector<GroupPlan> passes;
        std::vector<GroupPlan> open{std::move(group)};  // the first lights are last
        while (!open.empty()) {
            GroupPlan one = std::move(open.back());
            open.pop_back();
            if (one.lights.size() < 2 || !one.finer.empty() || fits(one)) {
                passes.push_back(std::move(one));
                continue;
            }
            const auto middle = one.lights.begin() + static_cast<std::ptrdiff_t>(one.lights.size() / 2);
            GroupPlan rest = one;
            rest.lights.assign(std::make_move_iterator(middle), std::make_move_iterator(one.lights.end()));
            rest.primary = 0;
            one.lights.erase(middle, one.lights.end());
            for (GroupPlan* half : {&rest, &one}) {
                half->outputs = outputsOf(scene, plan, *half);
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

// The reason why a slide needs shading at pixels: texels blur features that are less than two texels wide. (A slide of
// noise in smoke, with pixels as large as a texel, gave errors of 5 to 7 % at texels and 1.5 % at pixels; with pixels
// four times as large, 2 % and 1.5 %.) Empty if no slide needs it.
std::string fineSlide(const ViewScene& scene, const std::vector<Light>& lights, const std::vector<std::string>& culled,
                      double texel) {
    const Vec3 center = wsBounds(scene).center();
    for (std::size_t i = 0; i < lights.size(); ++i) {
        const Light& light = lights[i];
        if (!light.slide || !culled[i].empty()) continue;
        const std::optional<double> pixel = slidePixel(light, center);
        if (pixel && *pixel < 2 * texel)
            return fmt::format(
                "a pixel of the slide of '{}' covers {:.3g} at the volume, less than two texels of {:.3g}", light.name,
                *pixel, texel);
    }
    return {};
}

// Optical depth of a sheet from which on media are shaded at pixels. A texel shows 1 - e^-tau,
// which is increasingly non-linear as tau grows, and so is the interpolation between two texels.
// (Smoke with these optical depths per voxel had these errors at texels and at pixels: 0.23: 0.5,
// 0.4 %; 0.46: 1.0, 0.7 %; 0.9: 1.9, 0.9 %; 2.3: 3.1, 1.8 %; 9: 8.2, 4.6 %, for a fifth more time.)
constexpr double kDenseSheet = 0.4;

// The reason why a dense medium needs shading at pixels; empty if no medium is that dense.
std::string denseMedium(const ViewScene& scene, const Plan& plan) {
    for (const ViewVolume& volume : scene.volumes) {
        const double tau =
            volume.field->maxValue * volume.medium.mostExtinction() * plan.groups.front().sheets.thickness;
        if (!volume.classified && tau > kDenseSheet)
            return fmt::format("volume {} reaches an optical depth of {:.2g} a sheet, more than texels resolve",
                               volume.name, tau);
    }
    return {};
}

// Rays from an eye diverge: the slant of its rays, and with it the optical depth of a sheet, changes from a texel to
// the next by about texel / distance. At a smaller distance than this, in texels, that change is no longer small.
constexpr double kNearEye = 4;

bool eyeAmong(const ViewScene& scene, double texel) {
    if (scene.camera.type != CameraType::perspective) return false;
    Bounds ws = wsBounds(scene);
    ws.lower -= kNearEye * texel;
    ws.upper += kNearEye * texel;
    return ws.contains(scene.camera.wsPosition);
}

// True if the border of a spot's cone is sharper than texels where it meets the volumes.
bool sharpCone(const ViewScene& scene, const Light& light, double texel) {
    constexpr double kTexels = 4;  // a border of half a texel left 17 % at texels, and 1 % at pixels
    if (!light.spot()) return false;
    const SpotEdges edges(*light.spot());
    const double border = std::acos(edges.outer) - std::acos(edges.inner);
    return border * wsBounds(scene).distance(light.wsPosition) < kTexels * texel;
}

// The reason why something in the scene needs shading at pixels; empty if texels serve as well.
std::string needOfPixels(const ViewScene& scene, const Plan& plan, const std::vector<std::string>& culled) {
    const double texel = plan.groups.front().sheets.texel;
    for (const ViewVolume& volume : scene.volumes)
        if (volume.classified)
            return fmt::format("volume {} is classified: surfaces are sharper than texels", volume.name);
    std::string near = plan.cellLights.lamp;
    for (const GroupPlan& group : plan.groups)
        for (const PlannedLight& light : group.lights)
            if (const Light& own = plan.subLights.of(light.light);
                near.empty() && (!light.ssWindows.empty() || sharpCone(scene, own, texel)))
                near = own.name;
    if (!near.empty()) return fmt::format("light {} is so near that its light changes between texels", near);
    if (eyeAmong(scene, texel)) return "the eye is so near that its view of a sheet changes between texels";
    if (sharpShadows(scene)) return "shadows of solids have edges that are sharper than texels";
    if (const std::string reason = fineSlide(scene, plan.subLights.lights, culled, texel); !reason.empty())
        return reason;
    return denseMedium(scene, plan);
}

// Whether light is added up at pixels of the picture or at texels of the sheets, and why (the dial `shade`).
std::pair<bool, std::string> shadingPlace(const ViewScene& scene, const Plan& plan,
                                          const std::vector<std::string>& culled) {
    if (plan.groups.empty()) return {false, ""};
    if (plan.perView) return {true, "per-view splatting always shades at pixels"};
    if (!plan.groups.front().finer.empty()) return {true, "volumes of unlike voxels have sheets of their own"};
    if (scene.dials.shade != ShadeMode::automatic) return {scene.dials.shade == ShadeMode::pixel, "the scene sets it"};
    if (const std::string need = needOfPixels(scene, plan, culled); !need.empty()) return {true, need};

    // For a thin medium both are equally exact. At texels, every texel is shaded, and every pixel reads the texels; at
    // pixels, every pixel reads extinction and shadows, and is shaded. The cost in nanoseconds per sample, measured for
    // smoke on one thread, is 5 + 4 lights at texels plus 7 for each pixel, or 6 + 4 lights at pixels.
    const Bounds ws = wsBounds(scene);
    const double distance = glm::distance(scene.camera.wsPosition, ws.center());
    const double pixel = pixelAt(scene.camera, distance) / scene.dials.antialias;
    const double across = plan.groups.front().sheets.texel / pixel, pixels = across * across;
    const std::size_t count = plan.subLights.lights.size();
    const double lights = double(count);
    const double atTexels = 5 + 4 * lights + 7 * pixels, atPixels = (6 + 4 * lights) * pixels;
    return {atPixels < atTexels,
            fmt::format("a texel is {:.2g} pixels wide and has {} light{}; a thin medium looks the same both ways",
                        across, count, count == 1 ? "" : "s")};
}

// Why a light that is not black itself has no sub-light but a black one.
const char* whyDark(const Light& light) {
    if (light.slide) return "its picture is black";
    return light.area() && light.area()->area() > 0 ? "it faces away from every volume" : "its surface has no area";
}

// For each light of the scene the reason why it is culled: that of its first sub-light, if all of them are culled.
std::vector<std::string> reasonsByOwner(const SubLights& lights, const std::vector<std::string>& reasons,
                                        const std::vector<Light>& owners) {
    std::vector<std::string> byOwner(owners.size());
    std::vector<bool> seen(owners.size(), false);
    for (std::size_t i = 0; i < reasons.size(); ++i) {
        const auto owner = std::size_t(lights.owners[i]);
        const bool dark = lights.lights[i].intensity == Rgb(0) && owners[owner].intensity != Rgb(0);
        if (!seen[owner] || reasons[i].empty()) byOwner[owner] = dark ? whyDark(owners[owner]) : reasons[i];
        seen[owner] = true;
    }
    return byOwner;
}

// For each volume the means of its phase function over what the sub-lights in its sweeps stand for,
// where some of them are wider than its lobes. Volumes of one phase function share them.
std::vector<std::shared_ptr<const PhaseOverCaps>> capsOf(const ViewScene& scene, const SubLights& lights,
                                                         const std::vector<std::string>& culled) {
    std::vector<std::shared_ptr<const PhaseOverCaps>> caps(scene.volumes.size());
    const Bounds box = wsBounds(scene);
    double widest = 0, needed = 0;
    for (std::size_t i = 0; i < lights.parts.size(); ++i) {
        if (!(lights.parts[i] > 0) || !culled[i].empty()) continue;
        const double own = widestCap(lights.lights[i], lights.parts[i], box);
        widest = std::max(widest, own);
        needed = std::max(needed, lights.lights[i].distant() ? own : kCapsOfSurfaces * own);
    }
    for (std::size_t v = 0; v < caps.size(); ++v) {
        const ViewVolume& volume = scene.volumes[v];
        if (volume.classified || volume.field->empty() || !needsCaps(volume.medium.phase, needed)) continue;
        for (std::size_t other = 0; other < v && !caps[v]; ++other)
            if (scene.volumes[other].medium.phase == volume.medium.phase) caps[v] = caps[other];
        if (!caps[v]) caps[v] = std::make_shared<const PhaseOverCaps>(volume.medium.phase, widest);
    }
    return caps;
}

// Memory of the picture itself.
std::size_t bytesOfFrame(const ViewScene& scene, const Plan& plan) {
    const PixelWindow tiles = tilesAround(plan.region);
    const std::size_t pixels =
        kTileSize * rasterArea(tiles.width() / kTileEdge, tiles.height() / kTileEdge, "tiles of 16 x 16 rays");
    constexpr std::size_t kDepthFloats = sizeof(PixelTiles::FirstDepth) / sizeof(Real);
    std::size_t floats = 4;
    for (const GroupPlan& group : plan.groups)
        floats = std::max(floats,
                          std::size_t(group.outputs.layout.floats() + (group.outputs.layout.depth ? kDepthFloats : 0)));
    return BackdropRays::bytes(scene) + pixels * (floats * sizeof(Real) + 1) +
           std::size_t(scene.region.width()) * std::size_t(scene.region.height()) * (4 + 3 * layerCount(scene)) *
               sizeof(float);
}

// Shadow buffers need no channels for lights on cells, whichever volumes cast shadows in them. The
// suns of a sky on cells have buffers.
ExtinctionChannels channelsOf(ViewScene scene, const CellLightPlan& cells) {
    for (ViewVolume& volume : scene.volumes) {
        for (std::size_t i = 0; i < volume.shadows.size(); ++i)
            if (cells.has(i) && sunsOfSky(scene, scene.lights[i]).empty()) volume.shadows[i] = true;
        if (std::count(volume.shadows.begin(), volume.shadows.end(), false) == 0) volume.shadows.clear();
    }
    return extinctionChannels(scene);
}

void checkSlides(const ViewScene& scene) {
    for (const Light& light : scene.lights) {
        std::string what = light.slide && !light.slide->image ? fmt::format("slide '{}'", light.slide->file) : "";
        if (light.luminaire && !light.luminaire->profile) what = fmt::format("luminaire '{}'", light.luminaire->file);
        if (!what.empty())
            throw Error(ErrorKind::usage, fmt::format("the {} of light '{}' is not loaded", what, light.name));
    }
}

}  // namespace

Plan makePlan(const ViewScene& scene, int threads, const ProgressSink& progress, bool oneLattice) {
    const Checkpoint checkpoint = [&] {
        if (progress && !progress(0)) throw Error(ErrorKind::interrupted, "the planning was interrupted");
    };
    Plan plan;
    plan.threads = threads;
    plan.simd = Simd(scene.dials.simd);
    plan.voxel = voxelUnit(scene);
    plan.region = supersampled(scene.region, scene.dials.antialias);
    plan.perView = scene.dials.splat == SplatMode::perView;
    const std::vector<Vec3> corners = wsCorners(scene);
    if (!corners.empty()) {
        checkSlides(scene);
        plan.cellLights = planCellLights(scene);
    }
    plan.extinction = channelsOf(scene, plan.cellLights);
    if (corners.empty()) return plan;
    const std::vector<ServedLight> served = servedLights(scene, plan.cellLights.lights);
    plan.subLights = subLights(scene, served);
    plan.transport = planTransport(scene);
    for (std::size_t i = 0; i < scene.lights.size(); ++i)
        plan.layersOfLights.push_back(lightOfLayer(scene, static_cast<int>(i)));
    const std::vector<std::string> culled = culledLights(scene, plan.subLights);
    plan.culledLights = reasonsByOwner(plan.subLights, culled, scene.lights);
    nameLightsOnCells(scene, plan.cellLights, served, plan.culledLights);
    plan.caps = capsOf(scene, plan.subLights, culled);

    const std::vector<VolumeLevel> levels = oneLattice ? oneLevel(scene) : volumeLevels(scene);
    for (EyePart& part : eyeParts(scene, corners)) {
        part.window = intersection(part.window, scene.region);
        if (part.window.empty()) continue;
        for (GroupPlan& group : groupLights(scene, plan.subLights, corners, part, culled, checkpoint))
            plan.groups.push_back(planGroup(scene, levels, plan, part, std::move(group), checkpoint));
        plan.eyeParts.push_back(std::move(part));
    }
    std::tie(plan.shadeAtPixels, plan.shadeReason) = shadingPlace(scene, plan, culled);

    const std::size_t frameBytes = bytesOfFrame(scene, plan);
    plan.bytes = frameBytes;
    splitIntoPasses(scene, frameBytes, plan);
    for (GroupPlan& group : plan.groups) {
        chooseBatch(scene, threads, frameBytes, plan, group);
        plan.bytes = std::max(plan.bytes, frameBytes + group.bytes);
    }
    plan.bytes += plan.transport.bytes + plan.cellLights.bytes;
    planDeep(scene, plan);
    estimateWork(scene, plan);
    return plan;
}

double expectedSeconds(const ViewScene& scene, const Plan& plan, int threads) {
    // Seconds on one thread, fitted to a study of smoke (scrim study, noise:350). A footprint
    // extends about three voxels beyond its slab in u and v, so its number of texels is the square
    // of that. About a third of sheets and pictures is not empty.
    constexpr double kFootprint = 2.0e-8, kFootprintTexel = 1.2e-9, kReach = 4;
    constexpr double kTexel = 2e-9, kLightSample = 1e-9, kPixelSheet = 1.5e-9, kStart = 5e-3;
    const double across = kReach / scene.dials.texel;
    const double views = plan.perView && !plan.groups.empty() ? 1.0 + double(plan.groups.front().lights.size()) : 1.0;
    const double work = double(plan.work.footprints) * views * (kFootprint + kFootprintTexel * across * across) +
                        double(plan.work.texelsShaded) * kTexel + double(plan.work.lightSamples) * kLightSample +
                        double(plan.work.pixelSheets) * kPixelSheet * (plan.shadeAtPixels ? 3 : 1);
    return kStart + work / threads;
}

}  // namespace scrim
