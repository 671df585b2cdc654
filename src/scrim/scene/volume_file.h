// SPDX-License-Identifier: Apache-2.0
// Finds the file that a volume shows at its frame: the sequence's own file, a held one, or none.
#pragma once

#include <scrim/scene/scene.h>

#include <string>

namespace scrim {

enum class FileState {
    present,  ///< the file to read is `path`
    black,    ///< the scene wants no volume at this frame
    missing,  ///< there should be a file; `problem` is the message of the error
};

struct VolumeFile {
    FileState state = FileState::present;
    std::string path;
    std::string problem;
};

/// For a volume with a file. The policies `hold` and `black` count before the first and after the last file of a
/// sequence; a gap inside the sequence is a lost file, and missing under any policy.
VolumeFile findVolumeFile(const SceneVolume& volume);

}  // namespace scrim
