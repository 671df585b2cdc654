// SPDX-License-Identifier: Apache-2.0
// The one table of the dials: name, unit, default, allowed values and meaning. The scene reader,
// the command line and the page of dials all take them from here, so that they cannot disagree.
// Presets of quality are named settings of these dials.
#pragma once

#include <scrim/scene/dials.h>

#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace scrim {

struct DialInfo {
    std::string name;         ///< name of the key in [render]
    std::string unit;         ///< "voxels"; empty for dials with a choice of words
    std::string defaultText;  ///< value in the preset "standard"
    std::string allowed;      ///< "a number from 0.05 to 16", "'linear', 'gaussian' or 'bspline'"
    std::string meaning;      ///< one line of text
    bool chosen = false;      ///< chosen for each scene so that the preset's promised error holds
};

/// All dials, in the order in which help explains them.
const std::vector<DialInfo>& dialTable();

using DialValue = std::variant<double, std::string>;

/// Sets one dial. Throws Error(input) "`where`: ..." for an unknown name, a value of the wrong type
/// or a value that is not allowed; the message says what is allowed.
void setDial(Dials& dials, const std::string& name, const DialValue& value, const std::string& where);

/// Sets one dial from text, as on a command line: "0.5", "bilinear". Throws as setDial does.
void setDialFromText(Dials& dials, const std::string& name, const std::string& text, const std::string& where);

/// Throws as setDial does if any dial has a value that setDial would refuse.
void checkDials(const Dials& dials, const std::string& where);

/// The value of one dial as text that `setDialFromText` accepts. Throws Error(input) for an unknown name.
std::string dialText(const Dials& dials, const std::string& name);

/// draft, standard, high, ultra: from the fastest to the most accurate.
const std::vector<std::string>& presetNames();

/// The dials of a preset; no value for an unknown name. `texel` and `sheet_thickness` suit an average scene; for a
/// known scene they are chosen so that the preset's promise holds (verify/promise.h).
std::optional<Dials> presetDials(const std::string& name);

/// The `[render]` block that gives these dials in any scene.
std::string renderBlock(const Dials& dials);

/// The relative RMSE that a preset promises; it is larger for classified volumes, whose surfaces
/// are harder to resolve. 0 for an unknown name.
double promisedError(const std::string& name, bool classified);

/// The same for scenes in which light scatters more than once, of means over kScatteringMean x kScatteringMean pixels.
double promisedScatteringError(const std::string& name);
inline constexpr int kScatteringMean = 4;

}  // namespace scrim
