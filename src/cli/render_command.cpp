// SPDX-License-Identifier: Apache-2.0
#include "render_command.h"

#include "console.h"
#include "frame_lines.h"
#include "interrupt.h"
#include "progress.h"
#include "scene_input.h"

#include <scrim/base/atomic_file.h>
#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/image/exr.h>

#include <fmt/format.h>

#include <filesystem>
#include <functional>
#include <system_error>

namespace scrim::cli {
namespace {

constexpr double kWorthSaying = 2;  // seconds of a verification that are announced

/// Throws now what could only be known after the render otherwise.
void checkWritable(const std::string& path) {
    if (!path.empty()) const AtomicFile probe(path);
}

class RenderRun {
  public:
    explicit RenderRun(const SceneOptions& options)
        : m_options(options), m_console(options.verbose, options.quiet), m_progress(options.progress, m_console) {}

    void run();

  private:
    void renderFrame(SceneInput& input, int frame);
    RenderOptions optionsOf(const SceneInput& input, int frame);
    void announce(int frame, double seconds);
    void write(ShotFrame& frame, bool withPreview);
    void keepMissed(const ShotReport& report);

    const SceneOptions& m_options;
    Console m_console;
    Progress m_progress;
    std::vector<ShotReport> m_reports;
    std::vector<std::string> m_missed;  // tolerances
};

void RenderRun::run() {
    std::vector<SceneInput> inputs = openInputs(m_options, !m_options.printScene);
    if (m_options.printScene) {
        for (SceneInput& input : inputs) printOut(input.printedToml(renderOptionsOf(m_options, m_console.sink())));
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

/// Tells how long a verification will take, where that is worth a line.
void RenderRun::announce(int frame, double seconds) {
    if (seconds < kWorthSaying) return;
    const bool cut = m_options.verifyLimit > 0 && seconds > m_options.verifyLimit;
    m_console.line(
        fmt::format("frame {}: verifying it by brute force takes about {:.0f} s; --verify-limit {}", frame, seconds,
                    cut ? fmt::format("ends it after {:g} s", m_options.verifyLimit) : "SECONDS would end it earlier"));
}

RenderOptions RenderRun::optionsOf(const SceneInput& input, int frame) {
    RenderOptions options = renderOptionsOf(m_options, m_console.sink());
    options.progress = m_progress.stage(0, 1);
    options.announce = [this, frame](double seconds) { announce(frame, seconds); };
    if (m_options.verbose) options.planned = [this](const ShotPlan& plan) { m_console.detail(plan.table); };
    options.change = [this, &input](Scene& scene) {
        input.change(scene);
        for (const std::string& path : {scene.output.file, scene.output.preview.file, m_options.stats})
            checkWritable(path);
    };
    return options;
}

void RenderRun::keepMissed(const ShotReport& report) {
    if (!report.tolerance || report.tolerance->met) return;
    m_missed.push_back(
        fmt::format("frame {}: written, but its error may be {:.3g}, more than the tolerance of {:.3g}{}", report.frame,
                    report.tolerance->bound, report.tolerance->wanted,
                    report.verification->outOfTime ? " (--verify-limit left too few pixels to tell)" : ""));
}

/// The preview is written last: the picture is what matters.
void RenderRun::write(ShotFrame& frame, bool withPreview) {
    frame.write("", m_console.sink());
    if (withPreview) frame.preview();
}

void RenderRun::renderFrame(SceneInput& input, int frame) {
    std::error_code ignored;
    if (m_options.skipExisting && std::filesystem::exists(input.output().at(frame), ignored))
        return m_console.line(fmt::format("frame {}: {} exists already", frame, input.output().at(frame)));

    ShotFrame rendered = input.shot().render(frame, optionsOf(input, frame));
    if (rendered.skipped()) return;
    const ShotReport& report = rendered.report();
    if (report.verification && report.verification->outOfTime)
        m_console.warning(fmt::format("frame {}: --verify-limit ended the verification after {} pixels", frame,
                                      report.verification->pixels));
    keepMissed(report);
    throwIfInterrupted();
    write(rendered, !input.preview().pattern.empty());
    m_console.line(summaryLine(report));
    m_console.detail(detailLines(report));
    m_reports.push_back(report);
}

}  // namespace

void renderCommand(const SceneOptions& options) {
    TaskArena(options.threads).run([&] { RenderRun(options).run(); });
}

}  // namespace scrim::cli
