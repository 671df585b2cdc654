// SPDX-License-Identifier: Apache-2.0
#include "scene_input.h"

#include "internal_load.h"
#include "interrupt.h"

#include <scrim/base/error.h>
#include <scrim/scene/frame_path.h>
#include <scrim/shot/shot_text.h>

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>

namespace scrim::cli {
namespace {

/// A path of the command line, relative to the current folder, that may name variables of the environment.
FramePath pathFrom(const std::string& option, const std::string& text) {
    if (text.empty()) throw Error(ErrorKind::usage, option + ": the name is empty");
    const auto environment = [](const std::string& name) -> std::optional<std::string> {
        const char* value = std::getenv(name.c_str());
        return value == nullptr ? std::nullopt : std::optional<std::string>(value);
    };
    try {
        return {"", expandVariables(text, environment, option)};
    } catch (const Error& error) {
        throw Error(ErrorKind::usage, error.what());
    }
}

std::string quoted(const std::string& text) {
    std::string out(1, '"');
    for (const char c : text) {
        if (c == '"' || c == '\\') out += '\\';
        out += c;
    }
    out += '"';
    return out;
}

/// What the command line changes in the scene, in the order of being applied.
std::vector<std::string> overridesOf(const SceneOptions& options) {
    std::vector<std::string> overrides;
    if (!options.quality.empty()) overrides.push_back(fmt::format("render.quality={}", quoted(options.quality)));
    if (options.tolerance > 0) overrides.push_back(fmt::format("render.tolerance={}", options.tolerance));
    overrides.insert(overrides.end(), options.sets.begin(), options.sets.end());
    return overrides;
}

OpenOptions openOptionsOf(const SceneOptions& options, const Shot* sharing) {
    OpenOptions out;
    out.ocio = options.ocio;
    out.resolution = options.resolution;
    out.load = guardedLoading(options.memory, options.threads, options.verbose);
    out.checkedFrame = options.frames.empty() ? 1 : options.frames.front();
    out.shareWith = sharing;
    return out;
}

std::string rangeText(const std::vector<int>& frames) {
    if (frames.empty()) return "no files exist";
    return fmt::format("files exist for {} to {}", frames.front(), frames.back());
}

}  // namespace

SceneInput::SceneInput(const std::string& path, const SceneOptions& options, const SceneInput* sharing)
    : m_options(options),
      m_shot(Shot::open(path, overridesOf(options), openOptionsOf(options, sharing ? &sharing->m_shot : nullptr))) {
    Scene scene = m_shot.opened();
    change(scene);
    m_frames = framesOf(scene);
    m_output = scene.output.path;
    m_preview = scene.output.preview.path;
    if (lowerExtension(m_output.pattern) != ".exr")
        throw Error(ErrorKind::usage, fmt::format("the output '{}' does not end in '.exr'; --preview writes other "
                                                  "kinds of pictures",
                                                  shortened(m_output.pattern)));
}

void SceneInput::change(Scene& scene) const {
    if (!m_options.quality.empty() && m_options.tolerance == 0) scene.tolerance = 0;  // the preset is in its place
    SceneOutput& output = scene.output;
    const int frame = static_cast<int>(scene.frame);
    if (!m_options.output.empty()) output.path = pathFrom("--output", m_options.output);
    if (!m_options.preview.empty()) output.preview.path = pathFrom("--preview", m_options.preview);
    output.file = output.path.at(frame);
    if (!output.preview.path.pattern.empty()) output.preview.file = output.preview.path.at(frame);
}

std::vector<int> SceneInput::framesOf(const Scene& scene) const {
    if (!m_options.frames.empty()) return m_options.frames;
    if (m_options.printScene) return {1};
    for (const SceneVolume& volume : scene.volumes)
        if (volume.source.empty() && volume.sequence.hasFrame())
            throw Error(ErrorKind::usage,
                        fmt::format("{}: '{}' is a sequence; say which frames with --frames ({})", name(),
                                    volume.sequence.pattern, rangeText(existingFrames(volume.sequence))));
    if (scene.output.path.hasFrame())
        throw Error(ErrorKind::usage, fmt::format("{}: the output '{}' has a place for the frame; say which frames "
                                                  "with --frames",
                                                  name(), scene.output.path.pattern));
    return {1};
}

std::string SceneInput::printedToml(const RenderOptions& options) {
    if (m_options.output.empty()) return m_shot.toml({}, options);
    // The text that frames an asset stays as readable as it is.
    if (m_shot.isAsset() && overridesOf(m_options).empty())
        return m_shot.toml({}, options) + fmt::format("\n[output]\nfile = {}\n", quoted(m_options.output));
    // Paths of the command line are relative to the current folder, those of a scene to its own.
    const bool here = m_shot.isAsset() || std::filesystem::path(name()).parent_path().empty();
    const std::string file = here ? m_options.output : (std::filesystem::current_path() / m_options.output).string();
    return m_shot.toml({fmt::format("output.file={}", quoted(file))}, options);
}

std::vector<SceneInput> openInputs(const SceneOptions& options, bool writes) {
    std::vector<SceneInput> inputs;
    inputs.reserve(options.inputs.size());
    for (const std::string& path : options.inputs)
        inputs.emplace_back(path, options, inputs.empty() ? nullptr : &inputs.front());
    if (!writes) return inputs;

    std::map<std::string, std::string> writers;  // of each file
    const auto claim = [&](const SceneInput& input, const FramePath& path, int frame) {
        if (path.pattern.empty()) return;
        const std::string file = path.at(frame);
        const std::string place = std::filesystem::absolute(file).lexically_normal().string();
        const auto [writer, isNew] = writers.emplace(place, input.name());
        if (isNew) return;
        if (inputs.size() == 1 && input.frames().size() > 1 && !path.hasFrame())
            throw Error(ErrorKind::usage,
                        fmt::format("all {} frames would be written to '{}'; put the frame into its name: {}",
                                    input.frames().size(), file,
                                    std::filesystem::path(file)
                                        .replace_extension(".####" + std::filesystem::path(file).extension().string())
                                        .string()));
        throw Error(ErrorKind::usage,
                    fmt::format("'{}' would be written twice, for {} and for {}", file, writer->second, input.name()));
    };
    for (const SceneInput& input : inputs)
        for (const int frame : input.frames()) {
            claim(input, input.output(), frame);
            claim(input, input.preview(), frame);
        }
    return inputs;
}

RenderOptions renderOptionsOf(const SceneOptions& options, MessageSink messages) {
    RenderOptions out;
    out.crop = options.crop;
    out.threads = options.threads;
    out.memory = options.memory;
    out.missing = options.missing;
    out.verify = options.verify;
    out.verifyLimit = options.verifyLimit;
    out.checkpoint = throwIfInterrupted;
    out.messages = std::move(messages);
    return out;
}

}  // namespace scrim::cli
