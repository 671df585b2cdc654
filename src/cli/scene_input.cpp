// SPDX-License-Identifier: Apache-2.0
#include "scene_input.h"

#include "console.h"

#include <scrim/base/error.h>
#include <scrim/scene/framing.h>

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <system_error>

namespace scrim::cli {
namespace {

constexpr Int2 kFramedResolution{512, 512};

std::string lowerExtension(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string();
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return extension;
}

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

/// `path` as a scene would name it, literally where there is such a file.
std::string assetPattern(const std::string& path) {
    std::error_code ignored;
    if (!std::filesystem::exists(path, ignored)) return path;
    std::string pattern;
    for (const char c : path) pattern.append(c == '$' ? 2 : 1, c);
    return pattern;
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

/// What the command line changes in the scene (that of an asset has the resolution already), in the order of
/// being applied.
std::vector<std::string> overridesOf(const SceneOptions& options, bool framed) {
    std::vector<std::string> overrides;
    if (options.resolution && !framed)
        overrides.push_back(fmt::format("camera.resolution=[{}, {}]", options.resolution->x, options.resolution->y));
    if (!options.quality.empty()) overrides.push_back(fmt::format("render.quality={}", quoted(options.quality)));
    if (options.tolerance > 0) overrides.push_back(fmt::format("render.tolerance={}", options.tolerance));
    overrides.insert(overrides.end(), options.sets.begin(), options.sets.end());
    return overrides;
}

/// Of a sequence, frames that show how far it reaches; the same whichever frames a task of a farm renders.
std::vector<std::string> filesToFrame(const FramePath& path, const std::string& name) {
    if (!path.hasFrame()) return {path.at(0)};
    const std::vector<int> frames = existingFrames(path);
    if (frames.empty()) throw Error(ErrorKind::input, fmt::format("{}: the sequence has no files", name));
    std::vector<std::string> files;
    for (const int frame : {frames.front(), frames[frames.size() / 2], frames.back()})
        if (files.empty() || files.back() != path.at(frame)) files.push_back(path.at(frame));
    return files;
}

double sizeOf(const SparseField& field) {
    if (field.empty()) return 0;
    const Vec3 size = transformed(field.wsFromIs, field.isBounds()).size();
    return size.x * size.x + size.y * size.y + size.z * size.z;
}

std::string rangeText(const std::vector<int>& frames) {
    if (frames.empty()) return "no files exist";
    return fmt::format("files exist for {} to {}", frames.front(), frames.back());
}

}  // namespace

SceneInput::SceneInput(const std::string& path, const SceneOptions& options, const ColourConfig& colour,
                       FieldStore& store)
    : m_path(path), m_options(options), m_colour(colour), m_store(store) {
    const std::string extension = lowerExtension(path);
    m_asset = extension == ".vdb";
    if (!m_asset && extension != ".toml")
        throw Error(ErrorKind::usage, fmt::format("{}: expected a scene (.toml) or an asset (.vdb)", clipped(path)));
    if (m_asset) {
        // Until the asset is loaded: its scene but for the numbers.
        m_assetPattern = assetPattern(path);
        const SparseField nothing;
        m_text = {path + " (framed)", "", framedText(nothing)};
    } else {
        m_text = loadSceneText(path);
    }
    m_overrides = overridesOf(options, m_asset);
    const Scene scene = read(m_text, options.frames.empty() ? 1 : options.frames.front());
    m_frames = framesOf(scene);
    m_output = scene.output.path;
    m_preview = scene.output.preview.path;
    if (lowerExtension(m_output.pattern) != ".exr")
        throw Error(ErrorKind::usage, fmt::format("the output '{}' does not end in '.exr'; --preview writes other "
                                                  "kinds of pictures",
                                                  clipped(m_output.pattern)));
}

Scene SceneInput::read(const SceneText& text, int frame) const {
    Scene scene = readScene(text, frame, m_overrides, m_colour);
    if (!m_options.quality.empty() && m_options.tolerance == 0) scene.tolerance = 0;  // the preset is in its place
    SceneOutput& output = scene.output;
    if (!m_options.output.empty()) output.path = pathFrom("--output", m_options.output);
    if (output.path.pattern.empty()) {
        const std::string name = m_asset ? m_assetPattern : m_path;
        output.path = {"", std::filesystem::path(name).stem().string() + ".exr"};
    }
    output.file = output.path.at(frame);
    if (!m_options.preview.empty()) output.preview.path = pathFrom("--preview", m_options.preview);
    if (!output.preview.path.pattern.empty()) output.preview.file = output.preview.path.at(frame);
    return scene;
}

std::vector<int> SceneInput::framesOf(const Scene& scene) const {
    if (!m_options.frames.empty()) return m_options.frames;
    if (m_options.printScene) return {1};
    for (const SceneVolume& volume : scene.volumes)
        if (volume.source.empty() && volume.sequence.hasFrame())
            throw Error(ErrorKind::usage,
                        fmt::format("{}: '{}' is a sequence; say which frames with --frames ({})", m_path,
                                    volume.sequence.pattern, rangeText(existingFrames(volume.sequence))));
    if (scene.output.path.hasFrame())
        throw Error(ErrorKind::usage, fmt::format("{}: the output '{}' has a place for the frame; say which frames "
                                                  "with --frames",
                                                  m_path, scene.output.path.pattern));
    return {1};
}

void SceneInput::frameAsset() {
    m_framed = true;
    std::shared_ptr<const SparseField> largest;
    for (const std::string& file : filesToFrame({"", m_assetPattern}, m_path)) {
        const auto field = m_store.fieldOf(file, {});
        if (!largest || sizeOf(*field) > sizeOf(*largest)) largest = field;
    }
    m_text.text = framedText(*largest);
}

std::string SceneInput::framedText(const SparseField& field) const {
    return framingScene(m_assetPattern, {{"", &field}}, m_options.resolution.value_or(kFramedResolution));
}

Scene SceneInput::sceneAt(int frame) {
    if (m_asset && !m_framed) frameAsset();
    return read(m_text, frame);
}

std::string SceneInput::toml() {
    if (m_asset && !m_framed) frameAsset();
    return sceneAsToml(m_text, m_overrides);
}

std::string SceneInput::printedToml() {
    if (m_options.output.empty()) return toml();
    // The text that frames an asset stays as readable as it is.
    if (m_asset && m_overrides.empty())
        return toml() + fmt::format("\n[output]\nfile = {}\n", quoted(m_options.output));
    // Paths of the command line are relative to the current folder, those of a scene to its own.
    const bool here = m_text.folder.empty();
    const std::string file = here ? m_options.output : (std::filesystem::current_path() / m_options.output).string();
    toml();
    std::vector<std::string> overrides = m_overrides;
    overrides.push_back(fmt::format("output.file={}", quoted(file)));
    return sceneAsToml(m_text, overrides);
}

std::vector<SceneInput> openInputs(const SceneOptions& options, const ColourConfig& colour, FieldStore& store,
                                   bool writes) {
    std::vector<SceneInput> inputs;
    for (const std::string& path : options.inputs) inputs.emplace_back(path, options, colour, store);
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

std::size_t memoryLeft(std::size_t limit, const Fields& fields, std::size_t slideBytes) {
    const std::size_t taken = bytesOf(fields) + slideBytes;
    if (limit == 0) return 0;
    if (taken >= limit)
        throw Error(ErrorKind::memory,
                    fmt::format("the volumes{} take {}, which leaves nothing of the limit of {} (--memory)",
                                slideBytes > 0 ? " and slides" : "", bytesText(taken), bytesText(limit)));
    return limit - taken;
}

}  // namespace scrim::cli
