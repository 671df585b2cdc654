// SPDX-License-Identifier: Apache-2.0
// The table of keys (scene_keys.h) as text: for `scrim help`, for examples/SCENES.md, for man pages, for
// editors.
#pragma once

#include <string>
#include <vector>

namespace scrim {

/// What `sceneHelp` explains: the sections.
std::vector<std::string> sceneTopics();

/// A section by its topic, or, as "camera.fov" or "fov", the keys of that name. Empty where there is neither.
std::string sceneHelp(const std::string& topic);

/// All sections as Markdown.
std::string scenesAsMarkdown();

/// The same in roff, for a man page: a heading (.SH) a section.
std::string scenesAsRoff();
/// `text` as roff takes it literally.
std::string roffText(const std::string& text);

/// A JSON schema (draft 2020-12) of scenes, for editors that check TOML.
std::string sceneSchema();

/// Every path that --set takes, but for names of volumes and lights: "camera.fov", "light[0].slide.roll".
std::vector<std::string> scenePaths();

}  // namespace scrim
