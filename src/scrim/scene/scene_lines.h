// SPDX-License-Identifier: Apache-2.0
// Where a scene's text says what, for those who explain what the scene brought about.
#pragma once

#include <map>
#include <string>

namespace scrim {

class SceneLines {
  public:
    SceneLines() = default;
    explicit SceneLines(std::map<std::string, std::string> lines) : m_lines(std::move(lines)) {}

    /// "scene.toml:12:3" (or "--set light.key.shadows") of a key such as "light.key.shadows",
    /// "volume.plume.medium.phase" or "render.lod"; of a volume or light that has no name "light.light1". Empty where
    /// the text does not say it.
    std::string of(const std::string& path) const {
        const auto found = m_lines.find(path);
        return found == m_lines.end() ? "" : found->second;
    }

  private:
    std::map<std::string, std::string> m_lines;
};

}  // namespace scrim
