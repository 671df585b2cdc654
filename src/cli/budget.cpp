// SPDX-License-Identifier: Apache-2.0
#include "budget.h"

#include "interrupt.h"

#include <scrim/base/percent.h>
#include <scrim/base/error.h>
#include <scrim/scene/quality.h>
#include <scrim/scene/toml_text.h>

#include <fmt/format.h>

#include <string>
#include <vector>

namespace scrim::cli {
namespace {

// How long a frame takes with a preset.
struct Expected {
    std::string preset;
    ShotPlan plan;
    double seconds = 0;  ///< of the whole frame
};

void requireNoQuality(const SceneInput& input, const SceneOptions& options) {
    const char* const other = !options.quality.empty() ? "--quality"
                              : options.tolerance > 0  ? "--tolerance"
                              : !options.dials.empty() ? "--dials"
                                                       : nullptr;
    if (other != nullptr)
        throw Error(ErrorKind::usage, fmt::format("--budget chooses the preset; it cannot be combined with {}", other));
    if (input.shot().opened().tolerance > 0)
        throw Error(ErrorKind::usage,
                    fmt::format("{}: --budget cannot be combined with render.tolerance", input.name()));
}

void take(SceneInput& input, const std::string& preset) {
    input.shot().set({fmt::format("render.quality={}", tomlString(preset))});
}

std::string errorText(const ShotPlan& plan) {
    if (plan.promised == 0) return "the scene states its own texels or sheets, so nothing is promised";
    return fmt::format("an error of {} % is expected, and {} % promised", percentText(plan.expected),
                       percentText(plan.promised));
}

// What each preset takes for a frame; none, if the frame is skipped because its files are missing.
std::vector<Expected> expectedOf(SceneInput& input, int frame, const RenderOptions& options) {
    std::vector<Expected> all;
    for (const std::string& preset : presetNames()) {
        take(input, preset);
        all.push_back({preset, input.shot().plan(frame, options)});
        if (all.back().plan.skipped) return {};
    }
    return all;
}

}  // namespace

void takePresetWithin(SceneInput& input, const SceneOptions& options, Console& console) {
    requireNoQuality(input, options);
    // Warnings are those of the preset that is taken, and come when it renders.
    RenderOptions silent = renderOptionsOf(options, {});
    silent.crop = input.crop();
    silent.verify = 0;
    silent.progress = [](double) { return interruptSignal() == 0; };
    silent.change = [&input](Scene& scene) { input.change(scene); };
    std::vector<Expected> all;
    int frame = 0;  // the first that is rendered
    for (const int each : input.frames()) {
        frame = each;
        all = expectedOf(input, each, silent);
        if (!all.empty()) break;
    }
    if (all.empty()) return;
    // How fast the machine is, the coarsest preset tells; if even that is far beyond the budget, nobody waits for it.
    constexpr double kHopeless = 3;
    double scale = 1, beside = 0;
    if (all.front().plan.seconds < kHopeless * options.budget) {
        take(input, all.front().preset);
        const ShotTimes times = input.shot().render(frame, silent).report().seconds;
        scale = times.render / all.front().plan.seconds;
        beside = times.load + times.plan;
    }
    const Expected* chosen = &all.front();
    for (Expected& each : all) {
        each.seconds = beside + scale * each.plan.seconds;
        console.detail(fmt::format("{}: about {:.2g} s; {}", each.preset, each.seconds, errorText(each.plan)));
        if (each.seconds <= options.budget) chosen = &each;
    }
    take(input, chosen->preset);
    const std::string text = fmt::format("{}: quality '{}', about {:.2g} s a frame; {}", input.name(), chosen->preset,
                                         chosen->seconds, errorText(chosen->plan));
    if (chosen->seconds > options.budget)
        console.warning(fmt::format("{}; no preset fits into --budget {:g}", text, options.budget));
    else
        console.line(text);
}

}  // namespace scrim::cli
