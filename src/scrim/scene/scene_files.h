// SPDX-License-Identifier: Apache-2.0
// The files that a scene reads, in one list for code that must not overwrite them.
#pragma once

#include <scrim/scene/scene.h>

#include <string>
#include <vector>

namespace scrim {

struct SceneFile {
    std::string path;
    std::string role;  ///< "the volume 'plume'"
};

/// The files that are read at the frame of `scene`, except for the scene file itself; missing files are included.
std::vector<SceneFile> filesReadBy(const Scene& scene);

/// All existing files of the volumes' sequences, which are read when other frames are rendered.
std::vector<SceneFile> sequenceFilesOf(const Scene& scene);

}  // namespace scrim
