// SPDX-License-Identifier: Apache-2.0
// What a scene does to the grids of a volume before they become fields: putting them together from
// several files, cutting, refining, expressions in OpenVDB AX.
// This is the description alone; GridEditor (grid_editor.h) carries it out.
#pragma once

#include <scrim/geometry/bounds.h>
#include <scrim/geometry/spaces.h>
#include <scrim/volume/point_cloud.h>

#include <optional>
#include <string>
#include <vector>

namespace scrim {

/// The value of an external variable of an expression: a number, or three.
struct AxVariable {
    std::string name;           ///< "wind" for v$wind
    std::vector<double> value;  ///< one number or three

    /// True for numbers that AX, which computes in floats, can hold.
    bool isFinite() const;
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
    /// The place of a character of `text`, of which AX says that it is in this line and column,
    /// from 1: "scene.toml:9:3".
    std::string placeOf(int axLine, int axColumn) const;
};

/// The code in a file. Editors may begin it with UTF-8's mark, which is no part of it. Throws Error(input).
std::string axFileText(const std::string& path);

/// A grid that is put together from grids of files.
struct CombinedGrid {
    /// How the parts become one. A voxel that a part does not have counts as 0.
    enum class How { copied, max, add, multiply };
    struct Part {
        std::size_t file = 0;  ///< index into GridEdit::files
        std::string grid;      ///< name, or "name[i]"; "": the one called as the combined grid, or else the only one
        std::string where;     ///< where the scene names it

        bool operator==(const Part&) const = default;
    };
    std::string name;
    How how = How::copied;    ///< `copied` has one part
    std::vector<Part> parts;  ///< at least one; the voxels of all become like those of the first

    bool operator==(const CombinedGrid&) const = default;
};

/// The most files that one volume may be put together from.
inline constexpr std::size_t kMostGridFiles = 32;

/// Everything is done in the order of the members.
struct GridEdit {
    /// The grids that the volume has, in place of those of its file; empty: all of its file.
    std::vector<CombinedGrid> grids = {};
    std::vector<std::string> files = {};  ///< their files, the first of which is the volume's own
    /// Voxels outside of this box are left out unless something in it depends on them; in world units of the asset.
    std::optional<Bounds> clip = {};
    /// Voxels are divided by this factor along each axis; values between them are interpolated linearly.
    double resample = 1;
    std::string density;  ///< name of the grid whose voxels new grids get, as GridRequest has it
    std::vector<AxCode> programs;
    std::vector<AxVariable> variables;  ///< for all programs
    std::string where;                  ///< where the scene gives the first of all that
    PointLook points = {};              ///< how points become grids, before all that
    /// The density is shaded on voxels divided by this factor, where that shows; 0: as fine as its
    /// noise is. Readers of grids have no part in it.
    int detail = 1;

    /// True if grids are not read as they are.
    bool changesGrids() const { return editsGrids() || points != PointLook(); }
    /// True if anything is done to grids after they were read.
    bool editsGrids() const { return !grids.empty() || clip || resample != 1 || !programs.empty(); }
    bool operator==(const GridEdit&) const = default;
};

/// Convert to text for other processes, and back; equal edits have equal texts. The latter throws
/// Error(usage) where the text is not such a text.
std::string toText(const GridEdit& edit);
GridEdit gridEditFrom(const std::string& text);

/// The names of the external variables that an expression mentions: "frame" for $frame or f$frame. Comments count, too.
std::vector<std::string> variablesIn(const std::string& code);

}  // namespace scrim
