// SPDX-License-Identifier: Apache-2.0
#include "render_command.h"

#include "console.h"
#include "field_store.h"
#include "frame_output.h"
#include "frame_report.h"
#include "interrupt.h"
#include "scene_input.h"
#include "slide_store.h"

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/image/atomic_file.h>
#include <scrim/image/exr.h>
#include <scrim/render/assemble.h>
#include <scrim/render/plan_text.h>
#include <scrim/render/renderer.h>
#include <scrim/study/verify.h>

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

namespace scrim::cli {
namespace {

constexpr unsigned kVerifySeed = 1;  // any, but always the same pixels

/// Throws now what could only be known after the render otherwise.
void checkWritable(const std::string& path) {
    if (!path.empty()) const AtomicFile probe(path);
}

class RenderRun {
  public:
    explicit RenderRun(const SceneOptions& options)
        : m_options(options),
          m_console(options.verbose, options.quiet),
          m_threads(options.threads),
          m_colour(ColourConfig::open(options.ocio)),
          m_store({options.memory, options.threads, options.verbose}, m_console.sink()),
          m_slides(m_colour, m_console.sink()),
          m_progress(options.progress, m_console) {}

    void run();

  private:
    bool mayRender(int frame, std::vector<VolumeFile>& files);
    void renderFrame(SceneInput& input, int frame);
    Image renderImage(const ViewScene& view, const Plan& plan, FrameReport& report);
    void warnOfEmpty(const Scene& scene, const std::vector<VolumeFile>& files, const Fields& fields);

    const SceneOptions& m_options;
    Console m_console;
    ThreadLimit m_threads;
    ColourConfig m_colour;
    FieldStore m_store;
    SlideStore m_slides;
    Progress m_progress;
    std::vector<FrameReport> m_reports;
};

void RenderRun::run() {
    std::vector<SceneInput> inputs = openInputs(m_options, m_colour, m_store, !m_options.printScene);
    if (m_options.printScene) {
        for (SceneInput& input : inputs) printOut(input.printedToml());
        return;
    }
    setExrThreads(threadCount());
    int count = 0;
    for (const SceneInput& input : inputs) count += static_cast<int>(input.frames().size());
    m_progress.setFrameCount(count);
    for (SceneInput& input : inputs)
        for (const int frame : input.frames()) {
            throwIfInterrupted();
            m_progress.beginFrame(frame);
            renderFrame(input, frame);
            m_progress.endFrame();
            // After each frame: what a killed run did is known up to there.
            if (!m_options.stats.empty()) writeWholeFile(m_options.stats, reportsAsJson(m_reports));
        }
}

/// Whether the frame is rendered at all. Files that are missed and allowed to be become black.
bool RenderRun::mayRender(int frame, std::vector<VolumeFile>& files) {
    for (VolumeFile& file : files) {
        if (file.state != FileState::missing) continue;
        if (m_options.missing == MissingPolicy::error) throw Error(ErrorKind::input, file.problem);
        if (m_options.missing == MissingPolicy::skip) {
            m_console.warning(fmt::format("frame {} is skipped: {}", frame, file.problem));
            return false;
        }
        m_console.warning(fmt::format("frame {}: black instead: {}", frame, file.problem));
        file.state = FileState::black;
    }
    return true;
}

void RenderRun::warnOfEmpty(const Scene& scene, const std::vector<VolumeFile>& files, const Fields& fields) {
    for (std::size_t i = 0; i < fields.size(); ++i) {
        if (!fields[i] || !fields[i]->empty()) continue;
        const SceneVolume& volume = scene.volumes[i];
        m_console.warning(fmt::format("{}: nothing to render: grid '{}' has no active voxels",
                                      volume.source.empty() ? files[i].path : "source '" + volume.source + "'",
                                      fields[i]->name));
    }
}

Image RenderRun::renderImage(const ViewScene& view, const Plan& plan, FrameReport& report) {
    constexpr double kRenderedOfVerified = 0.5;  // where both are done, how much of the frame rendering seems to be
    const double rendered = m_options.verify > 0 ? kRenderedOfVerified : 1;
    Frame frame = timed(report.render, [&] { return render(view, plan, m_progress.stage(0, rendered)); });
    report.stages = frame.times;
    report.work = frame.work;
    if (m_options.verify > 0)
        report.verification = timed(report.verify, [&] {
            return summarise(
                samplePixels(view, frame.image, m_options.verify, kVerifySeed, m_progress.stage(rendered, 1)));
        });
    throwIfInterrupted();
    return std::move(frame.image);
}

void RenderRun::renderFrame(SceneInput& input, int frame) {
    std::error_code ignored;
    if (m_options.skipExisting && std::filesystem::exists(input.output().at(frame), ignored))
        return m_console.line(fmt::format("frame {}: {} exists already", frame, input.output().at(frame)));

    FrameReport report;
    Scene scene = timed(report.load, [&] { return input.sceneAt(frame); });
    report.input = input.name();
    report.file = scene.output.file;
    report.frame = frame;
    report.resolution = scene.camera.resolution;
    report.threads = threadCount();

    for (const std::string& path : {scene.output.file, scene.output.preview.file, m_options.stats}) checkWritable(path);

    std::vector<VolumeFile> files = findFiles(scene);
    if (!mayRender(frame, files)) return;
    const Fields fields = timed(report.load, [&] {
        m_slides.loadInto(scene);
        return m_store.fieldsOf(scene, files);
    });
    warnOfEmpty(scene, files, fields);

    ViewScene view;
    const Plan plan = timed(report.plan, [&] {
        view = assemble(scene, fields, m_options.crop, memoryLeft(m_options.memory, fields, m_slides.bytes()));
        return makePlan(view, threadCount());
    });
    report.planJson = planAsJson(view, plan);
    if (m_options.verbose) m_console.detail(planAsTable(view, plan));
    Image image = renderImage(view, plan, report);

    timed(report.write, [&] { writeFrame(scene, input.toml(), m_colour, std::move(image), report, m_console); });
    report.peakBytes = peakResidentBytes();
    m_console.line(summaryLine(report));
    m_console.detail(detailLines(report));
    m_reports.push_back(std::move(report));
}

}  // namespace

void renderCommand(const SceneOptions& options) {
    RenderRun(options).run();
}

}  // namespace scrim::cli
