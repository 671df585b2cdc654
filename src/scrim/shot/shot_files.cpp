// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/shot_files.h>

#include <scrim/shot/shot_content.h>

namespace scrim {

std::vector<SceneFile> filesReadBy(const Shot& shot, int frame) {
    std::vector<SceneFile> files = filesReadBy(shot.m_content->sceneUnframed(frame));
    // An asset is a volume.
    if (!shot.isAsset() && !shot.path().empty()) files.push_back({shot.path(), "the scene"});
    return files;
}

}  // namespace scrim
