// SPDX-License-Identifier: Apache-2.0
#include "steady_study.h"

#include "console.h"
#include "file_claims.h"
#include "progress.h"
#include "result_folder.h"
#include "scene_input.h"

#include <scrim/base/percent.h>
#include <scrim/base/error.h>
#include <scrim/scene/quality.h>
#include <scrim/study/steadiness_data.h>

#include <fmt/format.h>

#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

namespace scrim::cli {
namespace {

constexpr const char *kTable = "steady.csv", *kData = "steady.json";
constexpr std::size_t kLeastFrames = 3;

void requireNeighbours(const std::vector<int>& frames) {
    bool follow = frames.size() >= kLeastFrames;
    for (std::size_t i = 1; i < frames.size(); ++i) follow = follow && frames[i] == frames[i - 1] + 1;
    if (!follow)
        throw Error(ErrorKind::usage,
                    "study --steady: expected three or more frames that follow one another: --frames 1-5");
}

std::string tableOf(const ShotSteadinessResult& result) {
    std::string text = fmt::format(
        "frames {} to {}, {} x {} pixels, {:.0f} s; second differences of neighbouring frames, relative to the mean\n"
        "'{}' promises at most {} % more than converged frames have\n\n"
        "{:<24}{:>9}{:>12}{:>9}{:>9}   {}\n",
        result.frames.front(), result.frames.back(), result.resolution.x, result.resolution.y, result.seconds,
        result.quality, percentText(result.promised), "layer", "shown", "converged", "excess", "error",
        "the worst pixel");
    for (const LayerSteadiness& layer : result.layers) {
        if (layer.mean == 0) {
            text += fmt::format("{:<24}    black\n", layer.name);
            continue;
        }
        text += fmt::format("{:<24}{:>7.2f} %{:>10.2f} %{:>7.2f} %{:>7.2f} %", layer.name, 100 * layer.all.shown,
                            100 * layer.all.converged, 100 * layer.all.excess, 100 * layer.all.error);
        if (layer.worst > 0)
            text += fmt::format("   {} %, ({}, {}) in frame {}", percentText(layer.worst), layer.worstX, layer.worstY,
                                layer.worstFrame);
        text += "\n";
    }
    return text;
}

// Throws where a layer flickers more than is promised.
void requireKept(const ShotSteadinessResult& result) {
    const std::vector<std::string> restless = result.restless();
    for (const LayerSteadiness& layer : result.layers)
        if (!restless.empty() && layer.name == restless.front())
            throw Error(
                ErrorKind::accuracy,
                fmt::format("'{}' flickers: its second differences exceed those of converged frames by {} "
                            "%, and '{}' promises {} %{}",
                            layer.name, percentText(layer.all.excess), result.quality, percentText(result.promised),
                            restless.size() > 1 ? fmt::format(" (and {} more layers)", restless.size() - 1) : ""));
}

ShotSteadinessResult measured(SceneInput& input, const SceneOptions& options, const RenderOptions& rendering,
                              Progress& progress) {
    ShotSteadiness::Options steady;
    if (options.resolution) steady.mostPixels = 0;
    ShotSteadiness study(input.shot(), input.frames().front(), rendering, steady);
    progress.setFrameCount(static_cast<int>(input.frames().size()));
    double before = 0;
    for (const int frame : input.frames()) {
        progress.beginFrame(frame);
        study.add(frame, progress.stage(0, 1));
        progress.endFrame();
        const ShotSteadinessResult soFar = study.result();
        const double next = soFar.seconds + (soFar.seconds - std::exchange(before, soFar.seconds));
        if (options.budget > 0 && soFar.frames.size() >= kLeastFrames && next > options.budget) break;
    }
    return study.result();
}

}  // namespace

void steadyStudy(const SceneOptions& options) {
    Console console(options.verbose, options.quiet);
    Progress progress(options.progress, console);
    SceneOptions sceneOptions = options;
    sceneOptions.output.clear();  // here it is a folder
    std::vector<SceneInput> inputs = openInputs(sceneOptions);
    SceneInput& input = inputs.front();
    requireNeighbours(input.frames());
    RenderOptions rendering = renderOptionsOf(sceneOptions, console.sink());
    rendering.change = [&input](Scene& scene) { input.change(scene); };
    FileClaims claims;
    claimInputs(inputs, sceneOptions, claims);
    std::optional<ResultFolder> folder;
    if (!options.output.empty()) {
        ResultFolder::claim(options.output, {kTable, kData}, claims);
        folder.emplace(options.output);
    }
    const ShotSteadinessResult result = measured(input, options, rendering, progress);
    if (result.layers.empty() || result.layers.front().pixels == 0)
        throw Error(ErrorKind::render, "there is nothing to study: the picture is empty");
    if (folder) {
        folder->write(kTable, steadinessAsCsv(result));
        folder->write(kData, steadinessAsJson(result, std::filesystem::path(input.name()).filename().string()));
    }
    if (!options.quiet) printOut(tableOf(result));
    if (result.frames.size() < input.frames().size())
        console.line(
            fmt::format("--budget ended the study after {} of {} frames", result.frames.size(), input.frames().size()));
    console.detail(fmt::format("# the frames\n{}# the converged frames\n{}", renderBlock(result.dials),
                               renderBlock(result.converged)));
    if (folder) console.line(fmt::format("{}: {}, {}", folder->path(), kTable, kData));
    requireKept(result);
}

}  // namespace scrim::cli
