// SPDX-License-Identifier: Apache-2.0
#include "study_command.h"

#include "console.h"
#include "file_claims.h"
#include "progress.h"
#include "result_folder.h"
#include "scene_input.h"
#include "steady_study.h"

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/scene/quality.h>
#include <scrim/study/shot_study.h>
#include <scrim/study/study.h>
#include <scrim/study/study_data.h>
#include <scrim/study/study_page.h>

#include <fmt/format.h>

#include <filesystem>
#include <vector>

namespace scrim::cli {
namespace {

constexpr const char *kTable = "study.csv", *kData = "study.json", *kPage = "index.html";

std::string tableOf(const Study& study) {
    std::string text = fmt::format("{} reference pixels, {:.0f} s\n{:<12}{:<56}{:>9}{:>12}\n", study.pixels,
                                   study.spent, "error below", "setting", "error", "time");
    for (const Recommendation& r : recommendations(study)) {
        const Trial* t = r.trial ? &study.trials[*r.trial] : nullptr;
        text += t ? fmt::format("{:>9.1f} % {:<56}{:>7.2f} %{:>9.0f} ms\n", 100 * r.tolerance, t->name,
                                100 * t->error.error, 1e3 * t->time())
                  : fmt::format("{:>9.1f} % none of those tried\n", 100 * r.tolerance);
    }
    std::string before;
    for (const Recommendation& r : recommendations(study)) {
        if (!r.trial) continue;
        const std::string block = renderBlock(study.trials[*r.trial].dials);
        if (block != before) text += fmt::format("\n# below {:.1f} %\n{}", 100 * r.tolerance, block);
        before = block;
    }
    text += fmt::format("\n{:<12}one value finer or coarser\n", "dial");
    for (const DialWorth& w : worthOfDials(study)) text += fmt::format("{:<16}{}\n", w.dial, w.verdict);
    return text;
}

void study(const SceneOptions& options) {
    if (options.inputs.size() != 1) throw Error(ErrorKind::usage, "study: expected one scene or asset");
    if (options.steady) return steadyStudy(options);
    if (options.output.empty()) throw Error(ErrorKind::usage, "study: expected -o DIR, the folder for the results");
    Console console(options.verbose, options.quiet);
    Progress progress(options.progress, console);
    // Here the output is a folder; the scenes keep their own outputs unused.
    SceneOptions sceneOptions = options;
    sceneOptions.output.clear();
    std::vector<SceneInput> inputs = openInputs(sceneOptions);
    SceneInput& input = inputs.front();
    if (input.frames().size() != 1) throw Error(ErrorKind::usage, "study: expected one frame; give it with --frames");

    const int frame = input.frames().front();
    RenderOptions rendering = renderOptionsOf(sceneOptions, console.sink());
    rendering.change = [&input](Scene& scene) { input.change(scene); };
    FileClaims claims;
    claimInputs(inputs, sceneOptions, claims);
    ResultFolder::claim(options.output, {kTable, kData, kPage}, claims);
    ShotStudy shotStudy(input.shot(), frame, rendering);
    const ResultFolder folder(options.output);
    progress.beginFrame(frame);
    const Study study = shotStudy.run(options.budget, progress.stage(0, 1));
    progress.endFrame();

    const std::string name = std::filesystem::path(input.name()).filename().string();
    folder.write(kTable, studyAsCsv(study));
    folder.write(kData, studyAsJson(study, name));
    folder.write(kPage, studyAsHtml(study, name, input.shot().colour()));
    if (!options.quiet) printOut(tableOf(study));
    console.line(fmt::format("{}: {}, {}, {}", folder.path(), kTable, kData, kPage));
}

}  // namespace

void studyCommand(const SceneOptions& options) {
    TaskArena(options.threads).run([&] { study(options); });
}

}  // namespace scrim::cli
