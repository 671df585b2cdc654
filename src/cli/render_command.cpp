// SPDX-License-Identifier: Apache-2.0
#include "render_command.h"

#include "budget.h"
#include "console.h"
#include "display_server.h"
#include "progress.h"
#include "render_job.h"
#include "run_reports.h"
#include "scene_input.h"

#include <scrim/base/atomic_file.h>
#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/image/exr.h>

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <functional>
#include <optional>
#include <system_error>
#include <thread>
#include <vector>

namespace scrim::cli {
namespace {

/// A missing viewer does not prevent rendering.
void openDisplay(const SceneOptions& options, Console& console, std::optional<DisplayServer>& display) {
    if (options.display.empty()) return;
    try {
        display.emplace(options.display);
    } catch (const Error& error) {
        if (error.kind() != ErrorKind::output) throw;
        console.warning(fmt::format("{}; pictures are rendered but not shown", error.what()));
    }
}

/// Calls `work(i)` on a thread for each job but the first, which the caller's has; where a thread cannot be had, the
/// caller's does its work, too. Throws what the first of those that failed has thrown, after all have ended.
void onThreads(int count, std::atomic<bool>& stopped, const std::function<void(int)>& work) {
    std::vector<std::exception_ptr> errors(static_cast<std::size_t>(count));
    const auto run = [&](int i) {
        try {
            work(i);
        } catch (...) {
            errors[static_cast<std::size_t>(i)] = std::current_exception();
            stopped = true;
        }
    };
    std::vector<std::thread> threads;
    std::vector<int> here{0};
    for (int i = 1; i < count; ++i) try {
            threads.emplace_back(run, i);
        } catch (const std::system_error&) {
            here.push_back(i);
        }
    for (const int i : here) run(i);
    for (std::thread& thread : threads) thread.join();
    for (const std::exception_ptr& error : errors)
        if (error) std::rethrow_exception(error);
}

/// Renders frames side by side. Jobs share no volumes, so each has all of those that its frames show.
void renderSideBySide(RenderRun& run, const SceneOptions& options, const Stages& stages) {
    const int threads = threadCount();
    onThreads(run.jobs, run.stopped, [&](int i) {
        SceneOptions own = options;
        own.threads = std::max(1, threads * (i + 1) / run.jobs - threads * i / run.jobs);
        own.memory /= static_cast<std::size_t>(run.jobs);
        std::vector<SceneInput> inputs = openInputs(own, stages);
        TaskArena(own.threads).run([&] { RenderJob(run, own, inputs, i).render(); });
    });
}

void checkJobs(const SceneOptions& options) {
    if (options.jobs == 1) return;
    if (!options.display.empty())
        throw Error(ErrorKind::usage, "--jobs: --display-server shows one frame at a time; give one of the two");
    if (options.budget > 0)
        throw Error(ErrorKind::usage, "--jobs: --budget measures one frame that has the machine; give one of the two");
}

void renderAll(const SceneOptions& options) {
    checkJobs(options);
    Console console(options.verbose, options.quiet);
    Progress progress(options.progress, console);
    const Stages stages = readStages(options, console);
    std::vector<SceneInput> inputs = openInputs(options, stages);
    if (options.printScene) {
        for (SceneInput& input : inputs) printOut(input.printedToml(renderOptionsOf(options, console.sink())));
        return;
    }
    FileClaims claims;
    claimInputs(inputs, options, claims);
    claimOutputs(inputs, options, claims);
    std::optional<DisplayServer> display;
    openDisplay(options, console, display);
    for (const std::string& folder : claims.folders()) removeAbandonedFiles(folder);
    RunReports reports(options, console);
    if (options.budget > 0)
        for (SceneInput& input : inputs) takePresetWithin(input, options, console);
    int count = 0;
    for (const SceneInput& input : inputs) count += static_cast<int>(input.frames().size());
    progress.setFrameCount(count);
    RenderRun run{console, progress, reports, std::clamp(options.jobs, 1, std::max(1, count))};
    progress.setJobCount(run.jobs);
    setExrThreads(std::max(1, threadCount() / run.jobs));
    if (run.jobs > 1) {
        renderSideBySide(run, options, stages);
    } else {
        RenderJob job(run, options, inputs, 0);
        if (display) job.showOn(*display);
        job.render();
    }
    reports.finish();
}

}  // namespace

void renderCommand(const SceneOptions& options) {
    TaskArena(options.threads).run([&] { renderAll(options); });
}

}  // namespace scrim::cli
