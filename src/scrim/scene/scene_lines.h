// SPDX-License-Identifier: Apache-2.0
// The places of keys in a scene's text, for messages that explain an effect of the scene.
#pragma once

#include <map>
#include <string>

namespace scrim {

class SceneLines {
  public:
    SceneLines() = default;
    explicit SceneLines(std::map<std::string, std::string> lines) : m_lines(std::move(lines)) {}

    /// The place of a key as "scene.toml:12:3" (or "--set light.key.shadows"). The path is such as
    /// "light.key.shadows", "volume.plume.medium.phase" or "render.lod"; a volume or light without
    /// a name goes by "light.light1". Empty where the text does not contain the key.
    std::string of(const std::string& path) const {
        const auto found = m_lines.find(path);
        return found == m_lines.end() ? "" : found->second;
    }

  private:
    std::map<std::string, std::string> m_lines;
};

}  // namespace scrim
