// SPDX-License-Identifier: Apache-2.0
#include "plan_command.h"

#include "console.h"
#include "dials_file.h"
#include "interrupt.h"
#include "scene_input.h"

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace scrim::cli {
namespace {

using Json = nlohmann::ordered_json;

/// The plan of one frame, as JSON or as text. Both are empty where the frame is skipped.
struct PlannedFrame {
    Json json;
    std::string text;
};

/// The files that a render of the frame writes: their absolute patterns and their names.
Json outputsOf(const SceneInput& input, int frame) {
    Json out = Json::object();
    const auto add = [&](const char* key, const FramePath& path) {
        if (path.pattern.empty()) return;
        out[key] = {{"pattern", absolutePattern(path.folder, path.pattern)}, {"path", path.outputAt(frame)}};
    };
    add("file", input.output());
    add("deep", input.deep());
    add("preview", input.preview());
    for (std::size_t i = 0; i < input.files().size(); ++i)
        add(fmt::format("file{}", i + 2).c_str(), input.files()[i].path);
    return out;
}

PlannedFrame planFrame(SceneInput& input, int frame, RenderOptions options) {
    double tolerance = 0;
    std::string quality;
    Json said = Json::array();
    options.messages = [&said, sink = options.messages](Severity severity, const std::string& text) {
        said.push_back(text);
        notify(sink, severity, text);
    };
    options.change = [&](Scene& scene) {
        input.change(scene);
        tolerance = scene.tolerance;
        quality = scene.quality;
    };
    const ShotPlan plan = input.shot().plan(frame, options);
    if (plan.skipped) return {};
    PlannedFrame planned;
    planned.json = {{"input", input.name()},
                    {"frame", frame},
                    {"field_bytes", plan.fieldBytes},
                    {"outputs", outputsOf(input, frame)},
                    {"expected_seconds", plan.seconds},
                    {"messages", said},
                    {"plan", Json::parse(plan.json)}};
    planned.text =
        fmt::format("{}, frame {}\n{}{:<23} {}\n{:<23} about {:.2g} s on {} threads, within a factor of three\n",
                    input.name(), frame, plan.table, "memory of the fields", bytesText(plan.fieldBytes),
                    "expected time", plan.seconds, threadCount());
    if (tolerance > 0) {
        planned.json["tolerance"] = tolerance;
        planned.text += fmt::format("{:<23} {}: a render chooses texels and sheets for it; this is the plan of '{}'\n",
                                    "tolerance", tolerance, quality);
    }
    return planned;
}

void plan(const SceneOptions& options) {
    Console console(options.verbose, options.quiet);
    RenderOptions planning = renderOptionsOf(options, console.sink());
    planning.dialsOfEachFrame = !options.writeDials.empty();
    planning.progress = [](double) { return interruptSignal() == 0; };
    std::vector<SceneInput> inputs = openInputs(options);
    Json all = Json::array();
    ShotDials dials;
    bool first = true;
    for (SceneInput& input : inputs) {
        if (options.printScene) {
            printOut(input.printedToml(planning));
            continue;
        }
        for (const int frame : input.frames()) {
            PlannedFrame planned = planFrame(input, frame, planning);
            if (planned.text.empty()) continue;
            dials.add(planned.json["plan"]["render"]);
            if (options.json)
                all.push_back(std::move(planned.json));
            else
                printOut((first ? "" : "\n") + planned.text);
            first = false;
        }
    }
    if (!options.writeDials.empty() && !options.printScene) dials.write(options.writeDials);
    if (options.json && !options.printScene) printOut(all.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace

void planCommand(const SceneOptions& options) {
    TaskArena(options.threads).run([&] { plan(options); });
}

}  // namespace scrim::cli
