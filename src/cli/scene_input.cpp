// SPDX-License-Identifier: Apache-2.0
#include "scene_input.h"

#include "console.h"
#include "dials_file.h"
#include "guarded_loading.h"
#include "interrupt.h"

#include <scrim/base/error.h>
#include <scrim/base/letter_case.h>
#include <scrim/scene/frame_path.h>
#include <scrim/scene/volume_file.h>
#include <scrim/scene/toml_text.h>
#include <scrim/shot/shot_files.h>
#include <scrim/shot/shot_text.h>

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <numeric>
#include <optional>
#include <utility>

namespace scrim::cli {
namespace {

/// The overrides of the command line, in the order in which they are applied.
std::vector<std::string> overridesOf(const SceneOptions& options) {
    std::vector<std::string> overrides;
    if (!options.quality.empty()) overrides.push_back(fmt::format("render.quality={}", tomlString(options.quality)));
    if (options.tolerance > 0) overrides.push_back(fmt::format("render.tolerance={}", options.tolerance));
    if (!options.dials.empty()) {
        const std::vector<std::string> dials = dialsOf(options.dials);
        overrides.insert(overrides.end(), dials.begin(), dials.end());
    }
    overrides.insert(overrides.end(), options.sets.begin(), options.sets.end());
    return overrides;
}

OpenOptions openOptionsOf(const SceneOptions& options, const Shot* sharing) {
    OpenOptions out;
    out.ocio = options.ocio;
    out.resolution = options.resolution;
    out.wsUp = options.wsUp;
    out.turntable = options.turntable;
    out.load = guardedLoading(options.memory, options.verbose);
    out.checkedFrame = options.frames.empty() ? 1 : options.frames.front();
    out.deepFromCode = !options.deep.empty();
    out.shareWith = sharing;
    return out;
}

/// Options for a scene made from a stage, which already has the resolution.
OpenOptions stageOptionsOf(const SceneOptions& options, int frame, const Shot* sharing) {
    OpenOptions out = openOptionsOf(options, sharing);
    out.resolution = std::nullopt;
    out.checkedFrame = frame;
    return out;
}

std::string rangeText(const std::vector<int>& frames) {
    if (frames.empty()) return "no files exist";
    return fmt::format("files exist for {} to {}", frames.front(), frames.back());
}

}  // namespace

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

SceneInput::SceneInput(const std::string& path, const SceneOptions& options, const SceneInput* sharing)
    : m_options(options),
      m_shot(Shot::open(path, overridesOf(options), openOptionsOf(options, sharing ? &sharing->m_shot : nullptr))) {
    begin();
}

SceneInput::SceneInput(const std::string& stage, const UsdScenes& scenes, const UsdScene& part,
                       const SceneOptions& options, const SceneInput* sharing)
    : m_options(options),
      m_shot(Shot::parse(part.toml, stage, std::filesystem::path(stage).parent_path(), overridesOf(options),
                         stageOptionsOf(options, part.frames.front(), sharing ? &sharing->m_shot : nullptr))),
      m_frames(part.frames),
      m_crop(part.crop),
      m_folder(scenes.folder) {
    begin();
}

void SceneInput::begin() {
    Scene scene = m_shot.opened();
    change(scene);
    if (m_frames.empty()) m_frames = framesOf(scene);
    m_output = scene.output.path;
    m_preview = scene.output.preview.path;
    m_deep = scene.output.deep.path;
    m_files = scene.output.files;
    checkPreview(scene.output.preview);
    if (lowerExtension(m_output.pattern) != ".exr")
        throw Error(ErrorKind::usage, fmt::format("the output '{}' does not end in '.exr'; --preview writes other "
                                                  "kinds of pictures",
                                                  shortened(m_output.pattern)));
    if (!m_options.deep.empty() && lowerExtension(m_deep.pattern) != ".exr")
        throw Error(ErrorKind::usage,
                    fmt::format("--deep: the deep picture '{}' does not end in '.exr'", shortened(m_deep.pattern)));
}

std::vector<FramePath> SceneInput::exrs() const {
    std::vector<FramePath> all{m_output};
    for (const OutputFile& more : m_files) all.push_back(more.path);
    if (!m_deep.pattern.empty()) all.push_back(m_deep);
    return all;
}

void SceneInput::change(Scene& scene) const {
    // The preset replaces the tolerance.
    if (!m_options.quality.empty() && m_options.tolerance == 0) scene.tolerance = 0;
    SceneOutput& output = scene.output;
    const int frame = static_cast<int>(scene.frame);
    if (!m_options.output.empty()) output.path = pathFrom("--output", m_options.output);
    if (!m_options.deep.empty()) output.deep.path = pathFrom("--deep", m_options.deep);
    nameFiles(output.files);
    if (!m_options.view.empty()) output.preview.view = m_options.view;
    if (m_options.annotate) output.preview.annotate = true;
    if (!m_options.preview.empty()) output.preview.path = pathFrom("--preview", m_options.preview);
    nameOutputs(output, frame);
}

/// Names further files as the command line does.
void SceneInput::nameFiles(std::vector<OutputFile>& files) const {
    const std::vector<std::string>& names = m_options.files;
    if (names.empty()) return;
    if (names.size() != files.size())
        throw Error(ErrorKind::usage,
                    fmt::format("--file: expected one name for each further file of {}, {} in all; found {}", name(),
                                files.size(), names.size()));
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (lowerExtension(names[i]) != ".exr")
            throw Error(ErrorKind::usage, fmt::format("--file: '{}' does not end in '.exr'", shortened(names[i])));
        files[i].path = pathFrom("--file", names[i]);
        files[i].where = "--file";
    }
}

void SceneInput::checkPreview(const ScenePreview& preview) const {
    const char* const option = !m_options.view.empty() ? "--view"
                               : m_options.annotate    ? "--annotate"
                               : m_options.exposure    ? "--exposure"
                                                       : nullptr;
    if (option == nullptr) return;
    if (preview.path.pattern.empty())
        throw Error(ErrorKind::usage,
                    fmt::format("{}: there is no preview to apply it to; --preview FILE.png writes one", option));
    if (m_options.view.empty()) return;
    const std::vector<std::string> views = m_shot.colour().views(preview.display);
    for (const std::string& view : views)
        if (equalIgnoringCase(view, m_options.view)) return;
    throw Error(ErrorKind::usage,
                fmt::format("--view '{}': expected {}", shortened(m_options.view, 80), choices(views)));
}

std::vector<int> SceneInput::framesOf(const Scene& scene) const {
    if (!m_options.frames.empty()) return m_options.frames;
    if (m_options.printScene) return {1};
    if (m_options.turntable > 0) {
        std::vector<int> frames(static_cast<std::size_t>(m_options.turntable));
        std::iota(frames.begin(), frames.end(), 1);
        return frames;
    }
    for (const SceneVolume& volume : scene.volumes)
        if (const FramePath& sequence = leadingSequence(volume); volume.source.empty() && sequence.hasFrame())
            throw Error(ErrorKind::usage, fmt::format("{}: '{}' is a sequence; give the frames with --frames ({})",
                                                      name(), sequence.pattern, rangeText(existingFrames(sequence))));
    if (scene.output.path.outputHasFrame())
        throw Error(ErrorKind::usage,
                    fmt::format("{}: the output '{}' has a placeholder for the frame; give the frames with --frames",
                                name(), scene.output.path.pattern));
    return {1};
}

std::string SceneInput::printedToml(const RenderOptions& options) {
    if (m_shot.isAsset() && !isUtf8(name()))
        throw Error(
            ErrorKind::usage,
            fmt::format("{}: the name is not UTF-8, so no scene can name it; rename it, or make a link to it", name()));
    if (m_options.output.empty()) return m_shot.toml({}, options);
    if (!isUtf8(m_options.output))
        throw Error(ErrorKind::usage, "--output: the name is not UTF-8, so no scene can name it");
    // The generated text of an asset is kept as readable as it is.
    if (m_shot.isAsset() && overridesOf(m_options).empty())
        return m_shot.toml({}, options) + fmt::format("\n[output]\nfile = {}\n", tomlString(m_options.output));
    // Paths of the command line are relative to the current folder, those of a scene to the scene's folder.
    const bool here = m_shot.isAsset() || std::filesystem::path(name()).parent_path().empty();
    const std::string file = here ? m_options.output : absolutePattern("", m_options.output);
    return m_shot.toml({fmt::format("output.file={}", tomlString(file))}, options);
}

Stages readStages(const SceneOptions& options, Console& console) {
    Stages stages;
    for (const std::string& path : options.inputs) {
        stages.push_back(isStage(path) ? std::optional(readStage(path, options)) : std::nullopt);
        if (!stages.back()) continue;
        for (const std::string& text : stages.back()->warnings) console.warning(text);
        for (const std::string& text : stages.back()->notes) console.detail(text);
    }
    return stages;
}

std::vector<SceneInput> openInputs(const SceneOptions& options) {
    Console console(options.verbose, options.quiet);
    return openInputs(options, readStages(options, console));
}

std::vector<SceneInput> openInputs(const SceneOptions& options, const Stages& stages) {
    std::vector<SceneInput> inputs;
    std::size_t count = 0;
    for (const auto& stage : stages) count += stage ? stage->scenes.size() : 1;
    inputs.reserve(count);  // no reallocation: later inputs refer to the first
    for (std::size_t i = 0; i < options.inputs.size(); ++i) {
        const auto sharing = [&] { return inputs.empty() ? nullptr : &inputs.front(); };
        if (!stages[i]) {
            inputs.emplace_back(options.inputs[i], options, sharing());
            continue;
        }
        for (const UsdScene& part : stages[i]->scenes)
            inputs.emplace_back(options.inputs[i], *stages[i], part, options, sharing());
    }
    return inputs;
}

void claimInputs(const std::vector<SceneInput>& inputs, const SceneOptions& options, FileClaims& claims) {
    const char* const environment = std::getenv("OCIO");
    const std::string config = options.ocio.empty() && environment != nullptr ? environment : options.ocio;
    claims.reads(config, "the OpenColorIO config");
    for (const SceneInput& input : inputs)
        for (const SceneFile& file : filesReadBy(input.shot(), input.frames())) claims.reads(file.path, file.role);
}

/// The number of frames of all inputs with this name.
std::size_t framesOf(const std::vector<SceneInput>& inputs, const std::string& name) {
    std::size_t count = 0;
    for (const SceneInput& input : inputs)
        if (input.name() == name) count += input.frames().size();
    return count;
}

void claimOutputs(const std::vector<SceneInput>& inputs, const SceneOptions& options, FileClaims& claims) {
    const auto claim = [&](const SceneInput& input, const FramePath& path, int frame, const std::string& of) {
        if (path.pattern.empty()) return;
        const std::string file = path.outputAt(frame);
        const std::string other = claims.writes(file, of);
        if (other.empty()) return;
        if (other == of && !path.outputHasFrame())
            throw Error(ErrorKind::usage,
                        fmt::format("all {} frames would be written to '{}'; put the frame into its name: {}",
                                    framesOf(inputs, input.name()), file,
                                    std::filesystem::path(file)
                                        .replace_extension(".####" + std::filesystem::path(file).extension().string())
                                        .string()));
        throw Error(ErrorKind::usage, fmt::format("'{}' would be written twice, for {} and for {}", file, other, of));
    };
    for (const SceneInput& input : inputs)
        for (const int frame : input.frames()) {
            const std::string name = " of " + input.name();
            claim(input, input.output(), frame, "the picture" + name);
            claim(input, input.preview(), frame, "the preview" + name);
            claim(input, input.deep(), frame, "the deep picture" + name);
            for (const OutputFile& more : input.files())
                claim(input, more.path, frame, "the file of layers at " + more.where);
        }
    if (!options.stats.empty()) claims.writesAlone(options.stats, "--stats");
}

RenderOptions renderOptionsOf(const SceneOptions& options, MessageSink messages) {
    RenderOptions out;
    out.crop = options.crop;
    out.threads = options.threads;
    out.memory = options.memory;
    out.missing = options.missing;
    out.previewExposure = options.exposure.value_or(0);
    out.verify = options.verify;
    out.verifyLimit = options.verifyLimit;
    out.checkpoint = throwIfInterrupted;
    out.messages = std::move(messages);
    return out;
}

}  // namespace scrim::cli
