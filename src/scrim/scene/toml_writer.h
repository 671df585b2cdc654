// SPDX-License-Identifier: Apache-2.0
// Internal: a tree of TOML nodes as text that reads back as the same tree. The formatter of toml++
// is not used, because it writes some keys so that no parser reads them.
#pragma once

#include <string>

#include <toml++/toml.h>

namespace scrim {

/// Keys are sorted by name, values before sections. Tables that were written inline stay so; all
/// others get sections. Numbers are as short as they can be.
std::string tomlText(const toml::table& root);

}  // namespace scrim
