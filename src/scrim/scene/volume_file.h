// SPDX-License-Identifier: Apache-2.0
// Which file a volume shows at its frame, once the disk is asked: the sequence's own, the one that is held,
// or none.
#pragma once

#include <scrim/scene/scene.h>

#include <string>

namespace scrim {

enum class FileState {
    present,  ///< read `path`
    black,    ///< the scene wants no volume at this frame
    missing,  ///< there should be a file; `problem` is the text of the error
};

struct VolumeFile {
    FileState state = FileState::present;
    std::string path;
    std::string problem;
};

/// For a volume with a file. `hold` and `black` rule before the first and after the last file of a sequence;
/// a gap inside it is a lost file, and missing whatever the policy.
VolumeFile findVolumeFile(const SceneVolume& volume);

}  // namespace scrim
