// SPDX-License-Identifier: Apache-2.0
#include "render_command.h"

#include "budget.h"
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
#include <chrono>
#include <filesystem>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <set>
#include <system_error>
#include <utility>
#include <vector>

namespace scrim::cli {
namespace {

constexpr double kWorthSaying = 2;  // seconds from which on a verification is announced

/// Throws now if the file cannot be written, instead of after the render.
void checkWritable(const std::string& path) {
    if (!path.empty()) const AtomicFile probe(path);
}

/// A frame whose files are written while the next one is rendered.
struct FrameBeingWritten {
    const SceneInput* input;
    ShotFrame frame;
    std::vector<std::pair<Severity, std::string>> messages = {};
    std::future<void> done = {};  // the last member: its destructor waits for the thread
};

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
    void renderAll(std::vector<SceneInput>& inputs);
    static void write(const SceneInput& input, ShotFrame& frame, const MessageSink& messages);
    bool mayWriteBeside(const SceneInput& input, const ShotFrame& frame) const;
    void finishWriting();
    void tell(const ShotReport& report);
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
    std::unique_ptr<FrameBeingWritten> m_beside;
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
    if (m_options.budget > 0)
        for (SceneInput& input : inputs) takePresetWithin(input, m_options, m_console);
    int count = 0;
    for (const SceneInput& input : inputs) count += static_cast<int>(input.frames().size());
    m_progress.setFrameCount(count);
    renderAll(inputs);
    if (m_stats) m_stats->finish();
    if (m_missed == 0) return;
    const std::string others = m_missed > 1 ? fmt::format(" (and {} more frames)", m_missed - 1) : "";
    throw Error(ErrorKind::accuracy, m_firstMissed + others);
}

void RenderRun::renderAll(std::vector<SceneInput>& inputs) {
    try {
        for (SceneInput& input : inputs)
            for (const int frame : input.frames()) {
                throwIfInterrupted();
                m_progress.beginFrame(frame);
                renderFrame(input, frame);
                m_progress.endFrame();
            }
    } catch (...) {
        try {
            finishWriting();
        } catch (const Error&) {  // the first error is the one to report
        }
        throw;
    }
    finishWriting();
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
    options.progress = [this, sink = m_progress.stage(0, 1)](double part) {
        if (m_beside && m_beside->done.wait_for(std::chrono::seconds(0)) == std::future_status::ready) finishWriting();
        return sink(part);
    };
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
        for (const OutputFile& more : scene.output.files) checkWritable(more.file);
        const ColourConfig& colour = input.shot().colour();
        colour.requireConversion(scene.output.colorspace);
        for (const OutputFile& more : scene.output.files) colour.requireConversion(more.colorspace);
        if (scene.output.preview.file.empty()) return;
        pictureModulePath();
        colour.requireView(scene.output.preview.display, scene.output.preview.view);
    };
    return options;
}

void RenderRun::keepMissed(const ShotReport& report) {
    const auto keep = [this](const std::string& text) {
        if (m_missed++ == 0) m_firstMissed = text;
    };
    if (report.scattering && !report.scattering->converged)
        keep(
            fmt::format("frame {}: written, but multiple scattering has not converged: further sweeps would change it "
                        "by about {:.2g}, more than render.scatter_error = {:.2g}",
                        report.frame, report.scattering->error, report.scattering->wanted));
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
void RenderRun::write(const SceneInput& input, ShotFrame& frame, const MessageSink& messages) {
    frame.write("", messages);
    if (!input.deep().pattern.empty()) frame.writeDeep("", messages);
    if (!input.preview().pattern.empty()) frame.preview();
    // Every requested file must exist now, whichever way it was requested; otherwise the program fails.
    const int number = frame.report().frame;
    std::vector<FramePath> all = input.exrs();
    if (!input.preview().pattern.empty()) all.push_back(input.preview());
    for (const FramePath& promised : all) {
        const std::string path = promised.outputAt(number);
        if (std::error_code ignored; !std::filesystem::exists(path, ignored))
            throw Error(ErrorKind::output,
                        fmt::format("frame {}: '{}' was requested, but was not written", number, path));
    }
}

/// Deep pictures are large, and previews load the module that the next frame's slides are read by.
bool RenderRun::mayWriteBeside(const SceneInput& input, const ShotFrame& frame) const {
    return threadCount() > 1 && m_options.memory == 0 && input.preview().pattern.empty() && !frame.hasDeep();
}

/// Waits for the frame that is being written, if there is one, and tells of it. Throws what went wrong there.
void RenderRun::finishWriting() {
    const std::unique_ptr<FrameBeingWritten> written = std::move(m_beside);
    if (!written) return;
    written->done.wait();
    for (const auto& [severity, text] : written->messages) notify(m_console.sink(), severity, text);
    written->done.get();
    tell(written->frame.report());
}

void RenderRun::tell(const ShotReport& report) {
    m_console.line(summaryLine(report));
    m_console.detail(detailLines(report));
    if (m_stats) m_stats->add(report);
}

/// True if a complete picture exists, and complete other files where they are requested; all are then left alone.
bool RenderRun::existsAlready(const SceneInput& input, int frame) {
    if (!m_options.skipExisting) return false;
    for (const FramePath& output : input.exrs()) {
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
        m_console.line(
            m_whole.contains(path)
                ? fmt::format("frame {}: {} is complete, but a file beside it is not; rendering it again", frame, path)
                : fmt::format("frame {}: {} is incomplete; rendering it again", frame, path));

    ShotFrame rendered = input.shot().render(frame, optionsOf(input, frame));
    if (rendered.skipped()) return;
    const ShotReport& report = rendered.report();
    if (report.verification && report.verification->outOfTime)
        m_console.warning(fmt::format("frame {}: --verify-limit ended the verification after {} pixel{}", frame,
                                      report.verification->pixels, report.verification->pixels == 1 ? "" : "s"));
    keepMissed(report);
    if (m_display) m_display->finish(rendered.image());
    throwIfInterrupted();
    finishWriting();
    if (mayWriteBeside(input, rendered)) {
        std::unique_ptr<FrameBeingWritten> beside(new FrameBeingWritten{&input, std::move(rendered)});
        // Where there is no memory for a thread, finishWriting() writes it.
        beside->done = std::async(std::launch::async | std::launch::deferred, [all = beside.get()] {
            write(*all->input, all->frame,
                  [all](Severity severity, const std::string& text) { all->messages.emplace_back(severity, text); });
        });
        m_beside = std::move(beside);
    } else {
        write(input, rendered, m_console.sink());
        tell(rendered.report());
    }
    warnOfLostDisplay();
}

}  // namespace

void renderCommand(const SceneOptions& options) {
    TaskArena(options.threads).run([&] { RenderRun(options).run(); });
}

}  // namespace scrim::cli
