// SPDX-License-Identifier: Apache-2.0
// The files that a scene reads: one list for whoever must leave them as they are.
#pragma once

#include <scrim/scene/scene.h>

#include <string>
#include <vector>

namespace scrim {

struct SceneFile {
    std::string path;
    std::string role;  ///< "the volume 'plume'"
};

/// At the frame of `scene`. Not the file of the scene itself. Files that are missing are among them.
std::vector<SceneFile> filesReadBy(const Scene& scene);

/// All files that there are of the sequences of volumes: whoever renders other frames reads those.
std::vector<SceneFile> sequenceFilesOf(const Scene& scene);

}  // namespace scrim
