// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/volume_file.h>

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

namespace scrim {

VolumeFile findVolumeFile(const SceneVolume& volume) {
    VolumeFile found{FileState::present, volume.file, {}};
    std::error_code ignored;
    if (std::filesystem::exists(volume.file, ignored)) return found;

    const std::vector<int> frames = existingFrames(volume.sequence);
    const bool outside = frames.empty() || volume.frame < frames.front() || volume.frame > frames.back();
    if (outside && volume.outside == OutsidePolicy::black) {
        found.state = FileState::black;
    } else if (outside && volume.outside == OutsidePolicy::hold && !frames.empty()) {
        found.path = volume.sequence.at(volume.frame < frames.front() ? frames.front() : frames.back());
    } else {
        found.state = FileState::missing;
        found.problem = fmt::format("{}: volume '{}': there is no file '{}'", volume.where, volume.name, volume.file);
        if (!frames.empty())
            found.problem += fmt::format(" for frame {}; the sequence has frames {} to {}", volume.frame,
                                         frames.front(), frames.back());
    }
    return found;
}

}  // namespace scrim
