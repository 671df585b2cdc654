// SPDX-License-Identifier: Apache-2.0
// Internal: the text of a scene as a tree of TOML nodes that know where they come from, with the overrides of
// a command line put in. Only files of this folder that read scenes include this header, since it brings
// toml++.
#pragma once

#include <string>

#include <toml++/toml.h>

namespace scrim {

/// "file:line:column", or "--set key.path" for what an override brought in.
std::string whereOf(const toml::source_region& region);

/// Parses `text`; `file` starts every location. Throws Error(input) where it is malformed, or nested so
/// deeply that the parser could run out of stack.
toml::table parseToml(const std::string& text, const std::string& file);

/// Puts "key.path=value" into `root`. A part of the path is a key, quoted where it has other characters than
/// letters, digits, '-' and '_'; behind it "[i]" takes the i-th element (from 0) of a list. In a list of
/// tables a key takes the element of that name; elements without a name are called key1, key2, ... A value
/// that does not begin like TOML's is a string. Throws Error(input).
void applyOverride(toml::table& root, const std::string& assignment);

}  // namespace scrim
