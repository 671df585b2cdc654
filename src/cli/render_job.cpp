// SPDX-License-Identifier: Apache-2.0
#include "render_job.h"

#include "guarded_loading.h"
#include "interrupt.h"

#include <scrim/base/atomic_file.h>
#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/guard/load_fields.h>
#include <scrim/image/exr.h>
#include <scrim/image/picture_module.h>
#include <scrim/image/whole_picture.h>

#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <system_error>

namespace scrim::cli {
namespace {

constexpr double kWorthSaying = 2;  // seconds from which on a verification is announced

/// Throws now if the file cannot be written, instead of after the render.
void checkWritable(const std::string& path) {
    if (!path.empty()) const AtomicFile probe(path);
}

}  // namespace

/// In the order of the run.
std::vector<RenderJob::Task> RenderJob::tasks() {
    std::vector<Task> own;
    std::size_t place = 0;
    for (SceneInput& input : m_inputs)
        for (const int frame : input.frames()) {
            if (place % std::size_t(m_run.jobs) == std::size_t(m_number)) own.push_back({&input, frame, place});
            ++place;
        }
    return own;
}

void RenderJob::render() {
    const std::vector<Task> all = tasks();
    try {
        for (std::size_t i = 0; i < all.size() && !m_run.stopped; ++i) {
            throwIfInterrupted();
            m_run.progress.beginFrame(all[i].frame, m_number);
            renderFrame(all, i);
            m_run.progress.endFrame(m_number);
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
void RenderJob::announce(int frame, double seconds) {
    if (seconds < kWorthSaying) return;
    const bool cut = m_options.verifyLimit > 0 && seconds > m_options.verifyLimit;
    m_run.console.line(
        fmt::format("frame {}: verifying it by brute force takes about {:.0f} s; --verify-limit {}", frame, seconds,
                    cut ? fmt::format("ends it after {:g} s", m_options.verifyLimit) : "SECONDS limits this time"));
}

RenderOptions RenderJob::optionsOf(const SceneInput& input, int frame, std::optional<int> next) {
    RenderOptions options = renderOptionsOf(m_options, m_run.console.sink());
    options.crop = input.crop();
    options.progress = [this, sink = m_run.progress.stage(0, 1, m_number)](double part) {
        if (m_beside && m_beside->done.wait_for(std::chrono::seconds(0)) == std::future_status::ready) finishWriting();
        return sink(part);
    };
    options.next = next;
    options.announce = [this, frame](double seconds) { announce(frame, seconds); };
    if (m_display) {
        m_display->begin(input.output().outputAt(frame), input.shot().colour());
        options.shown = m_display->sink();
    }
    if (m_options.verbose) options.planned = [this](const ShotPlan& plan) { m_run.console.detail(plan.table); };
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

/// Warns once; pictures are still rendered and written.
void RenderJob::warnOfLostDisplay() {
    const std::string problem = m_display ? m_display->problem() : "";
    if (problem.empty()) return;
    m_run.console.warning(fmt::format("--display-server {}: stopped showing pictures: {}", m_options.display, problem));
    m_display = nullptr;
}

/// Writes the frame's files. The preview comes last, because the picture matters most.
void RenderJob::write(const SceneInput& input, ShotFrame& frame, const MessageSink& messages) {
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
bool RenderJob::mayWriteBeside(const SceneInput& input, const ShotFrame& frame) const {
    return threadCount() > 1 && m_options.memory == 0 && input.preview().pattern.empty() && !frame.hasDeep();
}

/// Waits for the frame that is being written, if there is one, and tells of it. Throws what went wrong there.
void RenderJob::finishWriting() {
    const std::unique_ptr<FrameBeingWritten> written = std::move(m_beside);
    if (!written) return;
    written->done.wait();
    for (const auto& [severity, text] : written->messages) notify(m_run.console.sink(), severity, text);
    written->done.get();
    m_run.reports.tell(written->place, written->frame.report());
}

/// True if a complete picture exists, and complete other files where they are requested; all are then left alone.
bool RenderJob::existsAlready(const SceneInput& input, int frame) {
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
bool RenderJob::hasPreview(const std::string& path) const {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored)) return false;
    if (const auto whole = isWholePicture(path)) return *whole;
    return readPicture(path, guardedLoading(m_options.memory, m_options.verbose), throwIfInterrupted).problem.empty();
}

/// Completes a frame whose picture exists.
void RenderJob::completeFrame(SceneInput& input, int frame) {
    const std::string path = input.output().outputAt(frame);
    const FramePath& preview = input.preview();
    if (preview.pattern.empty() || hasPreview(preview.outputAt(frame)))
        return m_run.console.line(fmt::format("frame {}: {} exists already", frame, path));
    RenderOptions options = renderOptionsOf(m_options, m_run.console.sink());
    options.change = [&input](Scene& scene) { input.change(scene); };
    input.shot().previewFromPicture(frame, options);
    m_run.console.line(fmt::format("frame {}: {} exists already; its preview was made", frame, path));
}

/// The frame that follows task `i`, of the same input.
std::optional<int> RenderJob::frameAfter(const std::vector<Task>& tasks, std::size_t i) {
    const SceneInput* input = tasks[i].input;
    while (++i < tasks.size() && tasks[i].input == input)
        if (!existsAlready(*input, tasks[i].frame)) return tasks[i].frame;
    return std::nullopt;
}

void RenderJob::renderFrame(const std::vector<Task>& tasks, std::size_t i) {
    const Task& task = tasks[i];
    SceneInput& input = *task.input;
    const int frame = task.frame;
    if (existsAlready(input, frame)) {
        completeFrame(input, frame);
        return m_run.reports.skip(task.place);
    }
    const std::string path = input.output().outputAt(frame);
    if (std::error_code ignored; m_options.skipExisting && std::filesystem::exists(path, ignored))
        m_run.console.line(
            m_whole.contains(path)
                ? fmt::format("frame {}: {} is complete, but a file beside it is not; rendering it again", frame, path)
                : fmt::format("frame {}: {} is incomplete; rendering it again", frame, path));

    ShotFrame rendered = input.shot().render(frame, optionsOf(input, frame, frameAfter(tasks, i)));
    if (rendered.skipped()) return m_run.reports.skip(task.place);
    const ShotReport& report = rendered.report();
    if (report.verification && report.verification->outOfTime)
        m_run.console.warning(fmt::format("frame {}: --verify-limit ended the verification after {} pixel{}", frame,
                                          report.verification->pixels, report.verification->pixels == 1 ? "" : "s"));
    m_run.reports.keepMissed(report);
    if (m_display) m_display->finish(rendered.image());
    throwIfInterrupted();
    finishWriting();
    if (mayWriteBeside(input, rendered)) {
        std::unique_ptr<FrameBeingWritten> beside(new FrameBeingWritten{&input, task.place, std::move(rendered)});
        // Where there is no memory for a thread, finishWriting() writes it.
        beside->done = std::async(std::launch::async | std::launch::deferred, [all = beside.get()] {
            write(*all->input, all->frame,
                  [all](Severity severity, const std::string& text) { all->messages.emplace_back(severity, text); });
        });
        m_beside = std::move(beside);
    } else {
        write(input, rendered, m_run.console.sink());
        m_run.reports.tell(task.place, rendered.report());
    }
    warnOfLostDisplay();
}

}  // namespace scrim::cli
