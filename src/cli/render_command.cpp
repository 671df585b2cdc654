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
#include <scrim/study/tolerance.h>
#include <scrim/study/verify.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <system_error>

namespace scrim::cli {
namespace {

constexpr unsigned kVerifySeed = 1;  // any, but always the same pixels
// Where a tolerance is asked for: pixels of its pilots, and of the verification unless --verify says how many.
constexpr int kPilotPixels = 96, kTolerancePixels = 200;
// Of a frame's progress: where its rendering ends and its verification begins.
constexpr double kRenderedOfVerified = 0.5;

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
    Frame renderOnce(const ViewScene& view, FrameReport& report, double from, double to);
    Frame renderVerified(const ViewScene& view, const ViewScene& truth, FrameReport& report);
    Frame renderWithin(double tolerance, ViewScene view, const ViewScene& truth, FrameReport& report);
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
    const auto empty = [](const std::shared_ptr<const SparseField>& field) { return field && field->empty(); };
    for (std::size_t i = 0; i < fields.size(); ++i) {
        const SceneVolume& volume = scene.volumes[i];
        const auto warn = [&](const char* what, const std::string& grid) {
            m_console.warning(fmt::format("{}: {}: grid '{}' has no active voxels",
                                          volume.source.empty() ? files[i].path : "source '" + volume.source + "'",
                                          what, grid));
        };
        if (empty(fields[i].density))
            warn(volume.emission.empty() ? "nothing to render" : "no density", fields[i].density->name);
        // A colour without any red is one, too.
        if (std::all_of(fields[i].albedo.begin(), fields[i].albedo.end(), empty))
            warn("the albedo is black", volume.albedoGrid->grid);
        for (const auto& emission : fields[i].emission)
            if (empty(emission)) warn("no emission", emission->name);
    }
}

Frame RenderRun::renderOnce(const ViewScene& view, FrameReport& report, double from, double to) {
    const Plan plan = timed(report.plan, [&] { return makePlan(view, threadCount()); });
    report.planJson = planAsJson(view, plan);
    if (m_options.verbose) m_console.detail(planAsTable(view, plan));
    Frame frame = timed(report.render, [&] { return render(view, plan, m_progress.stage(from, to)); });
    report.stages = frame.times;
    report.work = frame.work;
    return frame;
}

Frame RenderRun::renderVerified(const ViewScene& view, const ViewScene& truth, FrameReport& report) {
    Frame frame = renderOnce(view, report, 0, m_options.verify > 0 ? kRenderedOfVerified : 1);
    if (m_options.verify > 0)
        report.verification = timed(report.verify, [&] {
            return summarise(samplePixels(truth, frame.image, m_options.verify, kVerifySeed,
                                          m_progress.stage(kRenderedOfVerified, 1)));
        });
    return frame;
}

// Pilots, the setting that they recommend, and, where it misses after all, one better one: what was measured says by how
// much the pilots were wrong.
Frame RenderRun::renderWithin(double tolerance, ViewScene view, const ViewScene& truth, FrameReport& report) {
    constexpr double kPiloted = 0.3, kRendered = 0.6, kVerified = 0.9;
    std::array<Pilot, 2> pilots = pilotsFor(tolerance);
    timed(report.plan, [&] { runPilots(pilots, view, truth, kPilotPixels, m_progress.stage(0, kPiloted)); });
    ToleranceModel model = fitModel(pilots);
    ToleranceReport& out = report.tolerance.emplace();
    out.wanted = tolerance;
    const auto renderChoice = [&](double from, double to) {
        const ToleranceChoice choice = timed(report.plan, [&] { return chooseDials(view, model, tolerance); });
        view.dials = choice.dials;
        out.predicted = choice.predicted;
        out.texel = choice.dials.texel;
        out.sheetThickness = choice.dials.sheetThickness;
        return renderOnce(view, report, from, to);
    };
    Frame frame = renderChoice(kPiloted, kRendered);
    std::vector<VerifiedPixel> pixels = timed(report.verify, [&] {
        return samplePixels(truth, frame.image, m_options.verify > 0 ? m_options.verify : kTolerancePixels, kVerifySeed,
                            m_progress.stage(kRendered, kVerified));
    });
    report.verification = summarise(pixels);
    if (report.verification->error > tolerance) {
        model = scaled(model, report.verification->error / std::max(out.predicted, 1e-9));
        out.refined = true;
        frame = renderChoice(kVerified, 1);
        setRendered(pixels, frame.image);
        report.verification = summarise(pixels);
    }
    out.met = report.verification->error <= tolerance;
    if (!out.met)
        m_console.warning(fmt::format("frame {}: the error is {:.3g}, more than the tolerance of {:.3g}", report.frame,
                                      report.verification->error, tolerance));
    return frame;
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

    const auto viewWith = [&](double lod) {
        Scene turned = scene;
        turned.dials.lod = lod;
        return assemble(turned, fields, m_options.crop, memoryLeft(m_options.memory, fields, m_slides.bytes()));
    };
    const ViewScene view = timed(report.plan, [&] { return viewWith(scene.dials.lod); });
    // Of a picture that shows nothing one wants to know why.
    if (view.volumes.empty())
        for (const auto& [name, reason] : view.unseen)
            m_console.warning(fmt::format("frame {}: volume '{}' is left out: {}", frame, name, reason));
    // Coarser levels are an approximation like any other: what is true are the voxels of the file.
    const bool coarser = scene.dials.lod > 0 && (m_options.verify > 0 || scene.tolerance > 0);
    const ViewScene truth = coarser ? viewWith(0) : view;
    Frame rendered =
        scene.tolerance > 0 ? renderWithin(scene.tolerance, view, truth, report) : renderVerified(view, truth, report);
    throwIfInterrupted();
    timed(report.write, [&] { writeFrame(scene, input.toml(), m_colour, std::move(rendered), report, m_console); });
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
