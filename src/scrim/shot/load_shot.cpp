// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/load_shot.h>

#include <scrim/base/error.h>
#include <scrim/shot/view_motion.h>

#include <scrim/scene/check_scene.h>
#include <scrim/scene/layer_names.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

namespace scrim {
namespace {

/// Bytes that buffers may take: the rest of `limit` beside volumes and slides; 0 where there is no limit.
std::size_t memoryLeft(std::size_t limit, const Fields& fields, std::size_t slideBytes) {
    const std::size_t taken = bytesOf(fields) + slideBytes;
    if (limit == 0) return 0;
    if (taken >= limit)
        throw Error(
            ErrorKind::memory,
            fmt::format("the volumes{} take {}, which uses up the memory limit of {} (--memory)",
                        slideBytes > 0 ? ", slides, meshes and depths" : "", bytesText(taken), bytesText(limit)));
    return limit - taken;
}

Checkpoint checkpointOf(const RenderOptions& options) {
    if (options.checkpoint || !options.progress) return options.checkpoint;
    return [progress = options.progress] {
        if (!progress(0)) throw Error(ErrorKind::interrupted, "the render was interrupted");
    };
}

std::string missingText(int frame, const std::string& problem, MissingPolicy policy, ShotUse use) {
    if (use == ShotUse::plan) return fmt::format("frame {}: {}", frame, problem);
    return policy == MissingPolicy::skip ? fmt::format("frame {} is skipped: {}", frame, problem)
                                         : fmt::format("frame {}: black instead: {}", frame, problem);
}

/// Applies the policy for missing files: returns false where the frame is skipped, and turns
/// missing files into black ones where they are allowed.
bool allowsMissing(int frame, std::vector<VolumeFile>& files, const RenderOptions& options, ShotUse use) {
    for (VolumeFile& file : files) {
        if (file.state != FileState::missing) continue;
        if (options.missing == MissingPolicy::error) throw Error(ErrorKind::input, file.problem);
        notify(options.messages, Severity::warning, missingText(frame, file.problem, options.missing, use));
        if (options.missing == MissingPolicy::skip) return false;
        file.state = FileState::black;
    }
    return true;
}

/// Checks the volumes of a scene that was built in code, as the reader checks those of a file.
void checkVolumes(const Scene& scene, const FieldStore& store) {
    if (scene.volumes.empty()) throw Error(ErrorKind::usage, "the scene has no volume");
    for (const SceneVolume& volume : scene.volumes)
        if (volume.file.empty() && volume.source.empty() && !store.hasGrids(volume.name))
            throw Error(ErrorKind::usage, fmt::format("{}volume '{}' has no file, no source and no grids",
                                                      volume.where.empty() ? "" : volume.where + ": ", volume.name));
}

/// Throws where a layer has one picture for each name and two of these would share a channel name.
void checkChannels(const Scene& scene, Layer layer, const std::vector<std::string>& all) {
    const std::vector<Layer> layers = scene.output.allLayers();
    if (std::find(layers.begin(), layers.end(), layer) == layers.end()) return;
    std::map<std::string, std::string> names;
    for (const std::string& name : all) {
        const auto [known, isNew] = names.emplace(channelName(name), name);
        if (isNew) continue;
        const std::string where = scene.lines ? scene.lines->of("output.layers") : "";
        throw Error(ErrorKind::input, fmt::format("{}{}s '{}' and '{}' would both be the layer '{}.{}', whose name has "
                                                  "only letters, digits and underscores; expected different names",
                                                  where.empty() ? "" : where + ": ", nameOf(layer), known->second, name,
                                                  nameOf(layer), known->first));
    }
}

void checkChannels(const Scene& scene) {
    std::vector<std::string> lights, volumes;
    std::set<std::string> groups;
    for (const Light& light : scene.lights)
        if (light.group.empty() || groups.insert(light.group).second)
            lights.push_back(light.group.empty() ? light.name : light.group);
    for (const SceneVolume& volume : scene.volumes) volumes.push_back(volume.name);
    checkChannels(scene, Layer::light, lights);
    checkChannels(scene, Layer::volume, volumes);
}

/// Warns of a blackbody that is nowhere hot enough to be visible. Most often its grid is not in Kelvin.
void warnOfColdFire(const Scene& scene, const Fields& fields, const MessageSink& messages) {
    constexpr double kGlow = 700;  // Kelvin; the faintest visible red
    for (std::size_t v = 0; v < scene.volumes.size() && v < fields.size(); ++v)
        for (std::size_t e = 0; e < scene.volumes[v].emission.size() && e < fields[v].emission.size(); ++e) {
            const Emission& emission = scene.volumes[v].emission[e];
            const auto& field = fields[v].emission[e];
            if (!emission.blackbody || emission.scale == 0 || !field || field->empty()) continue;
            const double hottest = field->maxValue * emission.kelvinScale + emission.kelvinOffset;
            if (hottest < kGlow)
                notify(messages, Severity::warning,
                       fmt::format("{}: '{}' reaches {:.4g} K in frame {:g}, but nothing glows below {:g} K; set "
                                   "kelvin = [A, B], the temperatures of its values 0 and 1",
                                   emission.where, emission.grid, hottest, scene.frame, kGlow));
        }
}

/// Checks options, which a program may have filled in with anything.
void checkOptions(const RenderOptions& options) {
    const auto check = [](const char* name, double value, double low) {
        if (!(value >= low && std::isfinite(value)))
            throw Error(ErrorKind::usage, fmt::format("RenderOptions::{} is {}; expected a number{}", name, value,
                                                      std::isfinite(low) ? fmt::format(" of at least {}", low) : ""));
    };
    check("threads", options.threads, 0);
    check("verify", options.verify, 0);
    check("verifyLimit", options.verifyLimit, 0);
    check("previewExposure", options.previewExposure, -std::numeric_limits<double>::infinity());
}

}  // namespace

ViewScene LoadedShot::view(const RenderOptions& options, double lod, VolumesOf volumesOf) const {
    Scene turned = scene;
    turned.dials.lod = lod;
    ViewScene view =
        assemble(turned, fields, options.crop, memoryLeft(options.memory, fields, slideBytes), volumesOf, levels.get());
    view.solids = solids;
    if (wantsMotion(turned)) addMotion(view, turned, nextAt(0), fieldsAt(0));
    return view;
}

Scene LoadedShot::sceneAt(double t) const {
    if (!textAt || !scene.movesWithin || t == 0) return scene;
    Scene at = textAt(t);
    at.dials = scene.dials;
    if (scene.plate) at.camera = scene.camera;
    for (std::size_t i = 0; i < at.lights.size(); ++i) {
        Light& light = at.lights[i];
        if (light.slide && scene.lights[i].slide) {
            light.slide->image = scene.lights[i].slide->image;
            light.slide->parts = scene.lights[i].slide->parts;
        }
        if (light.luminaire && scene.lights[i].luminaire) light.luminaire->profile = scene.lights[i].luminaire->profile;
    }
    for (std::size_t i = 0; i < at.meshes.size(); ++i) at.meshes[i].mesh = scene.meshes[i].mesh;
    shineFromMeshes(at);
    at.output.holdout = scene.output.holdout;
    return at;
}

Scene LoadedShot::nextAt(double t) const {
    if (!textAt || !scene.movesOn) return scene;
    Scene next = textAt(t + 1);
    if (scene.plate) next.camera = scene.camera;
    return next;
}

Fields LoadedShot::fieldsAt(double t) const {
    Fields out = fields;
    for (std::size_t i = 0; i < out.size(); ++i)
        if (const SceneVolume& volume = scene.volumes[i]; volume.velocity) {
            const auto path = [&](double moment) {
                return volume.velocity->perFrame(scene.output.fps) *
                       filesWithin(volume, files[i].ends, scene.frame, moment);
            };
            out[i].time = path(t);
            out[i].onward = path(t + 1) - path(t);
        }
    return out;
}

ViewScene LoadedShot::viewAt(double t, const RenderOptions& options, double lod, VolumesOf volumesOf) const {
    return viewOf(sceneAt(t), t, options, lod, volumesOf);
}

ViewScene LoadedShot::viewOf(Scene at, double t, const RenderOptions& options, double lod, VolumesOf volumesOf) const {
    at.dials.lod = lod;
    ViewScene view = assemble(at, fieldsAt(t), options.crop, memoryLeft(options.memory, fields, slideBytes), volumesOf,
                              levels.get());
    view.solids = scene.movesWithin ? solidsOf(at) : solids;
    return view;
}

LoadOptions limited(LoadOptions load, const RenderOptions& options) {
    if (load.memory == 0) load.memory = options.memory;
    return load;
}

void listenTo(FieldStore& store, const LoadOptions& load, const RenderOptions& options) {
    store.listen(limited(load, options), options.messages, checkpointOf(options));
}

Scene withOptions(Scene scene, const RenderOptions& options, const ShotStores& stores) {
    checkOptions(options);
    if (options.tolerance) scene.tolerance = *options.tolerance;
    if (options.change) options.change(scene);
    if (scene.output.colorspace.empty()) scene.output.colorspace = stores.colour.workingSpace();
    checkScene(scene);
    return scene;
}

std::optional<LoadedShot> loadShot(ShotStores& stores, const LoadOptions& load, Scene scene,
                                   const RenderOptions& options, VolumesOf volumesOf, ShotUse use) {
    LoadedShot out;
    out.scene = std::move(scene);
    out.levels = stores.levels;
    checkVolumes(out.scene, stores.fields);
    checkChannels(out.scene);
    out.files = stores.fields.filesOf(out.scene);
    if (!allowsMissing(static_cast<int>(out.scene.frame), out.files, options, use)) return std::nullopt;
    listenTo(stores.fields, load, options);
    stores.slides.loadInto(out.scene, limited(load, options), options.messages, checkpointOf(options));
    stores.meshes.loadInto(out.scene, limited(load, options), checkpointOf(options));
    stores.depths.loadInto(out.scene, limited(load, options), checkpointOf(options));
    out.slideBytes = stores.slides.bytes() + stores.meshes.bytes() + stores.depths.bytes();
    out.solids = solidsOf(out.scene);
    out.fields = stores.fields.fieldsOf(out.scene, out.files, volumesOf);
    if (use == ShotUse::render) warnOfColdFire(out.scene, out.fields, options.messages);
    return out;
}

}  // namespace scrim
