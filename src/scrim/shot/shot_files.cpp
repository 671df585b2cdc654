// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/shot_files.h>

#include <scrim/shot/shot_content.h>

namespace scrim {

std::vector<SceneFile> filesReadBy(const Shot& shot, const std::vector<int>& frames) {
    std::vector<SceneFile> files;
    for (const int frame : frames) {
        const Scene scene = shot.m_content->sceneUnframed(frame);
        if (files.empty()) files = sequenceFilesOf(scene);
        const std::vector<SceneFile> own = filesReadBy(scene);
        files.insert(files.end(), own.begin(), own.end());
    }
    // The file of an asset is already listed as a volume.
    if (!shot.isAsset() && !shot.path().empty()) files.push_back({shot.path(), "the scene"});
    return files;
}

}  // namespace scrim
