// SPDX-License-Identifier: Apache-2.0
// File names with a frame number in them. "####", "%04d" and "$F4" stand for the frame with at least four digits, "%d"
// and "$F" for the frame without padding; "$$", "$#" and "$%" stand for "$", "#" and "%". "${NAME}" stands for a
// variable. The frame may stand in a file's name or in the names of its folders. OpenImageIO has patterns, too, but no
// "$F4". plugins/kit/scrim_kit/frames.py repeats these rules in Python, and a test compares the two.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace scrim {

/// The value of a variable; no value where it is not defined.
using VariableLookup = std::function<std::optional<std::string>(const std::string& name)>;

/// `pattern` with every ${NAME} replaced once: values are not searched for further variables, but may contain "####".
/// Throws Error(input) "`where`: ..." for an unknown or malformed variable and for a '$' that starts nothing known.
std::string expandVariables(const std::string& pattern, const VariableLookup& lookup, const std::string& where);

/// True if `pattern` names different files at different frames.
bool hasFrame(const std::string& pattern);

/// The pattern that names the file `path` at all frames, with its special characters escaped.
std::string patternOf(const std::string& path);

/// `pattern` as an absolute path; a relative one is relative to `folder` ("": the current folder).
std::string absolutePattern(const std::string& folder, const std::string& pattern);

/// `pattern` with the places for the frame removed.
std::string withoutFrame(const std::string& pattern);

/// `pattern` with the frame put in. Negative frames are written as printf writes them: "-005".
std::string expandFrame(const std::string& pattern, int frame);

/// `path` relative to `folder`; unchanged where it is absolute or `folder` is empty.
std::string pathIn(const std::string& folder, const std::string& path);

/// A pattern and the folder it is relative to. Only the pattern is searched for frame numbers, so
/// folders may have any name.
struct FramePath {
    std::string folder;
    std::string pattern;

    /// For reading. If a file exists whose name is the pattern itself ("take#2.vdb"), it is that file at all frames.
    bool hasFrame() const;
    std::string at(int frame) const;

    /// For writing. Existing files do not matter.
    bool outputHasFrame() const { return scrim::hasFrame(pattern); }
    std::string outputAt(int frame) const;
};

/// The frames for which `path` has a file, ascending. Empty where the pattern has no frame, or has
/// it in the name of a folder.
std::vector<int> existingFrames(const FramePath& path);

}  // namespace scrim
