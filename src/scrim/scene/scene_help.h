// SPDX-License-Identifier: Apache-2.0
// The table of keys (scene_keys.h) as text: for `scrim help`, for examples/SCENES.md, for editors.
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

/// A JSON schema (draft 2020-12) of scenes, for editors that check TOML.
std::string sceneSchema();

/// Every path that --set takes, but for names of volumes and lights: "camera.fov", "light[0].slide.roll".
std::vector<std::string> scenePaths();

}  // namespace scrim
