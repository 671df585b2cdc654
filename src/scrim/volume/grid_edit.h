// SPDX-License-Identifier: Apache-2.0
// What a scene does to the grids of a volume before they become fields: cutting, refining, expressions in OpenVDB AX.
// This is the description alone; GridEditor (grid_editor.h) carries it out.
#pragma once

#include <scrim/geometry/bounds.h>
#include <scrim/geometry/spaces.h>

#include <optional>
#include <string>
#include <vector>

namespace scrim {

/// The value of an external variable of an expression: a number, or three.
struct AxVariable {
    std::string name;           ///< "wind" for v$wind
    std::vector<double> value;  ///< one number or three

    bool operator==(const AxVariable&) const = default;
};

/// An expression in OpenVDB AX, and where it was written.
struct AxCode {
    std::string text;
    /// Where the scene says `ax` or `ax_file`: "scene.toml:7:6".
    std::string where;
    /// The file whose lines these are: the scene's, or that of `ax_file`. "" where there are no lines: --set.
    std::string file;
    int line = 1, column = 1;  ///< place of the first character of `text` in `file`

    bool operator==(const AxCode&) const = default;
    /// The place of a character of `text`, of which AX says that it is in this line and column, from 1:
    /// "scene.toml:9:3".
    std::string placeOf(int axLine, int axColumn) const;
};

/// Everything is done in the order of the members.
struct GridEdit {
    /// Voxels outside of this box are left out unless something in it depends on them; in world units of the asset.
    std::optional<Bounds> clip = {};
    /// Voxels are divided by this factor along each axis; values between them are interpolated linearly.
    double resample = 1;
    std::string density;  ///< name of the grid whose voxels new grids get, as GridRequest has it
    std::vector<AxCode> programs;
    std::vector<AxVariable> variables;  ///< for all programs
    std::string where;                  ///< where the scene gives the first of all that

    bool operator==(const GridEdit&) const = default;
};

/// Convert to text for other processes, and back; equal edits have equal texts. The latter throws Error(usage) where
/// the text is not such a text.
std::string toText(const GridEdit& edit);
GridEdit gridEditFrom(const std::string& text);

/// The names of the external variables that an expression mentions: "frame" for $frame or f$frame. Comments count, too.
std::vector<std::string> variablesIn(const std::string& code);

}  // namespace scrim
