// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/volume_file.h>

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <system_error>

namespace scrim {
namespace {

/// The frame of a sequence from `first` to `last` that repeats or goes to and fro.
int frameWithin(int frame, int first, int last, OutsidePolicy outside) {
    const std::int64_t steps = std::int64_t{last} - first;
    if (steps == 0) return first;
    const std::int64_t period = outside == OutsidePolicy::repeat ? steps + 1 : 2 * steps;
    const std::int64_t at = ((std::int64_t{frame} - first) % period + period) % period;
    return static_cast<int>(first + (at <= steps ? at : period - at));
}

/// Looks for one file, which `sequence` names at the volume's frame.
VolumeFile findFile(const SceneVolume& volume, const FramePath& sequence, const std::string& file) {
    VolumeFile found{FileState::present, file, {}};
    std::error_code ignored;
    if (std::filesystem::exists(file, ignored)) return found;

    const std::vector<int> frames = existingFrames(sequence);
    const bool outside = frames.empty() || volume.frame < frames.front() || volume.frame > frames.back();
    if (outside && volume.outside == OutsidePolicy::black) {
        found.state = FileState::black;
    } else if (outside && volume.outside == OutsidePolicy::hold && !frames.empty()) {
        found.path = sequence.at(volume.frame < frames.front() ? frames.front() : frames.back());
    } else if (outside && !frames.empty() &&
               (volume.outside == OutsidePolicy::repeat || volume.outside == OutsidePolicy::pingPong)) {
        SceneVolume within = volume;
        within.frame = frameWithin(volume.frame, frames.front(), frames.back(), volume.outside);
        return findFile(within, sequence, sequence.at(within.frame));
    } else {
        found.state = FileState::missing;
        found.problem = fmt::format("{}: volume '{}': there is no file '{}'", volume.where, volume.name, file);
        if (!frames.empty())
            found.problem += fmt::format(" for frame {}; the sequence has frames {} to {}", volume.frame,
                                         frames.front(), frames.back());
    }
    return found;
}

}  // namespace

VolumeFile findVolumeFile(const SceneVolume& volume) {
    if (volume.sequences.empty()) return findFile(volume, volume.sequence, volume.file);
    VolumeFile found{FileState::present, {}, {}};
    for (const FramePath& sequence : volume.sequences) {
        const VolumeFile one = findFile(volume, sequence, sequence.at(volume.frame));
        found.all.push_back(one.path);
        if (found.state != FileState::missing && one.state != FileState::present) {
            found.state = one.state;
            found.problem = one.problem;
        }
    }
    found.path = found.all.front();
    return found;
}

std::vector<FramePath> sequencesOf(const SceneVolume& volume) {
    if (!volume.source.empty() || volume.file.empty()) return {};
    return volume.sequences.empty() ? std::vector{volume.sequence} : volume.sequences;
}

const FramePath& leadingSequence(const SceneVolume& volume) {
    const auto moving = std::find_if(volume.sequences.begin(), volume.sequences.end(),
                                     [](const FramePath& sequence) { return sequence.hasFrame(); });
    return moving == volume.sequences.end() ? volume.sequence : *moving;
}

}  // namespace scrim
