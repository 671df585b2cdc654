// SPDX-License-Identifier: Apache-2.0
// Man pages, made from the same tables as `scrim help`.
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace scrim::cli {

/// The page in roff: scrim(1) where `topic` is "", scrim-render(1) for "render", scrim-scene(5) for "scene". `app`
/// holds the commands. Throws Error(usage) where there is no such page.
std::string manPage(const CLI::App& app, const std::string& topic);

}  // namespace scrim::cli
