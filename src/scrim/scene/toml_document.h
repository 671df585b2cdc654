// SPDX-License-Identifier: Apache-2.0
// Internal: the text of a scene as a tree of TOML nodes that know their places, with the overrides of a command line
// applied. Only files of this folder that read scenes include this header, since it pulls in toml++.
#pragma once

#include <string>

#include <toml++/toml.h>

namespace scrim {

/// "file:line:column", or "--set key.path" for a value from an override.
std::string whereOf(const toml::source_region& region);

/// Parses `text`; `file` starts every location. Throws Error(input) where the text is malformed, or
/// nested so deeply that the parser could run out of stack.
toml::table parseToml(const std::string& text, const std::string& file);

/// Applies "key.path=value" to `root`. A part of the path is a key, quoted where it contains characters other than
/// letters, digits, '-' and '_'; "[i]" after it selects the i-th element (from 0) of a list. In a list of tables a key
/// selects the element of that name; elements without a name are called key1, key2, ... A value that does not begin
/// like one of TOML's counts as a string. Throws Error(input).
void applyOverride(toml::table& root, const std::string& assignment);

}  // namespace scrim
