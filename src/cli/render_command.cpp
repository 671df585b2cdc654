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
#include <scrim/base/atomic_file.h>
#include <scrim/image/exr.h>
#include <scrim/shot/assemble.h>
#include <scrim/engine/plan/report.h>
#include <scrim/engine/sweep.h>
#include <scrim/verify/tolerance.h>
#include <scrim/verify/verify.h>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <system_error>

namespace scrim::cli {
namespace {

constexpr unsigned kVerifySeed = 1;  // any, but always the same pixels
constexpr double kWorthSaying = 2;   // seconds of a verification that are announced
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
    Frame renderTolerance(double tolerance, const ViewScene& view, const ViewScene& truth, FrameReport& report);
    void keepPlan(const ViewScene& view, const Plan& plan, FrameReport& report);
    std::function<void(double)> announcement(int frame);
    void warnOfEmpty(const Scene& scene, const std::vector<VolumeFile>& files, const Fields& fields);

    const SceneOptions& m_options;
    Console m_console;
    ColourConfig m_colour;
    FieldStore m_store;
    SlideStore m_slides;
    Progress m_progress;
    std::vector<FrameReport> m_reports;
    std::vector<std::string> m_missed;  // tolerances
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
    if (m_missed.empty()) return;
    const std::string others = m_missed.size() > 1 ? fmt::format(" (and {} more frames)", m_missed.size() - 1) : "";
    throw Error(ErrorKind::accuracy, m_missed.front() + others);
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

void RenderRun::keepPlan(const ViewScene& view, const Plan& plan, FrameReport& report) {
    report.planJson = planAsJson(view, plan);
    if (m_options.verbose) m_console.detail(planAsTable(view, plan));
}

/// Tells how long a verification will take, where that is worth a line.
std::function<void(double)> RenderRun::announcement(int frame) {
    return [this, frame](double seconds) {
        if (seconds < kWorthSaying) return;
        const bool cut = m_options.verifyLimit > 0 && seconds > m_options.verifyLimit;
        m_console.line(fmt::format(
            "frame {}: verifying it by brute force takes about {:.0f} s; --verify-limit {}", frame, seconds,
            cut ? fmt::format("ends it after {:g} s", m_options.verifyLimit) : "SECONDS would end it earlier"));
    };
}

Frame RenderRun::renderVerified(const ViewScene& view, const ViewScene& truth, FrameReport& report) {
    const double rendered = m_options.verify > 0 ? kRenderedOfVerified : 1;
    const Plan plan = timed(report.plan, [&] { return makePlan(view, threadCount(), m_progress.stage(0, 0)); });
    keepPlan(view, plan, report);
    Frame frame = timed(report.render, [&] { return render(view, plan, m_progress.stage(0, rendered)); });
    if (m_options.verify > 0) {
        SampleOptions sampling;
        sampling.count = m_options.verify;
        sampling.seed = kVerifySeed;
        sampling.seconds = m_options.verifyLimit;
        sampling.progress = m_progress.stage(rendered, 1);
        sampling.announce = announcement(report.frame);
        const PixelSample sample = timed(report.verify, [&] { return samplePixels(truth, frame.image, sampling); });
        report.verification = summarise(sample);
        report.verifiedInPart = sample.outOfTime;
    }
    return frame;
}

Frame RenderRun::renderTolerance(double tolerance, const ViewScene& view, const ViewScene& truth, FrameReport& report) {
    ToleranceOptions options;
    options.tolerance = tolerance;
    if (m_options.verify > 0) options.pixels = m_options.verify;
    options.seed = kVerifySeed;
    options.seconds = m_options.verifyLimit;
    options.progress = m_progress.stage(0, 1);
    options.announce = announcement(report.frame);
    options.planned = [&](const ViewScene& planned, const Plan& plan) { keepPlan(planned, plan, report); };
    ToleranceResult result = renderWithin(view, truth, options);
    report.plan += result.seconds.pilots + result.seconds.plan;
    report.render += result.seconds.render;
    report.verify += result.seconds.verify;
    report.verification = result.verification;
    report.verifiedInPart = result.outOfTime;
    report.tolerance = {tolerance,    result.predicted, result.dials.texel, result.dials.sheetThickness,
                        result.bound, result.attempts,  result.met};
    if (!result.met)
        m_missed.push_back(fmt::format(
            "frame {}: written, but its error may be {:.3g}, more than the tolerance of {:.3g}{}", report.frame,
            result.bound, tolerance, result.outOfTime ? " (--verify-limit left too few pixels to tell)" : ""));
    return std::move(result.frame);
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
    const bool verifies = m_options.verify > 0 || scene.tolerance > 0;
    const Fields fields = timed(report.load, [&] {
        m_slides.loadInto(scene);
        return m_store.fieldsOf(scene, files, verifies ? VolumesOf::scene : VolumesOf::picture);
    });
    warnOfEmpty(scene, files, fields);

    const auto viewWith = [&](double lod, VolumesOf volumesOf) {
        Scene turned = scene;
        turned.dials.lod = lod;
        const std::size_t left = memoryLeft(m_options.memory, fields, m_slides.bytes());
        return assemble(turned, fields, m_options.crop, left, volumesOf);
    };
    const ViewScene view = timed(report.plan, [&] { return viewWith(scene.dials.lod, VolumesOf::picture); });
    // Of a picture that shows nothing one wants to know why.
    if (view.volumes.empty())
        for (const auto& [name, reason] : view.unseen)
            m_console.warning(fmt::format("frame {}: volume '{}' is left out: {}", frame, name, reason));
    // What is true does not rest on what was left out as useless, nor on coarser levels.
    const ViewScene truth = verifies ? viewWith(0, VolumesOf::scene) : ViewScene{};
    Frame rendered = scene.tolerance > 0 ? renderTolerance(scene.tolerance, view, truth, report)
                                         : renderVerified(view, truth, report);
    if (report.verifiedInPart)
        m_console.warning(fmt::format("frame {}: --verify-limit ended the verification after {} pixels", frame,
                                      report.verification->pixels));
    report.stages = rendered.times;
    report.work = rendered.work;
    throwIfInterrupted();
    timed(report.write, [&] { writeFrame(scene, input.toml(), m_colour, std::move(rendered), report, m_console); });
    report.peakBytes = peakResidentBytes();
    m_console.line(summaryLine(report));
    m_console.detail(detailLines(report));
    m_reports.push_back(std::move(report));
}

}  // namespace

void renderCommand(const SceneOptions& options) {
    TaskArena(options.threads).run([&] { RenderRun(options).run(); });
}

}  // namespace scrim::cli
