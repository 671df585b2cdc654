// SPDX-License-Identifier: Apache-2.0
#include "plan_command.h"

#include "console.h"
#include "field_store.h"
#include "interrupt.h"
#include "scene_input.h"
#include "slide_store.h"

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/shot/assemble.h>
#include <scrim/engine/plan/report.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace scrim::cli {
namespace {

using Json = nlohmann::ordered_json;

/// What is planned of one frame: JSON, or a text to read. Nothing where the frame is skipped.
struct PlannedFrame {
    Json json;
    std::string text;
};

PlannedFrame planFrame(SceneInput& input, int frame, const SceneOptions& options, FieldStore& store, SlideStore& slides,
                       Console& console) {
    Scene scene = input.sceneAt(frame);
    std::vector<VolumeFile> files = findFiles(scene);
    for (VolumeFile& file : files) {
        if (file.state != FileState::missing) continue;
        if (options.missing == MissingPolicy::error) throw Error(ErrorKind::input, file.problem);
        console.warning(fmt::format("frame {}: {}", frame, file.problem));
        if (options.missing == MissingPolicy::skip) return {};
        file.state = FileState::black;
    }
    slides.loadInto(scene);
    const Fields fields = store.fieldsOf(scene, files);
    const ViewScene view = assemble(scene, fields, options.crop, memoryLeft(options.memory, fields, slides.bytes()));
    const Plan plan = makePlan(view, threadCount(), [](double) { return interruptSignal() == 0; });

    PlannedFrame planned;
    planned.json = {{"input", input.name()},
                    {"frame", frame},
                    {"field_bytes", bytesOf(fields)},
                    {"plan", Json::parse(planAsJson(view, plan))}};
    planned.text = fmt::format("{}, frame {}\n{}{:<23} {}\n", input.name(), frame, planAsTable(view, plan),
                               "memory of the fields", bytesText(bytesOf(fields)));
    if (scene.tolerance > 0) {
        planned.json["tolerance"] = scene.tolerance;
        planned.text += fmt::format("{:<23} {}: a render chooses texels and sheets for it; this is the plan of '{}'\n",
                                    "tolerance", scene.tolerance, scene.quality);
    }
    return planned;
}

void plan(const SceneOptions& options) {
    Console console(options.verbose, options.quiet);
    const ColourConfig colour = ColourConfig::open(options.ocio);
    FieldStore store({options.memory, options.threads, options.verbose}, console.sink());
    SlideStore slides(colour, console.sink());
    std::vector<SceneInput> inputs = openInputs(options, colour, store, false);
    Json all = Json::array();
    bool first = true;
    for (SceneInput& input : inputs) {
        if (options.printScene) {
            printOut(input.printedToml());
            continue;
        }
        for (const int frame : input.frames()) {
            PlannedFrame planned = planFrame(input, frame, options, store, slides, console);
            if (planned.text.empty()) continue;
            if (options.json)
                all.push_back(std::move(planned.json));
            else
                printOut((first ? "" : "\n") + planned.text);
            first = false;
        }
    }
    if (options.json && !options.printScene) printOut(all.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace

void planCommand(const SceneOptions& options) {
    TaskArena(options.threads).run([&] { plan(options); });
}

}  // namespace scrim::cli
