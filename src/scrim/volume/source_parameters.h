// SPDX-License-Identifier: Apache-2.0
// Parameters of volume sources: what a source declares, and how text becomes values. The host parses them, so that
// every source refuses bad parameters in the same words and none needs a parser.
#pragma once

#include <scrim/volume/scrim_source.h>

#include <deque>
#include <string>
#include <utility>
#include <vector>

namespace scrim {

enum class ParameterType { number, integer, vec3, string, boolean };

/// Names and values as text.
using SourceParameters = std::vector<std::pair<std::string, std::string>>;

/// "number", "integer", "vec3", "string" or "bool".
std::string typeName(ParameterType type);

struct ParameterDescription {
    std::string name;
    ParameterType type = ParameterType::number;
    std::string defaultText;
    double minimum = 0;  ///< both 0: no limits
    double maximum = 0;
    std::vector<std::string> choices;  ///< for strings; empty: any text
    std::string help;

    bool limited() const { return minimum != 0 || maximum != 0; }
};

/// Values in the order of their descriptions, together with the text that they point to.
struct ParameterValues {
    std::vector<scrim_value> values;
    std::deque<std::string> texts;
};

/// Values parsed from text, with defaults where none is given. Throws Error(input) "`where`: ..." for an unknown name
/// (with the choices) or a repeated one, and for text that does not fit the type, range or choices.
ParameterValues parseParameters(const std::vector<ParameterDescription>& descriptions, const SourceParameters& given,
                                const std::string& where);

}  // namespace scrim
