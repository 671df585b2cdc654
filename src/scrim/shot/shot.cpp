// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/shot.h>

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/base/timed.h>
#include <scrim/shot/frame_output.h>
#include <scrim/shot/frame_report.h>
#include <scrim/shot/render_shot.h>
#include <scrim/shot/shot_content.h>

#include <optional>
#include <set>
#include <utility>

namespace scrim {
namespace {

/// Runs `task` with so many threads, and returns what it returned.
template <typename Task>
auto withThreads(int threads, const Task& task) {
    std::optional<decltype(task())> result;
    TaskArena(threads).run([&] { result.emplace(task()); });
    return std::move(*result);
}

std::shared_ptr<ShotStores> storesFor(const std::shared_ptr<ShotStores>& shared, const OpenOptions& options) {
    return shared ? shared : std::make_shared<ShotStores>(ColourConfig::open(options.ocio));
}

}  // namespace

void Shot::Content::frameAsset(const RenderOptions& options) {
    listenTo(stores->fields, load, options);
    text->frameAsset(stores->fields);
}

Scene Shot::Content::sceneAt(int frame, const RenderOptions& options) {
    if (text) {
        frameAsset(options);
        return text->at(frame, stores->colour);
    }
    Scene scene = opened;
    scene.frame = frame;
    return scene;
}

ShotPlan Shot::Content::plan(Scene scene, const RenderOptions& options) {
    scene = withOptions(std::move(scene), options, *stores);
    const auto loaded = loadShot(*stores, load, std::move(scene), options, VolumesOf::picture, ShotUse::plan);
    if (loaded) return planLoaded(*loaded, options);
    ShotPlan skipped;
    skipped.skipped = true;
    return skipped;
}

ShotFrame Shot::Content::render(Scene scene, double seconds, const RenderOptions& options) {
    scene = withOptions(std::move(scene), options, *stores);
    auto frame = std::make_unique<ShotFrame::Content>(ShotFrame::Content{scene, "", stores->colour, {}});
    ShotReport& report = frame->report;
    report.input = path;
    report.file = scene.output.file;
    report.frame = static_cast<int>(scene.frame);
    report.resolution = scene.camera.resolution;
    report.seconds.load = seconds;
    const VolumesOf volumesOf = isVerified(scene, options) ? VolumesOf::scene : VolumesOf::picture;
    const auto loaded = timed(report.seconds.load, [&] {
        return loadShot(*stores, load, std::move(scene), options, volumesOf, ShotUse::render);
    });
    frame->skipped = !loaded;
    if (loaded) {
        takeFrame(*frame, renderLoaded(*loaded, options, report));
        if (text) frame->sceneToml = text->toml({});
    }
    report.peakBytes = peakResidentBytes();
    return ShotFrame(std::move(frame));
}

Shot::Shot(std::unique_ptr<Content> content) : m_content(std::move(content)) {}
Shot::Shot(Shot&&) noexcept = default;
Shot& Shot::operator=(Shot&&) noexcept = default;
Shot::~Shot() = default;

Shot Shot::open(const std::string& path, const std::vector<std::string>& overrides, const OpenOptions& options) {
    Shot shot(std::make_unique<Content>());
    Content& content = *shot.m_content;
    content.stores = storesFor(options.shareWith ? options.shareWith->m_content->stores : nullptr, options);
    content.path = path;
    content.load = options.load;
    content.text.emplace(path, overrides, options.resolution);
    content.opened = content.text->at(options.checkedFrame, content.stores->colour);
    return shot;
}

Shot Shot::make(Scene scene, const OpenOptions& options) {
    Shot shot(std::make_unique<Content>());
    Content& content = *shot.m_content;
    content.stores = storesFor(options.shareWith ? options.shareWith->m_content->stores : nullptr, options);
    content.path = scene.file;
    content.load = options.load;
    content.opened = std::move(scene);
    return shot;
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
        if (!volume.source.empty() || !volume.sequence.hasFrame()) continue;
        still = false;
        const int offset = volume.frame - static_cast<int>(scene.frame);
        for (const int frame : existingFrames(volume.sequence)) frames.insert(frame - offset);
    }
    if (still) return {1};
    return {frames.begin(), frames.end()};
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
    return withThreads(options.threads, [&] { return m_content->plan(std::move(scene), options); });
}

ShotFrame Shot::render(int frame, const RenderOptions& options) {
    return withThreads(options.threads, [&] {
        double seconds = 0;
        Scene scene = timed(seconds, [&] { return m_content->sceneAt(frame, options); });
        return m_content->render(std::move(scene), seconds, options);
    });
}

ShotFrame Shot::render(Scene scene, const RenderOptions& options) {
    return withThreads(options.threads, [&] { return m_content->render(std::move(scene), 0, options); });
}

}  // namespace scrim
