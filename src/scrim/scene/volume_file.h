// SPDX-License-Identifier: Apache-2.0
// Finds the file that a volume shows at its frame: the sequence's own file, a held one, or none.
#pragma once

#include <scrim/scene/scene.h>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace scrim {

enum class FileState {
    present,  ///< the file to read is `path`
    black,    ///< the scene wants no volume at this frame
    missing,  ///< there should be a file; `problem` is the message of the error
};

/// The numbers of the first and the last file of a sequence.
using FileEnds = std::array<int, 2>;

struct VolumeFile {
    FileState state = FileState::present;
    std::string path;
    std::string problem;
    std::vector<std::string> all = {};  ///< volumes with `grids`: the files to read, of which `path` is the first
    /// Where the volume shows what is between two files: the second one, to which its smoke moves. On the way back of a
    /// sequence that goes to and fro, that is the one shown before. Null where it is the same file, which is held.
    std::shared_ptr<const VolumeFile> next = nullptr;
    double beyond = 0;  ///< how far the volume is from the first to the second one, 0 to less than 1
    /// Of a sequence whose files are mixed, where it rests, turns or starts again there; else none.
    std::optional<FileEnds> ends = {};
};

/// For a volume with a file. The policies other than `error` count before the first and after the last file of a
/// sequence; a gap inside the sequence is a lost file, and missing under any policy. Each file of a volume with `grids`
/// is looked for like that: the volume is missing where one of them is, and black where one of them is. So is each of
/// the two files between which the volume lies.
VolumeFile findVolumeFile(const SceneVolume& volume);

/// How many files go by from the scene's frame `from` to `t` frames after it, backwards where that is negative. Where
/// files are not mixed, `t`. `ends` are those of the volume's file; none: not known, as if there were files on and on.
double filesWithin(const SceneVolume& volume, const std::optional<FileEnds>& ends, double from, double t);

/// The patterns of all files that the volume shows at some frame; none for a source.
std::vector<FramePath> sequencesOf(const SceneVolume& volume);
/// The pattern that says what frames there are: the first one with a frame number, else the first one.
const FramePath& leadingSequence(const SceneVolume& volume);

}  // namespace scrim
