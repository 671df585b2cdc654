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

/// Looks for one file, the one number `frame` of a sequence.
VolumeFile findFile(const SceneVolume& volume, const FramePath& sequence, int frame, const std::string& file) {
    VolumeFile found{FileState::present, file, {}};
    std::error_code ignored;
    if (std::filesystem::exists(file, ignored)) return found;

    const std::vector<int> frames = existingFrames(sequence);
    const bool outside = frames.empty() || frame < frames.front() || frame > frames.back();
    if (outside && volume.outside == OutsidePolicy::black) {
        found.state = FileState::black;
    } else if (outside && volume.outside == OutsidePolicy::hold && !frames.empty()) {
        found.path = sequence.at(frame < frames.front() ? frames.front() : frames.back());
    } else if (outside && !frames.empty() &&
               (volume.outside == OutsidePolicy::repeat || volume.outside == OutsidePolicy::pingPong)) {
        const int within = frameWithin(frame, frames.front(), frames.back(), volume.outside);
        return findFile(volume, sequence, within, sequence.at(within));
    } else {
        found.state = FileState::missing;
        found.problem = fmt::format("{}: volume '{}': there is no file '{}'", volume.where, volume.name, file);
        if (!frames.empty())
            found.problem +=
                fmt::format(" for frame {}; the sequence has frames {} to {}", frame, frames.front(), frames.back());
    }
    return found;
}

/// Looks for the files number `frame` of a volume.
VolumeFile findFiles(const SceneVolume& volume, int frame) {
    if (volume.sequences.empty())
        return findFile(volume, volume.sequence, frame,
                        frame == volume.frame ? volume.file : volume.sequence.at(frame));
    VolumeFile found{FileState::present, {}, {}};
    for (const FramePath& sequence : volume.sequences) {
        const VolumeFile one = findFile(volume, sequence, frame, sequence.at(frame));
        found.all.push_back(one.path);
        if (found.state != FileState::missing && one.state != FileState::present) {
            found.state = one.state;
            found.problem = one.problem;
        }
    }
    found.path = found.all.front();
    return found;
}

}  // namespace

VolumeFile findVolumeFile(const SceneVolume& volume) {
    VolumeFile found = findFiles(volume, volume.frame);
    if (volume.beyond == 0 || found.state == FileState::missing) return found;
    VolumeFile next = findFiles(volume, volume.frame + 1);
    if (next.state == FileState::missing) return next;
    if (next.state == FileState::black) found.state = next.state;
    if (found.state == FileState::present && (next.path != found.path || next.all != found.all))
        found.next = std::make_shared<const VolumeFile>(std::move(next));
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
