// SPDX-License-Identifier: Apache-2.0
#include "render_command.h"

#include "console.h"
#include "display_server.h"
#include "frame_lines.h"
#include "guarded_loading.h"
#include "interrupt.h"
#include "progress.h"
#include "scene_input.h"
#include "stats_file.h"

#include <scrim/base/atomic_file.h>
#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/image/exr.h>
#include <scrim/image/picture_module.h>
#include <scrim/image/whole_picture.h>
#include <scrim/guard/load_fields.h>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <system_error>

namespace scrim::cli {
namespace {

constexpr double kWorthSaying = 2;  // seconds from which on a verification is announced

/// Throws now if the file cannot be written, instead of after the render.
void checkWritable(const std::string& path) {
    if (!path.empty()) const AtomicFile probe(path);
}

class RenderRun {
  public:
    explicit RenderRun(const SceneOptions& options)
        : m_options(options), m_console(options.verbose, options.quiet), m_progress(options.progress, m_console) {}

    void run();

  private:
    bool existsAlready(const SceneInput& input, int frame);
    bool hasPreview(const std::string& path) const;
    void completeFrame(SceneInput& input, int frame);
    void renderFrame(SceneInput& input, int frame);
    std::optional<int> frameAfter(const SceneInput& input, int frame);
    RenderOptions optionsOf(const SceneInput& input, int frame);
    void announce(int frame, double seconds);
    void write(const SceneInput& input, ShotFrame& frame);
    void openDisplay();
    void warnOfLostDisplay();
    void keepMissed(const ShotReport& report);

    const SceneOptions& m_options;
    Console m_console;
    Progress m_progress;
    std::set<std::string> m_whole;  // pictures that existed before
    std::optional<StatsFile> m_stats;
    std::size_t m_missed = 0;  // number of tolerances that were missed
    std::string m_firstMissed;
    std::optional<DisplayServer> m_display;
};

void RenderRun::run() {
    std::vector<SceneInput> inputs = openInputs(m_options);
    if (m_options.printScene) {
        for (SceneInput& input : inputs) printOut(input.printedToml(renderOptionsOf(m_options, m_console.sink())));
        return;
    }
    FileClaims claims;
    claimInputs(inputs, m_options, claims);
    claimOutputs(inputs, m_options, claims);
    openDisplay();
    for (const std::string& folder : claims.folders()) removeAbandonedFiles(folder);
    if (!m_options.stats.empty()) m_stats.emplace(m_options.stats);
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
        }
    if (m_stats) m_stats->finish();
    if (m_missed == 0) return;
    const std::string others = m_missed > 1 ? fmt::format(" (and {} more frames)", m_missed - 1) : "";
    throw Error(ErrorKind::accuracy, m_firstMissed + others);
}

/// Announces how long a verification will take, if it is long enough.
void RenderRun::announce(int frame, double seconds) {
    if (seconds < kWorthSaying) return;
    const bool cut = m_options.verifyLimit > 0 && seconds > m_options.verifyLimit;
    m_console.line(
        fmt::format("frame {}: verifying it by brute force takes about {:.0f} s; --verify-limit {}", frame, seconds,
                    cut ? fmt::format("ends it after {:g} s", m_options.verifyLimit) : "SECONDS limits this time"));
}

RenderOptions RenderRun::optionsOf(const SceneInput& input, int frame) {
    RenderOptions options = renderOptionsOf(m_options, m_console.sink());
    options.crop = input.crop();
    options.progress = m_progress.stage(0, 1);
    options.next = frameAfter(input, frame);
    options.announce = [this, frame](double seconds) { announce(frame, seconds); };
    if (m_display) {
        m_display->begin(input.output().outputAt(frame), input.shot().colour());
        options.shown = m_display->sink();
    }
    if (m_options.verbose) options.planned = [this](const ShotPlan& plan) { m_console.detail(plan.table); };
    options.change = [this, &input](Scene& scene) {
        input.change(scene);
        for (const std::string& path : {scene.output.file, scene.output.deep.file, scene.output.preview.file})
            checkWritable(path);
        if (!scene.output.preview.file.empty()) pictureModulePath();
    };
    return options;
}

void RenderRun::keepMissed(const ShotReport& report) {
    const auto keep = [this](const std::string& text) {
        if (m_missed++ == 0) m_firstMissed = text;
    };
    if (report.scattering && !report.scattering->converged)
        keep(
            fmt::format("frame {}: written, but multiple scattering has not converged: a further sweep would change it "
                        "by {:.2g}, more than render.scatter_error = {:.2g}",
                        report.frame, report.scattering->change, report.scattering->wanted));
    if (!report.tolerance || report.tolerance->met) return;
    keep(fmt::format("frame {}: written, but its error may be {:.3g}, more than the tolerance of {:.3g}{}",
                     report.frame, report.tolerance->bound, report.tolerance->wanted,
                     report.verification->outOfTime ? " (--verify-limit allowed too few pixels to tell)" : ""));
}

/// A missing viewer does not prevent rendering.
void RenderRun::openDisplay() {
    if (m_options.display.empty()) return;
    try {
        m_display.emplace(m_options.display);
    } catch (const Error& error) {
        if (error.kind() != ErrorKind::output) throw;
        m_console.warning(fmt::format("{}; pictures are rendered but not shown", error.what()));
    }
}

/// Warns once; pictures are still rendered and written.
void RenderRun::warnOfLostDisplay() {
    const std::string problem = m_display ? m_display->problem() : "";
    if (problem.empty()) return;
    m_console.warning(fmt::format("--display-server {}: stopped showing pictures: {}", m_options.display, problem));
    m_display.reset();
}

/// Writes the frame's files. The preview comes last, because the picture matters most.
void RenderRun::write(const SceneInput& input, ShotFrame& frame) {
    frame.write("", m_console.sink());
    if (!input.deep().pattern.empty()) frame.writeDeep("", m_console.sink());
    if (!input.preview().pattern.empty()) frame.preview();
    // Every requested file must exist now, whichever way it was requested; otherwise the program fails.
    const int number = frame.report().frame;
    for (const FramePath& promised : {input.output(), input.deep(), input.preview()}) {
        if (promised.pattern.empty()) continue;
        const std::string path = promised.outputAt(number);
        if (std::error_code ignored; !std::filesystem::exists(path, ignored))
            throw Error(ErrorKind::output,
                        fmt::format("frame {}: '{}' was requested, but was not written", number, path));
    }
}

/// True if a complete picture exists, and a complete deep one where it is requested; both are then left alone.
bool RenderRun::existsAlready(const SceneInput& input, int frame) {
    if (!m_options.skipExisting) return false;
    for (const FramePath& output : {input.output(), input.deep()}) {
        if (output.pattern.empty()) continue;
        const std::string path = output.outputAt(frame);
        if (m_whole.contains(path)) continue;
        if (!isWholeExr(path)) return false;
        m_whole.insert(path);
    }
    return true;
}

/// True if a complete preview exists. Formats that cannot be checked by their structure are read in a child.
bool RenderRun::hasPreview(const std::string& path) const {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored)) return false;
    if (const auto whole = isWholePicture(path)) return *whole;
    return readPicture(path, guardedLoading(m_options.memory, m_options.verbose), throwIfInterrupted).problem.empty();
}

/// Completes a frame whose picture exists.
void RenderRun::completeFrame(SceneInput& input, int frame) {
    const std::string path = input.output().outputAt(frame);
    const FramePath& preview = input.preview();
    if (preview.pattern.empty() || hasPreview(preview.outputAt(frame)))
        return m_console.line(fmt::format("frame {}: {} exists already", frame, path));
    RenderOptions options = renderOptionsOf(m_options, m_console.sink());
    options.change = [&input](Scene& scene) { input.change(scene); };
    input.shot().previewFromPicture(frame, options);
    m_console.line(fmt::format("frame {}: {} exists already; its preview was made", frame, path));
}

/// The next frame of this input that will be rendered.
std::optional<int> RenderRun::frameAfter(const SceneInput& input, int frame) {
    const std::vector<int>& frames = input.frames();
    auto next = std::find(frames.begin(), frames.end(), frame);
    while (next != frames.end() && (*next == frame || existsAlready(input, *next))) ++next;
    return next == frames.end() ? std::nullopt : std::optional<int>(*next);
}

void RenderRun::renderFrame(SceneInput& input, int frame) {
    if (existsAlready(input, frame)) return completeFrame(input, frame);
    const std::string path = input.output().outputAt(frame);
    if (std::error_code ignored; m_options.skipExisting && std::filesystem::exists(path, ignored))
        m_console.line(m_whole.contains(path)
                           ? fmt::format("frame {}: {} has an incomplete deep picture; rendering it again", frame, path)
                           : fmt::format("frame {}: {} is incomplete; rendering it again", frame, path));

    ShotFrame rendered = input.shot().render(frame, optionsOf(input, frame));
    if (rendered.skipped()) return;
    const ShotReport& report = rendered.report();
    if (report.verification && report.verification->outOfTime)
        m_console.warning(fmt::format("frame {}: --verify-limit ended the verification after {} pixels", frame,
                                      report.verification->pixels));
    keepMissed(report);
    if (m_display) m_display->finish(rendered.image());
    throwIfInterrupted();
    write(input, rendered);
    m_console.line(summaryLine(report));
    m_console.detail(detailLines(report));
    if (m_stats) m_stats->add(report);
    warnOfLostDisplay();
}

}  // namespace

void renderCommand(const SceneOptions& options) {
    TaskArena(options.threads).run([&] { RenderRun(options).run(); });
}

}  // namespace scrim::cli
