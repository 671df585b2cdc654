// SPDX-License-Identifier: Apache-2.0
// Values as TOML text, for whoever writes a scene instead of reading one.
#pragma once

#include <string>

namespace scrim {

/// `text` as a string of TOML, in quotes.
std::string tomlString(const std::string& text);

}  // namespace scrim
