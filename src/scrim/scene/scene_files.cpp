// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/scene_files.h>

#include <scrim/guard/load_fields.h>
#include <scrim/scene/volume_file.h>
#include <scrim/volume/grid_edit.h>

#include <fmt/format.h>

namespace scrim {
namespace {

std::string roleOf(const SceneVolume& volume) {
    return fmt::format("the volume '{}'", volume.name);
}

void addVolume(const SceneVolume& volume, std::vector<SceneFile>& files) {
    const std::string role = roleOf(volume);
    if (volume.edit)
        for (const AxCode& code : volume.edit->programs)
            if (!code.file.empty() && !code.where.starts_with(code.file + ":"))
                files.push_back({code.file, "the expression of " + role});
    if (!volume.source.empty()) {
        if (const std::string file = fileIn(volume.parameters); !file.empty())
            files.push_back({file, "the file of " + role});
        return;
    }
    if (volume.file.empty()) return;  // the volume is made in code
    if (volume.sequences.empty()) files.push_back({volume.file, role});
    for (std::size_t i = 0; i < volume.sequences.size(); ++i) files.push_back({volume.edit->files[i], role});
    if (volume.beyond > 0)
        for (const FramePath& sequence : sequencesOf(volume)) files.push_back({sequence.at(volume.frame + 1), role});
}

}  // namespace

std::vector<SceneFile> filesReadBy(const Scene& scene) {
    std::vector<SceneFile> files;
    for (const SceneVolume& volume : scene.volumes) addVolume(volume, files);
    for (const SceneMesh& mesh : scene.meshes)
        if (!mesh.file.empty()) files.push_back({mesh.file, fmt::format("the mesh '{}'", mesh.name)});
    if (scene.plate) files.push_back({scene.plate->file, "the picture that the camera is that of"});
    if (!scene.output.holdout.file.empty()) files.push_back({scene.output.holdout.file, "the holdout's picture"});
    if (const auto& plate = scene.output.preview.backplate; plate && !plate->file.empty())
        files.push_back({plate->file, "the preview's backplate"});
    for (const Light& light : scene.lights)
        if (light.slide && !light.slide->file.empty())
            files.push_back({light.slide->file, fmt::format("the slide of light '{}'", light.name)});
    for (const Light& light : scene.lights)
        if (light.luminaire && !light.luminaire->file.empty())
            files.push_back({light.luminaire->file, fmt::format("the luminaire of light '{}'", light.name)});
    return files;
}

std::vector<SceneFile> sequenceFilesOf(const Scene& scene) {
    std::vector<SceneFile> files;
    for (const SceneVolume& volume : scene.volumes)
        for (const FramePath& sequence : sequencesOf(volume))
            for (const int frame : existingFrames(sequence)) files.push_back({sequence.at(frame), roleOf(volume)});
    return files;
}

}  // namespace scrim
