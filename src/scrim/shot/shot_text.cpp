// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/shot_text.h>

#include <scrim/base/error.h>
#include <scrim/base/letter_case.h>
#include <scrim/scene/toml_text.h>
#include <scrim/scene/turntable.h>
#include <scrim/volume/foreign_format.h>

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

namespace scrim {
namespace {

/// `path` as a scene would name it; taken literally where such a file exists.
std::string assetPattern(const std::string& path) {
    std::error_code ignored;
    return std::filesystem::exists(path, ignored) ? patternOf(path) : path;
}

}  // namespace

std::string lowerExtension(const std::string& path) {
    return lowerCase(std::filesystem::path(path).extension().string());
}

ShotText::ShotText(const std::string& path, const std::vector<std::string>& overrides, const OpenOptions& options)
    : m_path(path), m_turntable(options.turntable) {
    m_asset = isAssetFile(path);
    if (const ForeignFormat* const format = foreignFormat(path))
        throw Error(ErrorKind::input, fmt::format("{}: {}", shortened(path), textOf(*format)));
    if (!m_asset && lowerExtension(path) != ".toml")
        throw Error(ErrorKind::usage,
                    fmt::format("{}: expected a scene (.toml), an asset (.vdb, .nvdb, .ply) or a scan (.nrrd, "
                                ".nhdr, .nii, .nii.gz, .hdr, .mha, .mhd, .npy, .mrc, .vti, .tif, .dcm, or a folder of "
                                "DICOM or TIFF slices)",
                                shortened(path)));
    if (m_asset) {
        // Until the asset is loaded, its scene lacks the numbers that depend on it.
        m_asAsset.resolution = options.resolution.value_or(m_asAsset.resolution);
        m_asAsset.wsUp = options.wsUp;
        m_assetPattern = assetPattern(path);
        m_text = {path + " (framed)", "", unframedText(m_assetPattern, m_asAsset)};
    } else {
        m_text = loadSceneText(path);
    }
    give(overrides, options);
}

ShotText::ShotText(SceneText text, const std::vector<std::string>& overrides, const OpenOptions& options)
    : m_path(text.file), m_turntable(options.turntable), m_text(std::move(text)) {
    give(overrides, options);
}

void ShotText::give(const std::vector<std::string>& overrides, const OpenOptions& options) {
    if (!m_asset) {
        if (options.wsUp)
            throw Error(ErrorKind::usage, fmt::format("{}: --up is for assets; for a scene use --set camera.up=[0,0,1]",
                                                      shortened(m_path)));
        m_text.gridsFromCode = options.gridsFromCode;
        m_text.deepFromCode = options.deepFromCode;
        if (const auto& resolution = options.resolution)
            m_given.push_back(fmt::format("camera.resolution=[{}, {}]", resolution->x, resolution->y));
    }
    add(overrides);
}

void ShotText::add(const std::vector<std::string>& overrides) {
    for (const std::string& assignment : overrides) {
        const std::size_t equals = std::min(assignment.find('='), assignment.size());
        const std::string key = assignment.substr(0, equals), value = assignment.substr(equals);
        // An asset that is not framed yet is framed for this picture, as by --res. Mistakes are the reader's to tell.
        Int2 size(0);
        if (!m_framed && key == "camera.resolution" && std::sscanf(value.c_str(), "=[%d,%d]", &size.x, &size.y) == 2 &&
            std::min(size.x, size.y) > 0)
            m_asAsset.resolution = size;
        if (!key.ends_with(".classified.window") || value.empty()) continue;
        m_asAsset.window = value.substr(1);
        m_framed = false;
    }
    m_given.insert(m_given.end(), overrides.begin(), overrides.end());
    applyTurntable();
}

void ShotText::applyTurntable() {
    m_overrides = m_given;
    if (m_turntable == 0) return;
    const std::vector<std::string> turn = turntableOverrides(m_text, m_given, m_turntable);
    m_overrides.insert(m_overrides.end(), turn.begin(), turn.end());
}

void ShotText::frameAsset(FieldStore& store, const MessageSink& messages) {
    if (!m_asset || m_framed) return;
    m_text.text = framedText(store, m_path, m_assetPattern, m_asAsset, messages);
    m_framed = true;
    applyTurntable();
}

void nameOutputs(SceneOutput& output, int frame) {
    output.file = output.path.outputAt(frame);
    for (OutputFile& more : output.files) more.file = more.path.outputAt(frame);
    if (!output.preview.path.pattern.empty()) output.preview.file = output.preview.path.outputAt(frame);
    if (!output.deep.path.pattern.empty()) output.deep.file = output.deep.path.outputAt(frame);
}

Scene ShotText::at(int frame, const ColourConfig& colour, double within) const {
    Scene scene = readScene(m_text, frame, m_overrides, colour, within);
    // A name that is not UTF-8 cannot be part of the scene's text, so it is set here.
    if (m_asset && !isUtf8(m_assetPattern))
        for (SceneVolume& volume : scene.volumes) {
            const FramePath path{"", m_assetPattern};
            if (volume.source.empty()) {
                volume.sequence = path;
                volume.file = path.at(volume.frame);
            }
            for (auto& [name, value] : volume.parameters)
                if (name == "file") value = path.at(frame);
        }
    SceneOutput& output = scene.output;
    if (output.path.pattern.empty()) {
        const bool sequence = m_asset && FramePath{"", m_assetPattern}.hasFrame();
        const bool turns = m_turntable > 0 && !sequence;
        const std::string name = std::filesystem::path(sequence ? m_assetPattern : m_path).stem().string();
        output.path = {"", (sequence ? name : patternOf(name)) + (turns ? ".####.exr" : ".exr")};
    }
    nameOutputs(output, frame);
    return scene;
}

std::string ShotText::toml(const std::vector<std::string>& more) const {
    std::vector<std::string> overrides = m_overrides;
    overrides.insert(overrides.end(), more.begin(), more.end());
    return sceneAsToml(m_text, overrides);
}

}  // namespace scrim
