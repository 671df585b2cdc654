// SPDX-License-Identifier: Apache-2.0
// File names with a frame in them. "####", "%04d" and "$F4" stand for the frame with at least four digits,
// "%d" and "$F" for the bare number; "$$", "$#" and "$%" for the second of these characters. "${NAME}" stands for a
// variable. What stands for the frame may be in a file's name or in the names of its folders. OpenImageIO has patterns,
// too, but no "$F4". plugins/kit/scrim_kit/frames.py says the same once more, and a test of it compares the two.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace scrim {

/// Value of a variable, or nothing where there is none.
using VariableLookup = std::function<std::optional<std::string>(const std::string& name)>;

/// `pattern` with every ${NAME} replaced, once: values are not searched for further variables, but may hold
/// "####". Throws Error(input) "`where`: ..." on an unknown or malformed one, and on a '$' that begins
/// nothing.
std::string expandVariables(const std::string& pattern, const VariableLookup& lookup, const std::string& where);

/// Whether `pattern` names different files for different frames.
bool hasFrame(const std::string& pattern);

/// The pattern that names `path`, whatever is in it, at all frames.
std::string patternOf(const std::string& path);

/// `pattern` as it is from the root of the file system on, where it is relative to `folder` ("": the current one).
std::string absolutePattern(const std::string& folder, const std::string& pattern);

/// `pattern` without what stands for the frame.
std::string withoutFrame(const std::string& pattern);

/// `pattern` with the frame put in. Negative frames are written as printf does: "-005".
std::string expandFrame(const std::string& pattern, int frame);

/// `path` as seen from `folder`, or `path` itself where it is absolute or `folder` is empty.
std::string pathIn(const std::string& folder, const std::string& path);

/// A pattern and the folder it is relative to. Only the pattern is searched for frames: folders may have any
/// name.
struct FramePath {
    std::string folder;
    std::string pattern;

    /// To read: a file that there is by the very name of the pattern ("take#2.vdb") is that file at all frames.
    bool hasFrame() const;
    std::string at(int frame) const;

    /// To write: whatever there is.
    bool outputHasFrame() const { return scrim::hasFrame(pattern); }
    std::string outputAt(int frame) const;
};

/// The frames for which `path` has a file, ascending. None where the pattern has no frame, or has it in the
/// name of a folder.
std::vector<int> existingFrames(const FramePath& path);

}  // namespace scrim
