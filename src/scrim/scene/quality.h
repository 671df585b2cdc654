// SPDX-License-Identifier: Apache-2.0
// The one table of the dials: name, unit, default, what is allowed, meaning. The scene reader, the command
// line and the page of dials take them from here, so that they cannot disagree. Presets of quality are points in the
// same space.
#pragma once

#include <scrim/scene/dials.h>

#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace scrim {

struct DialInfo {
    std::string name;         ///< as in [render]
    std::string unit;         ///< "voxels"; empty for a choice
    std::string defaultText;  ///< of the preset "standard"
    std::string allowed;      ///< "a number from 0.05 to 16", "'linear', 'gaussian' or 'bspline'"
    std::string meaning;      ///< one line
    bool chosen = false;      ///< by presets, for what they promise
};

/// All dials in the order they are explained in.
const std::vector<DialInfo>& dialTable();

using DialValue = std::variant<double, std::string>;

/// Turns one dial. Throws Error(input) "`where`: ..." on an unknown name, a value of the wrong type or one
/// that is not allowed; the message says what is.
void setDial(Dials& dials, const std::string& name, const DialValue& value, const std::string& where);

/// The same from text, as on a command line: "0.5", "bilinear".
void setDialFromText(Dials& dials, const std::string& name, const std::string& text, const std::string& where);

/// Throws as setDial where one of them stands where it could not be turned to.
void checkDials(const Dials& dials, const std::string& where);

/// The value of one dial as text that `setDialFromText` takes. Throws Error(input) on an unknown name.
std::string dialText(const Dials& dials, const std::string& name);

/// draft, standard, high, ultra: from fast to accurate.
const std::vector<std::string>& presetNames();

/// Nothing where there is no such preset. `texel` and `sheet_thickness` are those of an average scene; of a scene that
/// is known, they are chosen for what the preset promises (verify/promise.h).
std::optional<Dials> presetDials(const std::string& name);

/// The `[render]` block that gives these dials in any scene.
std::string renderBlock(const Dials& dials);

/// The relative RMSE that a preset promises: surfaces of classified volumes are harder. 0: there is no such preset.
double promisedError(const std::string& name, bool classified);

}  // namespace scrim
