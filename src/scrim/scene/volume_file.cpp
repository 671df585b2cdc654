// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/volume_file.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>
#include <utility>

namespace scrim {
namespace {

/// Where a sequence is at a number that may lie outside of its ends, by a policy other than `error` and `black`.
double placeWithin(double number, const FileEnds& ends, OutsidePolicy outside) {
    const double first = ends[0], last = ends[1], steps = last - first;
    if (steps == 0 || outside == OutsidePolicy::hold) return std::clamp(number, first, last);
    const bool repeats = outside == OutsidePolicy::repeat;
    const double period = repeats ? steps + 1 : 2 * steps;
    const double at = number - first - period * std::floor((number - first) / period);
    return first + (repeats || at <= steps ? at : period - at);
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
        const int within = static_cast<int>(placeWithin(frame, {frames.front(), frames.back()}, volume.outside));
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

/// VolumeFile::ends. Of several sequences, those of the leading one count.
std::optional<FileEnds> endsOf(const SceneVolume& volume) {
    const bool within = volume.outside == OutsidePolicy::error || volume.outside == OutsidePolicy::black;
    if (volume.frameMap.between == BetweenFiles::nearest || within) return {};
    const std::vector<int> frames = existingFrames(leadingSequence(volume));
    if (frames.empty()) return {};
    return {{frames.front(), frames.back()}};
}

}  // namespace

VolumeFile findVolumeFile(const SceneVolume& volume) {
    VolumeFile found = findFiles(volume, volume.frame);
    const auto ends = endsOf(volume);
    found.ends = ends;
    if (volume.beyond == 0 || found.state == FileState::missing) return found;
    VolumeFile next = findFiles(volume, volume.frame + 1);
    if (next.state == FileState::missing) return next;
    if (next.state == FileState::black) found.state = next.state;
    if (found.state != FileState::present || (next.path == found.path && next.all == found.all)) return found;
    // Velocities lead from each file to the one whose number is higher.
    const auto place = [&](int number) { return placeWithin(number, *ends, volume.outside); };
    const bool back =
        ends && volume.outside == OutsidePolicy::pingPong && place(volume.frame + 1) < place(volume.frame);
    if (back) std::swap(found, next);
    found.beyond = back ? 1 - volume.beyond : volume.beyond;
    found.ends = ends;
    found.next = std::make_shared<const VolumeFile>(std::move(next));
    return found;
}

double filesWithin(const SceneVolume& volume, const std::optional<FileEnds>& ends, double from, double t) {
    const FrameMap& map = volume.frameMap;
    if (map.between == BetweenFiles::nearest) return t;
    // One that repeats goes on in the same direction.
    const bool folds = ends && (volume.outside != OutsidePolicy::repeat || (*ends)[0] == (*ends)[1]);
    const auto at = [&](double frame) {
        return folds ? placeWithin(map.numberAt(frame), *ends, volume.outside) : map.numberAt(frame);
    };
    return at(from + t) - at(from);
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
