// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/scene_files.h>

#include <scrim/volume/load_fields.h>

#include <fmt/format.h>

namespace scrim {
namespace {

void addVolume(const SceneVolume& volume, std::vector<SceneFile>& files) {
    const std::string role = fmt::format("the volume '{}'", volume.name);
    if (!volume.source.empty()) {
        if (const std::string file = fileIn(volume.parameters); !file.empty())
            files.push_back({file, "the file of " + role});
        return;
    }
    if (volume.file.empty()) return;  // made in code
    files.push_back({volume.file, role});
    for (const int frame : existingFrames(volume.sequence)) files.push_back({volume.sequence.at(frame), role});
}

}  // namespace

std::vector<SceneFile> filesReadBy(const Scene& scene) {
    std::vector<SceneFile> files;
    for (const SceneVolume& volume : scene.volumes) addVolume(volume, files);
    if (scene.plate) files.push_back({scene.plate->file, "the picture that the camera is that of"});
    for (const Light& light : scene.lights)
        if (light.slide && !light.slide->file.empty())
            files.push_back({light.slide->file, fmt::format("the slide of light '{}'", light.name)});
    return files;
}

}  // namespace scrim
