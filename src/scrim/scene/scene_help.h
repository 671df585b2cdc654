// SPDX-License-Identifier: Apache-2.0
// The table of keys (scene_keys.h) as text: for `scrim help`, for examples/SCENES.md, for man pages and for editors.
#pragma once

#include <string>
#include <vector>

namespace scrim {

/// The topics that `sceneHelp` explains: one for each section.
std::vector<std::string> sceneTopics();

/// The help about a section, or about all keys named "fov" or the one key "camera.fov". Empty where there is neither.
std::string sceneHelp(const std::string& topic);

/// All sections as Markdown.
std::string scenesAsMarkdown();

/// All sections as roff for a man page, with a heading (.SH) for each.
std::string scenesAsRoff();
/// `text` escaped so that roff prints it literally.
std::string roffText(const std::string& text);

/// A JSON schema (draft 2020-12) of scenes, for editors that check TOML.
std::string sceneSchema();

/// Every path that --set takes, with indices in place of the names of volumes and lights:
/// "camera.fov", "light[0].slide.roll".
std::vector<std::string> scenePaths();

}  // namespace scrim
