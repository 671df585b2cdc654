// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/shot.h>

#include <scrim/base/percent.h>
#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/base/system_error.h>
#include <scrim/base/timed.h>
#include <scrim/scene/check_scene.h>
#include <scrim/scene/quality.h>
#include <scrim/scene/plate_camera.h>
#include <scrim/scene/volume_file.h>
#include <scrim/shot/frame_output.h>
#include <scrim/shot/frame_report.h>
#include <scrim/shot/render_shot.h>
#include <scrim/shot/keyed_light.h>
#include <scrim/shot/shot_content.h>
#include <scrim/shot/view_motion.h>
#include <scrim/guard/guarded_load.h>
#include <scrim/guard/load_fields.h>
#include <scrim/guard/load_job.h>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <utility>

namespace scrim {
namespace {

/// Runs `task` with `threads` threads and returns its result. Whatever it throws becomes an Error.
template <typename Task>
auto withThreads(int threads, const Task& task) {
    return withErrors([&] {
        std::optional<decltype(task())> result;
        TaskArena(threads).run([&] { result.emplace(task()); });
        return std::move(*result);
    });
}

/// Starts the loader program in advance, so that reading files can begin sooner.
void warmLoaderOf(const LoadOptions& load, LoadedFiles files = LoadedFiles::volumes) {
    if (load.volumes == VolumeLoading::guarded) warmLoader(load.loader, files);
}

std::string promiseText(const std::string& preset, const PromisedDials& promised, const Dials& dials, bool ofMoments) {
    std::string scattering;
    if (const auto& s = promised.scattering)
        scattering = fmt::format(
            "{:<23} '{}' promises {} % of error in means over {} x {} pixels, and {} % are "
            "expected: {}\n",
            "", preset, percentText(s->promised), kScatteringMean, kScatteringMean, percentText(s->choice.expected),
            s->choice.why);
    std::string beyond;
    for (const auto& [expected, why] : promised.beyond)
        beyond += fmt::format("{:<23} {} % are expected: {}\n", "", percentText(expected), why);
    return fmt::format("{:<23} '{}' promises {} % of error; for it, and for every {}:\n{}{}{}", "preset", preset,
                       percentText(promised.promised),
                       ofMoments ? "render of this frame's motion blur" : "frame of the shot", renderBlock(dials),
                       beyond, scattering);
}

/// Tells a plan's preset what it promises and what is expected of it.
void tellPromise(PlannedShot& planned, const std::string& preset, const PromisedDials& promised) {
    ShotPlan& plan = planned.plan;
    plan.table += promiseText(preset, promised, planned.dials, planned.coarser);
    plan.promised = promised.promised;
    plan.expected = promised.expected;
    for (const PromisedDials::Beyond& beyond : promised.beyond)
        plan.expected = std::max(plan.expected, beyond.expected);
    if (!promised.scattering) return;
    plan.promised = std::max(plan.promised, promised.scattering->promised);
    plan.expected = std::max(plan.expected, promised.scattering->choice.expected);
}

/// True if the cells or directions of multiply scattered light are to be chosen.
bool choosesScattering(const Scene& scene) {
    return (!scene.dials.scatterCell || !scene.dials.scatterDirections) &&
           std::any_of(scene.volumes.begin(), scene.volumes.end(),
                       [](const SceneVolume& volume) { return volume.scattersFully(); });
}

void warnOfPromise(const std::string& preset, const PromisedDials& chosen, const RenderOptions& options) {
    constexpr double kClearly = 1.05;
    if (chosen.beyond.empty() && chosen.expected > kClearly * chosen.promised)
        notify(options.messages, Severity::warning,
               fmt::format("the preset '{}' promises an error of {} %, but the finest dials that it "
                           "may choose are expected to leave {} % in this scene",
                           preset, percentText(chosen.promised), percentText(chosen.expected)));
    for (const auto& [expected, why] : chosen.beyond)
        notify(options.messages, Severity::warning,
               fmt::format("the preset '{}' promises an error of {} %, but {} % are expected in this scene: {}", preset,
                           percentText(chosen.promised), percentText(expected), why));
    if (const auto& s = chosen.scattering; s && s->choice.limited)
        notify(
            options.messages, Severity::warning,
            fmt::format("the memory limit leaves no room to look at finer cells of light that scatters more than once: "
                        "cells of {:.4g} voxels, which are expected to leave {} %, may be others without the limit; "
                        "render.scatter_cell states them",
                        s->choice.cell, percentText(s->choice.expected)));
    if (const auto& s = chosen.scattering; s && s->choice.expected > kClearly * s->promised)
        notify(options.messages, Severity::warning,
               fmt::format("the preset '{}' promises an error of {} % in means over {} x {} pixels where light "
                           "scatters more than once, but {} % are expected in this scene: {}",
                           preset, percentText(s->promised), kScatteringMean, kScatteringMean,
                           percentText(s->choice.expected), s->choice.why));
}

Vec3 middleOf(const LoadedShot& loaded, const RenderOptions& options) {
    const Bounds ws = wsBounds(loaded.view(options, loaded.scene.dials.lod.value_or(0), VolumesOf::picture));
    return ws.empty() ? Vec3(0) : ws.center();
}

}  // namespace

void Shot::Content::frameAsset(const RenderOptions& options) {
    listenTo(stores->fields, load, options);
    text->frameAsset(stores->fields, options.messages);
}

Scene Shot::Content::withPlateCamera(Scene scene, const RenderOptions& options) const {
    if (!scene.plate) return scene;
    const PlateCamera& plate = *scene.plate;
    try {
        const PictureHeader header = load.volumes == VolumeLoading::guarded
                                         ? guardedHeader(plate.file, load, options.checkpoint)
                                         : pictureModule().header(plate.file);
        if (!header.problem.empty()) throw Error(ErrorKind::input, header.problem);
        Camera camera = cameraOf(header, plate.ndc, stores->colour);
        camera.near = scene.camera.near;
        if (!plate.givesResolution) camera.resolution = scene.camera.resolution;
        scene.camera = camera;
    } catch (const Error& error) {
        if (error.kind() != ErrorKind::input) throw;
        throw Error(error.kind(), fmt::format("{}: the camera of '{}': {}", plate.where, plate.file, error.what()));
    }
    return scene;
}

Scene Shot::Content::sceneAt(int frame, const RenderOptions& options) {
    if (text) {
        frameAsset(options);
        for (const std::string& warning : std::exchange(opened.warnings, {}))  // they are the same for all frames
            notify(options.messages, Severity::warning, warning);
    }
    return withPlateCamera(sceneUnframed(frame), options);
}

Scene Shot::Content::sceneUnframed(int frame) const {
    if (text) return text->at(frame, stores->colour);
    Scene scene = opened;
    scene.frame = frame;
    return scene;
}

int Shot::Content::richestFrame(const Scene& scene) const {
    std::map<int, std::uintmax_t> bytes;
    for (const SceneVolume& volume : scene.volumes) {
        const FramePath& sequence = leadingSequence(volume);
        if (!volume.source.empty() || !sequence.hasFrame()) continue;
        for (const int file : existingFrames(sequence)) {
            std::error_code error;
            const auto size = std::filesystem::file_size(sequence.at(file), error);
            const std::optional<int> frame = volume.frameMap.frameOf(file);
            if (!error && frame) bytes[*frame] += size;
        }
    }
    const auto richest =
        std::max_element(bytes.begin(), bytes.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
    // Where the scene moves, one fixed frame decides for all; otherwise farm tasks of one frame
    // each would decide differently.
    if (richest == bytes.end()) return scene.moves && !scene.plate ? 1 : static_cast<int>(scene.frame);
    return richest->first;
}

std::optional<LoadedShot> Shot::Content::loadOnce(Scene scene, const RenderOptions& options, VolumesOf volumesOf,
                                                  ShotUse use) {
    RenderOptions heard = options;
    heard.messages = [&](Severity severity, const std::string& what) {
        if (said.erase(what) == 0) notify(options.messages, severity, what);
    };
    auto loaded = loadShot(*stores, load, std::move(scene), heard, volumesOf, use);
    said.clear();
    if (loaded) keepText(*loaded, options);
    return loaded;
}

void Shot::Content::keepText(LoadedShot& loaded, const RenderOptions& options) {
    if (text && (loaded.scene.movesWithin || (loaded.scene.movesOn && wantsMotion(loaded.scene))))
        loaded.textAt = [this, &options, frame = static_cast<int>(loaded.scene.frame)](double t) {
            return withOptions(text->at(frame, stores->colour, t), options, *stores);
        };
}

double Shot::Content::keepPromise(Scene& scene, const RenderOptions& options, ShotUse use) {
    if ((!scene.keepsPromise && !choosesScattering(scene)) || scene.tolerance > 0) return 0;
    double pilots = 0;
    if (!promised || promised->first != scene.quality || options.dialsOfEachFrame) {
        RenderOptions whole = options;
        whole.crop.reset();
        whole.messages = [&](Severity severity, const std::string& what) {
            if (said.insert(what).second) notify(options.messages, severity, what);
        };
        const bool own = !text || options.dialsOfEachFrame;
        const int frame = own ? static_cast<int>(scene.frame) : richestFrame(scene);
        Scene richest = scene;
        try {
            if (frame != static_cast<int>(scene.frame))
                richest = withOptions(sceneAt(frame, options), options, *stores);
            auto loaded = loadShot(*stores, load, std::move(richest), whole, VolumesOf::picture, use);
            if (!loaded) return 0;
            if (const auto& shutter = loaded->scene.shutter) {
                // A light may be out at the frame itself.
                keepText(*loaded, whole);
                KeyedLight(*loaded, shutter->open, shutter->close)
                    .average(shutter->open, shutter->close, loaded->scene);
            }
            const auto viewAt = [&](double lod) { return loaded->view(whole, lod, VolumesOf::picture); };
            const bool chooses = scene.keepsPromise && !loaded->scene.dials.lod;
            timed(pilots, [&] {
                promised.emplace(scene.quality,
                                 promisedDials(viewAt(loaded->scene.dials.lod.value_or(0)), scene.quality,
                                               chooses ? viewAt : std::function<ViewScene(double)>()));
            });
        } catch (const Error& error) {
            // An error in a file is reported when its own frame is rendered. Until then the
            // preset's dials are those of an average scene.
            if (error.kind() != ErrorKind::input) throw;
            return pilots;
        }
        if (scene.keepsPromise) warnOfPromise(scene.quality, promised->second, options);
    }
    const PromisedDials& chosen = promised->second;
    if (chosen.scattering) setScattering(scene.dials, chosen.scattering->choice);
    if (!scene.keepsPromise) return pilots;
    if (!scene.dials.lod) scene.dials.lod = chosen.dials.lod;
    if (!scene.dials.lightCell) scene.dials.lightCell = chosen.dials.lightCell;
    if (!scene.dials.lightCellOthers) scene.dials.lightCellOthers = chosen.dials.lightCellOthers;
    scene.dials.texel = chosen.dials.texel;
    scene.dials.sheetThickness = chosen.dials.sheetThickness;
    scene.dials.opacityCutoff = std::min(scene.dials.opacityCutoff, chosen.dials.opacityCutoff);
    scene.dials.lightError = std::min(scene.dials.lightError, chosen.dials.lightError);
    return pilots;
}

Scene Shot::Content::byHand(Scene scene) {
    scene.movesWithin = scene.movesOn = false;
    return scene;
}

ShotPlan Shot::Content::plan(Scene scene, const RenderOptions& options) {
    scene = withOptions(std::move(scene), options, *stores);
    keepPromise(scene, options, ShotUse::plan);
    const auto loaded = loadOnce(std::move(scene), options, VolumesOf::picture, ShotUse::plan);
    if (loaded) {
        PlannedShot planned = planLoaded(*loaded, options);
        if (loaded->scene.keepsPromise && promised) tellPromise(planned, loaded->scene.quality, promised->second);
        return std::move(planned.plan);
    }
    ShotPlan skipped;
    skipped.skipped = true;
    return skipped;
}

void Shot::Content::readAhead(const RenderOptions& options, const LoadedShot& loaded, VolumesOf volumesOf,
                              std::size_t buffers) {
    if (!text || !options.next) return;
    // Memory beside a field while a child reads one: the child needs about as much for the tree as
    // for the field it makes.
    constexpr std::size_t kFieldsBeside = 3;
    const std::size_t bytes = kFieldsBeside * bytesOf(loaded.fields) + loaded.slideBytes + buffers;
    if (options.memory > 0 && bytes >= options.memory) return;
    const std::size_t beside = bytesOf(loaded.fields) + loaded.slideBytes + buffers;
    const std::size_t left = options.memory > 0 ? options.memory - beside : 0;
    try {
        const Scene next = text->at(*options.next, stores->colour);
        stores->fields.readAhead(next, stores->fields.filesOf(next), volumesOf, left);
    } catch (const Error&) {
        // The error occurs again, and is reported, when its frame is rendered.
    }
}

ShotFrame Shot::Content::render(Scene scene, double seconds, const RenderOptions& options) {
    scene = withOptions(std::move(scene), options, *stores);
    const double pilots = timed(seconds, [&] { return keepPromise(scene, options, ShotUse::render); });
    auto frame = std::make_unique<ShotFrame::Content>(ShotFrame::Content{scene, "", stores->colour, {}});
    frame->previewExposure = options.previewExposure;
    ShotReport& report = frame->report;
    report.input = path;
    report.file = scene.output.file;
    report.frame = static_cast<int>(scene.frame);
    report.resolution = scene.camera.resolution;
    report.seconds.load = seconds - pilots;
    report.seconds.plan = pilots;
    const VolumesOf volumesOf = isVerified(scene, options) ? VolumesOf::scene : VolumesOf::picture;
    const auto loaded =
        timed(report.seconds.load, [&] { return loadOnce(std::move(scene), options, volumesOf, ShotUse::render); });
    frame->skipped = !loaded;
    if (loaded) {
        frame->scene.output.preview.backplate = loaded->scene.output.preview.backplate;
        if (frame->scene.output.preview.annotate) frame->wsMiddle = middleOf(*loaded, options);
        bool first = true;
        takeFrame(*frame, renderLoaded(*loaded, options, report, [&](std::size_t buffers) {
            if (std::exchange(first, false)) readAhead(options, *loaded, volumesOf, buffers);
        }));
        if (text) frame->sceneToml = text->toml({});
    }
    report.peakBytes = peakResidentBytes();
    return ShotFrame(std::move(frame));
}

Shot::Shot(std::unique_ptr<Content> content) : m_content(std::move(content)) {}
Shot::Shot(Shot&&) noexcept = default;
Shot& Shot::operator=(Shot&&) noexcept = default;
Shot::~Shot() = default;

Shot Shot::withStores(const OpenOptions& options) {
    Shot shot(std::make_unique<Content>());
    Content& content = *shot.m_content;
    content.stores = options.shareWith ? options.shareWith->m_content->stores
                                       : std::make_shared<ShotStores>(ColourConfig::open(options.ocio));
    content.load = options.load;
    return shot;
}

Shot Shot::open(const std::string& path, const std::vector<std::string>& overrides, const OpenOptions& options) {
    return withErrors([&] {
        if (isAssetFile(path)) warmLoaderOf(options.load);
        Shot shot = withStores(options);
        shot.m_content->text.emplace(path, overrides, options);
        shot.begin(options);
        return shot;
    });
}

Shot Shot::parse(const std::string& toml, const std::string& name, const std::string& folder,
                 const std::vector<std::string>& overrides, const OpenOptions& options) {
    return withErrors([&] {
        Shot shot = withStores(options);
        shot.m_content->text.emplace(SceneText{name, folder, toml}, overrides, options);
        shot.begin(options);
        return shot;
    });
}

void Shot::begin(const OpenOptions& options) {
    Content& content = *m_content;
    content.path = content.text->path();
    content.opened = content.text->at(options.checkedFrame, content.stores->colour);
    for (const SceneVolume& volume : content.opened.volumes)
        if (!volume.file.empty() || !fileIn(volume.parameters).empty()) warmLoaderOf(options.load);
    for (const Light& light : content.opened.lights)
        if (light.slide && !light.slide->file.empty()) warmLoaderOf(options.load, LoadedFiles::pictures);
}

Shot Shot::make(Scene scene, const OpenOptions& options) {
    return withErrors([&] {
        checkScene(scene);
        Shot shot = withStores(options);
        Content& content = *shot.m_content;
        content.path = scene.file;
        content.opened = std::move(scene);
        return shot;
    });
}

const std::string& Shot::path() const {
    return m_content->path;
}
bool Shot::isAsset() const {
    return m_content->text && m_content->text->isAsset();
}
const Scene& Shot::opened() const {
    return m_content->opened;
}
const ColourConfig& Shot::colour() const {
    return m_content->stores->colour;
}

std::vector<int> Shot::frames() const {
    const Scene& scene = opened();
    std::set<int> frames;
    bool still = true;
    for (const SceneVolume& volume : scene.volumes) {
        const FramePath& sequence = leadingSequence(volume);
        if (!volume.source.empty() || !sequence.hasFrame()) continue;
        still = false;
        const std::vector<int> files = existingFrames(sequence);
        std::set<int> shown;
        for (const int file : files)
            if (const std::optional<int> frame = volume.frameMap.frameOf(file)) shown.insert(*frame);
        if (shown.empty()) continue;
        // In slow motion a file is shown for several frames.
        const auto isThere = [&](double file) {
            return std::binary_search(files.begin(), files.end(), static_cast<int>(file));
        };
        for (int frame = *shown.begin(); frame <= *shown.rbegin(); ++frame) {
            const double file = volume.frameMap.fileAt(frame);
            if (isThere(file) && (volume.frameMap.beyondAt(frame) == 0 || isThere(file + 1))) frames.insert(frame);
        }
    }
    if (still) return {1};
    return {frames.begin(), frames.end()};
}

void Shot::previewFromPicture(int frame, const RenderOptions& options) {
    withThreads(options.threads, [&] {
        Scene scene = withOptions(m_content->sceneUnframed(frame), options, *m_content->stores);
        const LoadOptions load = limited(m_content->load, options);
        FilePicture picture = readPicture(scene.output.file, load, options.checkpoint);
        ShotFrame::Content content{scene, "", m_content->stores->colour, {}};
        content.previewExposure = options.previewExposure;
        if (scene.output.preview.annotate) {
            content.scene = scene = withOptions(m_content->sceneAt(frame, options), options, *m_content->stores);
            if (const auto loaded = m_content->loadOnce(scene, options, VolumesOf::picture, ShotUse::render))
                content.wsMiddle = middleOf(*loaded, options);
        }
        if (scene.output.preview.backplate) {
            Scene plate;
            plate.output.preview = scene.output.preview;
            SlideStore(m_content->stores->colour).loadInto(plate, load, options.messages, options.checkpoint);
            content.scene.output.preview = plate.output.preview;
        }
        writePreviewOfPicture(content, std::move(picture));
        return 0;
    });
}

void Shot::set(const std::vector<std::string>& overrides) {
    Content& content = *m_content;
    if (!content.text) throw Error(ErrorKind::usage, fmt::format("{}: the scene was built in code", content.path));
    withErrors([&] {
        ShotText changed = *content.text;
        changed.add(overrides);
        content.opened = changed.at(static_cast<int>(content.opened.frame), content.stores->colour);
        content.text = std::move(changed);
        content.promised.reset();
    });
}

void Shot::setVolume(const std::string& name, std::vector<SparseField> grids) {
    m_content->stores->fields.setGrids(name, std::move(grids));
}

Scene Shot::scene(int frame, const RenderOptions& options) {
    return withThreads(options.threads, [&] { return m_content->sceneAt(frame, options); });
}

std::string Shot::toml(const std::vector<std::string>& more, const RenderOptions& options) {
    if (!m_content->text) return "";
    return withThreads(options.threads, [&] {
        m_content->frameAsset(options);
        return m_content->text->toml(more);
    });
}

ShotPlan Shot::plan(int frame, const RenderOptions& options) {
    return withThreads(options.threads, [&] { return m_content->plan(m_content->sceneAt(frame, options), options); });
}

ShotPlan Shot::plan(Scene scene, const RenderOptions& options) {
    return withThreads(options.threads, [&] { return m_content->plan(Content::byHand(std::move(scene)), options); });
}

ShotFrame Shot::render(int frame, const RenderOptions& options) {
    return withThreads(options.threads, [&] {
        double seconds = 0;
        Scene scene = timed(seconds, [&] { return m_content->sceneAt(frame, options); });
        return m_content->render(std::move(scene), seconds, options);
    });
}

ShotFrame Shot::render(Scene scene, const RenderOptions& options) {
    return withThreads(options.threads,
                       [&] { return m_content->render(Content::byHand(std::move(scene)), 0, options); });
}

}  // namespace scrim
