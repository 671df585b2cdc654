// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/shot_text.h>

#include <scrim/base/error.h>
#include <scrim/scene/framing.h>

#include <fmt/format.h>

#include <cctype>
#include <filesystem>
#include <system_error>

namespace scrim {
namespace {

constexpr Int2 kFramedResolution{512, 512};

/// `path` as a scene would name it, literally where there is such a file.
std::string assetPattern(const std::string& path) {
    std::error_code ignored;
    if (!std::filesystem::exists(path, ignored)) return path;
    std::string pattern;
    for (const char c : path) pattern.append(c == '$' ? 2 : 1, c);
    return pattern;
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

}  // namespace

std::string lowerExtension(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string();
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return extension;
}

ShotText::ShotText(const std::string& path, const std::vector<std::string>& overrides,
                   const std::optional<Int2>& resolution)
    : m_path(path), m_framedResolution(resolution.value_or(kFramedResolution)) {
    const std::string extension = lowerExtension(path);
    m_asset = extension == ".vdb";
    if (!m_asset && extension != ".toml")
        throw Error(ErrorKind::usage, fmt::format("{}: expected a scene (.toml) or an asset (.vdb)", shortened(path)));
    if (m_asset) {
        // Until the asset is loaded: its scene but for the numbers.
        m_assetPattern = assetPattern(path);
        const SparseField nothing;
        m_text = {path + " (framed)", "", framedText(nothing)};
    } else {
        m_text = loadSceneText(path);
        if (resolution) m_overrides.push_back(fmt::format("camera.resolution=[{}, {}]", resolution->x, resolution->y));
    }
    m_overrides.insert(m_overrides.end(), overrides.begin(), overrides.end());
}

std::string ShotText::framedText(const SparseField& field) const {
    return framingScene(m_assetPattern, {{"", &field}}, m_framedResolution);
}

void ShotText::frameAsset(FieldStore& store) {
    if (!m_asset || m_framed) return;
    std::shared_ptr<const SparseField> largest;
    for (const std::string& file : filesToFrame({"", m_assetPattern}, m_path)) {
        const auto field = store.fieldOf(file, {});
        if (!largest || sizeOf(*field) > sizeOf(*largest)) largest = field;
    }
    m_text.text = framedText(*largest);
    m_framed = true;
}

Scene ShotText::at(int frame, const ColourConfig& colour) const {
    Scene scene = readScene(m_text, frame, m_overrides, colour);
    SceneOutput& output = scene.output;
    if (output.path.pattern.empty())
        output.path = {"", std::filesystem::path(m_asset ? m_assetPattern : m_path).stem().string() + ".exr"};
    output.file = output.path.at(frame);
    if (!output.preview.path.pattern.empty()) output.preview.file = output.preview.path.at(frame);
    return scene;
}

std::string ShotText::toml(const std::vector<std::string>& more) const {
    std::vector<std::string> overrides = m_overrides;
    overrides.insert(overrides.end(), more.begin(), more.end());
    return sceneAsToml(m_text, overrides);
}

}  // namespace scrim
